#include "solver/effects/cost.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "solver/effects/shape.h"

namespace rro {
namespace {

// Fitted to 20 solves (Cornell box, twelve-object room, halls of boxes and of sample objects; 4 to 126 instances, 500 to
// 86,000 faces, accuracies 0.3 to 0.02). Processor seconds follow from links, rays and sweeps to 40 %; links from the
// counts of a scene to a factor of two, most of them.
constexpr double kSecondsPerLink = 12e-6;
constexpr double kSecondsPerRay = 0.46e-6;
constexpr double kSecondsPerFaceAndSweep = 2.5e-6;  // three channels
constexpr double kOneChannel = 0.5;                 // of that, with one channel instead of three
constexpr double kBytesPerLink = 100;
constexpr double kBytesPerFaceAndChannel = 40;

// Links between objects: so many per instance at a low accuracy, more for instances of many faces; from 0.1 on the
// accuracy counts more and more.
constexpr double kLinksPerInstance = 80, kFacesExponent = 0.4;
constexpr double kFineAccuracy = 0.09, kFineExponent = 2.4;

// Emitters, lamps' shades and windows light a scene from a few bright places: that takes more links where the places are
// curved, as shades are, or most faces are of curved objects. Light from all around, or from lamps without extent that no
// link leaves, takes fewer.
constexpr double kCurvedLinks = 2.2, kEvenLinks = 0.45;

// A sky that is seen through holes of a room alone: so many times more rays, links, and seconds for each of these (more
// rounds of division), by the ratio of a hole that makes no difference to those that there are.
constexpr double kWideOpen = 0.4, kWindowRays = 1.5, kWindowLinks = 0.67, kWindowSeconds = 0.75;
constexpr double kNarrowest = 0.01;  // of the fronts' area; a narrower hole lets in as good as nothing

// Links inside objects that see themselves: so many per face at 0.1.
constexpr double kSelfPerFace = 0.6, kSelfAccuracy = 0.1, kSelfExponent = 2.5;

constexpr double kRaysPerLink = 3.5, kRayAccuracy = 0.12, kRayExponent = 0.9;
constexpr double kSweeps = 8.5, kSweepAccuracy = 0.3, kSweepExponent = 0.5;
constexpr double kDirectSweeps = 4;  // where nothing is reflected: one for each round of refinement

// Sky, sun and each lamp: rays from every face, at 0.05, and more for a finer answer.
constexpr double kOutsideRaysPerFace = 70, kOutsideAccuracy = 0.05, kOutsideExponent = 1;

/// What the model counts.
struct Counts {
    double instances = 0, faces = 0, self_faces = 0, curved_faces = 0;
    double window = 1;  // how many times narrower than wide open the room around all else is
};

/// What holds for the room that an instance is, if all others stand in it.
double window_of(const Scene& scene, const Instance& instance) {
    const Vec3 slack = instance.bounds.extent() * 0.01;
    const Box3 room{instance.bounds.lo - slack, instance.bounds.hi + slack};
    const Box3 &all = scene.bounds;
    const auto within = [&](int k) { return all.lo[k] >= room.lo[k] && all.hi[k] <= room.hi[k]; };
    if (!within(0) || !within(1) || !within(2)) return 1;
    return std::max(1.0, kWideOpen / std::max(kNarrowest, openness(instance.data())));
}

Counts counts(const Scene& scene) {
    Counts c;
    struct Look {
        bool sees_itself, curved;
    };
    std::map<const Object*, Look> looks;  // looked at once each
    for (const Instance& instance : scene.instances) {
        const auto [known, is_new] = looks.emplace(instance.object, Look{});
        if (is_new) known->second = {!sees_nothing_of_itself(instance.data()), is_curved(instance.data())};
        const auto faces = static_cast<double>(instance.data().faces.size());
        c.faces += faces;
        if (known->second.sees_itself) c.self_faces += faces;
        if (known->second.curved) c.curved_faces += faces;
        if (scene.sky || scene.sun) c.window = std::max(c.window, window_of(scene, instance));
    }
    c.instances = static_cast<double>(scene.instances.size());
    return c;
}

double links_between(const Counts& c, double accuracy, const Plan& plan) {
    if (c.instances < 2) return 0;
    const bool bright_places = plan.on("emitters") || plan.on("transmission") || c.window > 1;
    const bool curved = plan.on("transmission") || 2 * c.curved_faces > c.faces;
    const double kind = !bright_places ? kEvenLinks : curved ? kCurvedLinks : 1;
    const double fine = 1 + std::pow(kFineAccuracy / accuracy, kFineExponent);
    return c.instances * kLinksPerInstance * std::pow(c.faces / c.instances, kFacesExponent) * fine * kind *
           std::pow(c.window, kWindowLinks);
}

double links_inside(const Counts& c, double accuracy) {
    return kSelfPerFace * c.self_faces * std::pow(kSelfAccuracy / accuracy, kSelfExponent) * std::pow(c.window, kWindowLinks);
}

Work work(double links, double rays, double bytes, double seconds) {
    const auto whole = [](double n) { return static_cast<std::uint64_t>(std::llround(n)); };
    return {whole(links), whole(rays), whole(bytes), seconds};
}

/// What carries light from object to object: where nothing is reflected, the emitters alone. Empty where there is none.
std::string carrier(const std::vector<EffectPlan>& effects) {
    for (const char* name : {"interreflection", "emitters"})
        for (const EffectPlan& e : effects)
            if (e.on && e.name == name) return name;
    return {};
}

Work sum_of(const std::vector<EffectPlan>& effects) {
    Work sum;
    for (const EffectPlan& effect : effects) {
        const Work w = effect.predicted.value_or(Work{});
        sum.links += w.links, sum.rays += w.rays, sum.bytes += w.bytes, sum.seconds += w.seconds;
    }
    return sum;
}

}  // namespace

Work predict_work(const Scene& scene, double accuracy, unsigned threads, Plan& plan) {
    const std::string carries = carrier(plan.effects);
    if (carries.empty()) return {};
    const Counts c = counts(scene);
    const double between = links_between(c, accuracy, plan), inside = plan.on("self") ? links_inside(c, accuracy) : 0;
    const double rays = (between + inside) * kRaysPerLink * std::max(1.0, std::pow(kRayAccuracy / accuracy, kRayExponent));
    const double sweeps = plan.on("interreflection") ? kSweeps * std::pow(kSweepAccuracy / accuracy, kSweepExponent)
                                                     : kDirectSweeps;
    const double sweeping = sweeps * c.faces * kSecondsPerFaceAndSweep / threads;
    const double per_link = kSecondsPerLink * std::pow(c.window, kWindowSeconds) / threads;

    plan[carries].predicted = work(between, 0, between * kBytesPerLink + c.faces * kBytesPerFaceAndChannel,
                                   between * per_link + sweeping * kOneChannel);
    if (plan.on("occlusion")) plan["occlusion"].predicted = work(0, rays, 0, rays * kSecondsPerRay / threads);
    if (plan.on("self")) plan["self"].predicted = work(inside, 0, inside * kBytesPerLink, inside * per_link);
    if (plan.on("colour"))
        plan["colour"].predicted = work(0, 0, 2 * c.faces * kBytesPerFaceAndChannel, sweeping * (1 - kOneChannel));
    for (const char* name : {"sky", "sun", "lights"}) {
        if (!plan.on(name)) continue;
        const double sources = std::string_view(name) == "lights" ? static_cast<double>(scene.lights.size()) : 1;
        const double finer = std::pow(kOutsideAccuracy / accuracy, kOutsideExponent);
        const double asked = plan.on("occlusion") ? sources * c.faces * kOutsideRaysPerFace * finer : 0;
        const double through = std::string_view(name) == "sky" ? std::pow(c.window, kWindowRays) : 1;
        plan[name].predicted = work(0, asked * through, 0, asked * through * kSecondsPerRay / threads);
    }
    return sum_of(plan.effects);
}

void account_seconds(Solution& solution) {
    const auto total = static_cast<double>(solution.links.total());
    const double inside = total > 0 ? static_cast<double>(solution.links.self) / total : 0;
    const std::string carries = carrier(solution.effects);
    const auto is_outside = [](const EffectPlan& e) { return e.name == "sky" || e.name == "sun" || e.name == "lights"; };
    const auto outside = std::count_if(solution.effects.begin(), solution.effects.end(),
                                       [&](const EffectPlan& e) { return e.on && is_outside(e); });
    for (EffectPlan& effect : solution.effects) {
        if (effect.on && is_outside(effect)) effect.seconds = solution.seconds.outside / static_cast<double>(outside);
        if (effect.name == carries) effect.seconds = solution.seconds.iterate + (1 - inside) * solution.seconds.links;
        if (effect.name == "self") effect.seconds = inside * solution.seconds.links;
        if (effect.name == "occlusion") effect.seconds = solution.seconds.visibility - solution.seconds.outside;
    }
}

}  // namespace rro
