#include "format/sha256.h"
#include "mesh_files.h"
#include "tests/support/image_files.h"

using namespace rro;
using namespace rro::test;

TEST_CASE("numbers follow the file's faces, and dropped triangles keep theirs", "[mesh][obj]") {
    const MeshFolder folder;
    const auto file = folder.write("a.obj",
                                   "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 5 5 nan\nv 9 9 9\n"
                                   "g first\nf 1 2 3 4\n"   // 0, 1
                                   "g second\nf 1 1 2\n"    // 2: degenerate
                                   "f 1 2 5\n"              // 3: not finite
                                   "g first\nf -6 -5 -4\n"  // 4
                                   "f 1 2\nf 2 3 4\n");     // no number; 5
    const auto [mesh, report, hash, files] = imported(file);
    CHECK(mesh.source_triangle == std::vector<std::uint32_t>{0, 1, 4, 5});
    CHECK(mesh.source_triangles == 6);
    CHECK(report.source_triangles == 6);
    CHECK(report.dropped_degenerate == 1);
    CHECK(report.dropped_not_finite == 1);
    CHECK(report.polygons_triangulated == 1);
    CHECK(report.polygons_ear_clipped == 0);
    CHECK(mesh.positions.size() == 4);  // unused and unusable ones are gone
    CHECK(corners(mesh, 0) == TriangleCorners{Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{1, 1, 0}});
    CHECK(corners(mesh, 1) == TriangleCorners{Vec3{0, 0, 0}, Vec3{1, 1, 0}, Vec3{0, 1, 0}});
    CHECK(report.ignored_faces == 1);
    CHECK(report.welded_vertices == 0);
    Mesh decided = mesh;
    ImportReport sides;
    decide_sides(decided, TwoSided::Auto, false, sides);
    CHECK(sides.duplicate_triangles == 1);  // number 4 is number 0 again
    CHECK(decided.source_triangle == std::vector<std::uint32_t>{0, 1, 5});
}

TEST_CASE("faces stay in the order of the file across groups and materials", "[mesh][obj]") {
    const MeshFolder folder;
    std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    for (int i = 0; i < 12; ++i)
        text += "v 0 0 " + std::to_string(i + 1) + "\n" +
                (i % 3 == 0   ? "g a\n"
                 : i % 3 == 1 ? "o b\n"
                              : "g\n") +
                "usemtl m" + std::to_string(i % 2) + "\nf 1 2 " + std::to_string(i + 4) + "\n";
    const Mesh mesh = imported(folder.write("a.obj", text)).mesh;
    REQUIRE(mesh.triangles.size() == 12);
    for (std::size_t i = 0; i < 12; ++i) {
        CHECK(corners(mesh, i)[2].z == static_cast<double>(i + 1));
        CHECK(mesh.materials[mesh.material[i]].name == "m" + std::to_string(i % 2));
    }
}

TEST_CASE("a polygon of more than 255 corners keeps them all", "[mesh][obj]") {
    const MeshFolder folder;
    std::string vertices, face = "f";
    for (int i = 0; i < 300; ++i) {
        const double angle = 2 * 3.14159265358979323846 * i / 300;
        vertices += "v " + std::to_string(std::cos(angle)) + " " + std::to_string(std::sin(angle)) + " 0\n";
        face += " " + std::to_string(i + 1);
    }
    const auto result = imported(folder.write("a.obj", vertices + face + "\n"));
    CHECK(result.report.source_triangles == 298);
    CHECK(total_area(result.mesh) == Approx(3.14136).epsilon(1e-4));  // 150 sin(2 pi / 300), six digits in the file
}

TEST_CASE("byte order mark, CRLF, continued lines, comments and a missing last line end are read", "[mesh][obj]") {
    const MeshFolder folder;
    const auto result = imported(folder.write("a.obj",
                                              "\xef\xbb\xbf# made on C:\\\r\nv 0 0 0 # origin\r\nv +1.5e0 0 0\r\nv 0 "
                                              "\\\r\n 1 \\\r\n0\r\nf 1//1 2//2 \\\r\n3"));
    CHECK(result.mesh.triangles.size() == 1);
    CHECK(total_area(result.mesh) == Approx(0.75));
}

TEST_CASE("units and the up axis", "[mesh][obj]") {
    const MeshFolder folder;
    const auto file = folder.write("a.obj", "v 1 2 3\nv 2 2 3\nv 1 3 3\nf 1 2 3\n");
    ImportOptions options;
    options.unit = 0.01;
    options.z_up = true;
    const Mesh mesh = imported(file, options).mesh;
    CHECK(corners(mesh, 0)[0] == Vec3{1, 3, -2} * 0.01);
    CHECK(total_area_vector(mesh).y > 0);  // the front faced +z, which is up
}

