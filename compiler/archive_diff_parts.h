// The parts of diff_archives, one per group of changes. Each adds what differs and nothing else.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "compiler/archive_diff.h"
#include "compiler/triangle_pairs.h"

namespace rro {

using Changes = std::vector<Change>;

/// Triangles, vertices, bounds, area, sides.
///
/// mesh_differs   the mesh sections differ; where no change of the geometry says why, the order of storage does
void compare_geometry(const ObjectData& a, const ObjectData& b, const TrianglePairs& triangles, bool mesh_differs,
                      Changes& out);

/// Materials by name, those of one name in order, and the triangles that changed theirs.
void compare_materials(const ObjectData& a, const ObjectData& b, const TrianglePairs& triangles, Changes& out);

/// In place of a patch's number: none.
inline constexpr std::uint32_t kNoPatch = 0xffffffffu;

/// What the trees of both versions have in common.
struct TreeMatch {
    std::vector<std::uint32_t> patch_in_b;  // [P of a] the patch of b with the same faces, or kNoPatch
    std::size_t matched = 0;                // of those, not kNoPatch
    bool same_clusters = false;             // the same patches in the same order under the same clusters
};
/// By the faces of patches, through pairs of triangles.
TreeMatch match_trees(const ObjectData& a, const ObjectData& b, const TrianglePairs& triangles);

/// Patches under textures that reflect otherwise; those that both have.
void compare_textures(const ObjectData& a, const ObjectData& b, const TreeMatch& trees, Changes& out);

/// Counts and depths of the trees.
void compare_structure(const ObjectData& a, const ObjectData& b, const TreeMatch& trees, Changes& out);

/// Directions, effective areas, visibility. Direction by direction where the grids are the same, else by the mean;
/// clusters other than the root where the trees are the same, visibility for the patches that both have.
void compare_tables(const Archive& a, const Archive& b, const TreeMatch& trees, Changes& out);

/// Hit probabilities: the root's by line where the grids are the same, else by the mean; those of other volumes where both
/// store the same ones.
void compare_hits(const Archive& a, const Archive& b, Changes& out);

/// Self links: how many, and the share of the object's light that meets the object again.
void compare_self_links(const ObjectData& a, const ObjectData& b, Changes& out);

/// Silhouettes, where both have them.
void compare_atlases(const ObjectData& a, const ObjectData& b, Changes& out);

}  // namespace rro
