// Shafts between two parallelograms through scenes in memory.
#pragma once

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "format/sample_points.h"
#include "solver/visibility/visibility.h"
#include "tests/support/scenes.h"

namespace rro::test {

struct Panel {
    Vec3 centre, side, other;
};

/// The parallelogram of two sides about its centre. A uniform distribution of width s has the variance s^2 / 12.
inline ShaftEnd parallelogram_end(const Vec3& centre, const Vec3& side, const Vec3& other) {
    const double deviation = 1 / std::sqrt(12.0);
    ShaftEnd end;
    end.centre = centre;
    end.spread = {side * deviation, other * deviation, Vec3{}};
    Vec3 reach;
    for (int i = 0; i < 3; ++i)
        for (const Vec3& s : end.spread) reach[i] += std::sqrt(3.0) * std::abs(s[i]);
    end.box = {centre - reach, centre + reach};
    return end;
}

inline Shaft shaft_between(const Panel& a, const Panel& b, std::uint64_t seed) {
    Shaft s;
    s.a = parallelogram_end(a.centre, a.side, a.other);
    s.b = parallelogram_end(b.centre, b.side, b.other);
    s.seed = seed;
    s.segment = [a, b](const std::array<float, 4>& u) {
        const auto at = [](const Panel& p, float x, float y) {
            return p.centre + p.side * (double(x) - 0.5) + p.other * (double(y) - 0.5);
        };
        return Segment{at(a, u[0], u[1]), at(b, u[2], u[3]), {}, {}};
    };
    return s;
}

inline double uniform(std::uint64_t& state) {
    state = mix64(state);
    return static_cast<double>(state >> 11) * 0x1p-53;
}

inline Vec3 random_direction(std::uint64_t& state) {
    const double z = 2 * uniform(state) - 1, angle = 2 * std::numbers::pi * uniform(state), r = std::sqrt(1 - z * z);
    return {r * std::cos(angle), r * std::sin(angle), z};
}

inline Panel square(const Vec3& centre, const Vec3& normal, double side) {
    const auto [x, y, z] = frame_about(normalised(normal));
    return {centre, x * side, y * side};
}

/// Shafts between squares of this side, 2 to 4 radii before and behind points in a ball about the origin.
inline std::vector<Shaft> shafts_through(double radius, double side, std::size_t count) {
    std::vector<Shaft> out;
    std::uint64_t state = 5;
    while (out.size() < count) {
        const Vec3 w = random_direction(state), through = random_direction(state) * (radius * std::cbrt(uniform(state)));
        const double before = radius * (2 + 2 * uniform(state)), behind = radius * (2 + 2 * uniform(state));
        out.push_back(shaft_between(square(through - w * before, w, side), square(through + w * behind, w, side), mix64(state)));
    }
    return out;
}

/// All that visibility looks at, and nothing else.
inline CompileOptions visibility_tables(bool every_node = false) {
    CompileOptions options;
    options.tables.errors = options.tables.selflinks = false;
    options.tables.every_node = every_node;
    return options;
}

inline Demand fixed_rays(std::uint32_t rays, LinePoints points = LinePoints::Sobol) {
    Demand d;
    d.rule = StopRule::Fixed;
    d.most = rays;
    d.points = points;
    return d;
}

/// By very many rays, other ones than the shaft's own.
inline double true_transmittance(const Scene& scene, const SceneRays& rays, Shaft shaft) {
    shaft.seed = mix64(~shaft.seed);
    return Visibility(scene, rays, VisibilityMethod::Rays).transmittance(shaft, fixed_rays(4096)).mean;
}

}  // namespace rro::test
