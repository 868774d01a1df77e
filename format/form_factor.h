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
/// errors   none: a point on the polygon's plane gives 0, a point on an edge of it the one-sided limit from the front
/// source   Lambert's contour formula, F = 1/(2 pi) sum_k n . Gamma_k [Baum 89]; the angle of each edge by
///          atan2(|a x b|, a . b), which is stable for nearly parallel and nearly opposite corners; far, tiny polygons
///          (solid angle below 1e-6) by the area form, where the contour formula cancels
double point_to_polygon(const Vec3& p, const Vec3& n, std::span<const Vec3> polygon);
double point_to_triangle(const Vec3& p, const Vec3& n, const TriangleCorners& t);

/// Form factor between two parallel coaxial disks, F12, with radii over distance R1, R2 >= 0.
///
/// source   paper figure 5, [MODE 93]; in the shape that does not cancel: 2 R2^2 / (Y + sqrt((1+(R1-R2)^2)(1+(R1+R2)^2))),
///          Y = 1 + R1^2 + R2^2; relative error 1e-15 over all ratios
double disk_to_disk(double r1, double r2);

/// A_a F_ab = A_b F_ba between two triangles' fronts, m^2, unoccluded, by adaptive quadrature of point_to_triangle over
/// `a` until two levels agree to `tolerance` (relative), at most `max_depth` subdivisions.
double exchange_area(const TriangleCorners& a, const TriangleCorners& b, double tolerance = 1e-6, int max_depth = 8);

}  // namespace rro
