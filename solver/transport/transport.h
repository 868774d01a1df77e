// --method reusable: hierarchical transport between reusable objects. Far pairs of clusters meet through their archives'
// direction tables, near pairs of triangles through exact form factors and rays; one error estimate decides which.
#pragma once

#include <cstdint>

#include "format/result.h"
#include "solver/effects/effect.h"
#include "solver/progress.h"
#include "solver/scene/scene.h"
#include "solver/solution.h"
#include "solver/visibility/visibility.h"

namespace rro {

/// What the reusable method is asked for.
struct TransportOptions {
    double accuracy = 0.02;  // area-weighted relative RMS error of the reflected radiosity
    std::uint64_t seed = 1;
    VisibilityMethod visibility = VisibilityMethod::Auto;
    double far_factor = 5;   // the five-times rule: a pair is far where distance >= factor * larger radius
};

/// How often links came and went.
struct LinkChange {
    std::uint64_t removed = 0, retested = 0, added = 0;  // retested: judged again, and still a link
};

/// Links, visibility, iteration and refinement until the error estimate is below `accuracy` or no refinement is left.
/// The result does not depend on the number of threads.
///
/// returns  radiosity and irradiance per face and element; `converged` tells whether the estimate met the accuracy
/// errors   none
Result<Solution> solve_reusable(const Scene& scene, const Plan& plan, const TransportOptions& options,
                                const Progress& progress = {});

}  // namespace rro
