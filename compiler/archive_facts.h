// Facts about an archive's content that no section states in so many words, for `inspect` and `diff`.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "format/archive_reader.h"

namespace rro {

/// "0.1": the format version of the file.
std::string format_version(const Archive& archive);

/// "octahedral" or "latlong".
std::string map_name(GridMap map);

/// Nodes on the longest way from the root to a leaf of a tree in preorder: clusters or volumes.
template <class Node>
std::size_t tree_depth(std::span<const Node> nodes) {
    std::vector<std::size_t> depth(nodes.size(), 1);
    std::size_t deepest = 0;
    for (std::size_t i = 0; i < nodes.size(); ++i) {  // preorder: parents come first
        deepest = std::max(deepest, depth[i]);
        if (nodes[i].right_child == 0) continue;
        depth[i + 1] = depth[nodes[i].right_child] = depth[i] + 1;
    }
    return deepest;
}

/// Material of every triangle, from the patches of its faces. [T]
std::vector<std::uint32_t> triangle_materials(const ObjectData& data);

/// How far the shares of patches' light that escape, meet faces and meet black backs are from 1 together.
struct ClosureDefect {
    double mean = 0, rms = 0;  // over the area
    double largest = 0;        // of one patch, absolute
};
/// Of all patches together.
ClosureDefect closure_defect(const ObjectData& data);

/// The shortest text that reads back as the same double.
std::string shortest(double x);

}  // namespace rro
