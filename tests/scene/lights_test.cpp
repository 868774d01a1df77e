#include "solver/scene/lights.h"

#include <cmath>
#include <numbers>

#include "solver/output/image_file.h"
#include "solver/scene/radiance_image.h"
#include "tests/scene/scene_files.h"

using namespace rro;
using namespace rro::test;
using Catch::Matchers::Contains;
using std::numbers::pi;

namespace {

constexpr int kSteps = 64;  // of the unit square's sides, midpoints

/// Irradiance of a plane by the sky's own samples: the mean of L cos / density.
Vec3 sampled_irradiance(const Sky& sky, const Vec3& normal) {
    Vec3 sum;
    for (int i = 0; i < kSteps; ++i)
        for (int j = 0; j < kSteps; ++j) {
            const Sky::Sample s = sky.sample((i + 0.5) / kSteps, (j + 0.5) / kSteps);
            CHECK(std::abs(length(s.from) - 1) < 1e-12);
            sum += s.radiance * (std::max(0.0, dot(normal, s.from)) / s.density);
        }
    return sum / (kSteps * kSteps);
}

std::string ies(const std::string& numbers, const std::string& tilt = "TILT=NONE\n") {
    return "IESNA:LM-63-2002\r\n[TEST] none\r\n" + tilt + numbers;
}

IesDistribution parsed(const std::string& text) {
    auto web = parse_ies(text, "lamp.ies");
    if (!web) FAIL(web.error().message);
    return std::move(*web);
}

std::string hdr(const std::string& size, const std::string& pixels, const std::string& header = "") {
    return "#?RADIANCE\n" + header + "FORMAT=32-bit_rle_rgbe\n\n" + size + "\n" + pixels;
}

/// A Radiance pixel of 1 in all channels, but for the half step that decoding adds.
const std::string kWhite{"\x80\x80\x80\x81", 4};

}  // namespace

TEST_CASE("a uniform sky gives pi L to a plane that sees half of it", "[lights]") {
    // 64^2 midpoints of a smooth integrand; the horizon's edge adds about 1 / 64^2.
    const Sky all = Sky::uniform({1, 2, 3}, false);
    for (const Vec3& normal : {Vec3{0, 1, 0}, Vec3{0, -1, 0}, Vec3{1, 0, 0}, normalised({1, 1, -1})}) {
        const Vec3 e = sampled_irradiance(all, normal);
        CHECK(e.x == Approx(pi).epsilon(2e-3));
        CHECK(e.z == Approx(3 * pi).epsilon(2e-3));
    }
    const Sky above = Sky::uniform({1, 1, 1}, true);
    CHECK(sampled_irradiance(above, {0, 1, 0}).x == Approx(pi).epsilon(2e-3));
    CHECK(sampled_irradiance(above, {0, 0, 1}).x == Approx(pi / 2).epsilon(2e-3));
    CHECK(sampled_irradiance(above, {0, -1, 0}).x == 0);
    CHECK(above.radiance({0, -0.1, std::sqrt(0.99)}) == Vec3{});
    CHECK(Sky::uniform({}, false).dark());
    CHECK_FALSE(all.is_peaked());
}

TEST_CASE("the overcast sky: 7/9 pi L_z horizontally, pi/6 + 4/9 vertically with the ground black", "[lights]") {
    const Sky sky = Sky::cie_overcast({9, 9, 9}, true);
    CHECK(sampled_irradiance(sky, {0, 1, 0}).x == Approx(7 * pi).epsilon(2e-3));
    CHECK(sampled_irradiance(sky, {1, 0, 0}).x == Approx(9 * (pi / 6 + 4.0 / 9)).epsilon(2e-3));
    // Below the horizon as at it, L_z / 3: the vertical plane gains pi/6 L_z.
    CHECK(sampled_irradiance(Sky::cie_overcast({9, 9, 9}, false), {1, 0, 0}).x ==
          Approx(9 * (pi / 3 + 4.0 / 9)).epsilon(2e-3));
    CHECK(sky.radiance({0, 1, 0}).x == Approx(9));
    CHECK(sky.radiance({1, 0, 0}).x == Approx(3));
}

