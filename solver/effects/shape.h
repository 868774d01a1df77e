// What the shape of one object tells about its own light.
#pragma once

#include "format/object_data.h"

namespace rro {

/// Do all triangles lie in one plane, within the rounding of stored coordinates?
bool is_flat(const ObjectData& object);

/// Can no face of the object see another (it is convex, or flat)? Any affine instance of it then cannot either.
bool sees_nothing_of_itself(const ObjectData& object);

}  // namespace rro
