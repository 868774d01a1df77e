#include "compiler/table_error.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "compiler/intrinsic_area.h"
#include "compiler/seen_area.h"
#include "format/parallel.h"

namespace rro {
namespace {

// Each cluster's error is then known to about 15 %, for a sixth of the images that its tables took.
constexpr std::uint32_t kPairs = 12;

/// Evenly over the sphere, as opposite pairs (their lines are the same); none is a node of a grid but by chance.
/// source   spherical Fibonacci points
std::vector<Vec3> directions_between_nodes() {
    std::vector<Vec3> directions;
    for (std::uint32_t i = 0; i < kPairs; ++i) {
        const double y = (i + 0.5) / kPairs, turn = 2 * std::numbers::pi * i / std::numbers::phi;
        const double radius = std::sqrt(1 - y * y);
        const Vec3 w = normalised(Vec3{radius * std::cos(turn), y, radius * std::sin(turn)});
        directions.push_back(w);
        directions.push_back(-w);
    }
    return directions;
}

/// Sums over directions, of one cluster.
struct Squares {
    double difference = 0, measured = 0;

    /// Adds one comparison of areas: `table` against cosine * seen / covered.
    void add(double table, double cosine, std::uint32_t seen, std::uint32_t covered) {
        if (covered == 0) return;  // too small for the image: nothing was measured
        const double share = std::min(1.0, static_cast<double>(seen) / covered);
        const double noise = share * (1 - share) / covered;  // variance of a share of that many samples
        const double off = table - cosine * share;
        difference += off * off - cosine * cosine * noise;
        measured += cosine * cosine * share * share;
    }
    Squares& operator+=(const Squares& other) {
        difference += other.difference;
        measured += other.measured;
        return *this;
    }
    float relative_error() const {
        return measured > 0 ? static_cast<float>(std::sqrt(std::max(0.0, difference) / measured)) : 0;
    }
};

std::vector<float> area_errors(const DirectionGrid& grid, std::span<const Vec3> directions,
                               std::span<const std::uint8_t> table, std::span<const float> scale,
                               std::span<const double> cosine, const SampleCounts& counts) {
    std::vector<float> errors(scale.size());
    const std::size_t count = directions.size();
    parallel_for(scale.size(), 16, [&](std::size_t k) {
        const auto row = table.subspan(k * grid.size(), grid.size());
        Squares sum;
        for (std::size_t d = 0; d < count; ++d)
            sum.add(grid.interpolate(row, directions[d]) * static_cast<double>(scale[k]) / 255, cosine[k * count + d],
                    counts.seen[k * count + d], counts.covered[k * count + d]);
        errors[k] = sum.relative_error();
    });
    return errors;
}

/// Of every patch's seen area, each for itself, summed over the patches of a cluster.
std::vector<float> visibility_errors(const ObjectData& object, const DirectionGrid& grid,
                                     std::span<const Vec3> directions, std::span<const double> cosine,
                                     const SampleCounts& counts) {
    const std::size_t count = directions.size();
    std::vector<Squares> patches(object.patches.size());
    parallel_for(patches.size(), 64, [&](std::size_t p) {
        const auto row = object.visibility.subspan(p * grid.size(), grid.size());
        for (std::size_t d = 0; d < count; ++d)
            patches[p].add(grid.interpolate(row, directions[d]) / 255 * cosine[p * count + d], cosine[p * count + d],
                           counts.seen[p * count + d], counts.covered[p * count + d]);
    });
    std::vector<float> errors(object.area_clusters.size());
    parallel_for(errors.size(), 16, [&](std::size_t k) {
        const Cluster& cluster = object.clusters[object.area_clusters[k]];
        Squares sum;
        for (std::uint32_t p = cluster.first_patch; p < cluster.first_patch + cluster.patch_count; ++p)
            sum += patches[p];
        errors[k] = sum.relative_error();
    });
    return errors;
}

}  // namespace

TableErrors measure_table_errors(const ObjectData& object) {
    const DirectionGrid grid(object.meta.grid_map, object.meta.grid_size);
    const std::vector<Vec3> directions = directions_between_nodes();
    const std::vector<FaceRange> clusters = cluster_ranges(object, object.area_clusters);
    const std::vector<double> of_patches = patch_cosines(object, directions);
    const std::vector<double> cosine = cluster_cosines(object, of_patches, directions.size(), object.area_clusters);
    const SeenCounts counts = count_seen_areas(object, directions, clusters, object.meta.image_resolution);

    TableErrors errors;
    errors.directions = static_cast<std::uint32_t>(directions.size());
    errors.whole =
        area_errors(grid, directions, object.whole_area, object.whole_area_scale, cosine, counts.clusters);
    errors.visibility = visibility_errors(object, grid, directions, of_patches, counts.patches);
    errors.intrinsic = object.meta.convex
                           ? errors.whole
                           : area_errors(grid, directions, object.intrinsic_area, object.intrinsic_area_scale, cosine,
                                         count_intrinsic(object, directions, object.area_clusters, object.meta.image_resolution));
    return errors;
}

}  // namespace rro
