// A row of factors by rays: for groups of so many polygons that pairs of them cannot be looked at one by one.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "solver/factors/surfaces.h"
#include "solver/visibility/scene_rays.h"

namespace rro {

struct SampledRow {
    std::vector<double> factor;          // [G]
    std::vector<double> standard_error;  // [G] from the scatter of independent replicates
    std::uint64_t rays = 0;
    bool converged = false;
};

/// What hits are counted as.
struct RayScene {
    const Scene& scene;
    const SurfaceGroups& groups;
    const Surfaces& surfaces;
    const SceneRays& rays;
    Sides sides = Sides::Front;
};

/// Cosine-weighted rays from points spread over the group by area, in 32 independently scrambled low-discrepancy sets
/// that are doubled until a third of the tolerance, accuracy * max(F, 0.01), is reached for every group in `wanted`.
///
/// returns  converged is false where the largest sets (2^20 points) do not get there
SampledRow sampled_row(const RayScene& scene, std::uint32_t group, std::span<const std::uint32_t> wanted,
                       double accuracy);

}  // namespace rro
