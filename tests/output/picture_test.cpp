#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <png.h>

#include <catch2/catch.hpp>
#include <numbers>

#include "format/parallel.h"
#include "solver/output/exposure.h"
#include "solver/output/image_file.h"
#include "solver/output/output.h"
#include "solver/output/tone_map.h"
#include "tests/output/hand_made_scene.h"
#include "tests/support/temporary_folder.h"

using namespace rro;
using namespace rro::test;

namespace {

struct PngPixels {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgb;
};

PngPixels read_png(const std::filesystem::path& path) {
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    REQUIRE(png_image_begin_read_from_file(&image, path.c_str()));
    CHECK((image.flags & PNG_IMAGE_FLAG_COLORSPACE_NOT_sRGB) == 0);
    image.format = PNG_FORMAT_RGB;
    PngPixels out{static_cast<int>(image.width), static_cast<int>(image.height), {}};
    out.rgb.resize(PNG_IMAGE_SIZE(image));
    REQUIRE(png_image_finish_read(&image, nullptr, out.rgb.data(), 0, nullptr));
    return out;
}

struct ExrPixels {
    int width = 0, height = 0;
    std::vector<Rgb> rgb;
};

ExrPixels read_exr(const std::filesystem::path& path) {
    Imf::InputFile file(path.c_str());
    const auto window = file.header().dataWindow();
    ExrPixels out{window.max.x - window.min.x + 1, window.max.y - window.min.y + 1, {}};
    out.rgb.resize(static_cast<std::size_t>(out.width) * static_cast<std::size_t>(out.height));
    Imf::FrameBuffer frame;
    char* base = reinterpret_cast<char*>(out.rgb.data());
    std::size_t offset = 0;
    for (const char* channel : {"R", "G", "B"}) {
        REQUIRE(file.header().channels().findChannel(channel));
        CHECK(file.header().channels().findChannel(channel)->type == Imf::FLOAT);
        frame.insert(channel, Imf::Slice(Imf::FLOAT, base + offset, sizeof(Rgb),
                                         sizeof(Rgb) * static_cast<std::size_t>(out.width)));
        offset += sizeof(float);
    }
    file.setFrameBuffer(frame);
    file.readPixels(window.min.y, window.max.y);
    return out;
}

Rgb seven(const Instance&, const Vec3&, std::uint32_t) { return {7, 7, 7}; }

Rgb by_place(const Instance&, const Vec3& centre, std::uint32_t) {
    return {static_cast<float>(2 + centre.x), static_cast<float>(2 + centre.y), static_cast<float>(2 + centre.z)};
}

}  // namespace

TEST_CASE("a furnace looks the same everywhere, from a view of its own choice", "[output][picture]") {
    Scene scene;
    add_instance(scene, "room", turned_inside_out(make_box(4, 3, 5, 2)));
    const Solution solution = solution_by(scene, seven);
    const SceneRays rays(scene);
    const TemporaryFolder folder;

    const auto stops = write_picture(scene, solution, rays, {48, 32, 16}, folder / "v.png");
    REQUIRE(stops);
    CHECK(*stops == Approx(std::log2(0.18 * std::numbers::pi / 7)));  // the log-average goes to 0.18
    const PngPixels png = read_png(folder / "v.png");
    CHECK(png.width == 48);
    CHECK(png.height == 32);
    // sRGB of 0.18 is 117.6; the tone curve leaves middle grey alone. From outside all would be black backs.
    CHECK(std::all_of(png.rgb.begin(), png.rgb.end(), [](std::uint8_t code) { return code == 118; }));

    const auto no_exposure = write_picture(scene, solution, rays, {48, 32, 16}, folder / "v.EXR");
    REQUIRE(no_exposure);
    CHECK(*no_exposure == 0);
    const ExrPixels exr = read_exr(folder / "v.EXR");
    CHECK(exr.width == 48);
    CHECK(exr.height == 32);
    for (const Rgb& p : exr.rgb) REQUIRE(p.x == Approx(7 / std::numbers::pi).epsilon(1e-6));
}

