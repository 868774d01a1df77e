#include "solver/edit/light_groups.h"

#include <algorithm>

#include "solver/edit/json_text.h"

namespace rro {
namespace {

double scale_of(const GroupScales& scales, std::string_view group) {
    const auto at = scales.find(group);
    return at == scales.end() ? 1 : at->second;
}

std::string scaled(const Vec3& power, double scale) {
    return json_numbers({power.x * scale, power.y * scale, power.z * scale});
}

/// One material's light as manifest and archive say: "*", then its name.
struct Emission {
    std::string group;
    Vec3 exitance;
};

Emission emission_of(const InstanceEntry& entry, const Material& material) {
    Emission emission{"", material.exitance};
    for (const auto& [name, said] : entry.materials) {
        if (name != "*" && name != material.name) continue;
        if (said.exitance) emission.exitance = *said.exitance;
        if (said.group) emission.group = *said.group;
    }
    return emission;
}

}  // namespace

Result<std::string> with_group_scales(const ManifestText& manifest, const Scene& scene, const GroupScales& scales) {
    ManifestText out = manifest;
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const auto& materials = scene.instances[i].data().materials;
        for (const Material& material : materials) {
            const Emission emission = emission_of(scene.manifest.instances[i], material);
            const double scale = scale_of(scales, emission.group);
            if (scale == 1 || emission.exitance == Vec3{}) continue;
            const auto same_name = std::count_if(materials.begin(), materials.end(),
                                                 [&](const Material& m) { return m.name == material.name; });
            if (same_name > 1)
                return bad_input(manifest.path.string() + ": /instances/" + std::to_string(i),
                                 "light group \"" + emission.group + "\" has " + std::to_string(same_name) +
                                     " materials of the name \"" + std::string(material.name) + "\", expected one");
            auto text = with_material_field(out, scene.instances[i].name, material.name, "exitance",
                                            scaled(emission.exitance, scale));
            if (!text) return text.error();
            out.text = std::move(*text);
        }
    }
    for (const PointLight& light : scene.lights) {
        const double scale = scale_of(scales, scene.light_groups[light.group]);
        if (scale == 1) continue;
        const auto& entries = scene.manifest.lights;
        const auto at = std::find_if(entries.begin(), entries.end(), [&](const auto& e) { return e.name == light.name; });
        const JsonSpan document = json_spans(out.text);
        out.text = with_member(out.text, document.find("lights")->values[static_cast<std::size_t>(at - entries.begin())],
                               "intensity", scaled(light.intensity, scale));
    }
    return std::move(out.text);
}

}  // namespace rro
