#include "solver/transport/group_light.h"

#include <algorithm>
#include <cmath>

#include "format/parallel.h"

namespace rro {
namespace {

constexpr double kSame = 1e-5;  // relative: exitance is float

/// Calls f(instance number, patch) for all patches of a group.
template <class F>
void for_each_patch(const Scene& scene, std::uint32_t group, const F& f) {
    for (std::size_t i = 0; i < scene.instances.size(); ++i)
        for (std::size_t p = 0; p < scene.instances[i].exitance.size(); ++p)
            if (scene.instances[i].light_group_of(p) == group) f(i, p);
}

/// The strongest channel of any patch, W/m^2.
double strongest(const Scene& scene, std::uint32_t group) {
    double most = 0;
    for_each_patch(scene, group, [&](std::size_t i, std::size_t p) {
        most = std::max(most, max_component(to_double(scene.instances[i].exitance[p])));
    });
    return most;
}

}  // namespace

std::vector<std::uint32_t> changed_groups(const Scene& before, const Scene& after) {
    std::vector<std::uint32_t> groups;
    if (before.light_groups != after.light_groups) return groups;
    for (std::size_t i = 0; i < after.instances.size(); ++i) {
        const Instance &a = before.instances[i], &b = after.instances[i];
        if (a.light_group != b.light_group) return {};
        for (std::size_t p = 0; p < b.exitance.size(); ++p) {
            if (a.exitance[p] == b.exitance[p]) continue;
            if (b.light_group_of(p) == 0) return {};
            groups.push_back(b.light_group_of(p));
        }
    }
    std::sort(groups.begin(), groups.end());
    groups.erase(std::unique(groups.begin(), groups.end()), groups.end());
    return groups;
}

bool shines(const Scene& scene, std::uint32_t group) { return strongest(scene, group) > 0; }

std::optional<double> level_of_group(const Scene& scene, std::uint32_t group, const Scene& than) {
    const double most = strongest(than, group), level = strongest(scene, group) / most;
    bool same = true;
    for_each_patch(scene, group, [&](std::size_t i, std::size_t p) {
        const Vec3 expected = to_double(than.instances[i].exitance[p]) * level;
        same = same && length(to_double(scene.instances[i].exitance[p]) - expected) <= kSame * level * most;
    });
    if (!same) return std::nullopt;
    return level;
}

void SquareByLevel::add(double level, double square) {
    if (points_.size() < 2 && (points_.empty() || points_[0][0] != level)) points_.push_back({level, square});
}

std::optional<double> SquareByLevel::at(double level) const {
    if (points_.size() < 2) return std::nullopt;
    const auto [x, p] = points_[0];
    const auto [y, q] = points_[1];
    const double slope = (q - p) / (y - x) - leading_ * (x + y);
    return std::max(0.0, p + (level - x) * (slope + leading_ * (level + x)));
}

Solution sum_of_light(const Solution& base, const Solution& light, double times) {
    Solution out = base;
    const auto add = [&](Rgb& to, const Rgb& more) {
        const auto sum = [&](float x, float y) { return static_cast<float>(std::max(0.0, double(x) + times * double(y))); };
        to = {sum(to.x, more.x), sum(to.y, more.y), sum(to.z, more.z)};
    };
    parallel_for(out.instances.size(), 1, [&](std::size_t i) {
        InstanceSolution& to = out.instances[i];
        const InstanceSolution& from = light.instances[i];
        for (std::size_t f = 0; f < to.radiosity.size(); ++f) {
            add(to.radiosity[f], from.radiosity[f]);
            add(to.irradiance[f], from.irradiance[f]);
        }
        for (std::size_t e = 0; e < to.elements.size(); ++e) {
            add(to.elements[e].radiosity, from.elements[e].radiosity);
            add(to.elements[e].irradiance, from.elements[e].irradiance);
        }
    });
    out.energy.emitted += light.energy.emitted * times;
    out.energy.absorbed += light.energy.absorbed * times;
    out.energy.escaped = out.energy.emitted - out.energy.absorbed;
    return out;
}

}  // namespace rro