TEST_CASE("the camera's exposure and field of view are obeyed", "[output][picture]") {
    Scene scene;
    // A square 2 x 2 in the plane y = 0, seen from straight above at distance 2: half of a picture 90 degrees high.
    add_instance(scene, "square", make_quad(2, 2));
    scene.manifest.camera = CameraEntry{{0, 2, 0}, {0, 0, 0}, {0, 0, -1}, 90, -1.0};
    const Solution solution = solution_by(scene, [](const Instance&, const Vec3&, std::uint32_t) {
        return Rgb{static_cast<float>(0.2 * std::numbers::pi), static_cast<float>(0.4 * std::numbers::pi), 0};
    });
    const SceneRays rays(scene);
    const TemporaryFolder folder;
    const auto stops = write_picture(scene, solution, rays, {80, 40, 4}, folder / "v.png");
    REQUIRE(stops);
    CHECK(*stops == -1);
    const PngPixels png = read_png(folder / "v.png");
    for (int y = 0; y < 40; ++y)
        for (int x = 0; x < 80; ++x) {
            const std::uint8_t* p = png.rgb.data() + 3 * (y * 80 + x);
            const bool inside = x >= 30 && x < 50 && y >= 10 && y < 30;
            CAPTURE(x, y);
            REQUIRE(int{p[0]} == (inside ? srgb_code(0.1) : 0));
            REQUIRE(int{p[1]} == (inside ? srgb_code(0.2) : 0));
            REQUIRE(int{p[2]} == 0);
        }
}

TEST_CASE("one-sided backs are black, both sides of a sheet show their own light", "[output][picture]") {
    for (const bool two_sided : {false, true}) {
        Scene scene;
        add_instance(scene, "sheet", make_quad(2, 2, two_sided));
        scene.manifest.camera = CameraEntry{{0, -1, 0}, {0, 0, 0}, {0, 0, 1}, 60, {}};
        const Solution solution = solution_by(scene, [](const Instance& i, const Vec3&, std::uint32_t face) {
            const bool back = i.data().faces[face].side() == Side::Back;
            return back ? Rgb{3, 2, 1} : Rgb{9, 9, 9};
        });
        const SceneRays rays(scene);
        const TemporaryFolder folder;
        REQUIRE(write_picture(scene, solution, rays, {8, 8, 4}, folder / "v.exr"));
        for (const Rgb& p : read_exr(folder / "v.exr").rgb) {
            CHECK(p.x == Approx(two_sided ? 3 / std::numbers::pi : 0));
            CHECK(p.y == Approx(two_sided ? 2 / std::numbers::pi : 0));
        }
    }
}

