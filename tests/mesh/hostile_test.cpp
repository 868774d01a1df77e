// What a broken or mistaken file leads to, in every format alike: an error that names the file, or a counted repair.
#include <algorithm>

#include "mesh_files.h"
#include "tests/fuzz/mesh_input.h"

using namespace rro;
using namespace rro::test;

namespace {

constexpr std::array<float, 9> corners_of_triangle{0, 0, 0, 1, 0, 0, 0, 1, 0};

std::string gltf_with(const std::string& buffer, const std::string& more = {}) {
    return R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0}],)" + more +
           R"("meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"buffers":[{)" + buffer +
           R"("byteLength":36}],"bufferViews":[{"buffer":0,"byteLength":36}],)"
           R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}]})";
}

const std::string inside =
    R"("uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA",)";

/// One triangle.
struct Sample {
    std::string ending, content;
    bool text = true;
};

std::vector<Sample> samples() {
    const std::string facet =
        "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
    const std::string ply =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
        "property float z\nelement face 1\nproperty list uchar int vertex_index\nend_header\n";
    std::string binary_ply = ply;
    binary_ply.replace(binary_ply.find("ascii"), 5, "binary_little_endian");
    return {{".obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"},
            {".off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"},
            {".stl", "solid a\n" + facet + "endsolid a\n"},
            {".ply", ply + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"},
            {".gltf", gltf_with(inside)},
            {".stl",
             std::string(80, ' ') + raw(std::uint32_t{1}) + std::string(12, '\0') + raw(corners_of_triangle) +
                 std::string(2, '\0'),
             false},
            {".ply", binary_ply + raw(corners_of_triangle) + "\3" + raw(std::array<std::int32_t, 3>{0, 1, 2}), false},
            {".glb", fuzz::glb_of(gltf_with("") + std::string(1, '\0') + raw(corners_of_triangle)), false}};
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
    for (std::size_t at = 0; (at = text.find(from, at)) != text.npos; at += to.size())
        text.replace(at, from.size(), to);
    return text;
}

}  // namespace

TEST_CASE("a file that is cut off anywhere is refused by name, or has lost nothing", "[mesh][bad]") {
    const MeshFolder folder;
    for (const auto& [ending, content, text] : samples()) {
        const auto whole = imported(folder.write("a" + ending, content));
        CHECK(whole.mesh.triangles.size() == 1);
        for (std::size_t size = 0; size < content.size(); ++size) {
            const auto file = folder.write("a" + ending, content.substr(0, size));
            const auto result = import_mesh(file, {});
            INFO(ending << " cut off at " << size);
            if (!result) CHECK(result.error().where.starts_with(file.string()));
            if (!result) continue;
            // Text goes without its last line's end. (An OBJ may end with any number: nothing says where it ends.)
            CHECK((text && content.size() - size <= (ending == ".stl" ? 3 : 1)));
            CHECK(result->mesh.positions == whole.mesh.positions);
        }
    }
}

TEST_CASE("a changed byte gives another mesh or an error that names the file", "[mesh][bad]") {
    const MeshFolder folder;
    for (const auto& [ending, content, text] : samples())
        for (std::size_t i = 0; i < content.size(); ++i) {
            constexpr std::array<int, 3> changes{0x01, 0x10, 0xff};  // the next digit, another letter, no text at all
            std::string changed = content;
            changed[i] = static_cast<char>(changed[i] ^ changes[i % 3]);
            const auto file = folder.write("a" + ending, changed);
            auto result = import_mesh(file, {});
            if (!result && !result.error().where.starts_with(file.string())) FAIL(result.error().where);
            if (result) decide_sides(result->mesh, TwoSided::Auto, true, result->report);
        }
}

TEST_CASE("a file with the ending of another format is refused, with the right one where it shows", "[mesh][bad]") {
    const MeshFolder folder;
    for (const auto& [ending, content, text] : samples())
        for (const std::string other : {".obj", ".off", ".stl", ".ply", ".gltf", ".glb"}) {
            if (other == ending || (ending.starts_with(".gl") && other.starts_with(".gl"))) continue;
            const auto file = folder.write("a" + other, content);
            const Error error = refused(file);
            INFO(ending << " named " << other);
            CHECK(error.where.starts_with(file.string()));
            const bool has_a_beginning = ending != ".obj" && (ending != ".stl" || text);
            CHECK((error.hint.find(" " + ending + " file") != error.hint.npos) == has_a_beginning);
        }
}

