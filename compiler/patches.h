// Nearly coplanar faces of one material, joined into patches: the leaves of the cluster tree.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "compiler/surface.h"

namespace rro {

/// What a patch may be.
struct PatchLimits {
    double largest_area = 0;          // m^2; a face larger than this is a patch alone
    double cone_cosine = 0.8;         // smallest cosine between a patch's mean normal and its faces'
    double reflectance_spread = 0.1;  // largest difference, per channel, from the patch's mean; textures only
};

/// P patches that share out all faces of a surface: patch p holds faces[first[p] .. first[p + 1]).
struct PatchGroups {
    std::vector<std::uint32_t> faces;  // [F] numbers of surface faces, within a patch along a Morton curve
    std::vector<std::uint32_t> first;  // [P + 1]

    std::size_t size() const { return first.size() - 1; }
    std::span<const std::uint32_t> patch(std::size_t p) const {
        return std::span(faces).subspan(first[p], first[p + 1] - first[p]);
    }
};

/// Grows patches over edges, nearest face first, from seeds along the rim of those before; then joins crumbs to a
/// neighbour, and dust to other dust nearby, where the limits allow. O(F log F), deterministic. The limits hold exactly
/// for the mean normal of the finished patch.
///
/// departs  the paper starts from single triangles
PatchGroups make_patches(const Surface& surface, const PatchLimits& limits);

}  // namespace rro
