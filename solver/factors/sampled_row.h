// Factors by rays, a row or a pair at a time: for groups of so many polygons that pairs of them cannot be looked at one by one.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "solver/factors/surfaces.h"
#include "solver/visibility/scene_rays.h"

namespace rro {

/// The factors from one group to all G.
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
/// that are doubled until a third of the tolerance, accuracy * max(F, kSmallFactor), is reached for every group in `wanted`.
///
/// returns  converged is false where the largest sets (2^20 points) do not get there
SampledRow sampled_row(const RayScene& scene, std::uint32_t group, std::span<const std::uint32_t> wanted,
                       double accuracy);

/// The factor of one pair.
struct SampledPair {
    double factor = 0;
    double standard_error = 0;  // as above
    std::uint64_t rays = 0;
};

/// Are both farther from one another than either is large? Then sampled_pair needs a fraction of sampled_row's rays, the
/// fewer the smaller the factor.
bool lie_apart(const Box3& a, const Box3& b);

/// The factor between two groups that lie apart: points spread over both by area, in as many sets, a ray between each two that
/// face one another. The estimate of the opposite direction is independent.
SampledPair sampled_pair(const RayScene& scene, std::uint32_t from, std::uint32_t to, double accuracy);

}  // namespace rro
