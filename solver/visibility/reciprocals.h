// Reciprocals of directions, for slab tests.
#pragma once

#include "format/geometry.h"

namespace rro {

/// 1 / d axis by axis, as slab tests want it: an axis along which a line stays in place gives an infinity with the sign
/// of its zero, on purpose, so a check for divisions by zero passes over this function.
__attribute__((no_sanitize("float-divide-by-zero"))) inline Vec3 reciprocals(const Vec3& d) {
    return {1 / d.x, 1 / d.y, 1 / d.z};
}

}  // namespace rro
