// Low-discrepancy points and maps of the unit square onto what is sampled.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "format/geometry.h"

namespace rro {

/// Stateless mixing of a 64-bit key; the same key gives the same stream on every machine and thread.
constexpr std::uint64_t mix64(std::uint64_t x) {
    x += 0x9e3779b97f4a7c15ull;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
    return x ^ (x >> 31);
}

/// Point `index` of the Owen-scrambled Sobol sequence in 4 dimensions, each in [0, 1). The scramble is chosen by `seed`.
/// Any power of two of consecutive points from 0 is a (0, m, 2)-net in dimensions (0,1), a (t, m, 2)-net in every
/// other pair, (2,3) among them, with t <= 2 up to 2^16 points, and stratified in each single dimension.
/// source   [Burley 2020] hash-based Owen scrambling and shuffling; direction numbers of [Joe and Kuo 2008]
std::array<float, 4> sobol4(std::uint32_t index, std::uint64_t seed);

/// Uniform barycentric coordinates (of corners 1 and 2) from the unit square, by the low-distortion map [Heitz 2019].
std::array<double, 2> square_to_triangle(double u, double v);

/// Cosine-weighted direction about +z from the unit square (concentric map).
Vec3 square_to_cosine_hemisphere(double u, double v);

/// An orthonormal frame whose third vector is the unit vector n [Duff 2017].
std::array<Vec3, 3> frame_about(const Vec3& n);

/// Point of a triangle.
inline Vec3 triangle_point(const TriangleCorners& t, double b1, double b2) {
    return t[0] + (t[1] - t[0]) * b1 + (t[2] - t[0]) * b2;
}

/// Solid angle of a triangle seen from p, sr; negative from its back [Van Oosterom 1983].
double solid_angle(const TriangleCorners& t, const Vec3& p);

/// A triangle as a point sees it: of its points, evenly by the solid angle that they fill, however close it is [Arvo 1995].
class SeenTriangle {
  public:
    SeenTriangle(const Vec3& from, const TriangleCorners& triangle);

    /// sr; at most 0 from its back or out of its plane
    double solid_angle() const { return solid_angle_; }

    /// From the unit square; of a small solid angle, evenly by area. Only where the solid angle is greater than 0.
    Vec3 point(double u, double v) const;

  private:
    Vec3 from_;
    TriangleCorners triangle_;
    std::array<Vec3, 3> corner_;  // unit vectors from the point
    double solid_angle_ = 0, cos_angle_ = 0, sin_angle_ = 0;  // of the spherical triangle at the first corner
    double cos_side_ = 0;                                     // of the side from the first corner to the second
};

/// A symmetric quadrature rule on the triangle: barycentric coordinates (of corners 1 and 2) and weights that sum to 1.
struct TriangleRule {
    struct Node {
        double b1, b2, weight;
    };
    std::span<const Node> nodes;
};

/// The rule with at least `points` nodes among 1, 3, 6, 7, 12, 16 (degrees 1, 2, 4, 5, 6, 8) [Dunavant 1985].
TriangleRule triangle_rule(int points);

}  // namespace rro
