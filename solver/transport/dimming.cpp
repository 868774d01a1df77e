#include "solver/transport/dimming.h"

#include <cmath>
#include <utility>

#include "solver/transport/fill_guide.h"

namespace rro {

namespace {

// Light that is to be added up may be this part of the accuracy away from converged.
constexpr double kSummed = 0.01;

/// Solves for one group by itself, over the links there are: in the scene before a change if it shines there. Both this
/// and the light of the whole are iterated far enough for sums of them.
template <int C>
GroupLight light_of_group(const Settled<C>& solve, const std::shared_ptr<const Scene>& before, std::uint32_t group) {
    Stage<C>& stage = solve.stage;
    LightField<C>& field = stage.field;
    const double goal = kSummed * solve.accuracy, reflectance = solve.sources.largest_reflectance;
    stage.nodes.set_materials(*before);
    if (solve.residual.relative > goal) solve.residual = iterate(field, goal, reflectance, kMostSweeps);
    const std::vector<float> all = field.irradiance();
    GroupLight light;
    light.lit_in = shines(*before, group) ? before : stage.scene;
    stage.nodes.set_materials(*light.lit_in);
    field.emit_only(group);
    field.extinguish();
    const Residual left = iterate(field, goal, reflectance, kMostSweeps);
    light.irradiance = field.irradiance();
    light.residual = left.relative * field.reflected_norm();
    store_light(stage.nodes, field, {}, light.solution);
    Guide guide = solve.guide;
    fill_guide(stage.nodes, field, guide);
    const double growth = solve.closed ? 1.0 : amplification(stage.nodes, field, *stage.outside);
    light.error_square = std::pow(estimate_error(solve.set, stage.nodes, growth, {}, guide).whole, 2) * guide.reflected;
    light.light_square = guide.reflected;
    field.emit_only(LightField<C>::kAllGroups);
    field.set_irradiance(all);
    field.relight();
    return light;
}

}  // namespace

template <int C>
void Dimming<C>::forget() {
    groups_.clear();
    dimmer_ = {};
}

template <int C>
bool Dimming<C>::dim(const Settled<C>& solve, const std::shared_ptr<const Scene>& before, const std::vector<std::uint32_t>& groups) {
    LightField<C>& field = solve.stage.field;
    std::vector<std::pair<std::uint32_t, double>> changes;
    for (const std::uint32_t group : groups) {
        const auto level = [&](const Scene& scene) { return level_of_group(scene, group, *groups_[group].lit_in); };
        const bool known = groups_.count(group) > 0 && level(*before) && level(*solve.stage.scene);
        if (!known) groups_[group] = light_of_group(solve, before, group), dimmer_ = {};
        const auto then = level(*before), now = level(*solve.stage.scene);
        if (!then || !now) return false;
        changes.emplace_back(group, *now - *then);
    }
    // What the iterations left undone stays when the light goes.
    double left = solve.residual.relative * field.reflected_norm();
    for (const auto& [group, more] : changes) {
        field.add(groups_[group].irradiance, more);
        left += std::abs(more) * groups_[group].residual;
    }
    const double norm = field.reflected_norm();
    solve.residual.relative = norm > 0 ? left / norm : 0;
    return !changes.empty();
}

template <int C>
void Dimming<C>::remember(const Scene& scene, const std::vector<std::uint32_t>& groups, const Solution& solution, double error_square,
                          double light_square) {
    const std::uint32_t group = groups.front();
    const auto found = groups_.find(group);
    if (groups.size() != 1 || found == groups_.end()) {
        dimmer_ = {};
        return;
    }
    if (dimmer_.group != group)
        dimmer_ = {group, SquareByLevel(found->second.error_square), SquareByLevel(found->second.light_square), 0, 0, {}};
    dimmer_.level = dimmer_.now = level_of_group(scene, group, *found->second.lit_in).value_or(0);
    dimmer_.base = solution;
    dimmer_.base.seconds = {};
    dimmer_.error.add(dimmer_.level, error_square);
    dimmer_.light.add(dimmer_.level, light_square);
}

template <int C>
bool Dimming<C>::again(const Scene& scene, const std::vector<std::uint32_t>& groups, double area, double allowed, double accuracy,
                       Solution& solution) {
    if (groups.size() != 1 || groups[0] != dimmer_.group) return false;
    const GroupLight& group = groups_.at(dimmer_.group);
    const auto level = level_of_group(scene, dimmer_.group, *group.lit_in);
    if (!level) return false;
    const auto error = dimmer_.error.at(*level), light = dimmer_.light.at(*level);
    if (!error || !light || std::sqrt(*error) > allowed * std::sqrt(*light)) return false;
    const double more = *level - dimmer_.level;
    solution = sum_of_light(dimmer_.base, group.solution, more);
    const double norm = std::sqrt(*light / area);
    const double left = dimmer_.base.residual * std::sqrt(*dimmer_.light.at(dimmer_.level) / area) + std::abs(more) * group.residual;
    solution.residual = norm > 0 ? left / norm : 0;
    solution.estimated_error = std::hypot(*light > 0 ? std::sqrt(*error / *light) : 0, solution.residual);
    solution.converged = solution.estimated_error <= accuracy;
    solution.iterations = 0;
    dimmer_.now = *level;
    return true;
}

template <int C>
void Dimming<C>::catch_up(Stage<C>& stage, const Scene& scene) {
    if (dimmer_.now == dimmer_.level) return;
    stage.nodes.set_materials(scene);
    stage.field.add(groups_.at(dimmer_.group).irradiance, dimmer_.now - dimmer_.level);
    stage.field.relight();
    dimmer_ = {};
}

template class Dimming<1>;
template class Dimming<3>;

}  // namespace rro
