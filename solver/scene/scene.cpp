#include "solver/scene/scene.h"

#include <algorithm>
#include <map>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

#include "format/parallel.h"
#include "format/tool/json_document.h"
#include "format/tool/names.h"
#include "solver/scene/resolve_lights.h"

namespace rro {
namespace {

// Reflectances below 1 in double must not round to 1 in float: light would never die out.
constexpr float kLargestReflectance = 0x1.fffffep-1f;

// Size over distance from 0 that an instance needs: its shape then keeps 4 of double's 16 digits.
constexpr double kFinestShape = 1e-12;

std::string place_of(const Manifest& manifest, std::size_t instance, const std::string& key) {
    return json_place(manifest.path.string(), "/instances/" + std::to_string(instance) + key);
}

using OpenedObjects = std::span<const std::shared_ptr<const Object>>;

std::shared_ptr<const Object> find_opened(OpenedObjects opened, const std::filesystem::path& path) {
    const auto at = std::find_if(opened.begin(), opened.end(), [&](const auto& object) { return object->path == path; });
    return at == opened.end() ? nullptr : *at;
}

/// Archives of a manifest, each once, in the order of first use; index[i] is that of instance i.
struct ArchiveFiles {
    std::vector<std::filesystem::path> paths;
    std::vector<std::size_t> first_instance;  // that names it, for messages
    std::vector<std::size_t> index;
};

Result<ArchiveFiles> archive_files(const Manifest& manifest, OpenedObjects opened) {
    ArchiveFiles files;
    std::map<std::filesystem::path, std::size_t> by_name, by_file;  // one file may have several names
    for (std::size_t i = 0; i < manifest.instances.size(); ++i) {
        const std::filesystem::path& name = manifest.instances[i].archive;
        auto known = by_name.find(name);
        if (known == by_name.end()) {
            std::error_code code;
            // What is open stays usable when its file is gone.
            const auto canonical = find_opened(opened, name) ? name : std::filesystem::canonical(name, code);
            if (code)
                return bad_input(place_of(manifest, i, "/archive"),
                                 name.string() + ": " + code.message() +
                                     ", expected an archive (paths are relative to "
                                     "the manifest)",
                                 "archives are written by rro-compile build");
            const auto [file, is_new] = by_file.emplace(canonical, files.paths.size());
            if (is_new) {
                files.paths.push_back(name);
                files.first_instance.push_back(i);
            }
            known = by_name.emplace(name, file->second).first;
        }
        files.index.push_back(known->second);
    }
    return files;
}

/// Tables are optional in an archive, but not for those who compute with them.
Status check_tables(const Archive& archive, SectionSet wanted, const std::filesystem::path& path) {
    const ObjectData& data = archive.data();
    const auto missing = [&](const char* section, const char* user = "--method reusable") {
        return bad_input(path.string(), "has no section " + std::string(section) + ", which " + user + " needs",
                         "compile it with rro-compile build --tables default");
    };
    if (wanted.has(Section::Area) && (data.whole_area.empty() || data.intrinsic_area.empty())) return missing("area");
    if (wanted.has(Section::Visibility) && data.visibility.empty()) return missing("visibility");
    if (wanted.has(Section::Hit) && data.hit_volumes.empty()) return missing("hit", "--visibility tables");
    if (wanted.has(Section::Atlas) && data.atlas_coverage.empty()) return missing("atlas", "--visibility atlas");
    return Done{};
}

Result<std::shared_ptr<const Object>> open_object(const std::filesystem::path& path, SectionSet wanted) {
    auto archive = Archive::open(path, wanted);
    if (!archive) return archive.error();
    if (auto checked = check_tables(*archive, wanted, path); !checked) return checked.error();
    return std::shared_ptr<const Object>(make_object(path, std::move(*archive)));
}

/// Opens several at a time; of several errors the first in the manifest is given.
Result<std::vector<std::shared_ptr<const Object>>> open_objects(const Manifest& manifest, const ArchiveFiles& files,
                                                                SectionSet wanted, OpenedObjects opened) {
    std::vector<std::optional<Result<std::shared_ptr<const Object>>>> found(files.paths.size());
    parallel_for(found.size(), 1, [&](std::size_t i) {
        auto object = find_opened(opened, files.paths[i]);
        found[i].emplace(object ? std::move(object) : open_object(files.paths[i], wanted));
    });
    std::vector<std::shared_ptr<const Object>> objects;
    for (std::size_t i = 0; i < found.size(); ++i) {
        if (!*found[i]) {
            Error error = found[i]->error();
            if (!error.where.empty()) error.message = error.where + ": " + error.message;
            error.where = place_of(manifest, files.first_instance[i], "/archive");
            return error;
        }
        objects.push_back(std::move(**found[i]));
    }
    return objects;
}

/// Compares the `content` pins with the files' hashes, each computed at most once.
Status check_pins(const Manifest& manifest, const ArchiveFiles& files,
                  const std::vector<std::shared_ptr<const Object>>& objects) {
    std::vector<std::string> hashes(objects.size());
    for (std::size_t i = 0; i < manifest.instances.size(); ++i) {
        const std::string& pin = manifest.instances[i].content;
        if (pin.empty()) continue;
        const Object& object = *objects[files.index[i]];
        std::string& hash = hashes[files.index[i]];
        if (hash.empty()) hash = object.archive.content_sha256();
        if (!hash.starts_with(pin))
            return bad_input(place_of(manifest, i, "/archive/content"),
                             object.path.string() + " has SHA-256 " + hash + ", expected one that starts with " + pin,
                             "the archive is not the one that the manifest was made for");
    }
    return Done{};
}

/// What the manifest says about each of the archive's materials: "*", then the exact name, field by field.
Result<std::vector<MaterialOverride>> material_overrides(const Manifest& manifest, std::size_t number,
                                                         const Instance& instance) {
    const ObjectData& data = instance.data();
    std::vector<MaterialOverride> overrides(data.materials.size());
    std::multimap<std::string_view, std::size_t> materials;
    for (std::size_t m = 0; m < overrides.size(); ++m) materials.emplace(data.materials[m].name, m);
    for (const auto& [name, said] : manifest.instances[number].materials) {
        const bool all = name == "*";
        const auto [begin, end] =
            all ? std::pair(materials.cbegin(), materials.cend()) : std::as_const(materials).equal_range(name);
        for (auto at = begin; at != end; ++at) {
            if (said.reflectance) overrides[at->second].reflectance = said.reflectance;
            if (said.exitance) overrides[at->second].exitance = said.exitance;
            if (said.transmittance) overrides[at->second].transmittance = said.transmittance;
            if (said.group) overrides[at->second].group = said.group;
        }
        if (begin == end && !all) {
            std::vector<std::string> names;
            for (const Material& material : data.materials) names.push_back(material.name);
            return bad_input(place_of(manifest, number, "/materials/" + pointer_step(name)),
                             instance.object->path.filename().string() + " has no material \"" + name +
                                 "\", expected one of: " + listed(names),
                             nearest_hint(name, names));
        }
    }
    return overrides;
}

/// Do all triangles of a patch have two sides?
bool is_two_sided(const Object& object, const Patch& patch) {
    const auto faces = object.data().faces.subspan(patch.first_face, patch.face_count);
    return std::all_of(faces.begin(), faces.end(), [&](Face face) {
        return object.front_face[face.triangle()] != kNoFace && object.back_face[face.triangle()] != kNoFace;
    });
}

/// A patch's transmittance, checked against its reflectance and its sides.
Result<Rgb> patch_transmittance(const Manifest& manifest, std::size_t number, const Instance& instance,
                                const Patch& patch, const Rgb& reflectance, const Vec3& wanted) {
    if (wanted == Vec3{}) return Rgb{};
    const std::string material = "material \"" + instance.data().materials[patch.material].name + "\" of " +
                                 instance.object->path.filename().string();
    const std::string where = place_of(manifest, number, "/materials");
    if (!is_two_sided(*instance.object, patch))
        return bad_input(where, material + " has a transmittance, but triangles with one side only",
                         "compile the archive with --two-sided yes");
    const Vec3 rho = to_double(reflectance);
    Rgb tau = to_float(wanted);
    float* const out[3] = {&tau.x, &tau.y, &tau.z};
    for (int c = 0; c < 3; ++c) {
        if (!(wanted[c] + rho[c] < 1))
            return bad_input(where, material + " has a transmittance of " + nlohmann::json(wanted[c]).dump() +
                                        " beside a reflectance of " + nlohmann::json(rho[c]).dump() +
                                        ", expected a sum below 1");
        *out[c] = std::min(*out[c], kLargestReflectance - static_cast<float>(rho[c]));
    }
    return tau;
}

/// Radiometry per patch: the archive's, or what the manifest says instead.
Status resolve_materials(const Manifest& manifest, std::size_t number, Instance& instance) {
    const ObjectData& data = instance.data();
    const auto resolved = material_overrides(manifest, number, instance);
    if (!resolved) return resolved.error();
    const std::vector<MaterialOverride>& overrides = *resolved;
    const bool transmits = std::any_of(overrides.begin(), overrides.end(), [](const MaterialOverride& m) {
        return m.transmittance && *m.transmittance != Vec3{};
    });
    for (std::size_t m = 0; m < overrides.size(); ++m)
        for (int c = 0; c < 3; ++c)
            if (const double own = data.materials[m].exitance[c]; !overrides[m].exitance && !is_usable_power(own))
                return bad_input(place_of(manifest, number, "/archive"),
                                 "material \"" + data.materials[m].name + "\" of " +
                                     instance.object->path.filename().string() + " has an exitance of " + nlohmann::json(own).dump() +
                                     " W/m^2, expected 0 or 1e-30 to 1e30",
                                 "give it another exitance under \"materials\"");
    for (const Patch& patch : data.patches) {
        const MaterialOverride& said = overrides[patch.material];
        Rgb reflectance = said.reflectance ? to_float(*said.reflectance) : patch.reflectance;
        for (float* channel : {&reflectance.x, &reflectance.y, &reflectance.z})
            *channel = std::min(*channel, kLargestReflectance);
        instance.reflectance.push_back(reflectance);
        instance.exitance.push_back(to_float(said.exitance.value_or(data.materials[patch.material].exitance)));
        if (!transmits) continue;
        const auto transmittance = patch_transmittance(manifest, number, instance, patch, reflectance,
                                                       said.transmittance.value_or(Vec3{}));
        if (!transmittance) return transmittance.error();
        instance.transmittance.push_back(*transmittance);
    }
    return Done{};
}

Result<Instance> place_instance(const Manifest& manifest, std::size_t number, const Object& object) {
    const InstanceEntry& entry = manifest.instances[number];
    Instance instance;
    instance.name = entry.name;
    instance.object = &object;
    instance.to_world = entry.to_world;
    instance.to_local = entry.to_world.inverse();
    instance.determinant_sign = entry.to_world.linear.determinant() < 0 ? -1 : 1;
    if (auto resolved = resolve_materials(manifest, number, instance); !resolved) return resolved.error();
    const ObjectData& data = object.data();
    std::vector<std::uint8_t> used(data.positions.size(), 0);
    for (const TriangleIndices& triangle : data.triangles)
        for (const std::uint32_t corner : triangle) used[corner] = 1;
    for (std::size_t v = 0; v < used.size(); ++v)
        if (used[v]) instance.bounds.add(instance.to_world.point(data.origin + to_double(data.positions[v])));
    const Box3& b = instance.bounds;
    const double reach = std::max(length(b.lo), length(b.hi));
    if (!(length(b.extent()) > kFinestShape * reach))  // also where the lengths overflow
        return bad_input(place_of(manifest, number, "/transform"),
                         "places the object so far from 0 that double precision loses its shape");
    return instance;
}

}  // namespace

std::unique_ptr<Object> make_object(std::filesystem::path path, Archive archive) {
    auto object = std::make_unique<Object>(Object{std::move(path), std::move(archive), nullptr, {}, {}, {}, {}});
    const ObjectData& data = object->data();
    object->rays = std::make_unique<ObjectRays>(data.positions, data.triangles);
    object->front_face.assign(data.triangles.size(), kNoFace);
    object->back_face.assign(data.triangles.size(), kNoFace);
    for (std::uint32_t f = 0; f < data.faces.size(); ++f) {
        const Face face = data.faces[f];
        (face.side() == Side::Front ? object->front_face : object->back_face)[face.triangle()] = f;
    }
    object->patch_of_face.assign(data.faces.size(), 0);
    for (std::uint32_t p = 0; p < data.patches.size(); ++p)
        std::fill_n(object->patch_of_face.begin() + data.patches[p].first_face, data.patches[p].face_count, p);
    object->self_pairs = self_pairs(data);
    return object;
}

Result<Scene> open_scene(Manifest manifest, SectionSet wanted, std::span<const std::shared_ptr<const Object>> opened) {
    auto files = archive_files(manifest, opened);
    if (!files) return files.error();
    auto objects = open_objects(manifest, *files, wanted, opened);
    if (!objects) return objects.error();
    if (auto pinned = check_pins(manifest, *files, *objects); !pinned) return pinned.error();

    Scene scene;
    scene.objects = std::move(*objects);
    std::vector<std::optional<Result<Instance>>> placed(manifest.instances.size());
    parallel_for(placed.size(), 1, [&](std::size_t i) {
        placed[i].emplace(place_instance(manifest, i, *scene.objects[files->index[i]]));
    });
    for (auto& instance : placed) {
        if (!*instance) return instance->error();
        scene.bounds.add((*instance)->bounds);
        scene.instances.push_back(std::move(**instance));
    }
    scene.manifest = std::move(manifest);
    if (auto lit = resolve_lights(scene); !lit) return lit.error();
    return scene;
}

}  // namespace rro