TEST_CASE("a picture's pixels lie where OpenEXR has them: middle +z, left of it +x, top +y", "[lights]") {
    // 4 x 2: columns span longitudes 180..90, 90..0, 0..-90, -90..-180 degrees from +z towards +x.
    std::vector<Rgb> pixels(8);
    for (std::size_t i = 0; i < 8; ++i) pixels[i] = {float(i + 1), 0, 0};
    const Sky sky = Sky::image(4, 2, pixels, false);
    CHECK(sky.radiance(normalised({1, 1, -1})).x == 1);
    CHECK(sky.radiance(normalised({1, 1, 1})).x == 2);
    CHECK(sky.radiance(normalised({-1, 1, 1})).x == 3);
    CHECK(sky.radiance(normalised({-1, 1, -1})).x == 4);
    CHECK(sky.radiance(normalised({1, -1, 1})).x == 6);
    CHECK(Sky::image(4, 2, pixels, true).radiance(normalised({1, -1, 1})).x == 0);
}

TEST_CASE("directions of a picture are chosen by brightness, and the density says how", "[lights]") {
    std::vector<Rgb> pixels(16 * 8, Rgb{0.1f, 0.1f, 0.1f});
    pixels[2 * 16 + 5] = {500, 400, 300};
    const Sky sky = Sky::image(16, 8, pixels, false);
    CHECK(sky.is_peaked());
    int bright = 0;
    for (int i = 0; i < kSteps; ++i)
        for (int j = 0; j < kSteps; ++j) {
            const Sky::Sample s = sky.sample((i + 0.5) / kSteps, (j + 0.5) / kSteps);
            if (s.radiance.x > 1) ++bright;
            CHECK(s.density == Approx(sky.density(s.from)));
            CHECK(s.radiance == sky.radiance(s.from));
        }
    // The bright pixel has 0.121 sr x 1200 of 3.8 + 145 W: 97 % of the light.
    CHECK(bright > 0.95 * kSteps * kSteps);
    // The densities of all directions add up to 1: sum over the picture's cells.
    double sum = 0;
    for (int row = 0; row < 8; ++row)
        for (int column = 0; column < 16; ++column) {
            const double latitude = pi / 2 - (row + 0.5) * pi / 8, longitude = pi - (column + 0.5) * pi / 8;
            const double solid_angle = (std::cos(row * pi / 8) - std::cos((row + 1) * pi / 8)) * pi / 8;
            sum += solid_angle * sky.density({std::cos(latitude) * std::sin(longitude), std::sin(latitude),
                                              std::cos(latitude) * std::cos(longitude)});
        }
    CHECK(sum == Approx(1).epsilon(1e-12));
    CHECK(sky.grey().radiance(normalised({0.1, 1, 0.1})).y == Approx(0.1).epsilon(1e-6));
    CHECK_FALSE(sky.is_grey());
    CHECK(sky.grey().is_grey());
}

TEST_CASE("the sun's irradiance holds for a facing plane at any diameter", "[lights]") {
    for (const double radius : {0.0, 0.0046, 0.5, 1.5}) {
        const Sun sun{normalised({0.3, -0.8, 0.5}), {2, 3, 4}, radius};
        Vec3 sum, nearly_across;
        const Vec3 tilted = normalised(Vec3{-0.3, 0.8, -0.5} + Vec3{0.5, 0.5, 0.5});
        for (int i = 0; i < kSteps; ++i)
            for (int j = 0; j < kSteps; ++j) {
                const Sun::Sample s = sun.sample((i + 0.5) / kSteps, (j + 0.5) / kSteps);
                CHECK(dot(s.from, -sun.direction) >= std::cos(radius) - 1e-12);
                sum += s.irradiance * dot(s.from, -sun.direction);
                nearly_across += s.irradiance * dot(s.from, tilted);
            }
        CHECK(sum.y / (kSteps * kSteps) == Approx(3).epsilon(1e-12));
        // A plane that sees the whole disc: the cosine law of the disc's centre, for a symmetric disc.
        if (radius < 0.6)
            CHECK(nearly_across.y / (kSteps * kSteps) == Approx(3 * dot(tilted, -sun.direction)).epsilon(1e-3));
        CHECK(sun.radiance(-sun.direction).y == Approx(radius > 0 ? 3 / (pi * std::pow(std::sin(radius), 2)) : 0));
        CHECK(sun.radiance(sun.direction) == Vec3{});
    }
}

