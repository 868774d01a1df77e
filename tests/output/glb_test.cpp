#include <catch2/catch.hpp>
#include <cstring>
#include <nlohmann/json.hpp>

#include "solver/output/output.h"
#include "solver/output/surface_mesh.h"
#include "tests/output/hand_made_scene.h"
#include "tests/support/temporary_folder.h"

using namespace rro;
using namespace rro::test;
using nlohmann::json;

namespace {

std::uint32_t word(const std::string& bytes, std::size_t at) {
    std::uint32_t value;
    REQUIRE(at + 4 <= bytes.size());
    std::memcpy(&value, bytes.data() + at, 4);
    return value;
}

/// A GLB taken apart as the specification demands; every departure fails the test.
struct Glb {
    json root;
    std::string buffer;

    explicit Glb(const std::string& bytes) {
        REQUIRE(bytes.substr(0, 4) == "glTF");
        REQUIRE(word(bytes, 4) == 2);
        REQUIRE(word(bytes, 8) == bytes.size());
        const std::uint32_t text = word(bytes, 12);
        REQUIRE(text % 4 == 0);
        REQUIRE(word(bytes, 16) == 0x4E4F534A);
        root = json::parse(bytes.substr(20, text));
        const std::size_t binary = 20 + text;
        REQUIRE(word(bytes, binary + 4) == 0x004E4942);
        buffer = bytes.substr(binary + 8);
        REQUIRE(word(bytes, binary) == buffer.size());
        REQUIRE(buffer.size() % 4 == 0);
        REQUIRE(root["buffers"].size() == 1);
        REQUIRE(root["buffers"][0]["byteLength"] == buffer.size());
        REQUIRE_FALSE(root["buffers"][0].contains("uri"));
        REQUIRE(root["asset"]["version"] == "2.0");
    }

