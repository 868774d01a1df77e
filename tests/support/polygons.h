// What two polygons exchange wherever they lie: the kernel of view factors as pairs of faces use it.
#pragma once

#include "solver/factors/planar_kernel.h"

namespace rro::test {

/// facing_exchange of the parts in front of one another's planes; 0 where there are none.
inline double planar_exchange(const Polygon& a, const Polygon& b) {
    FacingPair pair;
    return facing_parts(a, b, pair) ? facing_exchange(*pair.a, *pair.b) : 0;
}

}  // namespace rro::test