TEST_CASE("positions keep double precision", "[mesh][obj]") {
    const MeshFolder folder;
    const Mesh mesh = imported(folder.write("a.obj", "v 0.1234567890123456 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")).mesh;
    CHECK(mesh.positions[0].x == 0.1234567890123456);
}

TEST_CASE("materials come from the MTL: Kd is reflectance, Ke radiance, 0.95 the most", "[mesh][obj]") {
    const MeshFolder folder;
    folder.write("lib/my colours.mtl",
                 "newmtl Grey\nKd 0.3\nnewmtl grey\nKd 1 0.5 0.25\nKe 2 1 0\nd 0.5\nnewmtl bare\nNs 10\nnewmtl "
                 "unused\nKd 1 1 1\n");
    const auto file = folder.write("a.obj",
                                   "mtllib lib/my colours.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n"
                                   "f 1 2 3\nusemtl grey\nf 1 2 3\nusemtl Grey  \nf 1 2 3\nusemtl bare\nf 1 2 3\n"
                                   "usemtl gone\nf 1 2 3\nusemtl grey\nf 1 2 3\n");
    ImportOptions options;
    options.reflectance = Vec3{0.7, 0.8, 0.9};
    const auto [mesh, report, hash, files] = imported(file, options);
    REQUIRE(mesh.materials.size() == 5);
    CHECK(mesh.material == std::vector<std::uint32_t>{0, 1, 2, 3, 4, 1});
    CHECK(mesh.materials[0].name == "default");
    CHECK(mesh.materials[0].reflectance == *options.reflectance);
    CHECK(mesh.materials[1].name == "grey");
    CHECK(mesh.materials[1].reflectance == Vec3{0.95, 0.5, 0.25});
    CHECK(mesh.materials[1].exitance.x == Approx(2 * 3.14159265358979));
    CHECK(mesh.materials[1].exitance.z == 0);
    CHECK(mesh.materials[2].reflectance == Vec3{0.3, 0.3, 0.3});
    CHECK(mesh.materials[3].reflectance == *options.reflectance);  // described, but without a colour
    CHECK(mesh.materials[4].name == "gone");
    CHECK(mesh.materials[4].reflectance == *options.reflectance);
    CHECK(report.reflectance_clamped == 1);
    CHECK(warns(report, "gone"));
    CHECK(warns(report, "opaque"));
    CHECK(mesh.reflectance.empty());
    CHECK(files == std::vector<std::filesystem::path>{file, folder.path() / "lib/my colours.mtl"});
}

TEST_CASE("a missing MTL is a warning, its materials are grey and keep their names", "[mesh][obj]") {
    const MeshFolder folder;
    const auto [mesh, report, hash, files] =
        imported(folder.write("a.obj", "mtllib gone.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a b\nf 1 2 3\n"));
    CHECK(mesh.materials.at(0).name == "a b");
    CHECK(mesh.materials[0].reflectance == Vec3{0.5, 0.5, 0.5});
    CHECK(mesh.materials[0].exitance == Vec3{});
    CHECK(warns(report, "gone.mtl"));
    CHECK(files.size() == 1);
}

TEST_CASE("the hash covers the mesh, its MTL and its textures in order of use", "[mesh][obj]") {
    const MeshFolder folder;
    const std::string obj = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl t\nf 1 2 3\n",
                      mtl = "newmtl t\nmap_Kd t.png\n";
    folder.write("m.mtl", mtl);
    folder.write("t.png", small_png());
    const std::string all = obj + mtl + small_png();
    CHECK(imported(folder.write("a.obj", obj)).sha256 == sha256_hex(std::as_bytes(std::span(all))));
}

