#include "compiler/effective_area.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>

#include "compiler/direction_images.h"
#include "compiler/intrinsic_area.h"
#include "compiler/visible_share.h"
#include "format/parallel.h"

namespace rro {
namespace {

constexpr std::size_t kAreaClusters = 1024;  // as many as the link builder visits often; the rest sum their patches

/// The largest clusters by area, in preorder. Parents are at least as large as their children and come before them, so
/// every ancestor of a chosen cluster is chosen.
std::vector<std::uint32_t> largest_clusters(std::span<const Cluster> clusters) {
    std::vector<std::uint32_t> chosen(clusters.size());
    std::iota(chosen.begin(), chosen.end(), 0u);
    std::stable_sort(chosen.begin(), chosen.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return clusters[a].area > clusters[b].area; });
    chosen.resize(std::min(chosen.size(), kAreaClusters));
    std::sort(chosen.begin(), chosen.end());
    return chosen;
}

/// sums[i] = sum of values before i. [n + 1]
template <class Sum, class Value>
std::vector<Sum> prefix_sums(std::span<const Value> values) {
    std::vector<Sum> sums(values.size() + 1);
    for (std::size_t i = 0; i < values.size(); ++i) sums[i + 1] = sums[i] + values[i];
    return sums;
}

/// Half-open range of faces.
struct FaceRange {
    std::uint32_t begin, end;
};

std::vector<FaceRange> patch_ranges(const ObjectData& object) {
    std::vector<FaceRange> ranges;
    for (const Patch& p : object.patches) ranges.push_back({p.first_face, p.first_face + p.face_count});
    return ranges;
}

std::vector<FaceRange> cluster_ranges(const ObjectData& object, std::span<const std::uint32_t> clusters) {
    std::vector<FaceRange> ranges;
    for (const std::uint32_t c : clusters) {
        const Cluster& cluster = object.clusters[c];
        const Patch& last = object.patches[cluster.first_patch + cluster.patch_count - 1];
        ranges.push_back({object.patches[cluster.first_patch].first_face, last.first_face + last.face_count});
    }
    return ranges;
}

void add_ranges(std::span<const std::uint32_t> per_face, std::span<const FaceRange> ranges, std::size_t directions,
                std::size_t direction, std::vector<std::uint32_t>& out) {
    const std::vector<std::uint32_t> sums = prefix_sums<std::uint32_t>(per_face);
    for (std::size_t i = 0; i < ranges.size(); ++i)
        out[i * directions + direction] = sums[ranges[i].end] - sums[ranges[i].begin];
}

/// Counts of patches, of clusters and of the whole, from one image per direction.
struct WholeObjectCounts {
    SampleCounts patches, clusters, whole;
};

WholeObjectCounts count_whole_object(const ObjectData& object, const ObjectRays& rays, const DirectionGrid& grid,
                                     std::span<const FaceRange> patches, std::span<const FaceRange> clusters) {
    const std::size_t directions = grid.size();
    const std::vector<std::uint32_t> face_by_side = faces_by_side(object);
    WholeObjectCounts counts{SampleCounts(patches.size() * directions), SampleCounts(clusters.size() * directions),
                             SampleCounts(directions)};
    parallel_for(directions, 1, [&](std::size_t d) {
        const DirectionImage image =
            fit_image(object.positions, grid.direction(static_cast<std::uint32_t>(d)), object.meta.image_resolution);
        std::vector<std::uint32_t> seen(object.faces.size()), covered(object.faces.size());
        count_seen(object, face_by_side, rays, image, seen);
        count_covered(object, face_by_side, image, covered, {});
        add_ranges(seen, patches, directions, d, counts.patches.seen);
        add_ranges(covered, patches, directions, d, counts.patches.covered);
        add_ranges(seen, clusters, directions, d, counts.clusters.seen);
        add_ranges(covered, clusters, directions, d, counts.clusters.covered);
        counts.whole.seen[d] = std::accumulate(seen.begin(), seen.end(), 0u);
        counts.whole.covered[d] = std::accumulate(covered.begin(), covered.end(), 0u);
    });
    return counts;
}

/// Sum of A max(0, n . w) over the faces of each range. [ranges * D], m^2
std::vector<double> cosine_sums(const ObjectData& object, const DirectionGrid& grid,
                                std::span<const FaceRange> ranges) {
    std::vector<Vec3> area_vectors;
    area_vectors.reserve(object.faces.size());
    for (const Face f : object.faces) area_vectors.push_back(area_vector(object.corners(f)));
    std::vector<double> result(ranges.size() * grid.size());
    parallel_for(grid.size(), 1, [&](std::size_t d) {
        std::vector<double> projected;
        projected.reserve(area_vectors.size());
        for (const Vec3& a : area_vectors)
            projected.push_back(std::max(0.0, dot(a, grid.direction(static_cast<std::uint32_t>(d)))));
        const std::vector<double> sums = prefix_sums<double>(std::span<const double>(projected));
        for (std::size_t i = 0; i < ranges.size(); ++i)
            result[i * grid.size() + d] = std::max(0.0, sums[ranges[i].end] - sums[ranges[i].begin]);
    });
    return result;
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
            table.push_back(static_cast<std::uint8_t>(std::lround(255 * value)));
        }
    }
}

}  // namespace

EffectiveAreas measure_effective_areas(const ObjectData& object, const ObjectRays& rays) {
    assert(!object.faces.empty() && object.meta.image_resolution > 0);
    const DirectionGrid grid(object.meta.grid_map, object.meta.grid_size);
    EffectiveAreas areas;
    areas.clusters = largest_clusters(object.clusters);
    const std::vector<FaceRange> ranges = cluster_ranges(object, areas.clusters);
    const WholeObjectCounts counts = count_whole_object(object, rays, grid, patch_ranges(object), ranges);

    for (const float share : visible_shares(counts.patches, counts.whole, grid))
        areas.visibility.push_back(static_cast<std::uint8_t>(std::lround(255 * share)));
    const std::vector<double> cosine = cosine_sums(object, grid, ranges);
    quantise(cosine, visible_shares(counts.clusters, counts.whole, grid), grid.size(), areas.whole, areas.whole_scale);
    if (object.meta.convex) {  // nothing hides anything
        areas.intrinsic = areas.whole;
        areas.intrinsic_scale = areas.whole_scale;
    } else {
        const SampleCounts own = count_intrinsic(object, rays, grid, areas.clusters);
        quantise(cosine, visible_shares(own, counts.whole, grid), grid.size(), areas.intrinsic, areas.intrinsic_scale);
    }
    return areas;
}

}  // namespace rro
