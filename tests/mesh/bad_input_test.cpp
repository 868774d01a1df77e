#include "mesh_files.h"

using namespace rro;
using namespace rro::test;

namespace {

constexpr const char* vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

}  // namespace

TEST_CASE("what is no mesh file is refused by name", "[mesh][bad]") {
    const MeshFolder folder;
    const std::filesystem::path missing = folder.path() / "gone.obj";
    CHECK(refused(missing).where == missing.string());
    std::filesystem::create_directory(folder.path() / "folder.obj");
    CHECK(refused(folder.path() / "folder.obj").message.find("folder") != std::string::npos);
    for (const char* name : {"a.obj", "a.ply", "a.stl", "a.off", "a.gltf", "a.glb"})
        CHECK(refused(folder.write(name, "")).message.find("empty") != std::string::npos);
    CHECK(refused(folder.write("a.fbx", "x")).message.find(".obj") != std::string::npos);
    CHECK(refused(folder.write("noending", "x")).message.find(".obj") != std::string::npos);
    CHECK(imported(folder.write("UPPER.OBJ", std::string(vertices) + "f 1 2 3\n")).mesh.triangles.size() == 1);
}

TEST_CASE("a broken OBJ is refused with its line", "[mesh][bad]") {
    const MeshFolder folder;
    const auto obj = [&](const std::string& rest) { return refused(folder.write("a.obj", vertices + rest)); };
    CHECK(obj("f 1 2 4\n").where.ends_with("a.obj:4"));
    CHECK(obj("\nf 1 2 0\n").where.ends_with("a.obj:5"));
    CHECK(obj("f 1 2 -4\n").where.ends_with("a.obj:4"));
    CHECK(obj("f 1 2 3,5\n").where.ends_with("a.obj:4"));
    CHECK(obj("f 1/2/3/4 2 3\n").where.ends_with("a.obj:4"));
    CHECK(obj("f 1 2 99999999999999999999\n").where.ends_with("a.obj:4"));
    CHECK(obj("f 1/7 2/7 3/7\n").message.find("7") != std::string::npos);
    CHECK(obj("v 1,5 0 0\nf 1 2 3\n").where.ends_with("a.obj:4"));
    CHECK(obj("v 1 0\nf 1 2 3\n").where.ends_with("a.obj:4"));
    CHECK(obj("v 1 0 0x\nf 1 2 3\n").where.ends_with("a.obj:4"));
    CHECK(obj("").message.find("no faces") != std::string::npos);
    CHECK(obj("f 1 1 2\nf 1 2 2\n").message.find("2 degenerate") != std::string::npos);
    CHECK(refused(folder.write("a.obj", "just some text\n")).message.find("no faces") != std::string::npos);
    CHECK(refused(folder.write("a.obj", std::string("v 0 0\0 0\n", 9))).where.ends_with("a.obj:1"));
}

TEST_CASE("a broken MTL is refused with its own line", "[mesh][bad]") {
    const MeshFolder folder;
    const auto mtl = [&](const std::string& text) {
        folder.write("m.mtl", text);
        return refused(folder.write("a.obj", std::string("mtllib m.mtl\n") + vertices + "f 1 2 3\n"));
    };
    CHECK(mtl("newmtl a\nKd 0,5 0,5 0,5\n").where.ends_with("m.mtl:2"));
    CHECK(mtl("newmtl a\n\nKe -1 0 0\n").where.ends_with("m.mtl:3"));
    CHECK(mtl("newmtl a\nKd nan 0 0\n").where.ends_with("m.mtl:2"));
    CHECK(mtl("newmtl a\nKd 0.1 0.2\n").where.ends_with("m.mtl:2"));
}

TEST_CASE("slivers and straight triangles are degenerate, thin ones are not", "[mesh][bad]") {
    const MeshFolder folder;
    const auto result = imported(folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 1 1e-9 0\nf 1 2 3\nf 1 3 4\n"));
    CHECK(result.report.dropped_degenerate == 1);
    CHECK(result.mesh.source_triangle == std::vector<std::uint32_t>{1});
}

TEST_CASE("coordinates that areas cannot follow are refused, others are not", "[mesh][bad]") {
    const MeshFolder folder;
    const auto square = [&](const std::string& size, const std::string& offset) {
        return folder.write("a.obj", "v " + offset + " 0 0\nv " + offset + " " + size + " 0\nv " + offset + " 0 " +
                                         size + "\nf 1 2 3\n");
    };
    CHECK(refused(square("1e30", "0")).message.find("1e+30") != std::string::npos);
    CHECK(refused(square("1e-30", "0")).message.find("extends over") != std::string::npos);
    CHECK(refused(square("1", "1e30")).message.find("1e+30") != std::string::npos);
    CHECK(refused(square("1e200", "0")).hint.size() > 0);
    CHECK(total_area(imported(square("1e12", "0")).mesh) == Approx(0.5e24));
    CHECK(total_area(imported(square("1", "1e6")).mesh) == Approx(0.5));
    // A stray coordinate that no kept triangle uses does not matter.
    const auto stray = folder.write("b.obj", std::string(vertices) + "v 1e30 0 0\nv nan 0 0\nf 1 2 3\nf 1 4 5\n");
    CHECK(imported(stray).report.dropped_not_finite == 1);
}