TEST_CASE("radiosity is interpolated at the place that is seen, on fronts and backs, mirrored or not",
          "[output][picture]") {
    const bool mirrored = GENERATE(false, true);
    const bool from_below = GENERATE(false, true);
    CAPTURE(mirrored, from_below);
    Scene scene;
    const Affine3 mirror{Mat3{{Vec3{-1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}}, {}};
    add_instance(scene, "sheet", make_quad(2, 2, true, 16), mirrored ? mirror : Affine3{});
    scene.manifest.camera = CameraEntry{{0, from_below ? -2.0 : 2.0, 0}, {0, 0, 0}, {0, 0, -1}, 50, {}};
    const Solution solution = solution_by(scene, by_place);
    const SceneRays rays(scene);
    const TemporaryFolder folder;
    REQUIRE(write_picture(scene, solution, rays, {20, 20, 16}, folder / "v.exr"));
    const ExrPixels exr = read_exr(folder / "v.exr");
    const double reach = 2 * std::tan(25 * std::numbers::pi / 180);
    for (int y = 0; y < 20; ++y)
        for (int x = 0; x < 20; ++x) {
            // Up is -z, so right is +x from above and -x from below.
            const double world_x = ((x + 0.5) / 10 - 1) * reach * (from_below ? -1 : 1);
            const double world_z = ((y + 0.5) / 10 - 1) * reach;
            const Rgb& p = exr.rgb[static_cast<std::size_t>(y * 20 + x)];
            // A hundredth of the range; cells are 0.125 wide, a wrong triangle would miss by more.
            CHECK(p.x * std::numbers::pi == Approx(2 + world_x).margin(0.02));
            CHECK(p.z * std::numbers::pi == Approx(2 + world_z).margin(0.02));
        }
}

TEST_CASE("pictures and meshes are the same bytes on any number of threads", "[output][picture]") {
    Scene scene;
    add_instance(scene, "box", make_box(1, 1, 1, 3));
    add_instance(scene, "ball", make_sphere(2), translation({2, 0, 0}));
    Solution solution = solution_by(scene, by_place);
    subdivide(scene.instances[0], solution.instances[0], 17, 3, [](const Vec3& p) { return to_float(p + Vec3{2, 2, 2}); });
    const TemporaryFolder folder;
    std::vector<std::string> first;
    for (const unsigned threads : {1u, 2u, 5u}) {
        set_thread_count(threads);
        const SceneRays rays(scene);
        REQUIRE(write_picture(scene, solution, rays, {60, 40, 16}, folder / "v.png"));
        REQUIRE(write_picture(scene, solution, rays, {60, 40, 16}, folder / "v.exr"));
        REQUIRE(write_glb(scene, solution, folder / "v.glb"));
        REQUIRE(write_radiosity_csv(scene, solution, folder / "v.csv"));
        std::vector<std::string> files;
        for (const char* name : {"v.png", "v.exr", "v.glb", "v.csv"}) files.push_back(file_text(folder / name));
        if (first.empty()) first = files;
        CHECK(files == first);
    }
    set_thread_count(0);
}

TEST_CASE("a view from outside shows the whole scene", "[output][picture]") {
    Scene scene;
    add_instance(scene, "box", make_box(1, 1, 1));
    const SceneRays rays(scene);
    const TemporaryFolder folder;
    REQUIRE(write_picture(scene, solution_by(scene, seven), rays, {64, 36, 1}, folder / "v.exr"));
    const ExrPixels exr = read_exr(folder / "v.exr");
    int lit = 0;
    for (int y = 0; y < 36; ++y)
        for (int x = 0; x < 64; ++x) {
            const bool is_lit = exr.rgb[static_cast<std::size_t>(y * 64 + x)].x > 0;
            lit += is_lit;
            if (x == 0 || x == 63 || y == 0 || y == 35) CHECK_FALSE(is_lit);  // nothing is cut off
        }
    CHECK(lit > 64 * 36 / 8);
}

TEST_CASE("wrong names and sizes are usage errors", "[output][picture]") {
    Scene scene;
    add_instance(scene, "box", make_box(1, 1, 1));
    const Solution solution = solution_by(scene, seven);
    const SceneRays rays(scene);
    const auto jpeg = write_picture(scene, solution, rays, {}, "v.jpg");
    REQUIRE_FALSE(jpeg);
    CHECK(jpeg.error().kind == ErrorKind::Usage);
    CHECK(jpeg.error().where == "v.jpg");
    const auto empty = write_picture(scene, solution, rays, {0, 10, 1}, "v.png");
    REQUIRE_FALSE(empty);
    CHECK(empty.error().kind == ErrorKind::Usage);
}

TEST_CASE("the tone curve keeps dim colours, is smooth, rising, and stays below white", "[output][picture]") {
    double before = -1;
    for (double x = 0; x < 20; x += 0.01) {
        const double y = tone_curve({x, 0, 0}).x;
        CHECK(y > before);
        CHECK(y <= x + 1e-15);
        CHECK(y < 1);
        if (x <= 0.35) CHECK(y == x);
        before = y;
    }
    const double slope = (tone_curve({0.35 + 1e-6, 0, 0}).x - 0.35) / 1e-6;
    CHECK(slope == Approx(1).epsilon(1e-5));
    CHECK(srgb_code(0) == 0);
    CHECK(srgb_code(1) == 255);
    CHECK(srgb_code(0.5) == 188);  // 1.055 * 0.5^(1 / 2.4) - 0.055 = 0.7354
}

TEST_CASE("black and the brightest hundredth do not decide the exposure", "[output][picture]") {
    std::vector<WeightedLuminance> samples(990, {2.0, 1});
    samples.resize(1000, {1e6, 1});
    samples.resize(1500, {0.0, 1});
    samples.resize(1600, {1e-3, 1});  // light that fades, not a surface to see
    CHECK(automatic_exposure(samples) == Approx(0.09));
    std::vector<WeightedLuminance> black(10, {0.0, 1});
    CHECK(automatic_exposure(black) == 1);
    std::vector<WeightedLuminance> weighted{{1, 3}, {16, 1}};
    CHECK(automatic_exposure(weighted) == Approx(0.18 / 2));  // exp((3 log 1 + log 16) / 4) = 2
}
