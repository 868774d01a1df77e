// Light is linear in what is emitted: the light of one light group by itself, from which dimmed scenes are added up.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "solver/scene/scene.h"

namespace rro {

/// What surfaces receive of one light group's light, all bounces included.
struct GroupLight {
    std::shared_ptr<const Scene> lit_in;  // with the group's exitance in this scene
    std::vector<float> irradiance;        // as LightField::irradiance()
    double residual = 0;                  // of R, as LightField::reflected_norm()
};

/// The light groups whose exitance differs between two scenes that are otherwise the same; empty where surfaces of no group
/// differ, too, or groups have other names.
std::vector<std::uint32_t> changed_groups(const Scene& before, const Scene& after);

bool shines(const Scene& scene, std::uint32_t group);

/// How many times brighter all surfaces of a group are than in another scene, where it shines; none where they differ in
/// other ways.
std::optional<double> level_of_group(const Scene& scene, std::uint32_t group, const Scene& than);

}  // namespace rro