TEST_CASE("byte order marks and other line ends change nothing", "[mesh][bad]") {
    const MeshFolder folder;
    for (const auto& [ending, content, text] : samples()) {
        if (!text) continue;
        INFO(ending);
        const Mesh plain = imported(folder.write("a" + ending, content)).mesh;
        for (const std::string& changed :
             {"\xef\xbb\xbf" + content, replaced(content, "\n", "\r\n"), replaced(content, "\n", "\r"),
              "\xef\xbb\xbf" + replaced(content, "\n", "\r\n")})
            CHECK(imported(folder.write("a" + ending, changed)).mesh.positions == plain.positions);
        CHECK(refused(folder.write("a" + ending, "\xef\xbb\xbf")).where.find("a" + ending) != std::string::npos);
    }
    folder.write("m.mtl", "\xef\xbb\xbfnewmtl a\r\nKd 0.25 0.25 0.25\r\n");
    const Mesh mesh = imported(folder.write("a.obj", "mtllib m.mtl\r\nusemtl a\r\n" + samples()[0].content)).mesh;
    CHECK(mesh.materials.at(0).reflectance.x == 0.25);
}

TEST_CASE("decimal commas are refused where they stand", "[mesh][bad]") {
    const MeshFolder folder;
    for (const auto& [ending, content, text] : samples()) {
        if (!text || ending == ".gltf") continue;
        const Error error = refused(folder.write("a" + ending, replaced(content, "0 1 0", "0 1,5 0")));
        CHECK(error.message.find("'1,5'") != std::string::npos);
        CHECK(error.where.find("a" + ending + ":") != std::string::npos);
    }
}

TEST_CASE("no number, and numbers beyond all areas, are dropped with a count or refused", "[mesh][bad]") {
    const MeshFolder folder;
    for (const auto& [ending, content, text] : samples()) {
        INFO(ending);
        for (const float value :
             {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), 1e30f}) {
            const std::string word = value == 1e30f ? "1e30" : std::isinf(value) ? "inf" : "nan";
            std::string changed = replaced(content, "1 0 0", word + " 0 0");
            if (!text)
                changed = replaced(content, raw(1.0f) + raw(0.0f) + raw(0.0f), raw(value) + raw(0.0f) + raw(0.0f));
            if (ending == ".gltf") continue;  // its numbers are those of the .glb
            REQUIRE(changed != content);
            const Error error = refused(folder.write("a" + ending, changed));
            CHECK(error.message.find(value == 1e30f ? "1e+30 m" : "1 with corners that are not finite") !=
                  std::string::npos);
        }
    }
}

TEST_CASE("counts that a file only declares take neither memory nor time", "[mesh][bad][limits]") {
    const MeshFolder folder;
    const auto all = samples();
    CHECK(refused(folder.write("a.off", replaced(all[1].content, "3 1 0\n0", "4000000000 4000000000 0\n0")))
              .where.find("a.off:") != std::string::npos);
    CHECK(refused(folder.write("a.off", replaced(all[1].content, "3 0 1 2", "4000000000 0 1 2")))
              .where.ends_with("a.off:6"));
    CHECK(refused(folder.write("a.ply", replaced(all[3].content, "face 1", "face 4000000000")))
              .message.find("end of the file") != std::string::npos);
    CHECK(
        refused(folder.write("b.ply", replaced(all[6].content, "vertex 3", "vertex 4000000000"))).where.find("b.ply") !=
        std::string::npos);
    std::string stl = all[5].content;
    stl.replace(80, 4, 4, '\xff');
    CHECK(refused(folder.write("a.stl", stl)).message.find("4294967295 triangles") != std::string::npos);
    CHECK(refused(folder.write("a.gltf", replaced(all[4].content, "\"count\":3", "\"count\":4000000000")))
              .message.size() > 0);
}

