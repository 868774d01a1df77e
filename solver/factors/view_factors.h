// View factors between groups of surfaces, in order: groups, polygons, pairs (exact where nothing is between, cut out
// where few are, by rays where many are), rows, closure and reciprocity.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "format/result.h"
#include "solver/factors/surface_groups.h"
#include "solver/progress.h"
#include "solver/scene/scene.h"

namespace rro {

struct PreviousFactors;

/// Below it tolerances are absolute, and a relative difference says nothing.
inline constexpr double kSmallFactor = 0.01;

/// What view factors are asked for.
struct FactorOptions {
    GroupBy by = GroupBy::Auto;
    Sides sides = Sides::Front;
    double accuracy = 1e-3;  // relative where F > kSmallFactor; times that, absolute, below
    std::uint64_t numbers_at_a_time = 12'000'000;  // of the matrix: rows are computed in blocks of about so many
    const PreviousFactors* previous = nullptr;     // what pairs that nothing has changed for are taken from
};

/// One number of a row.
struct Factor {
    std::uint32_t to = 0;
    float standard_error = 0;  // 0 where exact
    double value = 0;
};
using FactorRow = std::vector<Factor>;  // ascending; what is missing is exactly 0

/// How many pairs of groups were found how.
struct FactorCounts {
    std::uint64_t exact = 0;    // ordered pairs, zeros included
    std::uint64_t cut = 0;      // shadows cut out at the nodes of a rule
    std::uint64_t sampled = 0;  // by rays
    std::uint64_t reused = 0;   // taken from earlier factors
    std::uint64_t missed = 0;   // of those sampled, above the tolerance asked
    std::uint64_t rays = 0;
};

/// What an instance was when factors were computed, to tell whether it has changed since.
struct InstanceRecord {
    std::string name;
    std::string content;                // of its archive, SHA-256
    std::array<double, 12> to_world{};  // row by row
    Box3 bounds;                        // world
    std::vector<std::uint32_t> groups;  // [materials of its archive], or kNoGroup
};

/// How far rows are from 1 (an open scene leaves 1 what escapes) and pairs from reciprocity.
struct ClosureReport {
    std::vector<double> row_sum;         // [G]
    double largest_defect = 0;           // of |row sum - 1|
    std::uint32_t worst_row = 0;
    double mean_defect = 0;              // area-weighted mean of |row sum - 1|
    double largest_asymmetry = 0;        // of |A_i F_ij - A_j F_ji| / the smaller group's area
    double largest_relative_asymmetry = 0;  // the same relative to the larger of both, where a factor is above kSmallFactor
    std::uint32_t asymmetric_from = 0, asymmetric_to = 0;
};

/// All about a matrix but its rows.
struct FactorTable {
    FactorOptions options;
    std::vector<std::string> names;         // [G]
    std::vector<double> area;               // [G] m^2
    std::vector<InstanceRecord> instances;
    FactorCounts counts;
    ClosureReport closure;
    std::uint64_t polygons = 0, blockers = 0;
};

/// A matrix in memory.
struct Factors : FactorTable {
    std::vector<FactorRow> rows;  // [G]
};

/// Takes rows as they come, in order, some at a time. The table has options, names, areas and instances then.
using TakeRows = std::function<Status(const FactorTable& table, std::uint32_t first, std::span<const FactorRow> rows)>;

/// Factors of all pairs. F_ij and F_ji are of independent estimates wherever something stands between. In memory are some
/// rows, and the pairs with something between.
///
/// scene     open with kGeometry
/// progress  may be empty
/// errors    those of surface_groups; BadInput: a group without a side that exchanges; those of `take`
Result<FactorTable> view_factors(const Scene& scene, const FactorOptions& options, const TakeRows& take,
                                 const Progress& progress = {});

/// The same with all rows in memory.
Result<Factors> view_factors(const Scene& scene, const FactorOptions& options, const Progress& progress = {});

/// Bytes that may be needed at worst, all pairs seeing each other, and the scene's polygons.
///
/// whole    the whole matrix at once, and not only blocks of it
std::uint64_t factors_memory(const Scene& scene, const FactorOptions& options, bool whole);

}  // namespace rro
