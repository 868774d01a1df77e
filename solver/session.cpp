#include "solver/session.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "solver/scene/transform.h"

namespace rro {
namespace {

SectionSet wanted_by(const SolveOptions& options) {
    return kGeometry | kTables | sections_of(options.visibility) | Section::Source;
}

Status check_transform(const std::string& name, const Affine3& to_world) {
    if (const std::string fault = transform_fault(to_world); !fault.empty()) return bad_input(name, fault);
    return Done{};
}

void dim_group(Scene& scene, const std::string& name, double scale) {
    const auto at = std::find(scene.light_groups.begin() + 1, scene.light_groups.end(), name);
    if (at == scene.light_groups.end()) return;
    const auto group = static_cast<std::uint32_t>(at - scene.light_groups.begin());
    for (Instance& instance : scene.instances)
        for (std::size_t p = 0; p < instance.exitance.size(); ++p)
            if (instance.light_group_of(p) == group) instance.exitance[p] = to_float(to_double(instance.exitance[p]) * scale);
    for (PointLight& lamp : scene.lights)
        if (lamp.group == group) lamp.intensity *= scale;
}

}  // namespace

SceneSession::SceneSession(Manifest manifest, SolveOptions options, Scene scene)
    : manifest_(std::move(manifest)), options_(std::move(options)), wanted_(wanted_by(options_)), opened_(scene.objects),
      scene_(std::make_shared<const Scene>(std::move(scene))) {}

Result<SceneSession> SceneSession::open(const std::filesystem::path& path, SolveOptions options) {
    auto manifest = read_manifest(path);
    if (!manifest) return manifest.error();
    auto scene = open_scene(*manifest, wanted_by(options));
    if (!scene) return scene.error();
    return SceneSession(std::move(*manifest), std::move(options), std::move(*scene));
}

Result<InstanceEntry*> SceneSession::entry(std::string_view name) {
    const auto at = std::find_if(manifest_.instances.begin(), manifest_.instances.end(),
                                 [&](const InstanceEntry& e) { return e.name == name; });
    if (at == manifest_.instances.end()) return bad_input(std::string(name), "no instance of this name");
    return &*at;
}

Status SceneSession::place(std::string name, const std::filesystem::path& archive, const Affine3& to_world) {
    if (name.empty() || name.find('/') != std::string::npos)
        return bad_input(name, "expected a name that is not empty and has no \"/\"");
    if (entry(name)) return bad_input(name, "an instance of this name is there already");
    if (const auto fits = check_transform(name, to_world); !fits) return fits.error();
    manifest_.instances.push_back({std::move(name), archive, {}, to_world, {}});
    return Done{};
}

Status SceneSession::move(std::string_view name, const Affine3& to_world) {
    const auto found = entry(name);
    if (!found) return found.error();
    if (const auto fits = check_transform((*found)->name, to_world); !fits) return fits.error();
    (*found)->to_world = to_world;
    return Done{};
}

Status SceneSession::remove(std::string_view name) {
    const auto found = entry(name);
    if (!found) return found.error();
    manifest_.instances.erase(manifest_.instances.begin() + (*found - manifest_.instances.data()));
    return Done{};
}

Status SceneSession::set_material(std::string_view name, std::string material, const MaterialOverride& fields) {
    const auto found = entry(name);
    if (!found) return found.error();
    auto& materials = (*found)->materials;
    auto at = std::find_if(materials.begin(), materials.end(), [&](const auto& m) { return m.first == material; });
    // "*" comes first, so that names beat it.
    if (at == materials.end())
        at = materials.insert(material == "*" ? materials.begin() : materials.end(), {std::move(material), {}});
    if (fields.reflectance) at->second.reflectance = fields.reflectance;
    if (fields.exitance) at->second.exitance = fields.exitance;
    return Done{};
}

Status SceneSession::set_reflectance(std::string_view name, std::string material, const Vec3& reflectance) {
    for (const double r : {reflectance.x, reflectance.y, reflectance.z})
        if (!(r >= 0 && r < 1)) return bad_input(std::string(name), "found a reflectance outside of [0, 1)");
    MaterialOverride fields;
    fields.reflectance = reflectance;
    return set_material(name, std::move(material), fields);
}

Status SceneSession::set_exitance(std::string_view name, std::string material, const Vec3& exitance) {
    for (const double m : {exitance.x, exitance.y, exitance.z})
        if (!(m >= 0 && is_usable_power(m))) return bad_input(std::string(name), "found an exitance that is negative, infinite, or beyond 1e30");
    MaterialOverride fields;
    fields.exitance = exitance;
    return set_material(name, std::move(material), fields);
}

Status SceneSession::dim(std::string light_group, double scale) {
    if (!(scale >= 0 && std::isfinite(scale))) return bad_input(light_group, "found a scale that is negative or infinite");
    light_scales_[std::move(light_group)] = scale;
    return Done{};
}

Result<const Solution*> SceneSession::solve(const Progress& progress) {
    auto scene = open_scene(manifest_, wanted_, opened_);
    if (!scene) return scene.error();
    for (const auto& [group, scale] : light_scales_) dim_group(*scene, group, scale);
    leave_out(options_.overrides, *scene);
    for (const auto& object : scene->objects)
        if (std::find(opened_.begin(), opened_.end(), object) == opened_.end()) opened_.push_back(object);
    const auto shared = std::make_shared<const Scene>(std::move(*scene));
    auto solution = solver_.solve(shared, options_, progress);
    if (!solution) return solution.error();
    scene_ = shared;
    solution_ = std::make_unique<const Solution>(std::move(*solution));
    return solution_.get();
}

Result<Vec3> SceneSession::radiosity(std::string_view name, std::uint32_t triangle) const {
    for (std::size_t i = 0; solution_ && i < scene_->instances.size(); ++i) {
        const Instance& instance = scene_->instances[i];
        if (instance.name != name) continue;
        const auto& source = instance.data().source_triangle;
        const auto at = std::find(source.begin(), source.end(), triangle);
        if (at == source.end()) return bad_input(std::string(name), "no triangle " + std::to_string(triangle));
        const std::uint32_t face = instance.object->front_face[static_cast<std::size_t>(at - source.begin())];
        return to_double(solution_->instances[i].radiosity[face]);
    }
    return bad_input(std::string(name), solution_ ? "no instance of this name in the scene solved" : "nothing is solved yet");
}

}  // namespace rro
