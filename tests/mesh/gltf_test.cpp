#include "mesh_files.h"

using namespace rro;
using namespace rro::test;

namespace {

/// Float positions of the unit square's corners, then 16-bit indices 0 1 2 0 2 3, then texture coordinates.
std::string square_bytes() {
    std::string bytes;
    for (const float x : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 1.f, 1.f, 0.f, 0.f, 1.f, 0.f}) bytes += raw(x);
    for (const std::uint16_t i : {0, 1, 2, 0, 2, 3}) bytes += raw(i);
    for (const float t : {0.1f, 0.1f, 0.4f, 0.1f, 0.4f, 0.4f, 0.1f, 0.4f}) bytes += raw(t);
    return bytes;  // 48 + 12 + 32
}

/// A document over square_bytes() in square.bin; accessors 0 positions, 1 indices, 2 texture coordinates.
std::string document(const std::string& rest, const std::string& uri = R"("uri": "square.bin", )") {
    return R"({"asset": {"version": "2.0"}, "buffers": [{)" + uri + R"("byteLength": 92}],
        "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 12},
                        {"buffer": 0, "byteOffset": 60, "byteLength": 32}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
                      {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"},
                      {"bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC2"}],)" +
           rest + "}";
}

const std::string one_mesh = R"("meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],)";

std::string glb(std::string json, std::string bin) {
    json.resize((json.size() + 3) / 4 * 4, ' ');
    bin.resize((bin.size() + 3) / 4 * 4, '\0');
    const auto u32 = [](std::size_t v) { return raw(static_cast<std::uint32_t>(v)); };
    return "glTF" + u32(2) + u32(12 + 8 + json.size() + 8 + bin.size()) + u32(json.size()) + "JSON" + json +
           u32(bin.size()) + std::string("BIN\0", 4) + bin;
}

}  // namespace

TEST_CASE("glTF: nodes depth first, with their transforms", "[mesh][gltf]") {
    const MeshFolder folder;
    folder.write("square.bin", square_bytes());
    const auto file =
        folder.write("a.gltf", document(one_mesh + R"("scene": 0, "scenes": [{"nodes": [2, 0]}], "nodes": [
            {"mesh": 0, "translation": [0, 0, 30]},
            {"mesh": 0, "rotation": [0, 0, 0.7071067811865476, 0.7071067811865476]},
            {"mesh": 0, "children": [1, 3], "matrix": [2,0,0,0, 0,2,0,0, 0,0,2,0, 0,0,10,1]},
            {"mesh": 0, "scale": [1, 3, 1]}])"));
    const auto [mesh, report, hash, files] = imported(file);
    REQUIRE(mesh.triangles.size() == 8);
    CHECK(corners(mesh, 0)[1] == Vec3{2, 0, 10});                 // node 2
    CHECK(length(corners(mesh, 2)[1] - Vec3{0, 2, 10}) < 1e-12);  // its child 1 turned about z, then scaled
    CHECK(corners(mesh, 4)[2] == Vec3{2, 6, 10});                 // its child 3
    CHECK(corners(mesh, 6)[1] == Vec3{1, 0, 30});                 // node 0
    CHECK(mesh.materials.at(0).name == "default");
    CHECK(files == std::vector<std::filesystem::path>{file, folder.path() / "square.bin"});
}

TEST_CASE("glTF: a mirrored node keeps its fronts", "[mesh][gltf]") {
    const MeshFolder folder;
    folder.write("square.bin", square_bytes());
    const auto faces = [&](const std::string& scale) {
        return total_area_vector(imported(folder.write("a.gltf", document(one_mesh + R"("scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0, "scale": )" + scale + "}]")))
                                     .mesh);
    };
    // A square facing +z, mirrored in x, still faces +z; mirrored in z it faces -z.
    CHECK(faces("[1, 1, 1]").z == Approx(1));
    CHECK(faces("[-1, 1, 1]").z == Approx(1));
    CHECK(faces("[1, 1, -1]").z == Approx(-1));
}

