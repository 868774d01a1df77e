#include "compiler/mesh_weld.h"

#include <algorithm>
#include <array>
#include <bit>
#include <numeric>

namespace rro {

std::vector<std::uint32_t> weld_positions(std::span<const Vec3> positions) {
    // By sorting: positions that collide in a hash table are easily made, and a mesh of them would never end.
    const auto key = [&](std::uint32_t i) {
        std::array<std::uint64_t, 3> bits;
        for (int c = 0; c < 3; ++c)
            bits[static_cast<std::size_t>(c)] = std::bit_cast<std::uint64_t>(positions[i][c] + 0.0);  // -0 + 0 = 0
        return bits;
    };
    std::vector<std::uint32_t> order(positions.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        const auto key_a = key(a), key_b = key(b);
        return key_a != key_b ? key_a < key_b : a < b;
    });
    std::vector<std::uint32_t> welded(positions.size());
    for (std::size_t n = 0; n < order.size(); ++n) {
        const bool repeats = n > 0 && key(order[n]) == key(order[n - 1]);
        welded[order[n]] = repeats ? welded[order[n - 1]] : order[n];
    }
    return welded;
}

}  // namespace rro
