// What a hostile mesh asks for: to be read for ever, or more memory than its size would suggest.
#include <sys/stat.h>

#include "compiler/mesh_weld.h"
#include "mesh_files.h"
#include "tests/support/image_files.h"

using namespace rro;
using namespace rro::test;

namespace {

constexpr const char* triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\n";

/// The error of a file that is good by itself but beyond these limits.
Error beyond(const std::filesystem::path& file, const ImportLimits& limits) {
    imported(file);
    ImportOptions options;
    options.limits = limits;
    const auto result = import_mesh(file, options);
    REQUIRE(!result);
    CHECK(result.error().kind == ErrorKind::BadInput);
    return result.error();
}

/// A star whose every corner lies in the way of others.
std::string star(int corners) {
    std::string text, face = "f";
    for (int i = 0; i < corners; ++i) {
        const double angle = 2 * 3.14159265358979 * i / corners, radius = i % 2 ? 1 : 3;
        text += "v " + std::to_string(radius * std::cos(angle)) + " " + std::to_string(radius * std::sin(angle)) + " 0\n";
        face += " " + std::to_string(i + 1);
    }
    return text + face + "\n";
}

}  // namespace

TEST_CASE("a pipe or a device is refused, not read for ever", "[mesh][limits]") {
    const MeshFolder folder;
    const auto pipe = folder.path() / "pipe.obj";
    REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
    CHECK(refused(pipe).message.find("pipe") != std::string::npos);
    std::filesystem::create_symlink("/dev/zero", folder.path() / "zero.ply");
    CHECK(refused(folder.path() / "zero.ply").message.find("device") != std::string::npos);
    // So is what a mesh refers to.
    folder.write("m.mtl", "newmtl t\nmap_Kd /dev/zero\n");
    const auto file = folder.write("a.obj", "mtllib /dev/zero\nmtllib m.mtl\nusemtl t\n" + std::string(triangle));
    CHECK(warns(imported(file).report, "'/dev/zero' is not read (found a pipe or a device"));
}

TEST_CASE("a mesh and what it refers to have a largest size together", "[mesh][limits]") {
    const MeshFolder folder;
    const std::string library = "newmtl t\n# " + std::string(500, 'x') + "\n";
    folder.write("m.mtl", library);
    const std::string mesh = "mtllib m.mtl\nusemtl t\n" + std::string(triangle);
    const auto file = folder.write("a.obj", mesh);
    CHECK(beyond(file, {.file_bytes = mesh.size() - 1}).where == file.string());
    CHECK(beyond(file, {.file_bytes = mesh.size() + library.size() - 1}).where.ends_with("m.mtl"));
    ImportOptions enough;
    enough.limits.file_bytes = mesh.size() + library.size();
    CHECK(import_mesh(file, enough));
}

TEST_CASE("a material file named before every object is read once", "[mesh][limits]") {
    const MeshFolder folder;
    folder.write("m.mtl", "newmtl t\nKd 0.25 0.25 0.25\n");
    std::string mesh;
    for (int i = 0; i < 10000; ++i) mesh += "mtllib m.mtl\n";
    const ImportedMesh result = imported(folder.write("a.obj", mesh + "usemtl t\n" + triangle));
    CHECK(result.files.size() == 2);
    CHECK(result.mesh.materials.at(0).reflectance.x == Approx(0.25));
}

TEST_CASE("every format counts vertices and corners", "[mesh][limits]") {
    const MeshFolder folder;
    const std::string stl_facet =
        "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
    std::string binary_stl = std::string(80, ' ') + raw(std::uint32_t{2});
    for (int facet = 0; facet < 2; ++facet)
        binary_stl += std::string(12, '\0') + raw(std::array<float, 9>{0, 0, 0, 1, 0, 0, 0, 1, 0}) + std::string(2, '\0');
    const std::string ply_header = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                                   "property float z\nelement face ";
    const std::string ply_body =
        "\nproperty list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    for (const auto& [name, content] : std::vector<std::pair<std::string, std::string>>{
             {"a.obj", std::string(triangle) + "f 1 2 3\n"},
             {"a.off", "OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 1 2\n"},
             {"a.stl", "solid\n" + stl_facet + stl_facet + "endsolid\n"},
             {"b.stl", binary_stl},
             {"a.ply", ply_header + "2" + ply_body + "3 0 1 2\n"}}) {
        INFO(name);
        CHECK(beyond(folder.write(name, content), {.corners = 5}).message.find("corners") != std::string::npos);
        CHECK(beyond(folder.write(name, content), {.corners = 2}).message.find("2 ") != std::string::npos);
    }
    // A list that claims more than there can be.
    CHECK(refused(folder.write("a.ply", ply_header + "1" + ply_body.substr(0, ply_body.size() - 8) + "2000000000 0 1\n"))
              .message.find("a list of 2000000000 values") != std::string::npos);
}

