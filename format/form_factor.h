// The geometric kernels of diffuse transport: contour and disk form factors. Self links and near field mean the same
// thing by them. Double precision throughout; unoccluded.
#pragma once

#include <span>

#include "format/geometry.h"

namespace rro {

/// Form factor from a differential area at `p` with unit normal `n` to the front of a planar polygon: the share of the
/// cosine-weighted hemisphere that it covers, in [0, 1]. Parts below the horizon of `p` are clipped.
///
/// polygon  3 or more corners, counter-clockwise as seen from its front; seen from behind it gives 0
/// errors   none: a point on the polygon's plane gives 0, a point on an edge of it the one-sided limit from the front.
///          Rounding: a few 1e-16 of the angles of the edges; 1e-16 / d where an edge passes at the distance d,
///          relative to its length
/// source   Lambert's contour formula, F = 1/(2 pi) sum_k n . Gamma_k [Baum 89]; the angle of each edge by
///          atan2(|a x b|, a . b), which is stable for nearly parallel and nearly opposite corners; far, small polygons
///          (extent below 1/50 of the distance) by the area form to 1e-12, where the contour formula cancels
double point_to_polygon(const Vec3& p, const Vec3& n, std::span<const Vec3> polygon);
/// The same for a triangle.
double point_to_triangle(const Vec3& p, const Vec3& n, const TriangleCorners& t);

/// The same by the contour formula alone, several edges at a time: for a polygon known to be above the horizon of `p` as a
/// whole, with `p` in front of it. Rounding: some 1e-16, whatever the form factor is.
double point_to_polygon_above(const Vec3& p, const Vec3& n, std::span<const Vec3> polygon);

/// The vector irradiance 1/(2 pi) sum_k Gamma_k of the front of a planar polygon at `p`: its dot product with any unit
/// normal that has the whole polygon above the horizon is the form factor point_to_polygon. Nothing is clipped, and the
/// length is at most 1. Polygon, rounding and source as above; from behind, or on the plane but off the edges, 0.
Vec3 polygon_vector_irradiance(const Vec3& p, std::span<const Vec3> polygon);

/// Form factor between two parallel coaxial disks, F12, with radii over distance R1, R2 >= 0.
///
/// source   paper figure 5, [MODE 93]; in the shape that does not cancel, with Y = 1 + R1^2 + R2^2:
///          2 R2^2 / (Y + sqrt((1 + (R1 - R2)^2) (1 + (R1 + R2)^2))); relative error 1e-15 over all ratios
double disk_to_disk(double r1, double r2);

/// A_a F_ab = A_b F_ba between two triangles' fronts, m^2, unoccluded, by adaptive quadrature of point_to_triangle over
/// the part of the smaller one in front of the other, until two levels agree to `tolerance` (relative), at most `max_depth`
/// subdivisions. Common edges and corners need no care; a gap of less than 1 % of the triangles, but none, may cost some
/// 1e-3 of it, and so may a needle on a common edge.
double exchange_area(const TriangleCorners& a, const TriangleCorners& b, double tolerance = 1e-6, int max_depth = 12);

}  // namespace rro
