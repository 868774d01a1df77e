// PLY, OFF and STL.
#include <algorithm>
#include <bit>

#include "mesh_files.h"

using namespace rro;
using namespace rro::test;

namespace {

template <class Value>
std::string bytes_of(Value value, bool big) {
    std::string bytes = raw(value);
    if (big) std::reverse(bytes.begin(), bytes.end());
    return bytes;
}

/// A quad and a triangle of the unit square; faces before vertices, unknown things in between.
std::string binary_ply(bool big) {
    std::string ply =
        std::string("ply\nformat binary_") + (big ? "big" : "little") +
        "_endian 1.0\ncomment x\nelement face 2\nproperty uchar flags\nproperty list ushort int vertex_index\n"
        "property list uchar double weights\nelement thing 2\nproperty short a\n"
        "element vertex 4\nproperty double z\nproperty float x\nproperty uint8 pad\nproperty float y\nend_header\n";
    const auto face = [&](std::initializer_list<std::int32_t> corners) {
        ply += bytes_of(std::uint8_t{9}, big) + bytes_of(static_cast<std::uint16_t>(corners.size()), big);
        for (const std::int32_t corner : corners) ply += bytes_of(corner, big);
        ply += bytes_of(std::uint8_t{1}, big) + bytes_of(0.5, big);
    };
    face({0, 1, 2, 3});
    face({0, 1, 2});
    ply += bytes_of(std::int16_t{1}, big) + bytes_of(std::int16_t{2}, big);
    for (const auto& [x, y] : {std::pair{0.f, 0.f}, {1.f, 0.f}, {1.f, 1.f}, {0.f, 1.f}})
        ply += bytes_of(0.1, big) + bytes_of(x, big) + bytes_of(std::uint8_t{7}, big) + bytes_of(y, big);
    return ply;
}

std::string binary_stl(const std::vector<std::array<float, 9>>& triangles, std::uint32_t count) {
    std::string stl = "solid but binary";
    stl.resize(80, ' ');
    stl += raw(count);
    for (const auto& t : triangles) stl += std::string(12, '\0') + raw(t) + std::string(2, '\0');
    return stl;
}

const std::string text_ply =
    "ply\r\nformat ascii 1.0\r\nelement vertex 4\r\nproperty float x\r\nproperty float y\r\nproperty float z\r\n"
    "element face 2\r\nproperty list uchar uint vertex_indices\r\nend_header\r\n"
    "0 0 0.1\r\n1 0 0.1\r\n1 1 0.1\r\n0 1 0.1\r\n4 0 1 2 3\r\n3 0 1 2\r\n";

}  // namespace

TEST_CASE("PLY: text and both byte orders give the same mesh", "[mesh][ply]") {
    const MeshFolder folder;
    for (const std::string& content : {text_ply, binary_ply(false), binary_ply(true)}) {
        const auto [mesh, report, hash, files] = imported(folder.write("a.ply", content));
        REQUIRE(mesh.triangles.size() == 3);
        CHECK(corners(mesh, 1) == TriangleCorners{Vec3{0, 0, 0.1}, Vec3{1, 1, 0.1}, Vec3{0, 1, 0.1}});
        CHECK(mesh.positions.size() == 4);
        CHECK(mesh.materials.at(0).name == "default");
        CHECK(mesh.materials[0].reflectance == Vec3{0.5, 0.5, 0.5});
        CHECK(report.warnings.empty());
    }
}

TEST_CASE("PLY: 8-bit colours are sRGB reflectances", "[mesh][ply]") {
    const MeshFolder folder;
    const auto [mesh, report, hash, files] = imported(
        folder.write("a.ply",
                     "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
                     "property uchar red\nproperty uchar green\nproperty uchar blue\n"
                     "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
                     "0 0 0 188 0 0\n1 0 0 188 255 0\n0 1 0 188 0 0\n3 0 1 2\n"));
    REQUIRE(mesh.reflectance.size() == 1);
    CHECK(mesh.reflectance[0].x == Approx(0.5029).epsilon(1e-3));
    CHECK(mesh.reflectance[0].y == Approx(1.0 / 3));
    CHECK(mesh.materials[0].textured);
}

TEST_CASE("PLY: broken files are refused where they break", "[mesh][ply]") {
    const MeshFolder folder;
    const auto with = [&](std::string from, const std::string& to) {
        std::string text = text_ply;
        text.replace(text.find(from), from.size(), to);
        return refused(folder.write("a.ply", text));
    };
    CHECK(with("3 0 1 2\r\n", "3 0 1 4\r\n").where.ends_with("a.ply:15"));
    CHECK(with("1 1 0.1", "1 1,5 0.1").where.ends_with("a.ply:12"));
    CHECK(with("3 0 1 2\r\n", "").message.find("end of the file") != std::string::npos);
    CHECK(with("3 0 1 2\r\n", "3 0 1 -2\r\n").message.find("-2") != std::string::npos);
    CHECK(with("ascii", "asci").where.ends_with("a.ply:2"));
    CHECK(with("property float y", "property floot y").where.ends_with("a.ply:5"));
    CHECK(with("element vertex 4", "element vertex 4000000000").message.size() > 0);
    const std::string binary = binary_ply(false);
    CHECK(refused(folder.write("b.ply", binary.substr(0, binary.size() - 1))).where.find("byte") != std::string::npos);
}

