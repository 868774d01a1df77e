// Points in an order that keeps neighbours together.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "format/geometry.h"

namespace rro {

/// Numbers of the points along the Morton curve through the cube about them, 2^21 cells to an axis; ties to the lower
/// number. O(n log n).
std::vector<std::uint32_t> morton_order(std::span<const Vec3> points);

}  // namespace rro
