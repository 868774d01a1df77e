#include "compiler/effective_area.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>

#include "compiler/intrinsic_area.h"
#include "compiler/seen_area.h"
#include "compiler/visible_share.h"

namespace rro {
namespace {

constexpr std::size_t kAreaClusters = 1024;  // as many as the link builder visits often; the rest sum their patches

/// The largest clusters by area, in preorder. Parents are at least as large as their children and come before them, so
/// every ancestor of a chosen cluster is chosen.
std::vector<std::uint32_t> largest_clusters(std::span<const Cluster> clusters, std::size_t count) {
    std::vector<std::uint32_t> chosen(clusters.size());
    std::iota(chosen.begin(), chosen.end(), 0u);
    std::stable_sort(chosen.begin(), chosen.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return clusters[a].area > clusters[b].area; });
    chosen.resize(std::min(chosen.size(), count));
    std::sort(chosen.begin(), chosen.end());
    return chosen;
}

std::vector<Vec3> node_directions(const DirectionGrid& grid) {
    std::vector<Vec3> directions;
    for (std::uint32_t node = 0; node < grid.size(); ++node) directions.push_back(grid.direction(node));
    return directions;
}

/// To a byte, in steps that leave the archive small.
std::uint8_t visibility_byte(double share) {
    constexpr double kSteps = 31;  // rounding by at most 0.016, a tenth of what interpolation errs by; halves the bytes
    return static_cast<std::uint8_t>(std::lround(255 * std::round(kSteps * share) / kSteps));
}

/// To a byte, likewise: rounding by at most 0.4 % of the table's largest value, far below what interpolation errs by; a
/// seventh of the bytes.
std::uint8_t area_byte(double share) {
    constexpr double kSteps = 127;
    return static_cast<std::uint8_t>(std::lround(255 * std::round(kSteps * share) / kSteps));
}

/// Tables of D values each to 8 bits with the table's largest value as its scale.
void quantise(std::span<const double> cosine, std::span<const float> share, std::size_t directions,
              std::vector<std::uint8_t>& table, std::vector<float>& scale) {
    table.reserve(cosine.size());
    for (std::size_t row = 0; row < cosine.size(); row += directions) {
        double largest = 0;
        for (std::size_t i = row; i < row + directions; ++i)
            largest = std::max(largest, cosine[i] * static_cast<double>(share[i]));
        scale.push_back(static_cast<float>(largest));
        for (std::size_t i = row; i < row + directions; ++i) {
            const double value = largest > 0 ? cosine[i] * static_cast<double>(share[i]) / largest : 0;
            table.push_back(area_byte(value));
        }
    }
}

void store_visibility(const SeenCounts& counts, const DirectionGrid& grid, EffectiveAreas& areas) {
    areas.visibility.reserve(counts.patches.seen.size());
    for (const float share : visible_shares(counts.patches, counts.whole, grid))
        areas.visibility.push_back(visibility_byte(static_cast<double>(share)));
}

/// ranges   the faces of areas.clusters
void store_areas(const ObjectData& object, const SeenCounts& counts, const DirectionGrid& grid,
                 std::span<const FaceRange> ranges, EffectiveAreas& areas) {
    const std::vector<Vec3> directions = node_directions(grid);
    const std::vector<double> cosine = cosine_sums(object, directions, ranges);
    quantise(cosine, visible_shares(counts.clusters, counts.whole, grid), grid.size(), areas.whole, areas.whole_scale);
    if (object.meta.convex) {  // nothing hides anything
        areas.intrinsic = areas.whole;
        areas.intrinsic_scale = areas.whole_scale;
    } else {
        const SampleCounts own = count_intrinsic(object, directions, areas.clusters);
        quantise(cosine, visible_shares(own, counts.whole, grid), grid.size(), areas.intrinsic, areas.intrinsic_scale);
    }
}

}  // namespace

EffectiveAreas measure_effective_areas(const ObjectData& object, const TableChoice& tables) {
    assert(!object.faces.empty() && object.meta.image_resolution > 0);
    assert(tables.area || tables.visibility);
    const DirectionGrid grid(object.meta.grid_map, object.meta.grid_size);
    EffectiveAreas areas;
    if (tables.area)
        areas.clusters =
            largest_clusters(object.clusters, tables.every_node ? object.clusters.size() : kAreaClusters);
    const std::vector<FaceRange> ranges = cluster_ranges(object, areas.clusters);
    const SeenCounts counts = count_seen_areas(object, node_directions(grid), ranges);
    if (tables.visibility) store_visibility(counts, grid, areas);
    if (tables.area) store_areas(object, counts, grid, ranges, areas);
    return areas;
}

}  // namespace rro
