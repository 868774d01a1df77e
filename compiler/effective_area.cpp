#include "compiler/effective_area.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>

#include "compiler/intrinsic_area.h"
#include "compiler/seen_area.h"
#include "compiler/table_fit.h"
#include "compiler/visible_share.h"
#include "format/parallel.h"

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

/// Tables of D values each, none negative, to 8 bits with the table's largest value as its scale.
void quantise(std::span<const float> values, std::size_t directions, std::vector<std::uint8_t>& table,
              std::vector<float>& scale) {
    table.reserve(values.size());
    for (std::size_t row = 0; row < values.size(); row += directions) {
        const auto own = values.subspan(row, directions);
        const float largest = *std::max_element(own.begin(), own.end());
        scale.push_back(largest);
        for (const float value : own)
            table.push_back(area_byte(largest > 0 ? static_cast<double>(value) / static_cast<double>(largest) : 0));
    }
}

/// Directions between the nodes of a grid, about one for each, in opposite pairs: their lines are the same.
std::vector<Vec3> directions_between(const DirectionGrid& grid) {
    const std::uint32_t n = grid.n();
    const DirectionGrid fine(grid.map(), 2 * n);  // four of its nodes about each of the grid's
    std::vector<bool> has_one(grid.size(), false);
    std::vector<Vec3> directions;
    for (std::uint32_t node = 0; node < grid.size(); ++node) {
        if (has_one[node]) continue;
        const std::uint32_t row = node / n, column = node % n;
        const Vec3 w = fine.direction((2 * row + (row + column) % 2) * 2 * n + 2 * column + row % 2);
        directions.insert(directions.end(), {w, -w});
        const DirectionTaps taps = grid.taps(-w);
        const auto nearest = std::max_element(taps.weight.begin(), taps.weight.end()) - taps.weight.begin();
        has_one[node] = has_one[taps.node[static_cast<std::size_t>(nearest)]] = true;
    }
    return directions;
}

/// What was measured at the nodes of the grid and between them, and the fit to both.
class Measurement {
  public:
    Measurement(const ObjectData& object, const DirectionGrid& grid, std::span<const std::uint32_t> clusters)
        : object_(object),
          grid_(grid),
          nodes_(node_directions(grid)),
          between_(directions_between(grid)),
          clusters_(clusters),
          fit_(grid, joined(nodes_, between_)),
          at_nodes_(count_seen_areas(object, nodes_, cluster_ranges(object, clusters), object.meta.image_resolution)),
          at_between_(count_seen_areas(object, between_, cluster_ranges(object, clusters), between_resolution())),
          cosine_(patch_cosines(object, nodes_)),
          cosine_between_(patch_cosines(object, between_)) {}

    /// Share of each patch that is seen. [P * D]
    std::vector<float> visibility() const {
        std::vector<float> shares = visible_shares(at_nodes_.patches, at_nodes_.whole, grid_);
        for_each_table(shares, [&](std::size_t p, std::span<float> nodes, std::span<float> samples, std::span<float> weights) {
            // What counts is the seen area, share times cosine; a few samples say less than many.
            const double area = static_cast<double>(object_.patches[p].area);
            for (std::size_t d = 0; d < nodes.size(); ++d) {
                samples[d] = nodes[d];
                weights[d] = static_cast<float>(std::pow(cosine_[p * nodes.size() + d] / area, 2));
            }
            for (std::size_t e = 0; e < between_.size(); ++e) {
                const std::size_t i = p * between_.size() + e;
                samples[nodes.size() + e] = share_of(at_between_.patches, i);
                weights[nodes.size() + e] = static_cast<float>(std::pow(cosine_between_[i] / area, 2) * trust(at_between_.patches, i));
            }
            fit_.fit(samples, weights, nodes);
            for (float& share : nodes) share = std::clamp(share, 0.0f, 1.0f);
        });
        return shares;
    }

    /// Whole-object areas of the clusters. [K * D], m^2
    std::vector<float> whole_areas() const { return areas(at_nodes_.clusters, at_between_.clusters); }

    /// Intrinsic areas. [K * D], m^2
    std::vector<float> intrinsic_areas() const {
        return areas(count_intrinsic(object_, nodes_, clusters_, object_.meta.image_resolution),
                     count_intrinsic(object_, between_, clusters_, between_resolution()));
    }

