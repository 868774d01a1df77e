// What two planar polygons exchange past others that stand between them.
#pragma once

#include <span>
#include <vector>

#include "solver/factors/polygon.h"
#include "solver/factors/solid.h"

namespace rro {

/// What stands between two polygons.
struct Obstacles {
    std::span<const Polygon* const> bodies;
    std::span<const Solid* const> solids;  // with no part of either inside
};

/// An exchange and how sure it is.
struct ObstructedExchange {
    double value = 0;           // A_a F_ab, m^2
    double standard_error = 0;  // m^2
};

/// The exchange of a's front with b's front, integrated over a: at each node of the rule the part of b that the obstacles
/// leave in sight is cut out exactly, so that the only error is that of the rule over a. Triangles of a are quartered
/// until two levels agree to `tolerance` (m^2, for the whole), and where a blocker smaller than they is near.
///
/// a         with its rules; b wholly in front of it, and it of b
/// quick     two rules over the whole of a that agree will do
/// obstacles may reach behind a and b: what does so is cut off
/// returns   the standard error is twice the quadratic sum of the last differences between levels, or four times that
///           between rules
ObstructedExchange obstructed_exchange(const Polygon& a, const Polygon& b, const Obstacles& obstacles,
                                       double tolerance, bool quick);

/// The same from a few points only, to know how large it is.
double rough_exchange(const Polygon& a, const Polygon& b, const Obstacles& obstacles);

}  // namespace rro
