// Is the object a convex body seen from outside?
#pragma once

#include "compiler/surface.h"

namespace rro {

/// True where the surface is closed, outward, one-sided, and no face sees another: every edge is convex, the surface
/// winds once about its centre, the centre is behind every face, and all corners are behind 256 sampled face planes
/// (all planes of smaller meshes). Dents below 1e-6 of the extent (rounded corners of flat sides) are allowed.
///
/// surface.closed is taken as given: every edge joins two faces that agree.
bool is_convex(const Surface& surface);

}  // namespace rro
