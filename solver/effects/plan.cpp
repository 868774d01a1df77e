#include <algorithm>
#include <cassert>
#include <cstdio>
#include <set>

#include "format/tool/names.h"
#include "solver/effects/effect.h"
#include "solver/effects/shape.h"

namespace rro {
namespace {

/// In the contract's order.
constexpr const char* kEffects[] = {"emitters", "interreflection", "occlusion",    "self",     "colour", "sky",
                                    "sun",      "lights",          "transmission", "textures", "groups", "medium"};
constexpr const char* kNotBuilt[] = {"sky", "sun", "lights", "transmission", "groups", "medium"};

bool listed_in(std::string_view name, std::span<const std::string> names) {
    return std::find(names.begin(), names.end(), name) != names.end();
}

bool is_built(std::string_view name) {
    return std::find(std::begin(kNotBuilt), std::end(kNotBuilt), name) == std::end(kNotBuilt);
}

bool grey(const Rgb& c) {
    return c.x == c.y && c.y == c.z;
}

bool black(const Rgb& c) {
    return c == Rgb{};
}

std::string amount(const Rgb& c) {
    char text[96];
    if (grey(c))
        std::snprintf(text, sizeof text, "%.6g", static_cast<double>(c.x));
    else
        std::snprintf(text, sizeof text, "(%.6g, %.6g, %.6g)", static_cast<double>(c.x), static_cast<double>(c.y),
                      static_cast<double>(c.z));
    return text;
}

const std::string& material_name(const Instance& instance, std::size_t patch) {
    return instance.data().materials[instance.data().patches[patch].material].name;
}

/// The first patch of the scene, in manifest order, that `is_one` says yes to: is_one(instance, patch number).
struct Found {
    const Instance* instance = nullptr;
    std::size_t patch = 0;
    explicit operator bool() const { return instance != nullptr; }
    std::string material() const { return material_name(*instance, patch); }
};

template <class Predicate>
Found find_patch(const Scene& scene, const Predicate& is_one) {
    for (const Instance& instance : scene.instances)
        for (std::size_t p = 0; p < instance.data().patches.size(); ++p)
            if (is_one(instance, p)) return {&instance, p};
    return {};
}

EffectPlan emitters(const Scene& scene) {
    const Found found = find_patch(scene, [](const Instance& i, std::size_t p) { return !black(i.exitance[p]); });
    if (!found) return {"emitters", false, "no surface emits"};
    return {"emitters", true,
            found.instance->name + ": exitance " + amount(found.instance->exitance[found.patch]) +
                " W/m^2 at material " + found.material()};
}

/// What can be told about who sees whom from the shapes of the objects alone.
struct Sight {
    std::size_t instances = 0;
    std::string self_seeing;  // the first instance that is neither convex nor flat, or empty
    bool light = false;       // does anything emit?
};

Sight sight(const Scene& scene, bool light) {
    std::set<const Object*> innocent;  // looked at once each
    for (const Instance& instance : scene.instances)
        if (innocent.insert(instance.object).second && !sees_nothing_of_itself(instance.data()))
            return {scene.instances.size(), instance.name, light};
    return {scene.instances.size(), {}, light};
}

EffectPlan interreflection(const Scene& scene, const Sight& s) {
    const std::string name = "interreflection";
    if (!s.light) return {name, false, "no surface emits"};
    if (s.instances == 1 && s.self_seeing.empty())
        return {name, false, "one object, convex or flat: nothing sees anything"};
    const Found found = find_patch(scene, [](const Instance& i, std::size_t p) { return !black(i.reflectance[p]); });
    if (!found) return {name, false, "all reflectances are 0"};
    return {name, true,
            found.instance->name + ": reflectance " + amount(found.instance->reflectance[found.patch]) +
                " at material " + found.material()};
}

/// Between two surfaces, each convex or flat, a segment that leaves one front and meets the other's front passes
/// through nothing else: a convex or flat body is not met twice from outside. Three bodies can block.
EffectPlan occlusion(const Sight& s) {
    const std::string name = "occlusion";
    if (!s.light) return {name, false, "no surface emits"};
    if (!s.self_seeing.empty()) return {name, true, s.self_seeing + ": neither convex nor flat"};
    if (s.instances > 2) return {name, true, std::to_string(s.instances) + " objects"};
    return {name, false, s.instances == 1 ? "one object, convex or flat" : "two objects, each convex or flat"};
}

EffectPlan self(const Sight& s) {
    const std::string name = "self";
    if (!s.light) return {name, false, "no surface emits"};
    if (s.self_seeing.empty()) return {name, false, "every object is convex or flat"};
    return {name, true, s.self_seeing + ": neither convex nor flat"};
}

EffectPlan colour(const Scene& scene) {
    const Found found = find_patch(
        scene, [](const Instance& i, std::size_t p) { return !grey(i.reflectance[p]) || !grey(i.exitance[p]); });
    if (!found) return {"colour", false, "all reflectances and exitances are grey"};
    const Rgb reflectance = found.instance->reflectance[found.patch], exitance = found.instance->exitance[found.patch];
    return {"colour", true,
            found.instance->name + ": " +
                (grey(reflectance) ? "exitance " + amount(exitance) + " W/m^2" : "reflectance " + amount(reflectance)) +
                " at material " + found.material()};
}

/// A texture counts where its patches still have reflectances of their own, not the manifest's single one.
EffectPlan textures(const Scene& scene) {
    const Found found = find_patch(scene, [](const Instance& i, std::size_t p) {
        const Patch& patch = i.data().patches[p];
        return i.data().materials[patch.material].textured && i.reflectance[p] == patch.reflectance;
    });
    if (!found) return {"textures", false, "no textured material, or the manifest replaces the texture"};
    return {"textures", true, found.instance->name + ": material " + found.material() + " has a texture"};
}

Error usage(std::string message, std::string hint = {}) {
    return {ErrorKind::Usage, "", std::move(message), std::move(hint)};
}

Status check_names(const EffectOverrides& overrides) {
    const std::vector<std::string> effects(std::begin(kEffects), std::end(kEffects));
    for (const auto* list : {&overrides.with, &overrides.without})
        for (const std::string& name : *list) {
            const std::string option = list == &overrides.with ? "--with " : "--without ";
            if (!listed_in(name, effects))
                return usage(option + name + ": no such effect, expected one of: " + listed(effects),
                             nearest_hint(name, effects));
            if (list == &overrides.with && !is_built(name))
                return usage(option + name + ": not supported by this version");
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
            if (is_built(effect.name))
                plan.warnings.push_back("--without " + effect.name + ": left out, whatever the scene calls for");
            effect = {effect.name, false, "left out by --without"};
        }
    }
}

}  // namespace

