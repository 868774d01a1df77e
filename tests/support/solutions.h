// Solving scenes in tests, and comparing what comes out by the definition of error.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "solver/effects/effect.h"
#include "solver/study/reference.h"
#include "solver/transport/transport.h"
#include "tests/support/scenes.h"

namespace rro::test {

inline Solution solve_reusably(const Scene& scene, double accuracy, const std::vector<std::string>& without = {}) {
    auto plan = plan_effects(scene, {{}, without});
    REQUIRE(plan);
    TransportOptions options;
    options.accuracy = accuracy;
    auto solution = solve_reusable(scene, *plan, options);
    REQUIRE(solution);
    return std::move(*solution);
}

inline Solution solve_by_paths(const Scene& scene, std::uint32_t samples) {
    ReferenceOptions options;
    options.samples = samples;
    auto solution = solve_reference(scene, options);
    REQUIRE(solution);
    return std::move(*solution);
}

/// Reflected radiosity R = B - M of a face.
inline Vec3 reflected(const Instance& instance, const InstanceSolution& s, std::size_t f) {
    return to_double(s.radiosity[f]) - to_double(instance.exitance[instance.object->patch_of_face[f]]);
}

inline Spread radiosity(const Scene& scene, const Solution& s, std::size_t i) {
    return over_faces(scene.instances[i], [&](std::size_t f) { return double(s.instances[i].radiosity[f].y); });
}

/// Sums of area times square: of the difference of two solutions, of the truth's own variance, of its R.
struct ErrorSums {
    double difference = 0, noise = 0, truth = 0;
    double error() const { return truth > 0 ? std::sqrt(std::max(0.0, difference - noise) / truth) : 0; }
    /// Standard error of `truth`'s mean, relative to it.
    double truth_error() const { return truth > 0 ? std::sqrt(noise / truth) : 0; }
};

inline ErrorSums compare(const Instance& instance, const InstanceSolution& x, const InstanceSolution& truth) {
    ErrorSums s;
    for (std::size_t f = 0; f < truth.radiosity.size(); ++f) {
        const double a = face_area(instance, f);
        const double noise =
            truth.standard_error.empty() ? 0.0 : a * length2(to_double(truth.standard_error[f]));
        s.difference += a * length2(to_double(x.radiosity[f]) - to_double(truth.radiosity[f]));
        s.noise += noise;
        s.truth += a * length2(reflected(instance, truth, f)) - noise;
    }
    return s;
}

/// The error of solver/accuracy.md of a whole scene, and of its worst instance among those that matter.
struct SceneError {
    ErrorSums all;
    double worst = 0;
    std::string worst_name;
};

inline SceneError compare(const Scene& scene, const Solution& x, const Solution& truth) {
    SceneError out;
    std::vector<ErrorSums> each;
    std::vector<double> power;
    double total = 0;
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const Instance& instance = scene.instances[i];
        each.push_back(compare(instance, x.instances[i], truth.instances[i]));
        power.push_back(0);
        for (std::size_t f = 0; f < truth.instances[i].radiosity.size(); ++f) {
            const Vec3 r = reflected(instance, truth.instances[i], f);
            power.back() += face_area(instance, f) * (r.x + r.y + r.z);
        }
        total += power.back();
        out.all.difference += each.back().difference;
        out.all.noise += each.back().noise;
        out.all.truth += each.back().truth;
    }
    constexpr double kMatters = 1e-3;  // of all reflected power
    for (std::size_t i = 0; i < each.size(); ++i)
        if (power[i] > kMatters * total && each[i].error() > out.worst) {
            out.worst = each[i].error();
            out.worst_name = scene.instances[i].name;
        }
    return out;
}

/// The same of the whole scene, with the truth's own variance left in.
inline double difference(const Scene& scene, const Solution& x, const Solution& truth) {
    const ErrorSums s = compare(scene, x, truth).all;
    return std::sqrt(s.difference / (s.truth + s.noise));
}

/// Number of a source triangle's side.
inline std::size_t side_number(const ObjectData& data, std::size_t f) {
    return 2 * std::size_t(data.source_triangle[data.faces[f].triangle()]) +
           static_cast<std::size_t>(data.faces[f].side());
}

/// The same solution with the faces of another archive of the same triangles.
inline InstanceSolution renumbered(const ObjectData& from, const InstanceSolution& s, const ObjectData& to) {
    std::vector<std::size_t> face_of(2 * from.meta.source_triangles);
    for (std::size_t f = 0; f < from.faces.size(); ++f) face_of[side_number(from, f)] = f;
    InstanceSolution out;
    for (std::size_t f = 0; f < to.faces.size(); ++f) out.radiosity.push_back(s.radiosity[face_of[side_number(to, f)]]);
    return out;
}

}  // namespace rro::test
