// Patches joined bottom-up by similarity (paper, section 4).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "format/geometry.h"

namespace rro {

/// What the similarity of two clusters is judged by: sums over their faces.
struct ClusterSummary {
    Box3 box;
    Vec3 area_vector;       // m^2
    double area = 0;        // m^2
    Vec3 reflectance_area;  // reflectance times area
};

/// The paper's five factors. The cost of a pair is
///     r^2 (proximity + orientation (1 - |sum of area vectors| / area) + reflectivity |difference of mean reflectances|
///            + aspect (1 - second / largest extent) + size (1 - smaller / larger area)),
/// r = half the diagonal of the common box: nearness counts in any case, because a small radius for its area is what lets
/// a cluster stand for its patches from nearby; the others, each in [0, 1], decide between near candidates. The larger
/// the weight of proximity, the less they do. tests/bench/README.md has what was measured for these defaults.
struct ClusterWeights {
    double proximity = 1;
    double orientation = 10;
    double reflectivity = 0.5;
    double aspect = 0.25;
    double size = 0.25;
};

/// A node of the tree.
struct ClusterNode {
    std::uint32_t first_patch, patch_count;  // into ClusterTree::patch_order
    std::uint32_t right_child;               // 0 for a leaf
};

/// A binary tree over P patches in preorder: 2P - 1 nodes, left child = own index + 1.
struct ClusterTree {
    std::vector<std::uint32_t> patch_order;  // [P] depth first
    std::vector<ClusterNode> nodes;          // [2P - 1]
};

/// Agglomerates in rounds over a Morton-ordered list: each cluster finds its best partner among its neighbours in the
/// list, and pairs that choose each other merge. O(P log P), deterministic, ties to the lower number. At least a fifth
/// of the list merges in every round, so the depth is at most log P / log 1.25 (64 for 1.5 million patches).
///
/// patches  [P], P >= 1
/// source   paper section 4; locally-ordered clustering [Meister 2018]
/// departs  the paper does not weight its five factors
ClusterTree build_cluster_tree(std::span<const ClusterSummary> patches, const ClusterWeights& weights);

}  // namespace rro