TEST_CASE("glTF: strips, fans and unindexed triangles; points and lines are ignored with a warning", "[mesh][gltf]") {
    const MeshFolder folder;
    folder.write("square.bin", square_bytes());
    const auto mode = [&](const std::string& primitive) {
        return imported(
            folder.write("a.gltf", document(R"("meshes": [{"primitives": [{"attributes": {"POSITION": 0}, )" +
                                            primitive + R"(}, {"attributes": {"POSITION": 0}, "mode": 1}]}],
            "nodes": [{"mesh": 0}])")));
    };
    const auto fan = mode(R"("mode": 6)"), strip = mode(R"("mode": 5)"), plain = mode(R"("mode": 4)");
    CHECK(fan.mesh.triangles.size() == 2);
    CHECK(total_area_vector(fan.mesh).z == Approx(1));
    REQUIRE(strip.mesh.triangles.size() == 2);
    CHECK(corners(strip.mesh, 1) == TriangleCorners{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{1, 1, 0}});  // vertices 1, 3, 2
    CHECK(plain.mesh.triangles.size() == 1);
    CHECK(warns(plain.report, "lines"));
}

TEST_CASE("glTF: colours, emission and names", "[mesh][gltf]") {
    const MeshFolder folder;
    folder.write("square.bin", square_bytes());
    const auto [mesh, report, hash, files] = imported(folder.write("a.gltf", document(R"(
        "extensionsUsed": ["KHR_materials_emissive_strength"],
        "materials": [{"name": "paint", "pbrMetallicRoughness": {"baseColorFactor": [0.2, 0.4, 1, 1]}},
                      {"emissiveFactor": [1, 0.5, 0],
                       "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 10}}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 1},
                                   {"attributes": {"POSITION": 0}},
                                   {"attributes": {"POSITION": 0}, "material": 0}]}],
        "nodes": [{"mesh": 0}])")));
    REQUIRE(mesh.materials.size() == 3);
    CHECK(mesh.material == std::vector<std::uint32_t>{0, 1, 2});
    CHECK(mesh.materials[0].name == "material1");
    CHECK(mesh.materials[0].reflectance == Vec3{0.95, 0.95, 0.95});  // glTF's default is white
    CHECK(mesh.materials[0].exitance.x == Approx(31.4159265));
    CHECK(mesh.materials[0].exitance.y == Approx(15.7079633));
    CHECK(mesh.materials[1].name == "default");
    CHECK(mesh.materials[1].reflectance == Vec3{0.5, 0.5, 0.5});
    CHECK(mesh.materials[2].name == "paint");
    CHECK(mesh.materials[2].reflectance == Vec3{0.2, 0.4, 0.95});
    CHECK(report.reflectance_clamped == 2);
}

TEST_CASE("glTF: a texture's v runs down, and the factor multiplies it", "[mesh][gltf][texture]") {
    const MeshFolder folder;
    folder.write("square.bin", square_bytes());
    folder.write("my textures/t.png", small_png());
    const auto [mesh, report, hash, files] = imported(folder.write("a.gltf", document(R"(
        "images": [{"uri": "my%20textures/t.png"}], "textures": [{"source": 0}],
        "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [0.5, 1, 1, 1], "baseColorTexture": {"index": 0}}},
                      {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0,
                       "extensions": {"KHR_texture_transform": {"offset": [0.5, 0]}}}}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 2}, "indices": 1, "material": 0},
                                   {"attributes": {"POSITION": 0, "TEXCOORD_0": 2}, "indices": 1, "material": 1}]}],
        "nodes": [{"mesh": 0}])")));
    REQUIRE(mesh.reflectance.size() == 4);
    CHECK(to_double(mesh.reflectance[0]) == Vec3{0.5, 0, 0});  // the upper left pixel is red
    CHECK(mesh.reflectance[2] == Rgb{0, 0.95f, 0});            // the upper right one green
    CHECK(mesh.materials[0].textured);
    CHECK(files.back().filename() == "t.png");
}

