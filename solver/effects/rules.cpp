#include "solver/effects/rules.h"

#include <algorithm>
#include <cstdio>
#include <set>

#include "solver/effects/shape.h"

namespace rro {
namespace {

constexpr const char* kDark = "nothing gives light";
constexpr const char* kNotAsked = "not in the manifest";

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
    bool light = false;       // does anything give light?
    bool from_outside = false;  // do sky, sun or lights?
};

Sight sight(const Scene& scene, bool light) {
    Sight s;
    s.instances = scene.instances.size();
    s.light = light;
    s.from_outside = scene.sky || scene.sun || !scene.lights.empty();
    std::set<const Object*> innocent;  // looked at once each
    for (const Instance& instance : scene.instances)
        if (innocent.insert(instance.object).second && !sees_nothing_of_itself(instance.data())) {
            s.self_seeing = instance.name;
            break;
        }
    return s;
}

EffectPlan interreflection(const Scene& scene, const Sight& s) {
    const std::string name = "interreflection";
    if (!s.light) return {name, false, kDark};
    if (s.instances == 1 && s.self_seeing.empty())
        return {name, false, "one object, convex or flat: nothing sees anything"};
    const Found found = find_patch(scene, [](const Instance& i, std::size_t p) { return !black(i.reflectance[p]); });
    if (!found) return {name, false, "all reflectances are 0"};
    return {name, true,
            found.instance->name + ": reflectance " + amount(found.instance->reflectance[found.patch]) +
                " at material " + found.material()};
}

/// Between two surfaces, each convex or flat, a segment that leaves one front and meets the other's front passes
/// through nothing else: a convex or flat body is not met twice from outside. Three bodies can block, and light from
/// outside is one more.
EffectPlan occlusion(const Sight& s) {
    const std::string name = "occlusion";
    if (!s.light) return {name, false, kDark};
    if (!s.self_seeing.empty()) return {name, true, s.self_seeing + ": neither convex nor flat"};
    if (s.instances > 2) return {name, true, std::to_string(s.instances) + " objects"};
    if (s.instances == 2 && s.from_outside) return {name, true, "two objects, and light from outside"};
    return {name, false, s.instances == 1 ? "one object, convex or flat" : "two objects, each convex or flat"};
}

EffectPlan self(const Sight& s) {
    const std::string name = "self";
    if (!s.light) return {name, false, kDark};
    if (s.self_seeing.empty()) return {name, false, "every object is convex or flat"};
    return {name, true, s.self_seeing + ": neither convex nor flat"};
}

/// The first light from outside that is not grey, or what weakens it.
std::string coloured_surroundings(const Scene& scene) {
    if (scene.sky && !scene.sky->is_grey()) return "the sky is not grey";
    if (scene.sun && !grey(to_float(scene.sun->irradiance)))
        return "sun: irradiance " + amount(to_float(scene.sun->irradiance)) + " W/m^2";
    for (const PointLight& light : scene.lights)
        if (!grey(to_float(light.intensity)))
            return "light " + light.name + ": intensity " + amount(to_float(light.intensity)) + " W/sr";
    if (scene.medium && !grey(to_float(scene.medium->absorption)))
        return "medium: absorption " + amount(to_float(scene.medium->absorption)) + " 1/m";
    return {};
}

EffectPlan colour(const Scene& scene) {
    const Found found = find_patch(scene, [](const Instance& i, std::size_t p) {
        return !grey(i.reflectance[p]) || !grey(i.exitance[p]) || !grey(i.transmittance_of(p));
    });
    if (!found) {
        const std::string surroundings = coloured_surroundings(scene);
        if (surroundings.empty()) return {"colour", false, "every reflectance and every light is grey"};
        return {"colour", true, surroundings};
    }
    const Rgb reflectance = found.instance->reflectance[found.patch], exitance = found.instance->exitance[found.patch];
    const std::string what =
        !grey(reflectance) ? "reflectance " + amount(reflectance)
        : !grey(exitance)  ? "exitance " + amount(exitance) + " W/m^2"
                           : "transmittance " + amount(found.instance->transmittance_of(found.patch));
    return {"colour", true, found.instance->name + ": " + what + " at material " + found.material()};
}

EffectPlan sky(const Scene& scene) {
    if (scene.sky)
        return {"sky", true, scene.sky->has_ground() ? "light from above the horizon" : "light from all around"};
    return {"sky", false, scene.manifest.sky ? "its radiance is 0" : kNotAsked};
}

EffectPlan sun(const Scene& scene) {
    if (scene.sun) return {"sun", true, "irradiance " + amount(to_float(scene.sun->irradiance)) + " W/m^2"};
    return {"sun", false, scene.manifest.sun ? "its irradiance is 0" : kNotAsked};
}

EffectPlan lights(const Scene& scene) {
    if (scene.lights.empty())
        return {"lights", false, scene.manifest.lights.empty() ? kNotAsked : "their intensities are 0"};
    const PointLight& light = scene.lights.front();
    return {"lights", true,
            light.name + ": intensity " + amount(to_float(light.intensity)) + " W/sr" +
                (scene.lights.size() > 1 ? ", and " + std::to_string(scene.lights.size() - 1) + " more" : "")};
}

EffectPlan transmission(const Scene& scene) {
    const Found found =
        find_patch(scene, [](const Instance& i, std::size_t p) { return !black(i.transmittance_of(p)); });
    if (!found) return {"transmission", false, "no surface transmits"};
    return {"transmission", true,
            found.instance->name + ": transmittance " + amount(found.instance->transmittance_of(found.patch)) +
                " at material " + found.material()};
}

/// A light group counts where something in it gives light.
EffectPlan groups(const Scene& scene) {
    const Found found = find_patch(scene, [](const Instance& i, std::size_t p) {
        return i.light_group_of(p) > 0 && !black(i.exitance[p]);
    });
    if (found)
        return {"groups", true,
                found.instance->name + ": material " + found.material() + " is in light group " +
                    scene.light_groups[found.instance->light_group_of(found.patch)]};
    for (const PointLight& light : scene.lights)
        if (light.group > 0)
            return {"groups", true, "light " + light.name + " is in light group " + scene.light_groups[light.group]};
    return {"groups", false, scene.light_groups.size() > 1 ? "nothing in a light group gives light" : "no light group"};
}

EffectPlan medium(const Scene& scene) {
    if (scene.medium) return {"medium", true, "absorption " + amount(to_float(scene.medium->absorption)) + " 1/m"};
    return {"medium", false, scene.manifest.absorption ? "its absorption is 0" : kNotAsked};
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

}  // namespace

std::vector<EffectPlan> called_for(const Scene& scene) {
    const EffectPlan emission = emitters(scene), from_sky = sky(scene), from_sun = sun(scene), from_lights = lights(scene);
    const Sight s = sight(scene, emission.on || from_sky.on || from_sun.on || from_lights.on);
    return {emission, interreflection(scene, s), occlusion(s),        self(s),          colour(scene),  from_sky,
            from_sun, from_lights,               transmission(scene), textures(scene), groups(scene), medium(scene)};
}

}  // namespace rro
