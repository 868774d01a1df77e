#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include "format/atomic_file.h"
#include "solver/output/camera.h"
#include "solver/output/output.h"
#include "solver/output/surface_mesh.h"

namespace rro {
namespace {

using nlohmann::json;

// Numbers of the glTF 2.0 specification.
constexpr std::uint32_t kMagic = 0x46546C67, kVersion = 2, kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;
constexpr int kFloat = 5126, kUnsignedInt = 5125, kArrayBuffer = 34962, kElementArrayBuffer = 34963;

/// The nearest distance that the camera shows, as a share of the scene's diagonal.
constexpr double kNearPlane = 1e-3;

/// Cosine between two axes of a transform up to which viewers may take it for rotation and scale.
constexpr double kSquare = 1e-6;

/// Factor from radiosity to COLOR_0: that which a PNG of the same scene applies to B / pi.
double exposure_factor(const Scene& scene, const Solution& solution) {
    const auto& camera = scene.manifest.camera;
    if (camera && camera->exposure) return std::exp2(*camera->exposure) / std::numbers::pi;
    constexpr double aspect = 16.0 / 9;
    const SceneRays rays(scene);
    const CameraEntry view = camera ? *camera : choose_camera(scene, solution, rays, aspect);
    return view_exposure(scene, solution, rays, make_camera(view, aspect));
}

/// glTF nodes may turn, mirror and stretch along axes, but not shear.
bool is_square(const Mat3& m) {
    for (int i = 0; i < 3; ++i) {
        const Vec3 a = m.column(i), b = m.column((i + 1) % 3);
        if (std::abs(dot(a, b)) > kSquare * length(a) * length(b)) return false;
    }
    return true;
}

json column_major(const Affine3& m) {
    json out = json::array();
    for (int c = 0; c < 4; ++c) {
        const Vec3 column = c < 3 ? m.linear.column(c) : m.translation;
        out.insert(out.end(), {column.x, column.y, column.z, c < 3 ? 0.0 : 1.0});
    }
    return out;
}

/// The document and its one buffer, as they grow.
struct Document {
    json root;
    std::vector<std::byte> buffer;

