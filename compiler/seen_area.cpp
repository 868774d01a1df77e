#include "compiler/seen_area.h"

#include <algorithm>
#include <numeric>

#include "compiler/line_images.h"
#include "format/parallel.h"

namespace rro {
namespace {

/// sums[i] = sum of values before i. [n + 1]
template <class Sum, class Value>
std::vector<Sum> prefix_sums(std::span<const Value> values) {
    std::vector<Sum> sums(values.size() + 1);
    for (std::size_t i = 0; i < values.size(); ++i) sums[i + 1] = sums[i] + values[i];
    return sums;
}

void add_ranges(std::span<const std::uint32_t> per_face, std::span<const FaceRange> ranges, std::size_t directions,
                std::size_t direction, std::vector<std::uint32_t>& out) {
    const std::vector<std::uint32_t> sums = prefix_sums<std::uint32_t>(per_face);
    for (std::size_t i = 0; i < ranges.size(); ++i)
        out[i * directions + direction] = sums[ranges[i].end] - sums[ranges[i].begin];
}

}  // namespace

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

SeenCounts count_seen_areas(const ObjectData& object, std::span<const Vec3> directions,
                            std::span<const FaceRange> clusters, std::uint32_t resolution) {
    const std::size_t count = directions.size();
    const std::vector<FaceRange> patches = patch_ranges(object);
    const std::vector<std::uint32_t> face_by_side = faces_by_side(object), opposite_of = opposite_directions(directions);
    SeenCounts counts{SampleCounts(patches.size() * count), SampleCounts(clusters.size() * count), SampleCounts(count)};
    const auto store = [&](std::size_t d, std::span<const std::uint32_t> seen, std::span<const std::uint32_t> covered) {
        add_ranges(seen, patches, count, d, counts.patches.seen);
        add_ranges(covered, patches, count, d, counts.patches.covered);
        add_ranges(seen, clusters, count, d, counts.clusters.seen);
        add_ranges(covered, clusters, count, d, counts.clusters.covered);
        counts.whole.seen[d] = std::accumulate(seen.begin(), seen.end(), 0u);
        counts.whole.covered[d] = std::accumulate(covered.begin(), covered.end(), 0u);
    };
    parallel_for(count, 1, [&](std::size_t d) {
        const std::uint32_t opposite = opposite_of[d];
        if (opposite < d) return;  // done with its partner, on the same lines
        const DirectionImage image = fit_image(object.positions, directions[d], resolution);
        const auto [seen, covered] = count_samples(object, face_by_side, image);
        store(d, seen.toward, covered.toward);
        if (opposite != kNoDirection) store(opposite, seen.opposite, covered.opposite);
    });
    return counts;
}

std::vector<double> patch_cosines(const ObjectData& object, std::span<const Vec3> directions) {
    const std::size_t count = directions.size();
    std::vector<double> result(object.patches.size() * count, 0);
    parallel_for(object.patches.size(), 4, [&](std::size_t p) {
        const auto row = std::span(result).subspan(p * count, count);
        const Patch& patch = object.patches[p];
        for (std::uint32_t f = patch.first_face; f < patch.first_face + patch.face_count; ++f) {
            const Vec3 area = area_vector(object.corners(object.faces[f]));
            for (std::size_t d = 0; d < count; ++d) row[d] += std::max(0.0, dot(area, directions[d]));
        }
    });
    return result;
}

std::vector<double> cluster_cosines(const ObjectData& object, std::span<const double> of_patches, std::size_t directions,
                                    std::span<const std::uint32_t> clusters) {
    std::vector<double> result(clusters.size() * directions, 0);
    parallel_for(clusters.size(), 4, [&](std::size_t k) {
        const Cluster& cluster = object.clusters[clusters[k]];
        const auto row = std::span(result).subspan(k * directions, directions);
        for (std::uint32_t p = cluster.first_patch; p < cluster.first_patch + cluster.patch_count; ++p)
            for (std::size_t d = 0; d < directions; ++d) row[d] += of_patches[p * directions + d];
    });
    return result;
}

}  // namespace rro
