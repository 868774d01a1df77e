// A shaft: all straight lines between the points of two ends, as the methods of visibility need to know it.
#pragma once

#include <array>
#include <cstdint>
#include <functional>

#include "solver/visibility/scene_rays.h"

namespace rro {

/// An end of a shaft. Its points lie evenly about the centre with the covariance sum_i spread_i spread_i^T, and no point
/// is farther from it along any direction u than sqrt(3) sum_i |dot(spread_i, u)|: true of boxes, parallelograms and
/// triangles alike.
struct ShaftEnd {
    Box3 box;
    Vec3 centre;
    std::array<Vec3, 3> spread;  // m
    // All lines leave to this side of the end: nothing below `height` along the unit vector `front` meets them. 0: unknown.
    Vec3 front;
    double height = 0;
};

/// The points of a box.
ShaftEnd box_end(const Box3& box);
/// The points of a triangle.
ShaftEnd triangle_end(const TriangleCorners& corners);

/// One line between the ends.
struct Segment {
    Vec3 p, q;
    SceneTriangle p_on, q_on;  // the triangles that the points lie on, if any
    double weight = 1;         // in the mean; not above 0: the points do not see one another's front, and no ray is asked
    std::array<std::uint32_t, 2> passed{kNoInstance, kNoInstance};  // instances that this line passes through
};

/// Two ends and the lines between them.
struct Shaft {
    ShaftEnd a, b;
    std::array<std::uint32_t, 2> passed{kNoInstance, kNoInstance};  // instances that no line of it meets
    bool crowd = false;  // ends of many instances: those that lines pass through are the segments' own
    std::function<Segment(const std::array<float, 4>&)> segment;  // the line of a point of the unit hypercube
    std::uint64_t seed = 0;
};

/// A shaft in the frame of an object, and its cross-section at the foot of a point on its axis.
struct LocalShaft {
    Vec3 a, b;  // centres of the ends
    std::array<Vec3, 3> spread_a, spread_b;

    LocalShaft(const Shaft& shaft, const Affine3& to_local);
};

/// The cross-section of a shaft perpendicular to its axis: principal widths (of the rectangle of the same variance).
struct CrossSection {
    double t = 0;               // share of the way from a to b
    Vec3 at;                    // on the axis
    Vec3 direction;             // unit, from a to b
    Vec3 major, minor;          // unit, perpendicular to it
    double wide = 0, narrow = 0;  // full widths along them
    double area() const { return wide * narrow; }
};
/// In the frame of the shaft; nearest_to is a point of that frame.
CrossSection cross_section(const LocalShaft& shaft, const Vec3& nearest_to);

}  // namespace rro
