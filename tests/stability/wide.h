// Form factors in quadruple precision: witnesses that keep 30 digits where double cancels them.
#pragma once

#include <quadmath.h>

#include <span>
#include <vector>

#include "format/geometry.h"

namespace rro::test {

using Wide = __float128;

inline const Wide kWidePi = acosq(-1);

struct Wide3 {
    Wide x, y, z;
};
inline Wide3 wide(const Vec3& a) { return {Wide(a.x), Wide(a.y), Wide(a.z)}; }
inline Wide3 operator-(const Wide3& a, const Wide3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Wide3 operator+(const Wide3& a, const Wide3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Wide3 operator*(const Wide3& a, Wide s) { return {a.x * s, a.y * s, a.z * s}; }
inline Wide dot(const Wide3& a, const Wide3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Wide3 cross(const Wide3& a, const Wide3& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// Form factor from a point with a normal to the front of a polygon: Lambert's contour formula as the books print it, cut at
/// the horizon. p must not lie on the polygon's plane.
inline double wide_point_factor(const Vec3& p, const Vec3& n, std::span<const Vec3> polygon) {
    std::vector<Wide3> above;
    Wide3 normal{0, 0, 0};
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Wide3 a = wide(polygon[i]) - wide(p), b = wide(polygon[(i + 1) % polygon.size()]) - wide(p);
        normal = normal + cross(a, b);
        const Wide ha = dot(wide(n), a), hb = dot(wide(n), b);
        if (ha > 0) above.push_back(a);
        if ((ha > 0) != (hb > 0)) above.push_back(a + (b - a) * (ha / (ha - hb)));
    }
    if (dot(normal, wide(polygon[0]) - wide(p)) >= 0) return 0;  // from behind
    Wide sum = 0;
    for (std::size_t i = 0; i < above.size(); ++i) {
        const Wide3 &a = above[i], &b = above[(i + 1) % above.size()], c = cross(b, a);
        const Wide sine = sqrtq(dot(c, c));
        if (sine > 0) sum += dot(wide(n), c) / sine * atan2q(sine, dot(a, b));
    }
    return static_cast<double>(sum / (2 * kWidePi));
}

/// Identical facing rectangles of sides a and b at distance d, F (Howell C-11).
inline double wide_facing(double a, double b, double d) {
    const Wide x = Wide(a) / Wide(d), y = Wide(b) / Wide(d), x2 = 1 + x * x, y2 = 1 + y * y;
    const Wide sum = log1pq(x * x * y * y / (x2 + y * y)) / 2 + x * sqrtq(y2) * atanq(x / sqrtq(y2)) +
                     y * sqrtq(x2) * atanq(y / sqrtq(x2)) - x * atanq(x) - y * atanq(y);
    return static_cast<double>(2 / (kWidePi * x * y) * sum);
}

/// Exchange area A F of two rectangles at right angles with a common edge of this length; a and b are their other sides
/// (Howell C-14).
inline Wide wide_corner_exchange(Wide edge, Wide a, Wide b) {
    const Wide w = a / edge, h = b / edge, w2 = w * w, h2 = h * h, r2 = w2 + h2, r = sqrtq(r2);
    const Wide logs = logq((1 + w2) * (1 + h2) / (1 + r2)) + w2 * logq(w2 * (1 + r2) / ((1 + w2) * r2)) +
                      h2 * logq(h2 * (1 + r2) / ((1 + h2) * r2));
    return edge * edge / kWidePi * (w * atanq(1 / w) + h * atanq(1 / h) - r * atanq(1 / r) + logs / 4);
}

/// Coaxial parallel disks of these radii over their distance, F12 (Howell C-41).
inline double wide_disks(double r1, double r2) {
    const Wide a = Wide(r1) * Wide(r1), b = Wide(r2) * Wide(r2), x = 1 + a + b;
    return static_cast<double>(2 * b / (x + sqrtq(x * x - 4 * a * b)));  // the root as the books have it
}

}  // namespace rro::test
