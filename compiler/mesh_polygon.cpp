#include "compiler/mesh_polygon.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>

namespace rro {
namespace {

// All lengths below are in units of the polygon's own extent.
constexpr double kNoArea = 1e-13;       // turns within rounding are straight
constexpr double kPlanarWithin = 1e-6;  // what is left of a plane in text with seven digits

struct Point {
    double x, y;
    bool operator==(const Point&) const = default;
};

/// Twice the signed area; positive where a, b, c turn left.
double turn(const Point& a, const Point& b, const Point& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

bool inside(const Point& p, const Point& a, const Point& b, const Point& c) {
    return turn(a, b, p) >= -kNoArea && turn(b, c, p) >= -kNoArea && turn(c, a, p) >= -kNoArea;
}

bool cross_properly(const Point& a, const Point& b, const Point& c, const Point& d) {
    const double ca = turn(a, b, c), da = turn(a, b, d), ac = turn(c, d, a), bc = turn(c, d, b);
    return ((ca > kNoArea && da < -kNoArea) || (ca < -kNoArea && da > kNoArea)) &&
           ((ac > kNoArea && bc < -kNoArea) || (ac < -kNoArea && bc > kNoArea));
}

/// First corner at the origin, extent 1; empty where that is impossible.
std::vector<Vec3> normalised_corners(std::span<const Vec3> corners) {
    double extent = 0;
    for (const Vec3& p : corners) {
        const Vec3 q = p - corners[0];
        extent = std::max({extent, std::abs(q.x), std::abs(q.y), std::abs(q.z)});
        if (!is_finite(q)) return {};
    }
    if (!(extent > 0) || !std::isfinite(1 / extent)) return {};
    std::vector<Vec3> normalised;
    for (const Vec3& p : corners) normalised.push_back((p - corners[0]) / extent);
    return normalised;
}

/// Unit normal of the mean plane (Newell); where the areas cancel, of the largest corner; else 0.
Vec3 polygon_normal(const std::vector<Vec3>& q) {
    Vec3 sum, largest;
    for (std::size_t i = 0; i < q.size(); ++i) {
        const Vec3& next = q[(i + 1) % q.size()];
        sum += cross(q[i], next);
        const Vec3 corner = cross(next - q[i], q[(i + 2) % q.size()] - next);
        if (length2(corner) > length2(largest)) largest = corner;
    }
    if (length(sum) > kNoArea) return normalised(sum);
    return length(largest) > kNoArea ? normalised(largest) : Vec3{};
}

/// Drops the normal's largest component, so coordinates stay exact and straight lines straight.
std::vector<Point> projected(const std::vector<Vec3>& q, const Vec3& normal) {
    int axis = 0;
    for (int i = 1; i < 3; ++i)
        if (std::abs(normal[i]) > std::abs(normal[axis])) axis = i;
    int u = (axis + 1) % 3, v = (axis + 2) % 3;
    if (normal[axis] < 0) std::swap(u, v);
    std::vector<Point> points;
    for (const Vec3& p : q) points.push_back({p[u], p[v]});
    return points;
}

bool is_planar(const std::vector<Vec3>& q, const Vec3& normal) {
    double low = 0, high = 0;
    for (const Vec3& p : q) {
        low = std::min(low, dot(p, normal));
        high = std::max(high, dot(p, normal));
    }
    return high - low <= kPlanarWithin;
}

bool fan_covers(const std::vector<Point>& points) {
    const std::size_t k = points.size();
    for (std::size_t i = 0; i < k; ++i)
        if (turn(points[i], points[(i + 1) % k], points[(i + 2) % k]) < -kNoArea) return false;
    for (std::size_t i = 1; i + 1 < k; ++i)
        if (turn(points[0], points[i], points[i + 1]) <= kNoArea) return false;
    return true;
}

/// Whether the triangle at left[i] can be cut off: it turns left, nothing lies in it, its new side crosses nothing. Takes
/// off `steps` what it compares; their caller sees to it that there are enough.
bool is_ear(const std::vector<Point>& points, const std::vector<std::uint32_t>& left, std::size_t i,
            std::uint64_t& steps) {
    const std::size_t n = left.size();
    const Point &a = points[left[(i + n - 1) % n]], &b = points[left[i]], &c = points[left[(i + 1) % n]];
    if (turn(a, b, c) <= kNoArea) return false;
    for (std::size_t j = 0; j < n; ++j) {
        --steps;
        const Point &p = points[left[j]], &q = points[left[(j + 1) % n]];
        // A corner in the same place as one of ours (a bridge to a hole, a touching corner) is no obstacle in itself.
        if (p != a && p != b && p != c && inside(p, a, b, c)) return false;
        if (cross_properly(a, c, p, q)) return false;
    }
    return true;
}

/// The corner to cut off next: the first ear after the first corner; in a polygon that has none (it crosses itself, or
/// all that is left is straight), the corner with the smallest area. None where the steps end.
std::optional<std::size_t> next_corner(const std::vector<Point>& points, const std::vector<std::uint32_t>& left,
                                       std::uint64_t& steps) {
    const std::size_t n = left.size();
    for (std::size_t step = 1; step <= n; ++step) {
        if (steps <= 2 * n) return std::nullopt;  // for an ear and the search below
        --steps;
        if (is_ear(points, left, step % n, steps)) return step % n;
    }
    steps -= n;
    std::size_t best = 0;
    double smallest = 0;
    for (std::size_t i = 0; i < n; ++i) {
        const double area = std::abs(turn(points[left[(i + n - 1) % n]], points[left[i]], points[left[(i + 1) % n]]));
        if (i == 0 || area < smallest) best = i, smallest = area;
    }
    return best;
}

void fan(std::size_t k, PolygonTriangles& out) {
    for (std::uint32_t i = 1; i + 1 < k; ++i) out.triangles.push_back({0, i, i + 1});
}

}  // namespace

std::optional<PolygonTriangles> triangulate_polygon(std::span<const Vec3> corners, std::uint64_t& steps) {
    assert(corners.size() >= 3);
    PolygonTriangles out;
    const std::vector<Vec3> q = corners.size() > 3 ? normalised_corners(corners) : std::vector<Vec3>{};
    const Vec3 normal = polygon_normal(q);
    if (q.empty() || normal == Vec3{}) {
        fan(corners.size(), out);
        return out;
    }
    const std::vector<Point> points = projected(q, normal);
    if (fan_covers(points) && is_planar(q, normal)) {
        fan(corners.size(), out);
        return out;
    }
    out.ear_clipped = true;
    std::vector<std::uint32_t> left(corners.size());
    std::iota(left.begin(), left.end(), 0u);
    while (left.size() > 3) {
        const auto found = next_corner(points, left, steps);
        if (!found) return std::nullopt;
        const std::size_t n = left.size(), i = *found;
        out.triangles.push_back({left[(i + n - 1) % n], left[i], left[(i + 1) % n]});
        left.erase(left.begin() + static_cast<std::ptrdiff_t>(i));
    }
    out.triangles.push_back({left[0], left[1], left[2]});
    return out;
}

}  // namespace rro
