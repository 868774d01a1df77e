#include "solver/visibility/shaft.h"

#include <cmath>

#include "format/sample_points.h"

namespace rro {
namespace {

// A uniform distribution of width s has the variance s^2 / 12.
const double kDeviation = 1 / std::sqrt(12.0);

}  // namespace

ShaftEnd box_end(const Box3& box) {
    const Vec3 s = box.extent() * kDeviation;
    return {box, box.centre(), {Vec3{s.x, 0, 0}, Vec3{0, s.y, 0}, Vec3{0, 0, s.z}}, {}, 0};
}

// The covariance of a triangle is a twelfth of the sum over its corners; of their distances along a direction, which sum
// to 0, the largest is half the sum of absolute values.
ShaftEnd triangle_end(const TriangleCorners& corners) {
    ShaftEnd end;
    end.centre = (corners[0] + corners[1] + corners[2]) / 3;
    for (std::size_t i = 0; i < 3; ++i) {
        end.box.add(corners[i]);
        end.spread[i] = (corners[i] - end.centre) * kDeviation;
    }
    return end;
}

LocalShaft::LocalShaft(const Shaft& shaft, const Affine3& to_local)
    : a(to_local.point(shaft.a.centre)), b(to_local.point(shaft.b.centre)) {
    for (std::size_t i = 0; i < 3; ++i) {
        spread_a[i] = to_local.vector(shaft.a.spread[i]);
        spread_b[i] = to_local.vector(shaft.b.spread[i]);
    }
}

CrossSection cross_section(const LocalShaft& shaft, const Vec3& nearest_to) {
    CrossSection c;
    const Vec3 axis = shaft.b - shaft.a;
    c.t = dot(nearest_to - shaft.a, axis) / length2(axis);
    c.at = shaft.a + axis * c.t;
    c.direction = normalised(axis);
    const auto frame = frame_about(c.direction);
    const Vec3 &x = frame[0], &y = frame[1];
    double xx = 0, xy = 0, yy = 0;
    const auto add = [&](const Vec3& v, double share) {
        const double i = share * dot(v, x), j = share * dot(v, y);
        xx += i * i, xy += i * j, yy += j * j;
    };
    for (const Vec3& s : shaft.spread_a) add(s, 1 - c.t);
    for (const Vec3& s : shaft.spread_b) add(s, c.t);
    const double mean = 0.5 * (xx + yy), half = std::hypot(0.5 * (xx - yy), xy);
    const double angle = 0.5 * std::atan2(2 * xy, xx - yy);
    c.major = x * std::cos(angle) + y * std::sin(angle);
    c.minor = y * std::cos(angle) - x * std::sin(angle);
    c.wide = std::sqrt(12 * (mean + half));
    c.narrow = std::sqrt(12 * std::max(0.0, mean - half));
    return c;
}

}  // namespace rro
