// Positions that are exactly equal as one.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "format/geometry.h"

namespace rro {

/// For each position the lowest index of an equal one (0 and -0 are equal).
std::vector<std::uint32_t> weld_positions(std::span<const Vec3> positions);

}  // namespace rro