TEST_CASE("a spot's light ends at half its opening angle", "[lights]") {
    PointLight spot;
    spot.intensity = {5, 5, 5};
    spot.cone_cosine = std::cos(pi / 6);
    CHECK(spot.intensity_towards(normalised({std::sin(pi / 6 - 1e-6), -std::cos(pi / 6 - 1e-6), 0})).x == 5);
    CHECK(spot.intensity_towards(normalised({std::sin(pi / 6 + 1e-6), -std::cos(pi / 6 + 1e-6), 0})).x == 0);
    spot.cone_cosine = -1;
    CHECK(spot.intensity_towards({0, 1, 0}).x == 5);
}

TEST_CASE("a medium lets exp(-a d) through, nothing over infinite ways, all where it does not absorb", "[lights]") {
    const Medium fog{{0.5, 0, 2}};
    CHECK(fog.transmittance(3).x == Approx(std::exp(-1.5)));
    CHECK(fog.transmittance(3).y == 1);
    CHECK(fog.transmittance(std::numeric_limits<double>::infinity()) == Vec3{0, 1, 0});
}

TEST_CASE("IES files: multiplier, ballast, bilinear between angles, symmetry, dark outside", "[lights][ies]") {
    // 2 x 0.5 = 1 candela per unit. Vertical 0, 45, 90; horizontal 0, 90: symmetric about both planes.
    const IesDistribution web = parsed(ies("1 1000 2 3 2 1 2 0 0 0\n0.5 1 100\n0 45 90\n0 90\n100 50 0\n100,150,200\n"));
    CHECK(web.intensity(0, 0) == 100);
    CHECK(web.intensity(45, 0) == 50);
    CHECK(web.intensity(22.5, 0) == 75);
    CHECK(web.intensity(45, 90) == 150);
    CHECK(web.intensity(45, 45) == 100);
    for (const double angle : {-45.0, 135.0, 225.0, 315.0, 405.0}) CHECK(web.intensity(45, angle) == 100);
    CHECK(web.intensity(67.5, 90) == 175);
    CHECK(web.intensity(90.1, 0) == 0);
    CHECK(web.largest() == 200);
    const IesDistribution half = parsed(ies("1 1 1 2 3 1 1 0 0 0 1 1 1  0 180  0 90 180  1 1  2 2  5 5"));
    CHECK(half.intensity(10, 270) == 2);
    CHECK(half.intensity(10, 315) == 1.5);
    const IesDistribution full = parsed(ies("1 1 1 2 5 1 1 0 0 0 1 1 1  0 180  0 90 180 270 360  1 1  2 2  5 5 8 8 1 1"));
    CHECK(full.intensity(10, 315) == 4.5);
    CHECK(full.intensity(10, -45) == 4.5);
    const IesDistribution across = parsed(ies("1 1 1 2 3 1 1 0 0 0 1 1 1  0 180  90 180 270  1 1  2 2  5 5"));
    CHECK(across.intensity(10, 0) == 2);    // 0 mirrors 180
    CHECK(across.intensity(10, 300) == 4);  // 300 mirrors 240
    const IesDistribution round = parsed(ies("1 1 1 3 1 1 1 0 0 0 1 1 1  90 120 180  0  1 2 3", "TILT=INCLUDE\n1 2 0 90 1 0.9\n"));
    CHECK(round.intensity(105, 77) == 1.5);
    CHECK(round.intensity(80, 0) == 0);
}

TEST_CASE("a measured lamp hangs down, turns with its direction, and is as bright as asked", "[lights][ies]") {
    // Horizontal 0, 90, 180, 270, 360 with 1, 2, 3, 4 cd at vertical 90.
    PointLight lamp;
    lamp.measured = std::make_shared<IesDistribution>(
        parsed(ies("1 1 1 3 5 1 1 0 0 0 1 1 1  0 90 180  0 90 180 270 360  4 1 0  4 2 0  4 3 0  4 4 0  4 1 0")));
    lamp.intensity = {8, 4, 0};
    CHECK(lamp.intensity_towards({0, -1, 0}).x == Approx(8));
    CHECK(lamp.intensity_towards({0, 1, 0}).x == Approx(0).margin(1e-9));
    CHECK(lamp.intensity_towards({1, 0, 0}).x == Approx(2));
    CHECK(lamp.intensity_towards({0, 0, -1}).x == Approx(4));
    CHECK(lamp.intensity_towards({-1, 0, 0}).x == Approx(6));
    CHECK(lamp.intensity_towards({0, 0, 1}).y == Approx(4));
    lamp.direction = {0, 0, 1};  // turned about x: what was at -z is at -y
    CHECK(lamp.intensity_towards({0, 0, 1}).x == Approx(8));
    CHECK(lamp.intensity_towards({1, 0, 0}).x == Approx(2));
    CHECK(lamp.intensity_towards({0, -1, 0}).x == Approx(4));
    lamp.direction = {0, 1, 0};
    CHECK(lamp.intensity_towards({0, 1, 0}).x == Approx(8));
    CHECK(lamp.intensity_towards({0, 0, 1}).x == Approx(4));
}

