// View factors between groups of surfaces, in order: groups, polygons, pairs (exact where nothing is between, cut out
// where few are, by rays where many are), closure and reciprocity.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "format/result.h"
#include "solver/factors/surface_groups.h"
#include "solver/progress.h"
#include "solver/scene/scene.h"

namespace rro {

struct FactorOptions {
    GroupBy by = GroupBy::Auto;
    Sides sides = Sides::Front;
    double accuracy = 1e-3;  // relative where F > 0.01; a hundredth of it absolute below
};

/// One number of a row.
struct Factor {
    std::uint32_t to = 0;
    float standard_error = 0;  // 0 where exact
    double value = 0;
};

/// How many pairs of groups were found how.
struct FactorCounts {
    std::uint64_t exact = 0;    // ordered pairs, zeros included
    std::uint64_t cut = 0;      // shadows cut out at the nodes of a rule
    std::uint64_t sampled = 0;  // by rays
    std::uint64_t missed = 0;   // of these, above the tolerance asked
    std::uint64_t rays = 0;
};

struct Factors {
    FactorOptions options;
    std::vector<std::string> names;         // [G]
    std::vector<double> area;               // [G] m^2
    std::vector<std::vector<Factor>> rows;  // [G] ascending; what is missing is exactly 0
    FactorCounts counts;
    std::uint64_t polygons = 0, blockers = 0;
};

/// Factors of all pairs. F_ij and F_ji are of independent estimates wherever something stands between.
///
/// progress  may be empty
/// errors    those of surface_groups; BadInput: a group without a side that exchanges
Result<Factors> view_factors(const Scene& scene, const FactorOptions& options, const Progress& progress = {});

/// Bytes that the matrix may need at worst, all pairs seeing each other, and the scene's polygons.
std::uint64_t factors_memory(const Scene& scene, GroupBy by);

}  // namespace rro
