#include "compiler/mesh_duplicates.h"

#include <algorithm>
#include <array>
#include <tuple>
#include <vector>

#include "compiler/mesh_weld.h"

namespace rro {
namespace {

/// A triangle by its corners, whichever of them is named first.
struct Place {
    std::array<std::uint32_t, 3> corners;  // ascending
    bool forward;                          // does it run through them in that order?
    std::uint32_t triangle;
};

std::vector<Place> places_of(const Mesh& mesh) {
    const std::vector<std::uint32_t> welded = weld_positions(mesh.positions);
    std::vector<Place> places;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        std::array<std::uint32_t, 3> corners;
        for (std::size_t k = 0; k < 3; ++k) corners[k] = welded[mesh.triangles[t][k]];
        const auto least = std::min_element(corners.begin(), corners.end());
        std::rotate(corners.begin(), least, corners.end());
        const bool forward = corners[1] < corners[2];
        if (!forward) std::swap(corners[1], corners[2]);
        places.push_back({corners, forward, t});
    }
    std::sort(places.begin(), places.end(), [](const Place& a, const Place& b) {
        return std::tie(a.corners, a.triangle) < std::tie(b.corners, b.triangle);
    });
    return places;
}

template <class T>
void keep_only(const std::vector<bool>& kept, std::vector<T>& values) {
    if (values.empty()) return;
    std::size_t to = 0;
    for (std::size_t t = 0; t < kept.size(); ++t)
        if (kept[t]) values[to++] = values[t];
    values.resize(to);
}

}  // namespace

std::uint32_t drop_duplicates(Mesh& mesh) {
    const std::vector<Place> places = places_of(mesh);
    std::vector<bool> kept(mesh.triangles.size(), true);
    std::uint32_t dropped = 0;
    for (std::size_t first = 0, end; first < places.size(); first = end) {
        bool taken[2] = {false, false};  // is there one that looks this way already?
        for (end = first; end < places.size() && places[end].corners == places[first].corners; ++end) {
            const Place& place = places[end];
            const bool both = !mesh.two_sided.empty() && mesh.two_sided[place.triangle] != 0;
            if (taken[place.forward] && (!both || taken[!place.forward])) {
                kept[place.triangle] = false;
                ++dropped;
            }
            taken[place.forward] = true;
            taken[!place.forward] = taken[!place.forward] || both;
        }
    }
    if (dropped == 0) return 0;
    keep_only(kept, mesh.triangles);
    keep_only(kept, mesh.source_triangle);
    keep_only(kept, mesh.material);
    keep_only(kept, mesh.reflectance);
    keep_only(kept, mesh.two_sided);
    return dropped;
}

}  // namespace rro
