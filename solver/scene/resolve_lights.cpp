#include "solver/scene/resolve_lights.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "format/tool/json_document.h"
#include "solver/scene/radiance_image.h"

namespace rro {
namespace {

// Watts per lumen of white light, as in Radiance's ies2rad: 1 / 179.
constexpr double kLumensPerWatt = 179;

constexpr double kDegree = std::numbers::pi / 180;

/// An error of a file, at the place in the manifest that names it.
Error at_place(const Scene& scene, const std::string& pointer, Error error) {
    error.message = error.where + ": " + error.message;
    error.where = json_place(scene.manifest.path.string(), pointer);
    return error;
}

Result<Sky> resolved_sky(const Scene& scene, const SkyEntry& entry) {
    if (entry.radiance) return Sky::uniform(*entry.radiance, entry.ground);
    if (entry.cie_overcast) return Sky::cie_overcast(*entry.cie_overcast, entry.ground);
    auto image = read_sky_image(entry.image);
    if (!image) return at_place(scene, "/sky/image", image.error());
    for (Rgb& pixel : image->pixels) {
        const Vec3 scaled = to_double(pixel) * entry.scale;
        pixel = to_float(scaled);
        if (!is_usable_power(max_component(scaled)) && max_component(scaled) > 1)
            return at_place(scene, "/sky/image",
                            bad_input(entry.image.string(), "has a radiance above 1e30 W/(m^2 sr), scaled"));
    }
    return Sky::image(image->width, image->height, std::move(image->pixels), entry.ground);
}

Result<PointLight> resolved_light(const Scene& scene, std::size_t number) {
    const LightEntry& entry = scene.manifest.lights[number];
    PointLight light;
    light.name = entry.name;
    light.position = entry.position;
    light.direction = entry.direction;
    light.intensity = entry.intensity.value_or(Vec3{});
    if (entry.type == LightEntry::Type::Spot) light.cone_cosine = std::cos(0.5 * entry.cone_degrees * kDegree);
    if (entry.type != LightEntry::Type::Ies) return light;
    auto web = read_ies(entry.file);
    if (!web) return at_place(scene, "/lights/" + std::to_string(number) + "/file", web.error());
    if (!entry.intensity) light.intensity = Vec3{1, 1, 1} * (web->largest() / kLumensPerWatt);
    light.measured = std::make_shared<const IesDistribution>(std::move(*web));
    return light;
}

/// Numbers light groups by the order of their names.
class LightGroups {
  public:
    explicit LightGroups(const Manifest& manifest) {
        for (const InstanceEntry& instance : manifest.instances)
            for (const auto& [material, said] : instance.materials)
                if (said.group) numbers_.emplace(*said.group, 0);
        for (const LightEntry& light : manifest.lights)
            if (!light.group.empty()) numbers_.emplace(light.group, 0);
        for (auto& [name, number] : numbers_) {
            number = static_cast<std::uint32_t>(names.size());
            names.push_back(name);
        }
    }
    std::uint32_t operator[](const std::string& name) const { return name.empty() ? 0 : numbers_.at(name); }

    std::vector<std::string> names = {""};

  private:
    std::map<std::string, std::uint32_t> numbers_;
};

/// As with the other fields of a material: "*" first, then the exact name.
void resolve_groups(const InstanceEntry& entry, const LightGroups& groups, Instance& instance) {
    if (std::none_of(entry.materials.begin(), entry.materials.end(), [](const auto& m) { return m.second.group; })) return;
    const ObjectData& data = instance.data();
    std::vector<std::uint32_t> of_material(data.materials.size(), 0);
    for (const auto& [name, said] : entry.materials)
        for (std::size_t m = 0; m < of_material.size(); ++m)
            if (said.group && (name == "*" || name == data.materials[m].name)) of_material[m] = groups[*said.group];
    for (const Patch& patch : data.patches) instance.light_group.push_back(of_material[patch.material]);
}

}  // namespace

Status resolve_lights(Scene& scene) {
    const Manifest& manifest = scene.manifest;
    if (manifest.sky) {
        auto sky = resolved_sky(scene, *manifest.sky);
        if (!sky) return sky.error();
        if (!sky->dark()) scene.sky = std::move(*sky);
    }
    if (manifest.sun && manifest.sun->irradiance != Vec3{})
        scene.sun = Sun{manifest.sun->direction, manifest.sun->irradiance, 0.5 * manifest.sun->angular_diameter * kDegree};
    const LightGroups groups(manifest);
    scene.light_groups = groups.names;
    for (std::size_t i = 0; i < manifest.lights.size(); ++i) {
        auto light = resolved_light(scene, i);
        if (!light) return light.error();
        light->group = groups[manifest.lights[i].group];
        if (light->intensity != Vec3{}) scene.lights.push_back(std::move(*light));
    }
    if (manifest.absorption && *manifest.absorption != Vec3{}) scene.medium = Medium{*manifest.absorption};
    for (std::size_t i = 0; i < scene.instances.size(); ++i)
        resolve_groups(manifest.instances[i], groups, scene.instances[i]);
    return Done{};
}

}  // namespace rro