TEST_CASE("what a mesh has twice, or not at all, is counted", "[mesh][report]") {
    const MeshFolder folder;
    // A square of two triangles with corners of their own, one of them twice; a fin on its diagonal; a bow tie.
    const auto [mesh, report, hash, files] =
        imported(folder.write("a.obj",
                              "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\n"
                              "f 1 2 3\nf 4 5 6\nf 6 5 4\nf 1 3 7\nf 1 1 2 3\nf 7\n"));
    CHECK(report.welded_vertices == 2);
    CHECK(report.dropped_degenerate == 1);
    CHECK(report.ignored_faces == 1);
    CHECK(report.reflectance_assumed == 1);
    CHECK(report.extent == Vec3{1, 1, 1});
    ImportReport sides;
    Mesh copy = mesh;
    decide_sides(copy, TwoSided::Auto, false, sides);
    CHECK(sides.non_manifold_edges == 1);  // the diagonal; the square's own edges have two triangles each
    CHECK(sides.open_edges == 4);          // of the fin, and of the first triangle: its second copy is no neighbour
    CHECK(sides.duplicate_triangles == 2);  // 6 5 4, and what is left of 1 1 2 3
    CHECK(copy.source_triangle == std::vector<std::uint32_t>{0, 1, 3});
}

TEST_CASE("a self-touching polygon keeps its area, or says what it lost", "[mesh][report]") {
    const MeshFolder folder;
    // A square with a square hole, as one polygon that runs in and out along the same edge: 16 - 4.
    const auto ring = imported(folder.write("a.obj",
                                            "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nv 1 1 0\nv 1 3 0\nv 3 3 0\nv 3 1 0\n"
                                            "f 1 2 3 4 1 5 6 7 8 5\n"));
    CHECK(total_area(ring.mesh) == Approx(12));
    CHECK(ring.report.polygons_ear_clipped == 1);
    const auto bow = imported(folder.write("b.obj", "v 0 0 0\nv 1 1 0\nv 1 0 0\nv 0 1 0\nf 1 2 3 4\n"));
    CHECK(bow.mesh.triangles.size() + bow.report.dropped_degenerate == 2);
}

TEST_CASE("what a format says and nobody reads is a warning", "[mesh][report]") {
    const MeshFolder folder;
    const auto all = samples();
    const auto obj = imported(folder.write("a.obj", all[0].content + "l 1 2\np 1\nsurf 0 1 0 1 1 2 3\ncurv 0 1 1 2\n"));
    CHECK(warns(obj.report, "points and lines are ignored"));
    CHECK(warns(obj.report, "2 statements of another kind are ignored, the first is 'surf' in line 7"));
    const auto unknown = imported(folder.write("b.obj", "usemtl a\n" + all[0].content + "usemtl b\nf 1 2 3\n"));
    CHECK(warns(unknown.report, "b.obj:1: no MTL describes material 'a' and 1 more"));
    const std::string strips = "element tristrips 1\nproperty list int int vertex_indices\nend_header";
    CHECK(warns(imported(folder.write("a.ply", replaced(all[3].content, "end_header", strips) + "3 0 1 2\n")).report,
                "triangle strips are ignored"));
    std::string stl = all[5].content;
    stl.replace(0, 6, "COLOR=");
    CHECK(warns(imported(folder.write("a.stl", stl)).report, "colours are ignored"));
}

TEST_CASE("glTF: extensions, skins, morph targets, animations and lost textures are warnings", "[mesh][gltf][report]") {
    const MeshFolder folder;
    const std::string more =
        R"("extensionsUsed":["KHR_materials_transmission","KHR_materials_pbrSpecularGlossiness",)"
        R"("KHR_materials_emissive_strength","KHR_lights_punctual"],)"
        R"("animations":[{"channels":[],"samplers":[]}],"skins":[{"joints":[0],"inverseBindMatrices":0}],)"
        R"("images":[{"uri":"gone.png"}],"textures":[{"source":0}],)"
        R"("materials":[{"name":"m","pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}],)";
    std::string text = gltf_with(inside, more);
    text = replaced(text, R"({"mesh":0})", R"({"mesh":0,"skin":0})");
    text = replaced(text, R"("POSITION":0})", R"("POSITION":0},"material":0,"targets":[{"POSITION":0}])");
    const auto result = imported(folder.write("a.gltf", text));
    CHECK(warns(result.report, "'KHR_materials_transmission' is ignored"));
    CHECK(warns(result.report, "'KHR_materials_pbrSpecularGlossiness' is ignored"));
    CHECK_FALSE(warns(result.report, "emissive_strength"));
    CHECK(warns(result.report, "lights are ignored"));
    CHECK(warns(result.report, "animations are ignored"));
    CHECK(warns(result.report, "skins are ignored"));
    CHECK(warns(result.report, "morph targets are ignored"));
    CHECK(warns(result.report, "'gone.png' cannot be read"));
    CHECK(result.report.textures_not_read == 1);
}