    /// Appends an array and describes it; every component is 4 bytes wide, so all stays aligned. Returns the accessor.
    template <class T>
    json& add(std::span<const T> values, const char* type, int component, int target) {
        const auto bytes = std::as_bytes(values);
        json& views = root["bufferViews"];
        views.push_back({{"buffer", 0}, {"byteOffset", buffer.size()}, {"byteLength", bytes.size()}, {"target", target}});
        buffer.insert(buffer.end(), bytes.begin(), bytes.end());
        json& accessors = root["accessors"];
        const std::size_t components = sizeof(T) / 4 * values.size();
        accessors.push_back({{"bufferView", views.size() - 1},
                             {"componentType", component},
                             {"count", std::strcmp(type, "SCALAR") == 0 ? components : values.size()},
                             {"type", type}});
        return accessors.back();
    }
    std::size_t add_vectors(const std::vector<Vec3f>& values) {
        add<Vec3f>(values, "VEC3", kFloat, kArrayBuffer);
        return root["accessors"].size() - 1;
    }
};

/// What of an instance's surface goes into the file: positions and normals in the node's frame.
struct NodeMesh {
    json matrix;  // of the node; null where the vertices are in the world already
    std::vector<Vec3f> positions, normals;
    std::vector<TriangleIndices> triangles;
};

/// The node's frame is the archive's, with the origin taken off so that float positions stay precise.
NodeMesh node_mesh(const Instance& instance, const SurfaceMesh& mesh) {
    NodeMesh out;
    out.triangles = mesh.triangles;
    if (is_square(instance.to_world.linear)) {
        const Vec3 origin = instance.data().origin;
        out.matrix = column_major(instance.to_world * Affine3{{}, origin});
        for (const Vec3& p : mesh.positions) out.positions.push_back(to_float(p - origin));
        out.normals = mesh.normals;
        return out;
    }
    for (const Vec3& p : mesh.positions) out.positions.push_back(to_float(instance.to_world.point(p)));
    const Mat3 to_world_normal = instance.to_world.linear.inverse().transposed();
    for (const Vec3f& n : mesh.normals)
        out.normals.push_back(to_float(normalised(to_world_normal * to_double(n))));
    // Viewers flip the winding under a mirroring node; without the node it is done here.
    if (instance.determinant_sign < 0)
        for (TriangleIndices& t : out.triangles) std::swap(t[1], t[2]);
    return out;
}

std::vector<Vec3f> colours(const std::vector<Rgb>& radiosity, double factor) {
    std::vector<Vec3f> out;
    const auto shown = [&](float b) { return static_cast<float>(std::clamp(b * factor, 0.0, 1.0)); };
    for (const Rgb& b : radiosity) out.push_back({shown(b.x), shown(b.y), shown(b.z)});
    return out;
}

void add_bounds(json& accessor, const std::vector<Vec3f>& positions) {
    Box3 box;
    for (const Vec3f& p : positions) box.add(to_double(p));
    accessor["min"] = {box.lo.x, box.lo.y, box.lo.z};
    accessor["max"] = {box.hi.x, box.hi.y, box.hi.z};
}

void add_instance(Document& document, const Instance& instance, const InstanceSolution& solution, double factor) {
    const SurfaceMesh mesh = surface_mesh(instance, solution);
    const NodeMesh shown = node_mesh(instance, mesh);
    json node{{"name", instance.name}};
    if (!shown.matrix.is_null()) node["matrix"] = shown.matrix;
    if (!shown.triangles.empty()) {
        json attributes;
        attributes["POSITION"] = document.add_vectors(shown.positions);
        add_bounds(document.root["accessors"].back(), shown.positions);
        attributes["NORMAL"] = document.add_vectors(shown.normals);
        attributes["COLOR_0"] = document.add_vectors(colours(mesh.radiosity, factor));
        attributes["_RADIOSITY"] = document.add_vectors(mesh.radiosity);
        document.add<TriangleIndices>(shown.triangles, "SCALAR", kUnsignedInt, kElementArrayBuffer);
        const std::size_t indices = document.root["accessors"].size() - 1;
        json& meshes = document.root["meshes"];
        meshes.push_back({{"name", instance.name},
                          {"primitives", json::array({{{"attributes", attributes},
                                                       {"indices", indices},
                                                       {"material", 0}}})}});
        node["mesh"] = meshes.size() - 1;
    }
    document.root["nodes"].push_back(node);
}

void add_camera(json& root, const CameraEntry& entry, const Box3& bounds) {
    const Camera camera = make_camera(entry, 1.0);
    const double near = bounds.empty() ? kNearPlane : kNearPlane * length(bounds.extent());
    root["cameras"] = json::array(
        {{{"type", "perspective"},
          {"perspective", {{"yfov", entry.vertical_fov * std::numbers::pi / 180}, {"znear", near}}}}});
    // A glTF camera looks along its -z.
    const Mat3 to_camera{{camera.right, camera.up, -camera.forward}};
    root["nodes"].push_back(
        {{"name", "camera"}, {"camera", 0}, {"matrix", column_major({to_camera.transposed(), camera.position})}});
}

void append_word(std::string& out, std::uint32_t word) {
    out.append(reinterpret_cast<const char*>(&word), sizeof word);
}

/// Header, JSON chunk padded by spaces, binary chunk padded by zeros.
Result<std::string> container(Document& document) {
    if (!document.buffer.empty()) document.root["buffers"] = json::array({{{"byteLength", document.buffer.size()}}});
    std::string text = document.root.dump(-1, ' ', false, json::error_handler_t::replace);
    text.resize((text.size() + 3) / 4 * 4, ' ');
    const std::size_t total = 12 + 8 + text.size() + (document.buffer.empty() ? 0 : 8 + document.buffer.size());
    if (total > std::numeric_limits<std::uint32_t>::max())
        return failed("", "the solution needs " + std::to_string(total) + " bytes, GLB holds 4294967295",
                      "ask for less accuracy, or for a picture or CSV instead");
    std::string out;
    out.reserve(total);
    append_word(out, kMagic);
    append_word(out, kVersion);
    append_word(out, static_cast<std::uint32_t>(total));
    append_word(out, static_cast<std::uint32_t>(text.size()));
    append_word(out, kJsonChunk);
    out += text;
    if (!document.buffer.empty()) {
        append_word(out, static_cast<std::uint32_t>(document.buffer.size()));
        append_word(out, kBinaryChunk);
        out.append(reinterpret_cast<const char*>(document.buffer.data()), document.buffer.size());
    }
    return out;
}

}  // namespace

Status write_glb(const Scene& scene, const Solution& solution, const std::filesystem::path& path) {
    const double factor = exposure_factor(scene, solution);
    Document document;
    json& root = document.root;
    root["asset"] = {{"version", "2.0"}, {"generator", "rro-solve"}, {"extras", {{"exposure", factor}}}};
    root["extensionsUsed"] = json::array({"KHR_materials_unlit"});
    root["materials"] = json::array({{{"name", "radiosity"},
                                      {"extensions", {{"KHR_materials_unlit", json::object()}}},
                                      {"pbrMetallicRoughness", {{"metallicFactor", 0.0}, {"roughnessFactor", 1.0}}}}});
    root["nodes"] = json::array();
    for (std::size_t i = 0; i < scene.instances.size(); ++i)
        add_instance(document, scene.instances[i], solution.instances[i], factor);
    if (scene.manifest.camera) add_camera(root, *scene.manifest.camera, scene.bounds);
    std::vector<std::size_t> all(root["nodes"].size());
    for (std::size_t n = 0; n < all.size(); ++n) all[n] = n;
    if (all.empty()) root.erase("nodes");
    root["scene"] = 0;
    root["scenes"] = json::array({all.empty() ? json::object() : json{{"nodes", all}}});
    const Result<std::string> bytes = container(document);
    if (!bytes) return Error{bytes.error().kind, path.string(), bytes.error().message, bytes.error().hint};
    return write_file_atomically(path, *bytes);
}

}  // namespace rro
