// The value types an archive stores and both programs compute with, and their arithmetic.
//
// Lengths are metres. Right-handed, y up. Points are columns: p' = M p.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

namespace rro {

/// A point, direction or RGB triple in double precision.
struct Vec3 {
    double x = 0, y = 0, z = 0;

    constexpr Vec3() = default;
    constexpr Vec3(double x_, double y_, double z_) : x(x_), y(y_), z(z_) {}

    constexpr double& operator[](int i) { return i == 0 ? x : i == 1 ? y : z; }
    constexpr double operator[](int i) const { return i == 0 ? x : i == 1 ? y : z; }
    constexpr Vec3& operator+=(const Vec3& b) { return x += b.x, y += b.y, z += b.z, *this; }
    constexpr Vec3& operator-=(const Vec3& b) { return x -= b.x, y -= b.y, z -= b.z, *this; }
    constexpr Vec3& operator*=(double s) { return x *= s, y *= s, z *= s, *this; }
    constexpr bool operator==(const Vec3&) const = default;
};

// Arithmetic of vectors; hadamard multiplies component by component.
constexpr Vec3 operator+(Vec3 a, const Vec3& b) { return a += b; }
constexpr Vec3 operator-(Vec3 a, const Vec3& b) { return a -= b; }
constexpr Vec3 operator-(const Vec3& a) { return {-a.x, -a.y, -a.z}; }
constexpr Vec3 operator*(Vec3 a, double s) { return a *= s; }
constexpr Vec3 operator*(double s, Vec3 a) { return a *= s; }
constexpr Vec3 operator/(Vec3 a, double s) { return a *= 1.0 / s; }
constexpr double dot(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
constexpr Vec3 cross(const Vec3& a, const Vec3& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
constexpr Vec3 hadamard(const Vec3& a, const Vec3& b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
constexpr double length2(const Vec3& a) { return dot(a, a); }
inline double length(const Vec3& a) { return std::sqrt(dot(a, a)); }
constexpr double max_component(const Vec3& a) { return std::max(a.x, std::max(a.y, a.z)); }
inline bool is_finite(const Vec3& a) { return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z); }

/// a / |a|; the zero vector stays zero.
inline Vec3 normalised(const Vec3& a) {
    const double n = length(a);
    return n > 0 ? a / n : Vec3{};
}

/// Storage form of a point relative to an archive's origin, or of an RGB triple. 12 bytes, no padding.
struct Vec3f {
    float x = 0, y = 0, z = 0;

    constexpr bool operator==(const Vec3f&) const = default;
};
static_assert(sizeof(Vec3f) == 12);

/// Exact.
constexpr Vec3 to_double(const Vec3f& a) { return {a.x, a.y, a.z}; }
/// Rounded to nearest.
constexpr Vec3f to_float(const Vec3& a) {
    return {static_cast<float>(a.x), static_cast<float>(a.y), static_cast<float>(a.z)};
}

/// Three corner indices; the front is the side from which they run counter-clockwise.
using TriangleIndices = std::array<std::uint32_t, 3>;

/// Three corner positions.
using TriangleCorners = std::array<Vec3, 3>;

/// Area times unit normal: half the cross product of two edges.
constexpr Vec3 area_vector(const Vec3& a, const Vec3& b, const Vec3& c) { return 0.5 * cross(b - a, c - a); }
/// The same.
constexpr Vec3 area_vector(const TriangleCorners& t) { return area_vector(t[0], t[1], t[2]); }

/// Axis-aligned box; empty until something is added.
struct Box3 {
    Vec3 lo{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(),
            std::numeric_limits<double>::infinity()};
    Vec3 hi{-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(),
            -std::numeric_limits<double>::infinity()};

    constexpr bool empty() const { return !(lo.x <= hi.x && lo.y <= hi.y && lo.z <= hi.z); }
    constexpr void add(const Vec3& p) {
        for (int i = 0; i < 3; ++i) {
            lo[i] = std::min(lo[i], p[i]);
            hi[i] = std::max(hi[i], p[i]);
        }
    }
    constexpr void add(const Box3& b) {
        if (!b.empty()) add(b.lo), add(b.hi);
    }
    constexpr Vec3 centre() const { return 0.5 * (lo + hi); }
    constexpr Vec3 extent() const { return hi - lo; }
    constexpr double surface_area() const {
        const Vec3 e = extent();
        return 2 * (e.x * e.y + e.y * e.z + e.z * e.x);
    }
    constexpr bool contains(const Vec3& p) const {
        return p.x >= lo.x && p.x <= hi.x && p.y >= lo.y && p.y <= hi.y && p.z >= lo.z && p.z <= hi.z;
    }
    constexpr bool overlaps(const Box3& b) const {
        return lo.x <= b.hi.x && b.lo.x <= hi.x && lo.y <= b.hi.y && b.lo.y <= hi.y && lo.z <= b.hi.z && b.lo.z <= hi.z;
    }
};

/// 3x3 matrix, rows first.
struct Mat3 {
    std::array<Vec3, 3> rows{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};

    constexpr double operator()(int r, int c) const { return rows[static_cast<std::size_t>(r)][c]; }
    constexpr Vec3 operator*(const Vec3& v) const { return {dot(rows[0], v), dot(rows[1], v), dot(rows[2], v)}; }
    constexpr Vec3 column(int c) const { return {rows[0][c], rows[1][c], rows[2][c]}; }
    constexpr Mat3 transposed() const { return {{column(0), column(1), column(2)}}; }
    constexpr double determinant() const { return dot(rows[0], cross(rows[1], rows[2])); }

    /// Inverse by cofactors; the caller has checked that the determinant is not 0.
    constexpr Mat3 inverse() const {
        const double s = 1.0 / determinant();
        const Mat3 cofactors{{cross(rows[1], rows[2]) * s, cross(rows[2], rows[0]) * s, cross(rows[0], rows[1]) * s}};
        return cofactors.transposed();
    }
    constexpr bool operator==(const Mat3&) const = default;
};

/// First b, then a.
constexpr Mat3 operator*(const Mat3& a, const Mat3& b) {
    const Mat3 bt = b.transposed();
    return {{bt * a.rows[0], bt * a.rows[1], bt * a.rows[2]}};
}

/// p' = linear p + translation.
struct Affine3 {
    Mat3 linear;
    Vec3 translation;

    constexpr Vec3 point(const Vec3& p) const { return linear * p + translation; }
    constexpr Vec3 vector(const Vec3& v) const { return linear * v; }
    constexpr Affine3 inverse() const {
        const Mat3 m = linear.inverse();
        return {m, -(m * translation)};
    }
    constexpr Box3 box(const Box3& b) const {
        Box3 out;
        for (int corner = 0; corner < 8; ++corner)
            out.add(point({corner & 1 ? b.hi.x : b.lo.x, corner & 2 ? b.hi.y : b.lo.y, corner & 4 ? b.hi.z : b.lo.z}));
        return out;
    }
    constexpr bool operator==(const Affine3&) const = default;
};

/// First b, then a.
constexpr Affine3 operator*(const Affine3& a, const Affine3& b) {
    return {a.linear * b.linear, a.point(b.translation)};
}

/// Linear RGB, or one value per channel, in float.
using Rgb = Vec3f;

}  // namespace rro
