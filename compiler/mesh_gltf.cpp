// glTF 2.0 and GLB. tinygltf parses; every number that becomes an index or an offset is checked here.
#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <set>

#include "compiler/mesh_gltf_accessor.h"
#include "compiler/mesh_gltf_material.h"
#include "compiler/mesh_readers.h"
#include "compiler/mesh_text.h"

namespace rro {
namespace {

/// Extensions that are read.
bool is_read_extension(const std::string& name) {
    return name == "KHR_materials_emissive_strength" || name == "KHR_texture_transform" ||
           name == "KHR_mesh_quantization";
}

/// Extensions without which a mesh still has its shape.
bool is_known_extension(const std::string& name) {
    return name.starts_with("KHR_materials_") || name == "KHR_lights_punctual" || is_read_extension(name);
}

/// How tinygltf reaches files: only those beside the mesh (it would look in the working folder, too), noted as used.
struct Folder {
    static constexpr const char* marker = "mesh-folder";
    std::filesystem::path path;
    SourceFiles* files;

    static std::string expand(const std::string& name, void* user) {
        const std::string prefix = std::string(marker) + "/";
        if (!name.starts_with(prefix)) return {};
        return (static_cast<Folder*>(user)->path / name.substr(prefix.size())).string();
    }
    static bool exists(const std::string& name, void* user) { return static_cast<Folder*>(user)->files->has(name); }
    static bool read(std::vector<unsigned char>* out, std::string* error, const std::string& name, void* user) {
        const auto bytes = static_cast<Folder*>(user)->files->read(name);
        if (!bytes) *error += bytes.error().message;
        if (bytes) out->assign(bytes->begin(), bytes->end());
        return static_cast<bool>(bytes);
    }
};

/// Keeps the bytes of an image as they are: only those that colour something are decoded. What lies in a buffer view is
/// fetched later, checked (the library hands over unchecked pointers there).
bool keep_image(tinygltf::Image* image, const int, std::string*, std::string*, int, int, const unsigned char* bytes,
                int size, void*) {
    if (image->bufferView < 0) image->image.assign(bytes, bytes + size);
    image->as_is = true;
    return true;
}

/// The document of a GLB (its first chunk), or the text itself.
std::string_view json_of(std::string_view bytes) {
    constexpr std::size_t kLengthAt = 12, kJsonAt = 20;
    if (!bytes.starts_with("glTF") || bytes.size() < kJsonAt) return bytes;
    std::uint32_t length = 0;
    std::memcpy(&length, bytes.data() + kLengthAt, sizeof length);
    return bytes.substr(kJsonAt, length);
}

/// How deep the document is and how much is in it, before the library makes values of it: it goes down on the stack, and
/// takes up to 2 kB for the three bytes of an empty material.
Status check_extent(std::string_view json, const ImportLimits& limits, const std::filesystem::path& path) {
    constexpr std::size_t kDeepest = 256;
    std::size_t depth = 0;
    std::uint64_t values = 0;
    bool in_text = false;
    for (std::size_t i = 0; i < json.size(); ++i) {
        const char c = json[i];
        if (in_text) {
            if (c == '\\') ++i;  // what follows ends no text
            in_text = c != '"';
            continue;
        }
        in_text = c == '"';
        const bool opens = c == '{' || c == '[';
        if (opens && ++depth > kDeepest)
            return bad_input(at_byte(path, i), "nested deeper than " + std::to_string(kDeepest) + " levels");
        if ((c == '}' || c == ']') && depth > 0) --depth;
        if ((opens || c == ',') && ++values > limits.json_values)
            return bad_input(at_byte(path, i),
                             "more than " + std::to_string(limits.json_values) + " values in one document",
                             "split the mesh into several objects, or save it with its data in a binary buffer");
    }
    return Done{};
}

Affine3 node_transform(const tinygltf::Node& node) {
    Affine3 transform;
    if (node.matrix.size() == 16) {  // columns first
        const auto& m = node.matrix;
        transform.linear.rows = {Vec3{m[0], m[4], m[8]}, Vec3{m[1], m[5], m[9]}, Vec3{m[2], m[6], m[10]}};
        transform.translation = {m[12], m[13], m[14]};
        return transform;
    }
    if (node.rotation.size() == 4) {
        const double norm =
            std::hypot(std::hypot(node.rotation[0], node.rotation[1]), std::hypot(node.rotation[2], node.rotation[3]));
        const double s = norm > 0 ? 1 / norm : 0;
        const double x = node.rotation[0] * s, y = node.rotation[1] * s, z = node.rotation[2] * s;
        const double w = norm > 0 ? node.rotation[3] * s : 1;
        transform.linear.rows = {Vec3{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
                                 Vec3{2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
                                 Vec3{2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}};
    }
    if (node.scale.size() == 3)
        for (Vec3& row : transform.linear.rows) row = hadamard(row, {node.scale[0], node.scale[1], node.scale[2]});
    if (node.translation.size() == 3)
        transform.translation = {node.translation[0], node.translation[1], node.translation[2]};
    return transform;
}

/// The corner triples of a primitive of `n` vertices by its mode, in the order of the file.
std::vector<std::array<std::size_t, 3>> triangles_of(int mode, std::size_t n) {
    std::vector<std::array<std::size_t, 3>> triangles;
    if (mode == TINYGLTF_MODE_TRIANGLES)
        for (std::size_t i = 0; i + 2 < n; i += 3) triangles.push_back({i, i + 1, i + 2});
    if (mode == TINYGLTF_MODE_TRIANGLE_STRIP)  // every second one runs the other way round
        for (std::size_t i = 0; i + 2 < n; ++i) triangles.push_back({i, i + 1 + i % 2, i + 2 - i % 2});
    if (mode == TINYGLTF_MODE_TRIANGLE_FAN)
        for (std::size_t i = 1; i + 1 < n; ++i) triangles.push_back({i, i + 1, 0});
    return triangles;
}

constexpr Uv kNoUv{std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::quiet_NaN()};

/// The numbers of one primitive, n vertices.
struct PrimitiveData {
    std::vector<double> positions;  // [n][3], in the node's own frame
    std::vector<double> order;      // indices of vertices, as the mode wants them
    std::vector<double> uvs;        // [n][2] or empty
    std::vector<double> colours;    // [n][channels], linear; or empty
    std::size_t channels = 3;
    std::uint32_t material = 0;
};

class GltfReader {
  public:
    GltfReader(const std::filesystem::path& path, SourceFiles& files)
        : path_(path), files_(files), materials_(model_, path, files.limits(), mesh_) {}

    Result<SourceMesh> read(std::string_view bytes);

  private:
    std::string place(const std::string& pointer) const { return path_.string() + ": " + pointer; }
    Status parse(std::string_view bytes);
    Result<std::vector<int>> roots();
    Status walk(const std::vector<int>& roots);
    Status add_mesh(int number, const Affine3& transform, const std::string& where);
    Result<PrimitiveData> load(const tinygltf::Primitive& primitive, const std::string& where);
    Status add_primitive(const tinygltf::Primitive& primitive, const Affine3& transform, const std::string& where);
    void add_corner(const PrimitiveData& data, std::uint32_t first, std::size_t vertex);
    void warn_once(const std::string& text) {
        if (warned_.insert(text).second) mesh_.warnings.push_back(text);
    }

    const std::filesystem::path& path_;
    SourceFiles& files_;
    tinygltf::Model model_;
    SourceMesh mesh_;
    GltfMaterials materials_;
    std::set<std::string> warned_;
    std::uint64_t primitives_met_ = 0;
};

Status GltfReader::parse(std::string_view bytes) {
    if (bytes.size() > std::numeric_limits<int>::max()) return bad_input(path_.string(), "larger than 2 GiB");
    if (auto checked = check_extent(json_of(bytes), files_.limits(), path_); !checked) return checked;
    tinygltf::TinyGLTF loader;
    Folder folder{path_.parent_path(), &files_};
    tinygltf::FsCallbacks calls{};
    calls.FileExists = Folder::exists;
    calls.ExpandFilePath = Folder::expand;
    calls.ReadWholeFile = Folder::read;
    calls.user_data = &folder;
    loader.SetFsCallbacks(calls);
    loader.SetImageLoader(keep_image, nullptr);
    std::string error, warning;
    bool loaded = false;
    try {
        const auto size = static_cast<unsigned>(bytes.size());
        if (bytes.starts_with("glTF")) {
            // The library compares the second chunk's length without its 8 bytes of header: let it find zeros there.
            std::string padded(bytes);
            padded.append(8, '\0');
            loaded = loader.LoadBinaryFromMemory(
                &model_, &error, &warning, reinterpret_cast<const unsigned char*>(padded.data()), size, Folder::marker);
        } else {
            loaded = loader.LoadASCIIFromString(&model_, &error, &warning, bytes.data(), size, Folder::marker);
        }
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& fault) {  // the JSON library's and the containers' own
        error += fault.what();
    }
    if (!loaded || !error.empty()) {
        while (!error.empty() && (error.back() == '\n' || error.back() == ' ')) error.pop_back();
        for (char& c : error)
            if (c == '\n') c = ' ';
        return bad_input(path_.string(),
                         "no glTF 2.0 that can be read: " + (error.empty() ? "no reason given" : error));
    }
    for (const std::string& name : model_.extensionsRequired)
        if (!is_known_extension(name))
            return bad_input(path_.string(), "requires the extension " + in_quotes(name) + ", which is not supported",
                             "export it without compression");
    for (const std::string& name : model_.extensionsUsed) {
        if (name == "KHR_lights_punctual")
            warn_once("lights are ignored: a scene has its own");
        else if (!is_read_extension(name))
            warn_once("the extension " + in_quotes(name) + " is ignored");
    }
    if (!model_.animations.empty()) warn_once("animations are ignored: everything stands as its nodes say");
    return Done{};
}

/// The nodes of the default scene; of the first where none is named; all nodes without a parent where there is no
/// scene.
Result<std::vector<int>> GltfReader::roots() {
    if (!model_.scenes.empty()) {
        const int scene = model_.defaultScene < 0 ? 0 : model_.defaultScene;
        if (static_cast<std::size_t>(scene) >= model_.scenes.size())
            return bad_input(place("/scene"), "scene " + std::to_string(scene) + ", but there are " +
                                                  std::to_string(model_.scenes.size()));
        return model_.scenes[static_cast<std::size_t>(scene)].nodes;
    }
    std::vector<bool> has_parent(model_.nodes.size(), false);
    for (const tinygltf::Node& node : model_.nodes)
        for (const int child : node.children)
            if (child >= 0 && static_cast<std::size_t>(child) < has_parent.size())
                has_parent[static_cast<std::size_t>(child)] = true;
    std::vector<int> free;
    for (std::size_t i = 0; i < has_parent.size(); ++i)
        if (!has_parent[i]) free.push_back(static_cast<int>(i));
    if (free.empty() && !model_.nodes.empty()) return bad_input(place("/nodes"), "the nodes form a cycle");
    return free;
}

/// Depth first, children in their order. A node may be met once: glTF's nodes are trees.
Status GltfReader::walk(const std::vector<int>& roots) {
    struct Visit {
        int node;
        Affine3 parent;
    };
    std::vector<Visit> open;
    for (auto root = roots.rbegin(); root != roots.rend(); ++root) open.push_back({*root, {}});
    std::vector<bool> met(model_.nodes.size(), false);
    while (!open.empty()) {
        const Visit visit = open.back();
        open.pop_back();
        const std::string where = place("/nodes/" + std::to_string(visit.node));
        const auto at = static_cast<std::size_t>(visit.node);
        if (visit.node < 0 || at >= model_.nodes.size())
            return bad_input(where, "no such node, there are " + std::to_string(model_.nodes.size()));
        if (met[at]) return bad_input(where, "the node is its own ancestor or has two parents, expected a tree");
        met[at] = true;
        const tinygltf::Node& node = model_.nodes[at];
        const Affine3 transform = visit.parent * node_transform(node);
        if (node.skin >= 0) warn_once("skins are ignored: meshes stand as they were modelled");
        if (node.mesh >= 0)
            if (auto added = add_mesh(node.mesh, transform, where); !added) return added;
        for (auto child = node.children.rbegin(); child != node.children.rend(); ++child)
            open.push_back({*child, transform});
    }
    for (std::size_t i = 0; i < met.size(); ++i)
        if (!met[i] && model_.nodes[i].mesh >= 0) warn_once("meshes outside the default scene are left out");
    return Done{};
}

Status GltfReader::add_mesh(int number, const Affine3& transform, const std::string& where) {
    if (static_cast<std::size_t>(number) >= model_.meshes.size())
        return bad_input(where,
                         "mesh " + std::to_string(number) + ", but there are " + std::to_string(model_.meshes.size()));
    const auto& primitives = model_.meshes[static_cast<std::size_t>(number)].primitives;
    for (std::size_t i = 0; i < primitives.size(); ++i) {
        if (++primitives_met_ > files_.limits().json_values)
            return bad_input(where, "more than " + std::to_string(files_.limits().json_values) +
                                        " primitives, counted as often as nodes use them");
        const std::string pointer = "/meshes/" + std::to_string(number) + "/primitives/" + std::to_string(i);
        if (auto added = add_primitive(primitives[i], transform, place(pointer)); !added) return added;
    }
    return Done{};
}

Result<PrimitiveData> GltfReader::load(const tinygltf::Primitive& primitive, const std::string& where) {
    const auto attribute = [&](const std::string& name) {
        const auto at = primitive.attributes.find(name);
        return at == primitive.attributes.end() ? -1 : at->second;
    };
    PrimitiveData data;
    const auto material = materials_.use(primitive.material, where);
    if (!material) return material.error();
    data.material = *material;
    if (attribute("POSITION") < 0) return bad_input(where, "a primitive without POSITION");
    const std::uint64_t most = files_.limits().corners;
    auto positions = gltf_values(model_, attribute("POSITION"), 3, most, where);
    if (!positions) return positions.error();
    data.positions = *std::move(positions);
    const std::size_t vertices = data.positions.size() / 3;
    if (primitive.indices >= 0) {
        auto indices = gltf_values(model_, primitive.indices, 1, most, where);
        if (!indices) return indices.error();
        data.order = *std::move(indices);
    } else {
        for (std::size_t i = 0; i < vertices; ++i) data.order.push_back(static_cast<double>(i));
    }
    const int uvs = attribute("TEXCOORD_" + std::to_string(materials_.uv_set(data.material)));
    if (uvs >= 0 && mesh_.materials[data.material].texture) {
        auto values = gltf_values(model_, uvs, 2, vertices, where);
        if (!values) return values.error();
        data.uvs = *std::move(values);
    }
    if (const int colours = attribute("COLOR_0"); colours >= 0) {
        auto values = gltf_values(model_, colours, 3, vertices, where);
        if (!values) {
            values = gltf_values(model_, colours, 4, vertices, where);
            data.channels = 4;
        }
        if (!values) return values.error();
        data.colours = *std::move(values);
        if (!std::all_of(data.colours.begin(), data.colours.end(), [](double c) { return std::isfinite(c); }))
            return bad_input(where, "a vertex colour that is not a finite number");
    }
    return data;
}

Status GltfReader::add_primitive(const tinygltf::Primitive& primitive, const Affine3& transform,
                                 const std::string& where) {
    const int mode = primitive.mode < 0 ? TINYGLTF_MODE_TRIANGLES : primitive.mode;
    if (mode < TINYGLTF_MODE_TRIANGLES) {
        warn_once("points and lines are ignored");
        return Done{};
    }
    if (!primitive.targets.empty()) warn_once("morph targets are ignored");
    const auto data = load(primitive, where);
    if (!data) return data.error();
    const std::vector<double>& p = data->positions;
    const std::size_t triangles = data->order.size() / (mode == TINYGLTF_MODE_TRIANGLES ? 3 : 1);  // or two less
    if (is_too_large(mesh_, files_.limits(), std::max(p.size() / 3, 3 * triangles)))
        return too_large(where, files_.limits());
    const auto first = static_cast<std::uint32_t>(mesh_.positions.size());
    for (std::size_t i = 0; i + 2 < p.size(); i += 3)
        mesh_.positions.push_back(transform.point({p[i], p[i + 1], p[i + 2]}));
    const std::size_t vertices = p.size() / 3;
    const bool mirrored = transform.linear.determinant() < 0;
    for (auto corners : triangles_of(mode, data->order.size())) {
        if (mirrored) std::swap(corners[1], corners[2]);
        for (const std::size_t corner : corners) {
            const double index = data->order[corner];
            if (!(index >= 0 && index < static_cast<double>(vertices) && index == std::floor(index)))
                return bad_input(where,
                                 "vertex " + std::to_string(index) + ", but there are " + std::to_string(p.size() / 3));
            add_corner(*data, first, static_cast<std::size_t>(index));
        }
        end_face(mesh_, data->material);
    }
    return Done{};
}

/// Texture coordinates and colours start with the first primitive that has some.
void GltfReader::add_corner(const PrimitiveData& data, std::uint32_t first, std::size_t vertex) {
    const std::size_t corner = mesh_.corners.size(), u = 2 * vertex, red = data.channels * vertex;
    mesh_.corners.push_back(first + static_cast<std::uint32_t>(vertex));
    if (u + 1 < data.uvs.size()) {
        mesh_.uvs.resize(corner, kNoUv);
        mesh_.uvs.push_back({data.uvs[u], data.uvs[u + 1]});
    }
    if (red + 2 < data.colours.size()) {
        mesh_.colours.resize(corner, Vec3{1, 1, 1});
        mesh_.colours.emplace_back(data.colours[red], data.colours[red + 1], data.colours[red + 2]);
    }
}

Result<SourceMesh> GltfReader::read(std::string_view bytes) {
    if (auto parsed = parse(bytes); !parsed) return parsed.error();
    const auto tops = roots();
    if (!tops) return tops.error();
    if (auto walked = walk(*tops); !walked) return walked.error();
    if (!mesh_.uvs.empty()) mesh_.uvs.resize(mesh_.corners.size(), kNoUv);
    if (!mesh_.colours.empty()) mesh_.colours.resize(mesh_.corners.size(), Vec3{1, 1, 1});
    return std::move(mesh_);
}

}  // namespace

Result<SourceMesh> read_gltf(const std::filesystem::path& path, std::string_view bytes, SourceFiles& files) {
    return GltfReader(path, files).read(bytes);
}

}  // namespace rro