TEST_CASE("glTF: texture coordinates beyond all pixels give the mean of the texture", "[mesh][gltf][texture]") {
    const MeshFolder folder;
    std::string bytes = square_bytes();
    folder.write("t.png", small_png());
    const auto with = [&](float u, const std::string& transform) {
        std::string changed = bytes;
        changed.replace(60, 4, raw(u));
        folder.write("square.bin", changed);
        const auto result = imported(folder.write("a.gltf", document(R"("images": [{"uri": "t.png"}], "textures": [{"source": 0}],
            "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "extensions": {"KHR_texture_transform": {)" +
                                                                     transform + R"(}}}}}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 2}, "indices": 1, "material": 0}]}],
            "nodes": [{"mesh": 0}])")));
        return to_double(result.mesh.reflectance.at(0));
    };
    // Half of the pixels (one of red, green, blue, white) have each channel.
    CHECK(with(3e38f, "") == to_double(to_float({0.5, 0.5, 0.5})));
    CHECK(with(0.1f, R"("scale": [1e308, 1e308])") == to_double(to_float({0.5, 0.5, 0.5})));
    CHECK(with(0.1f, R"("texCoord": 1e300)") == to_double(to_float({0.5, 0.5, 0.5})));
    CHECK(with(0.1f, R"("texCoord": -1)") == to_double(to_float({0.5, 0.5, 0.5})));
    CHECK(with(0.1f, R"("texCoord": 0)") == to_double(to_float({0.95, 0, 0})));
}

TEST_CASE("glTF: vertex colours that are no numbers are refused", "[mesh][gltf][bad]") {
    const MeshFolder folder;
    std::string bytes = square_bytes();
    bytes.replace(0, 4, raw(std::numeric_limits<float>::quiet_NaN()));
    folder.write("square.bin", bytes);
    const auto error = refused(folder.write("a.gltf", document(R"("meshes": [{"primitives": [
        {"attributes": {"POSITION": 0, "COLOR_0": 0}, "indices": 1}]}], "nodes": [{"mesh": 0}])")));
    CHECK(error.message.find("colour") != std::string::npos);
}

TEST_CASE("glTF: a small document cannot ask for much", "[mesh][gltf][limits]") {
    const MeshFolder folder;
    folder.write("square.bin", square_bytes());
    const auto beyond = [&](const std::string& rest, const ImportLimits& limits) {
        ImportOptions options;
        options.limits = limits;
        const auto result = import_mesh(folder.write("a.gltf", document(rest)), options);
        REQUIRE(!result);
        return result.error().message;
    };
    const std::string node = R"("nodes": [{"mesh": 0}])";
    // Deep enough to end on the stack of a parser that follows.
    const std::string deep = R"("extras": )" + std::string(100000, '[') + std::string(100000, ']') + ",";
    CHECK(beyond(deep + one_mesh + node, {}).find("deeper than 256") != std::string::npos);
    CHECK_NOTHROW(imported(folder.write("b.gltf", document(R"("extras": "[[\"[[", )" + one_mesh + node))));
    CHECK(beyond(one_mesh + node, {.json_values = 20}).find("20 values") != std::string::npos);

    // One square, 6 corners each time, used by three nodes.
    const std::string nodes = R"("nodes": [{"mesh": 0}, {"mesh": 0}, {"mesh": 0}])";
    ImportOptions enough;
    enough.limits.corners = 18;
    CHECK(import_mesh(folder.write("c.gltf", document(one_mesh + nodes)), enough));
    CHECK(beyond(one_mesh + nodes, {.corners = 17}).find("17 vertices") != std::string::npos);

}

TEST_CASE("glTF: elements without a byte and primitives without a corner are counted", "[mesh][gltf][limits]") {
    const MeshFolder folder;
    // 40 nodes that use 40 primitives each; the accessor has no buffer view, so its elements are zeros.
    const auto bare = [&](const std::string& count) {
        std::string nodes = R"({"mesh": 0})", primitives = R"({"attributes": {"POSITION": 0}})";
        for (int i = 1; i < 40; ++i) {
            nodes += R"(, {"mesh": 0})";
            primitives += R"(, {"attributes": {"POSITION": 0}})";
        }
        return folder.write("a.gltf", R"({"asset": {"version": "2.0"}, "nodes": [)" + nodes + R"(], "meshes": [{"primitives": [)" +
                                          primitives + R"(]}], "accessors": [{"componentType": 5126, "type": "VEC3", "count": )" +
                                          count + "}]}");
    };
    CHECK(refused(bare("0")).message.find("no faces") != std::string::npos);
    CHECK(refused(bare("3")).message.find("1600 degenerate") != std::string::npos);
    CHECK(refused(bare("100000000")).message.find("100000000 elements, expected at most") != std::string::npos);
    ImportOptions few;
    few.limits.corners = 60;
    CHECK(import_mesh(bare("3"), few).error().message.find("60 vertices") != std::string::npos);
    few = {};
    few.limits.json_values = 1000;
    const auto result = import_mesh(bare("0"), few);
    REQUIRE(!result);
    CHECK(result.error().message.find("more than 1000 primitives") != std::string::npos);
}

TEST_CASE("GLB holds its own buffer", "[mesh][gltf]") {
    const MeshFolder folder;
    const std::string whole = glb(document(one_mesh + R"("nodes": [{"mesh": 0}])", ""), square_bytes());
    CHECK(total_area(imported(folder.write("a.glb", whole)).mesh) == Approx(1));
    // Cut at every length: refused, never read beyond the end.
    for (std::size_t length = 1; length < whole.size(); length += 7)
        refused(folder.write("b.glb", whole.substr(0, length)));
}

TEST_CASE("glTF: broken files are refused", "[mesh][gltf][bad]") {
    const MeshFolder folder;
    folder.write("square.bin", square_bytes());
    const auto gltf = [&](const std::string& rest) { return refused(folder.write("a.gltf", document(rest))); };
    const std::string node = R"("nodes": [{"mesh": 0}])";
    CHECK(gltf(one_mesh + R"("nodes": [{"children": [1]}, {"children": [0], "mesh": 0}])").where.find("/nodes") !=
          std::string::npos);
    CHECK(gltf(one_mesh + R"("scenes": [{"nodes": [0]}], "nodes": [{"children": [1]}, {"children": [0]}])")
              .message.find("ancestor") != std::string::npos);
    CHECK(gltf(one_mesh + R"("scenes": [{"nodes": [7]}], "nodes": [{"mesh": 0}])").where.find("/nodes/7") !=
          std::string::npos);
    CHECK(gltf(R"("meshes": [{"primitives": [{"attributes": {"POSITION": 9}}]}],)" + node).message.find("accessor 9") !=
          std::string::npos);
    CHECK(gltf(R"("meshes": [{"primitives": [{"attributes": {"POSITION": 2}}]}],)" + node).message.find("components") !=
          std::string::npos);
    CHECK(gltf(R"("meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 3}]}],)" + node)
              .message.find("material 3") != std::string::npos);
    CHECK(gltf(R"("extensionsRequired": ["KHR_draco_mesh_compression"],)" + one_mesh + node).message.find("draco") !=
          std::string::npos);
    CHECK(gltf(node).message.find("mesh 0") != std::string::npos);
    CHECK(gltf(R"("scenes": [{"nodes": []}])").message.find("no faces") != std::string::npos);
    CHECK(refused(folder.write("b.gltf", "{\"asset\": ")).message.size() > 0);
    CHECK(refused(folder.write("b.gltf", "[]")).message.size() > 0);

    // Index 9 of 4 vertices; a view that ends behind its buffer; a missing buffer.
    std::string bytes = square_bytes();
    bytes[48] = 9;
    folder.write("square.bin", bytes);
    CHECK(gltf(one_mesh + node).message.find("vertex 9") != std::string::npos);
    std::string far = document(one_mesh + node);
    far.replace(far.find("\"byteLength\": 12"), 16, "\"byteLength\": 99");
    CHECK(refused(folder.write("a.gltf", far)).message.find("ends behind") != std::string::npos);
    std::filesystem::remove(folder.path() / "square.bin");
    CHECK(gltf(one_mesh + node).message.find("square.bin") != std::string::npos);
}
