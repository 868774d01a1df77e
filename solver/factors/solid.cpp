#include "solver/factors/solid.h"

#include <algorithm>
#include <map>
#include <tuple>

namespace rro {
namespace {

constexpr std::size_t kFewFaces = 8;  // fewer are as well cut out one by one

constexpr double kInLine = 1e-28;     // squared sine of an edge seen end-on

struct Earlier {
    bool operator()(const Vec3& a, const Vec3& b) const { return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z); }
};

}  // namespace

bool Solid::in_front_of(const Vec3& normal, double offset) const {
    return std::all_of(corners.begin(), corners.end(), [&](const Vec3& c) { return dot(normal, c) > offset; });
}

bool Solid::contains(const Vec3& p) const {
    return std::all_of(planes.begin(), planes.end(),
                       [&](const Plane& plane) { return dot(plane.normal, p) - plane.offset <= rounding; });
}

void Solid::outline(const Vec3& x, std::vector<std::uint8_t>& turned, std::vector<Vec3>& inner) const {
    turned.clear();
    inner.clear();
    for (const Plane& plane : planes) turned.push_back(dot(plane.normal, x) > plane.offset);
    for (const Edge& edge : edges) {
        if (turned[edge.left] == turned[edge.right]) continue;
        const Vec3 a = corners[edge.from] - x, b = corners[edge.to] - x, n = cross(a, b);
        if (length2(n) <= kInLine * length2(a) * length2(b)) continue;  // no plane; its neighbours bound the outline
        inner.push_back(turned[edge.left] ? -n : n);
    }
}

Solid Solid::in_front(const Vec3& normal, double offset) const {
    constexpr std::uint32_t none = 0xffffffffu;
    Solid part;
    part.corners = corners;  // numbers stay
    part.planes = planes;
    part.rounding = rounding;
    const auto cap = static_cast<std::uint32_t>(planes.size());
    part.planes.push_back({-normal, -offset});
    std::vector<std::uint32_t> leaves(planes.size(), none), enters(planes.size(), none);  // [faces] corners of the cut
    for (Edge edge : edges) {
        const double from = dot(normal, corners[edge.from]) - offset, to = dot(normal, corners[edge.to]) - offset;
        if (from <= 0 && to <= 0) continue;
        if (from <= 0 || to <= 0) {
            const auto cut = static_cast<std::uint32_t>(part.corners.size());
            part.corners.push_back(corners[edge.from] + (corners[edge.to] - corners[edge.from]) * (from / (from - to)));
            (from > 0 ? leaves : enters)[edge.left] = cut;
            (from > 0 ? enters : leaves)[edge.right] = cut;
            (from > 0 ? edge.to : edge.from) = cut;
        }
        part.edges.push_back(edge);
    }
    for (std::uint32_t f = 0; f < cap; ++f)
        if (leaves[f] != none && enters[f] != none) part.edges.push_back({leaves[f], enters[f], f, cap});
    return part;
}

Solid make_solid(std::span<const Polygon> faces) {
    Solid solid;
    if (faces.size() < kFewFaces) return {};
    std::map<Vec3, std::uint32_t, Earlier> known;
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> open;  // edges that wait for their other face
    for (std::uint32_t f = 0; f < faces.size(); ++f) {
        const Polygon& face = faces[f];
        solid.planes.push_back({face.normal, face.offset});
        solid.rounding = std::max(solid.rounding, face.rounding);
        std::vector<std::uint32_t> numbers;
        for (const Vec3& c : face.corners) {
            const auto [at, is_new] = known.emplace(c, static_cast<std::uint32_t>(solid.corners.size()));
            if (is_new) solid.corners.push_back(c);
            numbers.push_back(at->second);
        }
        for (std::size_t k = 0; k < numbers.size(); ++k) {
            const std::uint32_t from = numbers[k], to = numbers[(k + 1) % numbers.size()];
            if (const auto other = open.find({to, from}); other != open.end()) {
                solid.edges.push_back({to, from, other->second, f});
                open.erase(other);
            } else if (!open.emplace(std::pair(from, to), f).second) {
                return {};
            }
        }
    }
    return open.empty() ? solid : Solid{};
}

}  // namespace rro