    /// The words of an accessor; `components` and type must be as given.
    std::string data(std::size_t accessor, const char* type, std::size_t components, int component_type) const {
        const json& a = root["accessors"].at(accessor);
        REQUIRE(a["type"] == type);
        REQUIRE(a["componentType"] == component_type);
        const json& view = root["bufferViews"].at(a["bufferView"].get<std::size_t>());
        const std::size_t offset = view["byteOffset"], length = view["byteLength"], count = a["count"];
        REQUIRE(offset % 4 == 0);
        REQUIRE(offset + length <= buffer.size());
        REQUIRE(count * components * 4 == length);
        REQUIRE(count > 0);
        return buffer.substr(offset, length);
    }
    std::vector<Vec3f> vectors(std::size_t accessor) const {
        const std::string bytes = data(accessor, "VEC3", 3, 5126);
        std::vector<Vec3f> out(bytes.size() / sizeof(Vec3f));
        std::memcpy(out.data(), bytes.data(), bytes.size());
        return out;
    }
    std::vector<std::uint32_t> indices(std::size_t accessor) const {
        const std::string bytes = data(accessor, "SCALAR", 1, 5125);
        std::vector<std::uint32_t> out(bytes.size() / 4);
        std::memcpy(out.data(), bytes.data(), bytes.size());
        return out;
    }
    const json& node(const std::string& name) const {
        for (const json& n : root["nodes"])
            if (n.value("name", "") == name) return n;
        FAIL("no node " << name);
        return root;
    }
    const json& primitive(const json& node) const { return root["meshes"].at(node["mesh"].get<std::size_t>())["primitives"].at(0); }
};

Glb written(const Scene& scene, const Solution& solution) {
    const TemporaryFolder folder;
    REQUIRE(write_glb(scene, solution, folder / "s.glb"));
    return Glb(file_text(folder / "s.glb"));
}

Affine3 matrix_of(const json& node) {
    if (!node.contains("matrix")) return {};
    const std::vector<double> m = node["matrix"];
    REQUIRE(m.size() == 16);
    REQUIRE((m[3] == 0 && m[7] == 0 && m[11] == 0 && m[15] == 1));
    return {Mat3{{Vec3{m[0], m[4], m[8]}, Vec3{m[1], m[5], m[9]}, Vec3{m[2], m[6], m[10]}}}, {m[12], m[13], m[14]}};
}

Rgb by_place(const Instance&, const Vec3& centre, std::uint32_t) {
    return {static_cast<float>(2 + centre.x), static_cast<float>(3 + centre.y), 0.25f};
}

const Affine3 kTurned{Mat3{{Vec3{0, 0, 2}, Vec3{0, 3, 0}, Vec3{-2, 0, 0}}}, {5, 6, 7}};
const Affine3 kMirrored{Mat3{{Vec3{-1, 0, 0}, Vec3{0, 2, 0}, Vec3{0, 0, 1}}}, {1, 0, 0}};
const Affine3 kSheared{Mat3{{Vec3{1, 0.5, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}}, {0, 1, 0}};
const Affine3 kMirroredAndSheared{Mat3{{Vec3{-1, 0.5, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}}, {0, 0, 3}};

}  // namespace

TEST_CASE("every instance is a named node whose triangles lie and face as in the scene", "[output][glb]") {
    Scene scene;
    const Mesh box = make_box(1, 2, 3);
    add_instance(scene, "plain", box);
    add_instance(scene, "turned", box, kTurned);
    add_instance(scene, "mirrored", box, kMirrored);
    add_instance(scene, "sheared", box, kSheared);
    add_instance(scene, "mirrored and sheared", box, kMirroredAndSheared);
    add_instance(scene, "far origin", box, kTurned, {1e6, -2e6, 3e6});
    const Glb glb = written(scene, solution_by(scene, by_place));
    REQUIRE(glb.root["nodes"].size() == 6);
    REQUIRE(glb.root["scenes"][0]["nodes"].size() == 6);
    for (const Instance& instance : scene.instances) {
        CAPTURE(instance.name);
        const json& node = glb.node(instance.name);
        const Affine3 matrix = matrix_of(node);
        const json& primitive = glb.primitive(node);
        const std::vector<Vec3f> positions = glb.vectors(primitive["attributes"]["POSITION"]);
        const std::vector<std::uint32_t> indices = glb.indices(primitive["indices"]);
        REQUIRE(indices.size() == 36);
        // Single precision of coordinates up to 3, stretched by 3; at the far origin the world is in double.
        const double tolerance = 2e-6;
        for (std::uint32_t f = 0; f < 12; ++f) {
            TriangleCorners shown;
            for (std::size_t k = 0; k < 3; ++k) {
                REQUIRE(indices[3 * f + k] < positions.size());
                shown[k] = matrix.point(to_double(positions[indices[3 * f + k]]));
            }
            // A viewer turns the winding where the node mirrors.
            if (matrix.linear.determinant() < 0) std::swap(shown[1], shown[2]);
            const TriangleCorners wanted = instance.world_corners(instance.data().faces[f]);
            CHECK(length(area_vector(shown) - area_vector(wanted)) < 10 * tolerance);
            const Vec3 centre = (shown[0] + shown[1] + shown[2] - wanted[0] - wanted[1] - wanted[2]) / 3;
            CHECK(length(centre) < tolerance);
        }
    }
    // Shear is no rotation and scale: glTF allows it in no node, so the vertices carry it.
    CHECK_FALSE(glb.node("sheared").contains("matrix"));
    CHECK_FALSE(glb.node("mirrored and sheared").contains("matrix"));
}

TEST_CASE("attributes are complete, bounded and consistent", "[output][glb]") {
    Scene scene;
    add_instance(scene, "box", make_box(1, 2, 3), kMirrored);
    add_instance(scene, "sheet", make_quad(1, 1, true), kMirroredAndSheared);
    Solution solution = solution_by(scene, by_place);
    subdivide(scene.instances[0], solution.instances[0], 5, 3, [](const Vec3&) { return Rgb{9, 8, 7}; });
    const Glb glb = written(scene, solution);
    const double factor = glb.root["asset"]["extras"]["exposure"];
    CHECK(glb.root["extensionsUsed"] == json::array({"KHR_materials_unlit"}));
    CHECK(glb.root["materials"][0]["extensions"].contains("KHR_materials_unlit"));
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const SurfaceMesh mesh = surface_mesh(scene.instances[i], solution.instances[i]);
        const json& primitive = glb.primitive(glb.node(scene.instances[i].name));
        const json& attributes = primitive["attributes"];
        const std::vector<Vec3f> positions = glb.vectors(attributes["POSITION"]);
        const std::vector<Vec3f> normals = glb.vectors(attributes["NORMAL"]);
        const std::vector<Vec3f> colours = glb.vectors(attributes["COLOR_0"]);
        CHECK(glb.vectors(attributes["_RADIOSITY"]) == mesh.radiosity);
        REQUIRE(positions.size() == mesh.positions.size());
        REQUIRE(normals.size() == positions.size());
        REQUIRE(colours.size() == positions.size());
        CHECK(glb.indices(primitive["indices"]).size() == 3 * mesh.triangles.size());
        Box3 box;
        for (std::size_t v = 0; v < positions.size(); ++v) {
            box.add(to_double(positions[v]));
            CHECK(length(to_double(normals[v])) == Approx(1).epsilon(1e-6));
            CHECK(colours[v].x == static_cast<float>(std::clamp(mesh.radiosity[v].x * factor, 0.0, 1.0)));
            CHECK(colours[v].z == static_cast<float>(std::clamp(mesh.radiosity[v].z * factor, 0.0, 1.0)));
        }
        const json& accessor = glb.root["accessors"].at(attributes["POSITION"].get<std::size_t>());
        CHECK(accessor["min"] == json{box.lo.x, box.lo.y, box.lo.z});
        CHECK(accessor["max"] == json{box.hi.x, box.hi.y, box.hi.z});
    }
}

TEST_CASE("the manifest's camera comes along, with its exposure", "[output][glb]") {
    Scene scene;
    add_instance(scene, "box", make_box(1, 1, 1));
    scene.manifest.camera = CameraEntry{{3, 0, 0}, {0, 0, 0}, {0, 1, 0}, 60, 2.0};
    const Glb glb = written(scene, solution_by(scene, by_place));
    CHECK(glb.root["asset"]["extras"]["exposure"] == Approx(4 / 3.14159265358979));  // 2^2 / pi
    const json& node = glb.node("camera");
    const Affine3 matrix = matrix_of(node);
    CHECK(length(matrix.translation - Vec3{3, 0, 0}) == 0);
    CHECK(length(matrix.vector({0, 0, -1}) - Vec3{-1, 0, 0}) < 1e-12);  // looks along its -z
    CHECK(length(matrix.vector({0, 1, 0}) - Vec3{0, 1, 0}) < 1e-12);
    CHECK(matrix.linear.determinant() == Approx(1));
    const json& camera = glb.root["cameras"].at(node["camera"].get<std::size_t>());
    CHECK(camera["perspective"]["yfov"] == Approx(3.14159265358979 / 3));
}

TEST_CASE("a constant solution is shown in middle grey", "[output][glb]") {
    Scene scene;
    add_instance(scene, "box", make_box(1, 1, 1));
    const Solution solution = solution_by(scene, [](const Instance&, const Vec3&, std::uint32_t) { return Rgb{6, 6, 6}; });
    CHECK(written(scene, solution).root["asset"]["extras"]["exposure"] == Approx(0.18 / 6));
}