TEST_CASE("IES files that cannot be used say where and why", "[lights][ies]") {
    const auto error = [](const std::string& text) {
        const auto web = parse_ies(text, "lamp.ies");
        REQUIRE_FALSE(web);
        CHECK(web.error().kind == ErrorKind::BadInput);
        return text_of(web.error());
    };
    CHECK(error("hello") == "lamp.ies: has no line \"TILT=...\", expected an IES LM-63 file");
    CHECK_THAT(error(ies("", "TILT=lamp.tlt\n")), Contains("has TILT=lamp.tlt, expected NONE or INCLUDE"));
    CHECK(error(ies("1 1 x")) ==
          "lamp.ies: number 3 after TILT, candela multiplier: found \"x\", expected a number");
    CHECK_THAT(error(ies("1 1 1 3")), Contains("number of horizontal angles: found nothing, the file ends here"));
    CHECK_THAT(error(ies("1 1 1 1e9 1 1")), Contains("number of vertical angles: found 1e+09"));
    CHECK_THAT(error(ies("1 1 1 2.5 1 1")), Contains("a whole number"));
    CHECK_THAT(error(ies("1 1 1 2 1 2 1 0 0 0 1 1 1 0 90 0 1 1")), Contains("found 2 (B), expected 1 (C)"));
    CHECK_THAT(error(ies("1 1 1 2 1 1 1 0 0 0 1 1 1 90 0 0 1 1")), Contains("ascending"));
    CHECK_THAT(error(ies("1 1 1 2 2 1 1 0 0 0 1 1 1 0 90 0 45 1 1 1 1")), Contains("0 to 90"));
    CHECK_THAT(error(ies("1 1 1 2 1 1 1 0 0 0 1 1 1 0 90 0 1 -1")), Contains("intensity: found -1"));
    CHECK_THAT(error(ies("1 1 1 2 1 1 1 0 0 0 1 1 1 0 90 0 0 0")), Contains("no intensity above 0"));
    CHECK_THAT(error(ies("1 1 1 9e4 9e4 1 1 0 0 0 1 1 1 0 1 2 3")), Contains("expected ascending angles") || Contains("ends here"));
    // Cut anywhere, a file is refused or read whole.
    const std::string whole = ies("1 1000 2 3 2 1 2 0 0 0\n0.5 1 100\n0 45 90\n0 90\n100 50 0\n100 150 200");
    for (std::size_t length = 0; length + 3 < whole.size(); ++length) CHECK_FALSE(parse_ies(whole.substr(0, length), ""));
}

