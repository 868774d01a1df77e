// Puts everything in the depth-first order of the cluster tree, as the archive stores it.
#pragma once

#include "compiler/cluster_tree.h"
#include "compiler/compile_object.h"
#include "compiler/patches.h"
#include "compiler/surface.h"

namespace rro {

/// What the cluster tree needs to know of each patch. [P]
std::vector<ClusterSummary> summarise_patches(const Surface& surface, const PatchGroups& groups);

/// Fills positions, triangles, source numbers, faces, patches and clusters: faces in depth-first order, triangles in
/// the order of their first face, vertices in the order of first use. Bounds of patches and clusters hold exactly for
/// the stored corners.
void lay_out_object(const Surface& surface, const PatchGroups& groups, const ClusterTree& tree, CompiledObject& object);

}  // namespace rro
