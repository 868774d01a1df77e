// Triangles of an archive as its source numbers them.
#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

#include "format/object_data.h"

namespace rro {

/// The triangles in the order of their source numbers. [T]
///
/// object   read with Section::Source
inline std::vector<std::uint32_t> by_source_number(const ObjectData& object) {
    std::vector<std::uint32_t> order(object.triangles.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(),
              [&](std::uint32_t a, std::uint32_t b) { return object.source_triangle[a] < object.source_triangle[b]; });
    return order;
}

}  // namespace rro
