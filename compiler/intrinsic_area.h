// What a cluster shows when only its own triangles can hide it.
#pragma once

#include <cstdint>
#include <span>

#include "compiler/visible_share.h"
#include "format/object_data.h"

namespace rro {

/// Sample counts of K clusters over D directions, from images of half that resolution: `seen` where the
/// first of the cluster's own triangles along the line is a face of it, seen from its side. All clusters at once: along
/// each line the nearest triangle decides for its cluster and all above; a farther one stops at the first that is
/// decided.
///
/// directions [D] unit; those with an opposite among them are cheaper
/// clusters   [K] ascending; with a cluster all its ancestors
/// returns    [K * D]
SampleCounts count_intrinsic(const ObjectData& object, std::span<const Vec3> directions,
                             std::span<const std::uint32_t> clusters, std::uint32_t resolution);

}  // namespace rro
