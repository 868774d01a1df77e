// What two planar polygons exchange with nothing between them: the kernel of exact view factors.
#pragma once

#include <span>

#include "solver/factors/polygon.h"

namespace rro {

/// Two polygons that may see each other: the parts of each in front of the other's plane.
struct FacingPair {
    const Polygon* a = nullptr;  // the polygon itself, or cut_a
    const Polygon* b = nullptr;
    Polygon cut_a, cut_b;
};

/// returns  false where no part of one is in front of the other, or both lie in one plane and look the same way
bool facing_parts(const Polygon& a, const Polygon& b, FacingPair& pair);

/// A_a F_ab = A_b F_ba, m^2, of the fronts of two convex polygons, each wholly in front of the other, with nothing between.
/// Both carry their rules.
///
/// errors   none; relative 1e-6 or better wherever F is above 1e-12 of the smaller polygon's: common edges and corners,
///          tiny and far polygons included
/// source   far apart: product of Gauss rules; one small for its distance: a rule over it of the exact point-to-polygon
///          factor (format/form_factor.h); near and touching: the double contour integral
///          1/(2 pi) sum_e sum_e' (e . e') ln r, inner one in closed form, outer one by adaptive Gauss-Kronrod rules
double facing_exchange(const Polygon& a, const Polygon& b);

/// The double contour integral alone, for any two polygons each wholly in front of the other.
double contour_exchange(std::span<const Vec3> a, std::span<const Vec3> b);

}  // namespace rro