TEST_CASE("a texture gives each triangle its mean", "[mesh][obj][texture]") {
    const MeshFolder folder;
    folder.write("t.png", small_png());  // red, green / blue, white
    folder.write("m.mtl", "newmtl t\nKd 0.5 0.5 0.5\nmap_Kd C:\\Users\\somebody\\t.png\n");
    const auto file = folder.write("a.obj",
                                   "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
                                   "vt 0.1 0.9\nvt 0.4 0.9\nvt 0.1 0.6\n"  // in the red pixel: v runs up
                                   "vt 1.6 1.1\nvt 1.9 1.1\nvt 1.6 1.4\n"  // in the white one, repeated
                                   "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
                                   "usemtl t\nf 1/1 2/2 3/3\nf 1/4 2/5 3/6\nf 1/7 2/8 3/9 4/10\nf 1 2 3\n"
                                   "usemtl plain\nf 1 2 3\n");
    const auto [mesh, report, hash, files] = imported(file);
    REQUIRE(mesh.reflectance.size() == 6);
    CHECK(to_double(mesh.reflectance[0]) == Vec3{0.5, 0, 0});
    CHECK(to_double(mesh.reflectance[1]) == Vec3{0.5, 0.5, 0.5});
    // Lower right half of the square: half of it white, a quarter red and blue each have 1/4: exact by symmetry of the
    // parts to within the pixels' borders (8 % of 16 parts).
    const Vec3 halves = 0.5 * (to_double(mesh.reflectance[2]) + to_double(mesh.reflectance[3]));
    for (int c = 0; c < 3; ++c) CHECK(halves[c] == Approx(0.25).margin(0.02));
    for (int c = 0; c < 3; ++c) CHECK(mesh.reflectance[4].x == Approx(0.25));  // no coordinates: the image's mean
    CHECK(to_double(mesh.reflectance[5]) == Vec3{0.5, 0.5, 0.5});
    CHECK(mesh.materials[0].textured);
    CHECK_FALSE(mesh.materials[1].textured);
    Vec3 mean;  // the five triangles of the material have equal areas
    for (std::size_t t = 0; t < 5; ++t) mean += to_double(mesh.reflectance[t]) / 5;
    CHECK(length(mesh.materials[0].reflectance - mean) < 1e-6);
    CHECK(files.size() == 3);
}

TEST_CASE("8-bit textures are sRGB, and clamping counts the material once", "[mesh][obj][texture]") {
    const MeshFolder folder;
    folder.write("t.tga", tga_file(2, 1, {{188, 188, 188}, {255, 255, 255}}));
    folder.write("m.mtl", "newmtl t\nmap_Kd t.tga\n");
    const auto [mesh, report, hash, files] = imported(
        folder.write("a.obj",
                     "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.1 0.1\nvt 0.4 0.1\nvt 0.1 0.4\n"
                     "vt 0.6 0.1\nvt 0.9 0.1\nvt 0.9 0.4\nusemtl t\nf 1/1 2/2 3/3\nf 1/4 2/5 3/6\nf 1/4 2/5 3/6\n"));
    CHECK(mesh.reflectance.at(0).x == Approx(0.5029).epsilon(1e-3));  // ((188/255 + 0.055) / 1.055)^2.4
    CHECK(mesh.reflectance[1].y == Approx(0.95));
    CHECK(report.reflectance_clamped == 1);
}

TEST_CASE("a texture that cannot be read is a warning", "[mesh][obj][texture]") {
    const MeshFolder folder;
    folder.write("broken.png", small_png().substr(0, 40));
    folder.write("old.bmp", "BM......");
    folder.write("m.mtl",
                 "newmtl a\nKd 0.2 0.2 0.2\nmap_Kd gone.png\nnewmtl b\nKd 0.3 0.3 0.3\nmap_Kd broken.png\n"
                 "newmtl c\nmap_Kd old.bmp\n");
    const auto [mesh, report, hash, files] = imported(
        folder.write("a.obj", "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\nusemtl b\nf 1 2 3\nusemtl c\nf 1 2 3\n"));
    CHECK(mesh.materials.at(0).reflectance == Vec3{0.2, 0.2, 0.2});
    CHECK(mesh.materials.at(1).reflectance == Vec3{0.3, 0.3, 0.3});
    CHECK_FALSE(mesh.materials[0].textured);
    CHECK(mesh.reflectance.empty());
    CHECK(warns(report, "'gone.png' is not read (no such file): Kd alone counts"));
    CHECK(warns(report, "'broken.png' is not read (it is a broken PNG (the file is cut off))"));
    CHECK(warns(report, "'old.bmp' is not read (it is no PNG, JPEG or TGA)"));
    CHECK(report.textures_not_read == 3);
}

TEST_CASE("of several names behind mtllib the first that exists counts, and a library may come late", "[mesh][obj]") {
    const MeshFolder folder;
    folder.write("m.mtl", "newmtl a\nKd 0.1 0.1 0.1\n");
    const auto [mesh, report, hash, files] = imported(
        folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\nmtllib gone.mtl lost.mtl m.mtl\n"));
    CHECK(mesh.materials.at(0).reflectance == Vec3{0.1, 0.1, 0.1});
    CHECK(warns(report, "'lost.mtl' is missing"));
    CHECK(files.size() == 2);
}
