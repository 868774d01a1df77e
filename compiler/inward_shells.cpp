#include "compiler/inward_shells.h"

#include <algorithm>

#include "compiler/surface.h"

namespace rro {

std::vector<bool> inward_patches(const ObjectData& object) {
    std::vector<bool> inward(object.patches.size(), false);
    if (!object.meta.closed || object.faces.size() != object.triangles.size()) return inward;
    // Components: vertices that share a triangle, by union and find.
    std::vector<std::uint32_t> parent = weld(object.positions);
    const auto root = [&](std::uint32_t v) {
        while (parent[v] != v) v = parent[v] = parent[parent[v]];
        return v;
    };
    for (const TriangleIndices& t : object.triangles)
        for (int k = 1; k < 3; ++k) {
            const std::uint32_t a = root(t[0]), b = root(t[static_cast<std::size_t>(k)]);
            parent[std::max(a, b)] = std::min(a, b);
        }
    std::vector<double> volume(object.positions.size(), 0);  // six times it, by component; about one of its corners
    for (const TriangleIndices& t : object.triangles) {
        const std::uint32_t of = root(t[0]);
        const Vec3 o = to_double(object.positions[of]);
        const Vec3 a = to_double(object.positions[t[0]]) - o, b = to_double(object.positions[t[1]]) - o,
                   c = to_double(object.positions[t[2]]) - o;
        volume[of] += dot(a, cross(b, c));
    }
    for (std::size_t p = 0; p < inward.size(); ++p) {
        const Patch& patch = object.patches[p];
        const auto faces = object.faces.subspan(patch.first_face, patch.face_count);
        inward[p] = std::all_of(faces.begin(), faces.end(),
                                [&](const Face f) { return volume[root(object.triangles[f.triangle()][0])] < 0; });
    }
    return inward;
}

void hide_inward_patches(const ObjectData& object, EffectiveAreas& areas) {
    const std::vector<bool> inward = inward_patches(object);
    if (!areas.visibility.empty()) {
        const auto directions = static_cast<std::ptrdiff_t>(areas.visibility.size() / inward.size());
        for (std::size_t p = 0; p < inward.size(); ++p)
            if (inward[p]) std::fill_n(areas.visibility.begin() + static_cast<std::ptrdiff_t>(p) * directions, directions, std::uint8_t{0});
    }
    if (areas.clusters.empty()) return;
    const auto directions = static_cast<std::ptrdiff_t>(areas.whole.size() / areas.clusters.size());
    for (std::size_t k = 0; k < areas.clusters.size(); ++k) {
        const Cluster& cluster = object.clusters[areas.clusters[k]];
        const auto first = inward.begin() + cluster.first_patch;
        if (std::all_of(first, first + cluster.patch_count, [](bool i) { return i; }))
            std::fill_n(areas.whole.begin() + static_cast<std::ptrdiff_t>(k) * directions, directions, std::uint8_t{0});
    }
}

}  // namespace rro