TEST_CASE("Radiance pictures: plain rows, runs of pixels, runs of channels, exposure", "[lights][image]") {
    const auto decode = [](const std::string& bytes) {
        auto image = decode_sky_image(bytes, "sky.hdr");
        if (!image) FAIL(image.error().message);
        return std::move(*image);
    };
    const RadianceImage plain = decode(hdr("-Y 1 +X 2", kWhite + std::string("\x40\x00\x00\x82\x00", 4)));
    REQUIRE(plain.pixels.size() == 2);
    CHECK(plain.pixels[0].x == Approx(128.5 / 128));  // (128 + 1/2) 2^(129 - 136)
    CHECK(plain.pixels[1].x == Approx(64.5 / 64));
    const RadianceImage repeated = decode(hdr("-Y 2 +X 3", kWhite + std::string("\x01\x01\x01\x02", 4) + kWhite + kWhite + kWhite));
    for (const Rgb& pixel : repeated.pixels) CHECK(pixel == plain.pixels[0]);
    std::string row{"\x02\x02\x00\x08", 4};
    for (int channel = 0; channel < 3; ++channel) row += std::string("\x88\x80", 2);    // 8 times 128
    row += std::string("\x03\x81\x81\x81\x85\x81", 6);                                  // 3 literals, then 5 times
    const RadianceImage runs = decode(hdr("-Y 1 +X 8", row, "EXPOSURE= 2\n"));
    for (const Rgb& pixel : runs.pixels) CHECK(pixel.y == Approx(0.5 * 128.5 / 128));
    CHECK(decode(hdr("-Y 1 +X 1", std::string(4, '\0'))).pixels[0] == Rgb{});

    const std::string whole = hdr("-Y 1 +X 8", row);
    for (std::size_t length = 0; length < whole.size(); ++length)
        CHECK_FALSE(decode_sky_image(whole.substr(0, length), ""));
    const auto error = [](const std::string& bytes) {
        const auto image = decode_sky_image(bytes, "sky.hdr");
        REQUIRE_FALSE(image);
        return text_of(image.error());
    };
    CHECK_THAT(error("GIF89a"), Contains("sky.hdr: is neither a Radiance picture (.hdr) nor OpenEXR"));
    CHECK_THAT(error(hdr("+X 8 -Y 1", row)), Contains("has the size \"+X 8 -Y 1\", expected \"-Y height +X width\""));
    CHECK_THAT(error(hdr("-Y 1 +X 99999999", row)), Contains("has the size"));
    CHECK_THAT(error("#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n"), Contains("32-bit_rle_xyze"));
    CHECK_THAT(error(hdr("-Y 1 +X 9", row)), Contains("row 0 of 1 is broken or cut short"));
    CHECK_THAT(error("\x76\x2f\x31\x01 and then nothing"), Contains("is no OpenEXR picture that can be read"));
}

TEST_CASE("OpenEXR pictures are read as they were written, and refused where they are cut", "[lights][image]") {
    std::vector<Rgb> pixels;
    for (int i = 0; i < 6 * 4; ++i) pixels.push_back({float(i), 1e5f / float(i + 1), 0.25f});
    const auto encoded = encode_exr(pixels, 6, 4);
    REQUIRE(encoded);
    const auto image = decode_sky_image(*encoded, "sky.exr");
    if (!image) FAIL(image.error().message);
    CHECK(image->width == 6);
    CHECK(image->height == 4);
    REQUIRE(image->pixels.size() == pixels.size());
    for (std::size_t i = 0; i < pixels.size(); ++i)  // a mean of one pixel: float rounding
        CHECK(length(to_double(image->pixels[i]) - to_double(pixels[i])) <= 1e-6 * length(to_double(pixels[i])));
    for (std::size_t size = 0; size < encoded->size(); size += 7)
        CHECK_FALSE(decode_sky_image(encoded->substr(0, size), "sky.exr"));
    pixels[8].y = std::numeric_limits<float>::infinity();
    const auto infinite = decode_sky_image(*encode_exr(pixels, 6, 4), "sky.exr");
    REQUIRE_FALSE(infinite);
    CHECK(text_of(infinite.error()) == "sky.exr: the pixel in column 2, row 1 is no finite number");
}

TEST_CASE("a large picture becomes means that keep its light", "[lights][image]") {
    constexpr int width = 5000, height = 1500;  // no multiples of what is kept
    SkyRows rows(width, height);
    std::vector<Rgb> row(width);
    double light = 0;
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const float value = x == 4321 && y == 700 ? 1e5f : 0.25f;
            row[std::size_t(x)] = {value, value, value};
            light += double(value) * (std::cos(pi * y / height) - std::cos(pi * (y + 1) / height)) * 2 * pi / width;
        }
        REQUIRE(rows.add(row));
    }
    const RadianceImage image = rows.take();
    REQUIRE(image.width == kSkyWidth);
    REQUIRE(image.height == kSkyHeight);
    double kept = 0;
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x)
            kept += double(image.pixels[std::size_t(y) * std::size_t(image.width) + std::size_t(x)].x) *
                    (std::cos(pi * y / image.height) - std::cos(pi * (y + 1) / image.height)) * 2 * pi / image.width;
    // Means of unequal numbers of pixels: a bright one weighs up to 1 part in (5000/2048) more or less, here 5 % of all.
    CHECK(kept == Approx(light).epsilon(0.05));
    row[7].y = std::nanf("");
    SkyRows broken(width, height);
    const auto refused = broken.add(row);
    REQUIRE_FALSE(refused);
    CHECK_THAT(refused.error().message, Contains("the pixel in column 7, row 0 is no finite number"));
}

