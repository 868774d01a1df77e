#include "compiler/morton_order.h"

#include <algorithm>
#include <utility>

namespace rro {
namespace {

/// The lowest 21 bits of x, two zero bits after each.
std::uint64_t spread_bits(std::uint64_t x) {
    x &= 0x1fffff;
    x = (x | x << 32) & 0x1f00000000ffffull;
    x = (x | x << 16) & 0x1f0000ff0000ffull;
    x = (x | x << 8) & 0x100f00f00f00f00full;
    x = (x | x << 4) & 0x10c30c30c30c30c3ull;
    x = (x | x << 2) & 0x1249249249249249ull;
    return x;
}

}  // namespace

std::vector<std::uint32_t> morton_order(std::span<const Vec3> points) {
    Box3 box;
    for (const Vec3& p : points) box.add(p);
    const double extent = points.empty() ? 0 : max_component(box.extent());
    const double scale = extent > 0 ? ((1 << 21) - 1) / extent : 0;  // cubic cells: all axes count alike
    std::vector<std::pair<std::uint64_t, std::uint32_t>> keys;
    keys.reserve(points.size());
    for (std::uint32_t i = 0; i < points.size(); ++i) {
        const Vec3 at = (points[i] - box.lo) * scale;
        const auto bits = [](double x) { return spread_bits(static_cast<std::uint64_t>(x)); };
        keys.emplace_back(bits(at.x) | bits(at.y) << 1 | bits(at.z) << 2, i);
    }
    std::sort(keys.begin(), keys.end());
    std::vector<std::uint32_t> order;
    order.reserve(points.size());
    for (const auto& key : keys) order.push_back(key.second);
    return order;
}

}  // namespace rro
