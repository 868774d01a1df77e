#include "compiler/cluster_tree.h"

#include <algorithm>
#include <cassert>
#include <numeric>
#include <utility>

#include "compiler/morton_order.h"
#include "format/parallel.h"

namespace rro {
namespace {

constexpr std::uint32_t kNone = 0xffffffffu;
constexpr std::size_t kWindow = 16;        // neighbours in the list looked at on either side
constexpr std::size_t kSmallestShare = 5;  // at least one in five merges per round

/// A cluster during agglomeration. Children are numbers in the same vector; leaves are the patches.
struct Growing {
    ClusterSummary sums;
    std::uint32_t left = kNone, right = kNone;
};

double pair_cost(const ClusterSummary& a, const ClusterSummary& b, const ClusterWeights& weights) {
    Box3 box = a.box;
    box.add(b.box);
    const Vec3 extent = box.extent();
    const double area = a.area + b.area;
    std::array<double, 3> edges{extent.x, extent.y, extent.z};
    std::sort(edges.begin(), edges.end());
    const Vec3 difference = a.reflectance_area / a.area - b.reflectance_area / b.area;
    const double orientation = 1 - length(a.area_vector + b.area_vector) / area;
    const double reflectivity = std::max({std::abs(difference.x), std::abs(difference.y), std::abs(difference.z)});
    const double aspect = edges[2] > 0 ? 1 - edges[1] / edges[2] : 0;
    const double size = 1 - std::min(a.area, b.area) / std::max(a.area, b.area);
    return 0.25 * length2(extent) *
           (weights.proximity + weights.orientation * orientation + weights.reflectivity * reflectivity + weights.aspect * aspect +
            weights.size * size);
}

ClusterSummary joined(ClusterSummary a, const ClusterSummary& b) {
    a.box.add(b.box);
    a.area_vector += b.area_vector;
    a.area += b.area;
    a.reflectance_area += b.reflectance_area;
    return a;
}

struct Choice {
    double cost = 0;
    std::uint32_t position = kNone;  // of the partner in the list
};

/// Every list entry's best partner within the window; ties to the lower position.
std::vector<Choice> best_partners(const std::vector<Growing>& all, const std::vector<std::uint32_t>& list,
                                  const ClusterWeights& weights) {
    std::vector<Choice> best(list.size());
    parallel_for(list.size(), 256, [&](std::size_t i) {
        const std::size_t begin = i > kWindow ? i - kWindow : 0, end = std::min(list.size(), i + kWindow + 1);
        for (std::size_t j = begin; j < end; ++j) {
            if (j == i) continue;
            // Arguments in list order: both ends of a pair must see the same rounding.
            const double cost = pair_cost(all[list[std::min(i, j)]].sums, all[list[std::max(i, j)]].sums, weights);
            if (best[i].position == kNone || cost < best[i].cost) best[i] = {cost, static_cast<std::uint32_t>(j)};
        }
    });
    return best;
}

/// partner[i] = position that entry i merges with, or kNone.
std::vector<std::uint32_t> choose_merges(const std::vector<Growing>& all, const std::vector<std::uint32_t>& list,
                                         const ClusterWeights& weights) {
    const std::vector<Choice> best = best_partners(all, list, weights);
    std::vector<std::uint32_t> partner(list.size(), kNone);
    std::size_t merges = 0;
    for (std::uint32_t i = 0; i < list.size(); ++i)
        if (best[best[i].position].position == i) {
            partner[i] = best[i].position;
            merges += i < best[i].position ? 1 : 0;
        }
    const std::size_t wanted = (list.size() + kSmallestShare - 1) / kSmallestShare;
    if (merges >= wanted) return partner;

    // Chains of ever longer reach would make the tree a list: pair leftovers that follow one another, cheapest first.
    std::vector<std::pair<double, std::array<std::uint32_t, 2>>> spare;
    for (std::uint32_t i = 0, last = kNone; i < list.size(); ++i) {
        if (partner[i] != kNone) continue;
        if (last != kNone) spare.push_back({pair_cost(all[list[last]].sums, all[list[i]].sums, weights), {last, i}});
        last = i;
    }
    std::sort(spare.begin(), spare.end());
    for (const auto& [cost, pair] : spare) {
        if (merges >= wanted) break;
        if (partner[pair[0]] != kNone || partner[pair[1]] != kNone) continue;
        partner[pair[0]] = pair[1];
        partner[pair[1]] = pair[0];
        ++merges;
    }
    return partner;
}

void write_preorder(const std::vector<Growing>& all, std::uint32_t at, ClusterTree& tree) {
    const auto own = tree.nodes.size();
    tree.nodes.push_back({static_cast<std::uint32_t>(tree.patch_order.size()), 0, 0});
    if (all[at].left == kNone) {
        tree.patch_order.push_back(at);
    } else {
        write_preorder(all, all[at].left, tree);
        tree.nodes[own].right_child = static_cast<std::uint32_t>(tree.nodes.size());
        write_preorder(all, all[at].right, tree);
    }
    tree.nodes[own].patch_count = static_cast<std::uint32_t>(tree.patch_order.size()) - tree.nodes[own].first_patch;
}

}  // namespace

ClusterTree build_cluster_tree(std::span<const ClusterSummary> patches, const ClusterWeights& weights) {
    assert(!patches.empty());
    std::vector<Growing> all;
    all.reserve(2 * patches.size());
    for (const ClusterSummary& p : patches) all.push_back({p, kNone, kNone});
    std::vector<Vec3> centres;
    centres.reserve(patches.size());
    for (const ClusterSummary& p : patches) centres.push_back(p.box.centre());
    std::vector<std::uint32_t> list = morton_order(centres);
    while (list.size() > 1) {
        const std::vector<std::uint32_t> partner = choose_merges(all, list, weights);
        std::vector<std::uint32_t> next;
        next.reserve(list.size());
        for (std::uint32_t i = 0; i < list.size(); ++i) {
            if (partner[i] == kNone) {
                next.push_back(list[i]);
            } else if (i < partner[i]) {
                const std::uint32_t a = list[i], b = list[partner[i]];
                next.push_back(static_cast<std::uint32_t>(all.size()));
                all.push_back({joined(all[a].sums, all[b].sums), a, b});
            }
        }
        list = std::move(next);
    }
    ClusterTree tree;
    tree.patch_order.reserve(patches.size());
    tree.nodes.reserve(2 * patches.size() - 1);
    write_preorder(all, list.front(), tree);
    return tree;
}

}  // namespace rro