TEST_CASE("PLY: a whole number beyond every type is refused, infinity too", "[mesh][ply]") {
    const MeshFolder folder;
    for (const char* index : {"inf", "-inf", "1e300", "4294967296", "nan"}) {
        std::string text = text_ply;
        text.replace(text.find("3 0 1 2"), 7, std::string("3 0 1 ") + index);
        const Error error = refused(folder.write("a.ply", text));
        CHECK(error.where.ends_with("a.ply:15"));
        CHECK(error.message.find("whole number") != std::string::npos);
    }
}

TEST_CASE("the mean of clamped colours is not above what they are clamped to", "[mesh][off]") {
    const MeshFolder folder;
    // Areas of 0.1 to 0.7 m^2 so that the sums round.
    const Mesh mesh = imported(folder.write("a.off", "OFF\n5 3 0\n0 0 0\n1 0 0\n0.3 0.2 0\n0.1 1.1 0\n0.7 1.3 0.1\n"
                                                     "3 0 1 2 1.0 1.0 1.0\n3 0 2 3 1.0 1.0 1.0\n3 1 4 3 1.0 1.0 1.0\n"))
                          .mesh;
    for (int c = 0; c < 3; ++c) CHECK(mesh.materials.at(0).reflectance[c] <= 0.95);
}

TEST_CASE("OFF: comments, blank lines, counts on the first line, colours", "[mesh][off]") {
    const MeshFolder folder;
    CHECK(imported(
              folder.write("a.off", "# c\nOFF\n\n4 2 0 # counts\n0 0 0\n1 0 0\n\n1 1 0\n0 1 0\n4 0 1 2 3\n3 0 1 2\n"))
              .mesh.triangles.size() == 3);
    CHECK(imported(folder.write("a.off", "NOFF 3 1 0\n0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 1\n3 0 1 2\n"))
              .mesh.reflectance.empty());
    const Mesh vertex =
        imported(
            folder.write("a.off", "COFF\n3 1 0\n0 0 0 188 0 0 255\n1 0 0 188 0 0 255\n0 1 0 188 0 0 255\n3 0 1 2\n"))
            .mesh;
    CHECK(vertex.reflectance.at(0).x == Approx(0.5029).epsilon(1e-3));
    const Mesh face = imported(folder.write("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 0.25 0.5 0.75\n")).mesh;
    CHECK(to_double(face.reflectance.at(0)) == Vec3{0.25, 0.5, 0.75});
}

TEST_CASE("OFF: broken files are refused where they break", "[mesh][off]") {
    const MeshFolder folder;
    const auto off = [&](const std::string& text) { return refused(folder.write("a.off", text)); };
    CHECK(off("4OFF\n3 1 0\n").where.ends_with("a.off:1"));
    CHECK(off("OFF\n3 x 0\n").where.ends_with("a.off:2"));
    CHECK(off("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n").where.ends_with("a.off:6"));
    CHECK(off("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1\n").where.ends_with("a.off:6"));
    CHECK(off("OFF\n3 1 0\n0 0 0\n1 0 0\n").message.find("expected 3") != std::string::npos);
    CHECK(off("OFF\n3 1 0\n0 0 0\n1,0 0 0\n0 1 0\n3 0 1 2\n").where.ends_with("a.off:4"));
    CHECK(off("OFF BINARY\n").hint.size() > 0);
}

TEST_CASE("STL: text and binary, told apart by size", "[mesh][stl]") {
    const MeshFolder folder;
    const std::string facet =
        "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
    const Mesh text =
        imported(folder.write("a.stl", "solid my facet\n" + facet + facet + "endsolid my facet\nsolid\nendsolid\n"))
            .mesh;
    CHECK(text.triangles.size() == 2);
    CHECK(text.positions.size() == 3);  // equal positions are one
    const std::vector<std::array<float, 9>> triangles{
        {0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 0, 0, 0, 0, 0, 0, 1, 0}, {0, 0, 1, 1, 0, 1, 0, 1, 1}};
    const auto binary = imported(folder.write("b.stl", binary_stl(triangles, 3)));
    CHECK(binary.mesh.source_triangle == std::vector<std::uint32_t>{0, 2});
    CHECK(binary.report.dropped_degenerate == 1);
    CHECK(refused(folder.write("c.stl", "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 zero\n"))
              .where.ends_with("c.stl:4"));
    CHECK(refused(folder.write("c.stl", "solid x\n" + facet)).message.find("endsolid") != std::string::npos);
    std::string cut = binary_stl(triangles, 4);
    cut[0] = 'x';
    CHECK(refused(folder.write("c.stl", cut)).message.find("284") != std::string::npos);  // 84 + 4 * 50
    CHECK(refused(folder.write("c.stl", "junk")).message.find("84") != std::string::npos);
    CHECK(refused(folder.write("c.stl", binary_stl({}, 0))).message.find("no faces") != std::string::npos);
}
