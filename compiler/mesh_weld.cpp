#include "compiler/mesh_weld.h"

#include <bit>
#include <unordered_map>

#include "format/sample_points.h"

namespace rro {

std::vector<std::uint32_t> weld_positions(std::span<const Vec3> positions) {
    const auto hash = [](const Vec3& p) {
        std::uint64_t key = 0;
        for (int i = 0; i < 3; ++i) key = mix64(key ^ std::bit_cast<std::uint64_t>(p[i] + 0.0));  // -0 + 0 = 0
        return static_cast<std::size_t>(key);
    };
    std::unordered_map<Vec3, std::uint32_t, decltype(hash)> first(positions.size(), hash);
    std::vector<std::uint32_t> welded;
    welded.reserve(positions.size());
    for (std::size_t i = 0; i < positions.size(); ++i)
        welded.push_back(first.try_emplace(positions[i], static_cast<std::uint32_t>(i)).first->second);
    return welded;
}

}  // namespace rro
