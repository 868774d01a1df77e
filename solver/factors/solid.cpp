#include "solver/factors/solid.h"

#include <algorithm>
#include <map>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "format/four.h"

namespace rro {
namespace {

constexpr double kInLine = 1e-28;  // squared sine of an edge seen end-on
constexpr std::size_t kLargestConvexTest = 60'000;  // faces: each is compared with the corners of each

struct Earlier {
    bool operator()(const Vec3& a, const Vec3& b) const { return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z); }
};

/// Different corners of faces, and the faces by them.
struct Numbered {
    std::vector<Vec3> corners;
    std::vector<double> rounding;                    // [corners] of a face that has it
    std::vector<std::vector<std::uint32_t>> faces;
};

Numbered numbered(std::span<const Polygon* const> faces) {
    Numbered result;
    std::map<Vec3, std::uint32_t, Earlier> known;
    for (const Polygon* face : faces) {
        std::vector<std::uint32_t>& numbers = result.faces.emplace_back();
        for (const Vec3& c : face->corners) {
            const auto [at, is_new] = known.emplace(c, static_cast<std::uint32_t>(result.corners.size()));
            if (is_new) {
                result.corners.push_back(c);
                result.rounding.push_back(face->rounding);
            }
            numbers.push_back(at->second);
        }
    }
    return result;
}

std::uint64_t edge_key(std::uint32_t from, std::uint32_t to) {
    return (std::uint64_t{from} << 32) | to;
}

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

Solid make_solid(std::span<const Polygon* const> faces) {
    Solid solid;
    Numbered shape = numbered(faces);
    std::unordered_map<std::uint64_t, std::uint32_t> open;  // edges that wait for their other face
    for (std::uint32_t f = 0; f < faces.size(); ++f) {
        solid.planes.push_back({faces[f]->normal, faces[f]->offset});
        solid.rounding = std::max(solid.rounding, faces[f]->rounding);
        const std::vector<std::uint32_t>& numbers = shape.faces[f];
        for (std::size_t k = 0; k < numbers.size(); ++k) {
            const std::uint32_t from = numbers[k], to = numbers[(k + 1) % numbers.size()];
            if (const auto other = open.find(edge_key(to, from)); other != open.end()) {
                solid.edges.push_back({to, from, other->second, f});
                open.erase(other);
            } else if (!open.emplace(edge_key(from, to), f).second) {
                return {};
            }
        }
    }
    solid.corners = std::move(shape.corners);
    return open.empty() ? solid : Solid{};
}

std::vector<std::vector<std::uint32_t>> joined_by_edges(std::span<const Polygon* const> faces) {
    const Numbered shape = numbered(faces);
    std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> of_edge;
    for (std::uint32_t f = 0; f < faces.size(); ++f)
        for (std::size_t k = 0; k < shape.faces[f].size(); ++k)
            of_edge[edge_key(shape.faces[f][k], shape.faces[f][(k + 1) % shape.faces[f].size()])].push_back(f);
    std::vector<std::vector<std::uint32_t>> sets;
    std::vector<std::uint8_t> taken(faces.size(), 0);
    for (std::uint32_t seed = 0; seed < faces.size(); ++seed) {
        if (taken[seed]) continue;
        std::vector<std::uint32_t> set{seed};
        taken[seed] = 1;
        for (std::size_t i = 0; i < set.size(); ++i) {
            const std::vector<std::uint32_t>& numbers = shape.faces[set[i]];
            for (std::size_t k = 0; k < numbers.size(); ++k) {
                const std::uint32_t from = numbers[k], to = numbers[(k + 1) % numbers.size()];
                const auto other = of_edge.find(edge_key(to, from));
                if (other == of_edge.end() || other->second.size() > 1 || of_edge[edge_key(from, to)].size() > 1) continue;
                if (std::exchange(taken[other->second[0]], 1) == 0) set.push_back(other->second[0]);
            }
        }
        std::sort(set.begin(), set.end());
        sets.push_back(std::move(set));
    }
    return sets;
}

bool are_convex(std::span<const Polygon* const> faces) {
    if (faces.size() > kLargestConvexTest) return false;
    const Numbered shape = numbered(faces);
    const std::size_t count = shape.corners.size();
    std::vector<FourVec3> corners((count + 3) / 4);
    std::vector<Four> rounding(corners.size());
    for (std::size_t k = 0; k < 4 * corners.size(); ++k) {
        const std::size_t from = std::min(k, count - 1);
        corners[k / 4].x[k % 4] = shape.corners[from].x;
        corners[k / 4].y[k % 4] = shape.corners[from].y;
        corners[k / 4].z[k % 4] = shape.corners[from].z;
        rounding[k / 4][k % 4] = shape.rounding[from];
    }
    return std::all_of(faces.begin(), faces.end(), [&](const Polygon* face) {
        for (std::size_t k = 0; k < corners.size(); ++k) {
            const Four height = dot(face->normal, corners[k]) - face->offset;
            if (bits_of((height > rounding[k]) & (height > face->rounding)) != 0) return false;
        }
        return true;
    });
}

}  // namespace rro