TEST_CASE("a line of many millions of words is no statement", "[mesh][limits]") {
    const MeshFolder folder;
    std::string face = "f";
    for (int i = 0; i < (1 << 23); ++i) face += " 1";
    CHECK(refused(folder.write("a.obj", triangle + face + "\n")).where.ends_with("a.obj:6"));
    CHECK(refused(folder.write("a.off", "OFF\n1 1 0\n0 0 0\n" + face + "\n")).where.ends_with("a.off:4"));
    CHECK(refused(folder.write("a.stl", "solid\n" + face + "\n")).where.ends_with("a.stl:2"));
}

TEST_CASE("a polygon that would take too long to cut is refused by its line", "[mesh][limits]") {
    const MeshFolder folder;
    const auto file = folder.write("a.obj", "# a star\n" + star(100));
    // Each of its 98 triangles is compared with some of the corners that are left.
    const Error error = beyond(file, {.polygon_steps = 1000});
    CHECK(error.where.ends_with("a.obj:102"));
    CHECK(error.message.find("100 corners") != std::string::npos);
}

TEST_CASE("a texture with more pixels than are taken counts as none", "[mesh][limits]") {
    const MeshFolder folder;
    folder.write("a.tga", tga_file(4, 4, std::vector<Pixel>(16, {188, 188, 188})));
    folder.write("m.mtl", "newmtl t\nmap_Kd a.tga\nnewmtl u\nmap_Kd ./a.tga\n");
    const auto file =
        folder.write("a.obj", "mtllib m.mtl\nusemtl t\n" + std::string(triangle) + "usemtl u\nf 1 2 3\n");
    CHECK(imported(file).report.warnings.empty());
    ImportOptions options;
    options.limits.image_pixels = 15;
    CHECK(import_mesh(file, options)->report.warnings.size() == 2);
    options.limits = {.texture_pixels = 31};  // enough for one of them
    CHECK(import_mesh(file, options)->report.warnings.size() == 1);
    // A header that promises 8192 x 8192 pixels, and has none of them.
    folder.write("a.tga", tga_file(8192, 8192, std::vector<Pixel>(16)));
    CHECK(imported(file).report.warnings.size() == 2);
}

TEST_CASE("where texture samples are few, each triangle gets fewer", "[mesh][limits]") {
    const MeshFolder folder;
    std::vector<Pixel> noise(64 * 64);
    std::uint32_t state = 1;
    for (auto& pixel : noise) {
        state = state * 1664525 + 1013904223;  // any noise will do
        pixel.fill(static_cast<unsigned char>(state >> 24));
    }
    folder.write("a.tga", tga_file(64, 64, noise));
    folder.write("m.mtl", "newmtl t\nmap_Kd a.tga\n");
    const auto file = folder.write("a.obj", "mtllib m.mtl\nusemtl t\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n"
                                            "f 1/1 2/2 3/3\n");
    const auto mean = [&](std::uint64_t samples) {
        ImportOptions options;
        options.limits.texture_samples = samples;
        const auto result = import_mesh(file, options);
        REQUIRE(result);
        return result->mesh.reflectance.at(0).x;
    };
    CHECK(mean(1024) == mean(std::uint64_t{1} << 30));
    CHECK(mean(1) == mean(16));  // as few as it gets
    CHECK(mean(16) != mean(1024));
    // Noise of mean 0.35 and deviation 0.3: sixteen samples give it to 0.3 / 4, three times that are sure.
    CHECK(mean(16) == Approx(mean(1024)).margin(0.225));
}

TEST_CASE("equal positions are one, 0 and -0 too", "[mesh][weld]") {
    const std::vector<Vec3> positions{{1, 0, 0}, {0, 0, 0}, {1, -0.0, 0}, {0, 0, 1}, {-0.0, 0, 0}, {1, 0, 0}};
    CHECK(weld_positions(positions) == std::vector<std::uint32_t>{0, 1, 0, 3, 1, 0});
    CHECK(weld_positions({}).empty());
}