bool Plan::on(std::string_view name) const {
    return std::any_of(effects.begin(), effects.end(), [&](const EffectPlan& e) { return e.on && e.name == name; });
}

EffectPlan& Plan::operator[](std::string_view name) {
    const auto found =
        std::find_if(effects.begin(), effects.end(), [&](const EffectPlan& e) { return e.name == name; });
    assert(found != effects.end());
    return *found;
}

Result<Plan> plan_effects(const Scene& scene, const EffectOverrides& overrides) {
    if (auto names = check_names(overrides); !names) return names.error();
    Plan plan;
    for (const char* name : kEffects) plan.effects.push_back({name, false, "not in the manifest"});
    plan["emitters"] = emitters(scene);
    const Sight s = sight(scene, plan.on("emitters"));
    plan["interreflection"] = interreflection(scene, s);
    plan["occlusion"] = occlusion(s);
    plan["self"] = self(s);
    plan["colour"] = colour(scene);
    plan["textures"] = textures(scene);
    apply(overrides, plan);
    plan.channels = plan.on("colour") ? 3 : 1;
    return plan;
}

void leave_out(const EffectOverrides& overrides, Scene& scene) {
    const auto mean = [](const Rgb& c) {
        const float m =
            static_cast<float>((static_cast<double>(c.x) + static_cast<double>(c.y) + static_cast<double>(c.z)) / 3);
        return Rgb{m, m, m};
    };
    const bool no_emitters = listed_in("emitters", overrides.without);
    const bool no_textures = listed_in("textures", overrides.without);
    const bool no_colour = listed_in("colour", overrides.without);
    for (Instance& instance : scene.instances)
        for (std::size_t p = 0; p < instance.data().patches.size(); ++p) {
            const Patch& patch = instance.data().patches[p];
            const Material& material = instance.data().materials[patch.material];
            if (no_emitters) instance.exitance[p] = {};
            if (no_textures && material.textured && instance.reflectance[p] == patch.reflectance)
                instance.reflectance[p] = to_float(material.reflectance);
            if (no_colour) {
                instance.reflectance[p] = mean(instance.reflectance[p]);
                instance.exitance[p] = mean(instance.exitance[p]);
            }
        }
}

}  // namespace rro