TEST_CASE("a scene's lights are resolved, what is dark is left out, groups are numbered by name", "[lights][scene]") {
    SceneFiles files;
    std::ofstream(files.folder / "lamp.ies", std::ios::binary) << ies("1 1 1 2 1 1 1 0 0 0 1 1 1  0 90  0  358 179");
    std::ofstream(files.folder / "sky.hdr", std::ios::binary) << hdr("-Y 1 +X 2", kWhite + kWhite);
    const Scene scene = files.open(files.instances(
        R"({"name": "a", "archive": "box.rro", "materials": {"*": {"group": "night"}, "lamp": {"group": "day"}}},
           {"name": "b", "archive": "box.rro"})",
        R"(, "sky": {"image": "sky.hdr", "scale": 4}, "sun": {"direction": [0, -2, 0], "irradiance": [0, 0, 0]},
           "lights": [{"name": "off", "type": "point", "position": [0, 0, 0], "intensity": [0, 0, 0]},
                      {"name": "down", "type": "ies", "position": [0, 3, 0], "file": "lamp.ies", "group": "night"},
                      {"name": "s", "type": "spot", "position": [0, 3, 0], "direction": [3, 0, 0], "cone_degrees": 60,
                       "intensity": [1, 2, 3]}])"));
    REQUIRE(scene.sky);
    CHECK(scene.sky->radiance({0, 1, 0}).y == Approx(4 * 128.5 / 128));
    CHECK_FALSE(scene.sun);
    CHECK_FALSE(scene.medium);
    CHECK(scene.light_groups == std::vector<std::string>{"", "day", "night"});
    CHECK(scene.instances[0].light_group_of(0) == 2);
    CHECK(scene.instances[0].light_group_of(1) == 1);
    CHECK(scene.instances[1].light_group.empty());
    REQUIRE(scene.lights.size() == 2);
    CHECK(scene.lights[0].group == 2);
    CHECK(scene.lights[0].intensity_towards({0, -1, 0}).x == Approx(2));  // 358 cd / 179 lm/W
    CHECK(scene.lights[0].intensity_towards({1, 0, 0}).x == Approx(1));
    CHECK(scene.lights[1].cone_cosine == Approx(std::sqrt(0.75)));
    CHECK(scene.instances[0].transmittance.empty());
}

TEST_CASE("files of lights that cannot be used are named with their place in the manifest", "[lights][scene]") {
    SceneFiles files;
    CHECK_THAT(text_of(files.error(files.instances("", R"(, "sky": {"image": "no.hdr"})"))),
               Contains("room.json: /sky/image: no.hdr: cannot be read: No such file"));
    std::ofstream(files.folder / "bad.ies") << "nothing";
    CHECK_THAT(text_of(files.error(files.instances(
                   "", R"(, "lights": [{"name": "a", "type": "ies", "position": [0, 0, 0], "file": "bad.ies"}])"))),
               Contains("room.json: /lights/0/file: bad.ies: has no line \"TILT=...\""));
}

TEST_CASE("transmittance is for two-sided triangles, and below 1 with the reflectance", "[lights][scene]") {
    SceneFiles files;
    const auto error = [&](const std::string& materials) {
        return files.error(files.instances(R"({"name": "a", "archive": "box.rro", "materials": {)" + materials + "}}"));
    };
    const Error one_sided = error(R"("walls": {"transmittance": [0.1, 0.1, 0.1]})");
    CHECK(text_of(one_sided) ==
          "room.json: /instances/0/materials: material \"walls\" of box.rro has a transmittance, but triangles with one "
          "side only");
    CHECK(one_sided.hint == "compile the archive with --two-sided yes");
    CHECK(files.open(files.instances(
                    R"({"name": "a", "archive": "box.rro", "materials": {"*": {"transmittance": [0, 0, 0]}}})"))
              .instances[0]
              .transmittance.empty());
}
