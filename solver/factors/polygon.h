// Convex planar polygons in the world, double precision: what view factors are computed between, and what blocks.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "format/four.h"
#include "format/geometry.h"

namespace rro {

/// Nodes and weights (m^2) of a quadrature rule over a polygon, four at a time; those that fill up weigh nothing.
struct PolygonRule {
    std::vector<FourVec3> nodes;
    std::vector<Four> weights;
    std::uint32_t count = 0;  // of nodes with a weight
};

/// A convex polygon with what is derived from its corners. Lengths in metres.
struct Polygon {
    std::vector<Vec3> corners;  // 3 or more, convex, counter-clockwise as seen from the front
    Vec3 normal;                // unit
    double offset = 0;          // normal . x on the plane
    Vec3 centre;                // of area
    double radius = 0;          // about the centre
    double area = 0;            // m^2
    double rounding = 0;        // m: lesser heights are rounding of the archive's single precision
    PolygonRule coarse, fine, finest;  // exact for polynomials of degree 3, 5, 7 (parallelograms) or 2, 4, 8

    double height(const Vec3& p) const { return dot(normal, p) - offset; }
};

/// A polygon with all that is derived from its corners but the rules, which stay empty.
Polygon make_polygon(std::vector<Vec3> corners, double rounding);

/// The same for corners that are in place.
void derive_from_corners(Polygon& polygon);

/// Adds the quadrature rules: tensor Gauss on parallelograms, rules of triangles on a fan for all others.
void add_rules(Polygon& polygon);

/// The same polygon seen from its back.
Polygon reversed(const Polygon& polygon);

/// The part of a convex polygon where normal . x > offset; empty where there is none.
void clip_to_front(std::span<const Vec3> polygon, const Vec3& normal, double offset, std::vector<Vec3>& part);

/// How a polygon lies to a plane.
enum class Lies { Front, Behind, Across };
Lies lies(const Polygon& polygon, const Polygon& plane);

/// Whether two polygons lie in one plane and look the same way, but for rounding: they exchange nothing.
bool same_plane(const Polygon& a, const Polygon& b);

/// Distance from a point to a polygon, or less: m.
double distance_below(const Vec3& p, const Polygon& polygon);

}  // namespace rro
