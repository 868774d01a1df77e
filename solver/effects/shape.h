// What the shape of one object tells about its own light.
#pragma once

#include "format/object_data.h"

namespace rro {

/// Do all triangles lie in one plane, within the rounding of stored coordinates?
bool is_flat(const ObjectData& object);

/// Can no face of the object see another (it is convex, or flat)? Any affine instance of it then cannot either.
bool sees_nothing_of_itself(const ObjectData& object);

/// Do its triangles look in many directions, as those of scanned and turned things do and those of boxes and boards do not?
bool is_curved(const ObjectData& object);

/// How open an object is that everything looks into from its own fronts (a room, seen from inside): the area of its holes,
/// as far as they look the same way, over the area of its fronts. 0 where it is closed; 1 where its fronts look outwards.
double openness(const ObjectData& object);

}  // namespace rro
