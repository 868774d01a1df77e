// How a flat node receives the light of one link: a vector, whose product with a face's normal is the face's
// irradiance, and a gradient over position.
#pragma once

#include "solver/transport/nodes.h"

namespace rro {

/// The direction (unit, world) that light from u counts as. What comes from low above the node would change its share
/// wildly with a small tilt of a face; it is taken along the normal.
Vec3 arrival(const Node& flat, const Vec3& u);

/// Change of irradiance over the receiver's positions, per unit of the light that arrives from u (unit, world, towards
/// the source) over distance d, 1/m: that of the inverse square, of the receiver's cosine and, where the source is flat,
/// of the source's cosine.
Vec3 slope(const Node& receiver, const Node& source, const Vec3& u, double d);

}  // namespace rro
