// The HBV tree: a bounding volume hierarchy over triangles (paper, section 5).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "format/object_data.h"

namespace rro {

/// The tree as ObjectData stores it.
struct ObjectBvh {
    std::vector<Volume> volumes;           // preorder, left child = own index + 1
    std::vector<std::uint32_t> triangles;  // [T] leaf order; a volume's are volumes[i].first .. + count
};

/// Binary, split by the surface area heuristic over 16 bins per axis; leaves hold at most 4 triangles. Deterministic,
/// O(T log T); the depth is bounded (halving by count below depth 40). T >= 1.
ObjectBvh build_object_bvh(std::span<const Vec3f> positions, std::span<const TriangleIndices> triangles);

}  // namespace rro
