#include "compiler/cluster_tree.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "format/sample_points.h"

using namespace rro;

namespace {

double unit_random(std::uint64_t key) {
    return static_cast<double>(mix64(key) >> 11) * 0x1p-53;
}

ClusterSummary square_at(const Vec3& centre, double edge) {
    ClusterSummary s;
    s.box.add(centre - Vec3{edge, 0, edge} * 0.5);
    s.box.add(centre + Vec3{edge, 0, edge} * 0.5);
    s.area = edge * edge;
    s.area_vector = {0, s.area, 0};
    s.reflectance_area = Vec3{0.5, 0.5, 0.5} * s.area;
    return s;
}

std::size_t depth_below(const ClusterTree& tree, std::uint32_t node) {
    if (tree.nodes[node].right_child == 0) return 1;
    return 1 + std::max(depth_below(tree, node + 1), depth_below(tree, tree.nodes[node].right_child));
}

/// Every leaf one patch, children share out their parent's patches in order, all patches once.
void check_tree(const ClusterTree& tree, std::size_t patches) {
    REQUIRE(tree.nodes.size() == 2 * patches - 1);
    REQUIRE(tree.nodes[0].first_patch == 0);
    REQUIRE(tree.nodes[0].patch_count == patches);
    std::vector<std::uint32_t> order = tree.patch_order;
    std::sort(order.begin(), order.end());
    for (std::uint32_t p = 0; p < patches; ++p) REQUIRE(order[p] == p);
    for (std::uint32_t i = 0; i < tree.nodes.size(); ++i) {
        const ClusterNode& node = tree.nodes[i];
        if (node.right_child == 0) {
            REQUIRE(node.patch_count == 1);
            continue;
        }
        REQUIRE(node.right_child > i + 1);
        REQUIRE(node.right_child < tree.nodes.size());
        const ClusterNode &left = tree.nodes[i + 1], &right = tree.nodes[node.right_child];
        REQUIRE(left.first_patch == node.first_patch);
        REQUIRE(right.first_patch == left.first_patch + left.patch_count);
        REQUIRE(left.patch_count + right.patch_count == node.patch_count);
    }
}

}  // namespace

TEST_CASE("the cluster tree is a preorder tree over all patches", "[compiler][cluster_tree]") {
    const std::size_t count = GENERATE(1, 2, 3, 17, 2000);
    std::vector<ClusterSummary> patches;
    for (std::uint64_t i = 0; i < count; ++i)
        patches.push_back(square_at({unit_random(3 * i), unit_random(3 * i + 1), unit_random(3 * i + 2)}, 0.01));
    check_tree(build_cluster_tree(patches, {}), count);
}

TEST_CASE("near patches meet before far ones", "[compiler][cluster_tree]") {
    // Two groups a hundred of their sizes apart: the root parts them.
    std::vector<ClusterSummary> patches;
    for (std::uint64_t i = 0; i < 100; ++i)
        patches.push_back(square_at({unit_random(2 * i) + (i % 2 ? 100.0 : 0.0), 0, unit_random(2 * i + 1)}, 0.1));
    const ClusterTree tree = build_cluster_tree(patches, {});
    REQUIRE(tree.nodes[1].patch_count == 50);
    const std::uint32_t parity = tree.patch_order[0] % 2;
    for (std::size_t i = 0; i < 50; ++i) CHECK(tree.patch_order[i] % 2 == parity);
}

TEST_CASE("each factor decides between partners that are equally near", "[compiler][cluster_tree]") {
    // The middle one of three in a row joins the one that is like it.
    std::vector<ClusterSummary> row{square_at({-1, 0, 0}, 1), square_at({0, 0, 0}, 1), square_at({1, 0, 0}, 1)};
    SECTION("orientation") {
        row[0].area_vector = {0, -1, 0};
    }
    SECTION("reflectivity") {
        row[0].reflectance_area = Vec3{0.9, 0.5, 0.5};
    }
    SECTION("size") {
        row[0].area *= 0.5, row[0].area_vector *= 0.5, row[0].reflectance_area *= 0.5;
    }
    SECTION("aspect ratio") {
        row[0] = square_at({0, 0, 0}, 1);
        row[0].box = {{-1.5, 0, -0.5}, {-0.5, 0, 0.5}};
        row[1].box = {{-0.5, 0, -0.5}, {0.5, 0, 0.5}};
        // As far as the left one along the diagonal of the common box, but that box is square.
        const double edge = std::sqrt(2.5);
        row[2].box = {{0.5 - edge + 0.5, 0, 0.5}, {0.5, 0, -0.5 + edge}};
        row[2].box.lo.x = 0.5 - edge;
    }
    const ClusterTree tree = build_cluster_tree(row, {});
    const bool left_is_pair = tree.nodes[1].patch_count == 2;
    const std::uint32_t single = left_is_pair ? tree.patch_order[2] : tree.patch_order[0];
    CHECK(single == 0);
}

TEST_CASE("chains of growing reach stay shallow", "[compiler][cluster_tree]") {
    // Each patch is nearest to all before it together: plain agglomeration makes a list 900 deep.
    std::vector<ClusterSummary> patches;
    for (int i = 0; i < 900; ++i) patches.push_back(square_at({std::exp2(i - 450.0), 0, 0}, std::exp2(i - 460.0)));
    const ClusterTree tree = build_cluster_tree(patches, {});
    check_tree(tree, 900);
    CHECK(depth_below(tree, 0) <= 1 + std::ceil(std::log(900.0) / std::log(1.25)));
}
