#include <algorithm>
#include <cassert>

#include "format/tool/names.h"
#include "solver/effects/effect.h"
#include "solver/effects/rules.h"

namespace rro {
namespace {

bool listed_in(std::string_view name, std::span<const std::string> names) {
    return std::find(names.begin(), names.end(), name) != names.end();
}

Error usage(std::string message, std::string hint = {}) {
    return {ErrorKind::Usage, "", std::move(message), std::move(hint)};
}

Status check_names(const EffectOverrides& overrides) {
    const std::vector<std::string> effects(kEffects.begin(), kEffects.end());
    for (const auto* list : {&overrides.with, &overrides.without})
        for (const std::string& name : *list) {
            const std::string option = list == &overrides.with ? "--with " : "--without ";
            if (!listed_in(name, effects))
                return usage(option + name + ": no such effect, expected one of: " + listed(effects),
                             nearest_hint(name, effects));
            if (listed_in(name, overrides.with) && listed_in(name, overrides.without))
                return usage("--with " + name + " and --without " + name + " contradict one another");
        }
    return Done{};
}

/// Switches by hand, with a warning where the plan says otherwise.
void apply(const EffectOverrides& overrides, Plan& plan) {
    for (EffectPlan& effect : plan.effects) {
        if (listed_in(effect.name, overrides.with) && !effect.on) {
            plan.warnings.push_back("--with " + effect.name + ": not called for (" + effect.reason + ")");
            effect = {effect.name, true, "asked for by --with"};
        }
        if (listed_in(effect.name, overrides.without)) {
            plan.warnings.push_back("--without " + effect.name + ": left out, whatever the scene calls for");
            effect = {effect.name, false, "left out by --without"};
        }
    }
}

}  // namespace

bool Plan::called_for(std::string_view name) const {
    return std::any_of(effects.begin(), effects.end(), [&](const EffectPlan& e) { return e.on && e.name == name; });
}

EffectPlan& Plan::operator[](std::string_view name) {
    const auto found =
        std::find_if(effects.begin(), effects.end(), [&](const EffectPlan& e) { return e.name == name; });
    assert(found != effects.end());
    return *found;
}

Status all_built(const Plan& plan, std::span<const std::string_view> built, const std::string& manifest) {
    for (const EffectPlan& effect : plan.effects)
        if (effect.on && std::find(built.begin(), built.end(), effect.name) == built.end())
            return bad_input(manifest, "calls for " + effect.name + " (" + effect.reason + "), which this build leaves out",
                             "use a build that has it (-DRRO_EFFECTS), or leave it out with --without " + effect.name);
    return Done{};
}

Result<Plan> plan_effects(const Scene& scene, const EffectOverrides& overrides) {
    if (auto names = check_names(overrides); !names) return names.error();
    Plan plan;
    plan.effects = called_for(scene);
    apply(overrides, plan);
    if (auto built = all_built(plan, kChosenEffects, scene.manifest.path.string()); !built) return built.error();
    plan.channels = plan.on("colour") ? 3 : 1;
    return plan;
}

void leave_out(const EffectOverrides& overrides, Scene& scene) {
    const auto mean = [](const Rgb& c) { return to_float(grey(to_double(c))); };
    const auto without = [&](const char* name) { return listed_in(name, overrides.without); };
    const bool no_emitters = without("emitters"), no_textures = without("textures"), no_colour = without("colour");
    for (Instance& instance : scene.instances) {
        if (without("transmission")) instance.transmittance.clear();
        if (without("groups")) instance.light_group.clear();
        for (std::size_t p = 0; p < instance.data().patches.size(); ++p) {
            const Patch& patch = instance.data().patches[p];
            const Material& material = instance.data().materials[patch.material];
            if (no_emitters) instance.exitance[p] = {};
            if (no_textures && material.textured && instance.reflectance[p] == patch.reflectance)
                instance.reflectance[p] = to_float(material.reflectance);
            if (no_colour) {
                instance.reflectance[p] = mean(instance.reflectance[p]);
                instance.exitance[p] = mean(instance.exitance[p]);
                if (!instance.transmittance.empty()) instance.transmittance[p] = mean(instance.transmittance[p]);
            }
        }
    }
    if (without("sky")) scene.sky.reset();
    if (without("sun")) scene.sun.reset();
    if (without("lights")) scene.lights.clear();
    if (without("medium")) scene.medium.reset();
    if (without("groups")) scene.light_groups.resize(1);
    if (without("groups"))
        for (PointLight& light : scene.lights) light.group = 0;
    if (!no_colour) return;
    if (scene.sky) scene.sky = scene.sky->grey();
    if (scene.sun) scene.sun->irradiance = grey(scene.sun->irradiance);
    for (PointLight& light : scene.lights) light.intensity = grey(light.intensity);
    if (scene.medium) scene.medium->absorption = grey(scene.medium->absorption);
}

}  // namespace rro
