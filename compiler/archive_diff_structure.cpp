#include <algorithm>

#include "compiler/archive_diff_parts.h"
#include "compiler/archive_facts.h"
#include "compiler/diff_words.h"

namespace rro {
namespace {

/// Patch of every side of every triangle, kNoPatch for black ones. [2 T]
std::vector<std::uint32_t> patch_of_side(const ObjectData& data) {
    std::vector<std::uint32_t> patch(2 * data.triangles.size(), kNoPatch);
    for (std::uint32_t p = 0; p < data.patches.size(); ++p)
        for (const Face f : data.faces.subspan(data.patches[p].first_face, data.patches[p].face_count))
            patch[f.packed] = p;
    return patch;
}

std::vector<std::uint32_t> match_patches(const ObjectData& a, const ObjectData& b, const TrianglePairs& triangles) {
    constexpr std::uint32_t kNoTriangle = 0xffffffffu;
    std::vector<std::uint32_t> triangle_in_b(a.triangles.size(), kNoTriangle);
    for (const TrianglePair& pair : triangles.all()) triangle_in_b[pair.a] = pair.b;
    const std::vector<std::uint32_t> patch_b = patch_of_side(b);
    const auto patch_in_b = [&](Face f) {
        const std::uint32_t triangle = triangle_in_b[f.triangle()];
        return triangle == kNoTriangle ? kNoPatch : patch_b[Face::make(triangle, f.side()).packed];
    };
    std::vector<std::uint32_t> match;
    for (const Patch& patch : a.patches) {
        const auto faces = a.faces.subspan(patch.first_face, patch.face_count);
        const std::uint32_t candidate = patch_in_b(faces.front());
        const bool same = candidate != kNoPatch && b.patches[candidate].face_count == patch.face_count &&
                          std::ranges::all_of(faces, [&](Face f) { return patch_in_b(f) == candidate; });
        match.push_back(same ? candidate : kNoPatch);
    }
    return match;
}

}  // namespace

TreeMatch match_trees(const ObjectData& a, const ObjectData& b, const TrianglePairs& triangles) {
    TreeMatch trees;
    trees.patch_in_b = match_patches(a, b, triangles);
    bool in_order = a.patches.size() == b.patches.size();
    for (std::uint32_t p = 0; p < trees.patch_in_b.size(); ++p) {
        if (trees.patch_in_b[p] != kNoPatch) ++trees.matched;
        in_order = in_order && trees.patch_in_b[p] == p;
    }
    trees.same_clusters =
        in_order && std::ranges::equal(a.clusters, b.clusters, [](const Cluster& x, const Cluster& y) {
            return x.first_patch == y.first_patch && x.patch_count == y.patch_count;
        });
    return trees;
}

void compare_structure(const ObjectData& a, const ObjectData& b, const TreeMatch& trees, Changes& out) {
    const auto compare = [&](const std::string& kind, const std::string& what, std::size_t before, std::size_t after) {
        compare_count("structure", kind, what, before, after, out);
    };
    const std::size_t patches = a.patches.size();
    const bool same_patches = trees.matched == patches && patches == b.patches.size();
    if (!same_patches)
        out.push_back({"structure",
                       "patches",
                       "patches",
                       std::uint64_t{patches},
                       std::uint64_t{b.patches.size()},
                       {{"kept", std::uint64_t{trees.matched}}},
                       "patches: " + from_to(patches, b.patches.size()) + "; " + std::to_string(trees.matched) +
                           " hold the same triangles"});
    compare("clusters", "clusters", a.clusters.size(), b.clusters.size());
    if (same_patches && !trees.same_clusters)
        out.push_back({"structure",
                       "cluster_tree",
                       "cluster tree",
                       {},
                       {},
                       {},
                       "cluster tree: the same patches, grouped in another way"});
    compare("cluster_depth", "depth of the cluster tree", tree_depth(a.clusters), tree_depth(b.clusters));
    compare("volumes", "volumes", a.volumes.size(), b.volumes.size());
    compare("volume_depth", "depth of the volume tree", tree_depth(a.volumes), tree_depth(b.volumes));
}

}  // namespace rro