  private:
    static std::vector<Vec3> joined(std::vector<Vec3> a, const std::vector<Vec3>& b) {
        a.insert(a.end(), b.begin(), b.end());
        return a;
    }
    // A quarter of the samples: what lies between informs several nodes at once.
    std::uint32_t between_resolution() const { return (object_.meta.image_resolution + 1) / 2; }

    static float share_of(const SampleCounts& counts, std::size_t i) {
        return counts.covered[i] > 0 ? std::min(1.0f, static_cast<float>(counts.seen[i]) / static_cast<float>(counts.covered[i])) : 0;
    }
    static double trust(const SampleCounts& counts, std::size_t i) {
        constexpr double kHalf = 4;  // a share of so many samples is as uncertain as neighbouring directions differ
        return counts.covered[i] / (counts.covered[i] + kHalf);
    }

    template <class Body>
    void for_each_table(std::vector<float>& tables, const Body& body) const {
        parallel_chunks(tables.size() / nodes_.size(), 64, [&](std::size_t begin, std::size_t end) {
            std::vector<float> samples(nodes_.size() + between_.size()), weights(samples.size());
            for (std::size_t k = begin; k < end; ++k)
                body(k, std::span(tables).subspan(k * nodes_.size(), nodes_.size()), samples, weights);
        });
    }

    std::vector<float> areas(const SampleCounts& at_nodes, const SampleCounts& at_between) const {
        std::vector<float> values = visible_shares(at_nodes, at_nodes_.whole, grid_);
        const std::vector<double> cosine = cluster_cosines(object_, cosine_, nodes_.size(), clusters_);
        const std::vector<double> cosine_between = cluster_cosines(object_, cosine_between_, between_.size(), clusters_);
        for (std::size_t i = 0; i < values.size(); ++i) values[i] *= static_cast<float>(cosine[i]);
        for_each_table(values, [&](std::size_t k, std::span<float> nodes, std::span<float> samples, std::span<float> weights) {
            std::copy(nodes.begin(), nodes.end(), samples.begin());
            std::fill_n(weights.begin(), nodes.size(), 1.0f);
            for (std::size_t e = 0; e < between_.size(); ++e) {
                const std::size_t i = k * between_.size() + e;
                samples[nodes.size() + e] = static_cast<float>(cosine_between[i]) * share_of(at_between, i);
                weights[nodes.size() + e] = cosine_between[i] > 0 ? static_cast<float>(trust(at_between, i)) : 1.0f;
            }
            fit_.fit(samples, weights, nodes);
            for (float& area : nodes) area = std::max(0.0f, area);
        });
        return values;
    }

    const ObjectData& object_;
    const DirectionGrid& grid_;
    std::vector<Vec3> nodes_, between_;
    std::span<const std::uint32_t> clusters_;
    TableFit fit_;
    SeenCounts at_nodes_, at_between_;
    std::vector<double> cosine_, cosine_between_;  // of patches
};

}  // namespace

EffectiveAreas measure_effective_areas(const ObjectData& object, const TableChoice& tables) {
    assert(!object.faces.empty() && object.meta.image_resolution > 0);
    assert(tables.area || tables.visibility);
    const DirectionGrid grid(object.meta.grid_map, object.meta.grid_size);
    EffectiveAreas areas;
    if (tables.area)
        areas.clusters =
            largest_clusters(object.clusters, tables.every_node ? object.clusters.size() : kAreaClusters);
    const Measurement measured(object, grid, areas.clusters);
    if (tables.visibility) {
        const std::vector<float> shares = measured.visibility();
        areas.visibility.reserve(shares.size());
        for (const float share : shares) areas.visibility.push_back(visibility_byte(static_cast<double>(share)));
    }
    if (tables.area) {
        quantise(measured.whole_areas(), grid.size(), areas.whole, areas.whole_scale);
        if (object.meta.convex) {  // nothing hides anything
            areas.intrinsic = areas.whole;
            areas.intrinsic_scale = areas.whole_scale;
        } else {
            quantise(measured.intrinsic_areas(), grid.size(), areas.intrinsic, areas.intrinsic_scale);
        }
    }
    return areas;
}

}  // namespace rro
