// What holds of every solution, and what of those in furnaces.
#pragma once

#include <catch2/catch.hpp>

#include "tests/stability/record.h"
#include "tests/support/shapes.h"
#include "tests/support/solutions.h"

namespace rro::test {

/// corner + [0, 1] u + [0, 1] v, front along u x v.
inline Mesh make_parallelogram(const Vec3& corner, const Vec3& u, const Vec3& v, int divisions = 1, bool two_sided = false) {
    Mesh mesh = empty_mesh(false);
    add_parallelogram(mesh, corner, u, v, divisions, two_sided);
    return mesh;
}

/// Upside down, then there.
inline Affine3 turned_down(const Vec3& at) { return {{{Vec3{1, 0, 0}, Vec3{0, -1, 0}, Vec3{0, 0, -1}}}, at}; }

/// All radiosities lie between 0 and M_max / (1 - rho_max), per channel.
///
/// returns  the largest excess over that, relative to it; infinity where any number of the solution is none
inline double excess(const Scene& scene, const Solution& s) {
    Vec3 reflectance, exitance;
    for (const Instance& instance : scene.instances)
        for (std::size_t p = 0; p < instance.reflectance.size(); ++p)
            for (int c = 0; c < 3; ++c) {
                reflectance[c] = std::max(reflectance[c], to_double(instance.reflectance[p])[c]);
                exitance[c] = std::max(exitance[c], to_double(instance.exitance[p])[c]);
            }
    Worst worst;
    const auto look = [&](const Rgb& radiosity, const Rgb& irradiance) {
        for (int c = 0; c < 3; ++c) {
            const double most = exitance[c] / (1 - reflectance[c]), b = to_double(radiosity)[c], e = to_double(irradiance)[c];
            const double unit = most > 0 ? most : std::numeric_limits<double>::min();
            for (const double x : {b, e}) {
                worst.add((x - most) / unit);
                worst.add(-x / unit);
            }
        }
    };
    for (const InstanceSolution& i : s.instances) {
        REQUIRE(i.radiosity.size() == i.irradiance.size());
        for (std::size_t f = 0; f < i.radiosity.size(); ++f) look(i.radiosity[f], i.irradiance[f]);
        for (const Element& e : i.elements) look(e.radiosity, e.irradiance);
    }
    const Vec3 &in = s.energy.emitted, &out = s.energy.absorbed, &lost = s.energy.escaped;
    for (const double x : {in.x, in.y, in.z, out.x, out.y, out.z, lost.x, lost.y, lost.z, s.estimated_error, s.residual})
        if (!std::isfinite(x)) worst.add(x);
    return worst.value();
}

/// Rounding of single precision that a reflectance close to 1 amplifies, and what a surface's row may exceed 1 by.
constexpr double kSoundExcess = 1e-4;

/// Solves, and holds the solution to what must hold of any.
inline Solution solve_soundly(const std::string& family, const Scene& scene, double accuracy) {
    Solution s = solve_reusably(scene, accuracy);
    record(family, "every scene of this family", "all numbers finite, 0 <= B <= M_max / (1 - rho_max); excess", kSoundExcess,
           excess(scene, s));
    return s;
}

/// How far a furnace, where all surfaces have the radiosity b0, is from that: relative to R = B - M.
struct FurnaceError {
    double rms = 0, worst = 0;
};

/// counts   (instance, face) -> whether its light is known
template <class Counts>
FurnaceError furnace_error(const Scene& scene, const Solution& s, double b0, const Counts& counts) {
    double off = 0, norm = 0;
    Worst worst;
    for (std::size_t i = 0; i < scene.instances.size(); ++i)
        for (std::size_t f = 0; f < s.instances[i].radiosity.size(); ++f) {
            if (!counts(i, f)) continue;
            const Instance& instance = scene.instances[i];
            const double area = face_area(instance, f), difference = double(s.instances[i].radiosity[f].x) - b0;
            const double r = b0 * double(instance.reflectance[instance.object->patch_of_face[f]].x);
            off += area * difference * difference;
            norm += area * r * r;
            if (r > 0) worst.add(std::abs(difference) / r);
        }
    return {norm > 0 ? std::sqrt(off / norm) : 0, worst.value()};
}

inline FurnaceError furnace_error(const Scene& scene, const Solution& s, double b0) {
    return furnace_error(scene, s, b0, [](std::size_t, std::size_t) { return true; });
}

/// Surfaces of this reflectance that emit 1 - rho: their radiosity is 1 wherever light cannot escape.
inline Placed furnace(Mesh mesh, double rho, const Affine3& to_world = {}, std::string name = {}) {
    const double m = 1 - rho;
    return {std::move(mesh), to_world, {rho, rho, rho}, {m, m, m}, std::move(name)};
}

}  // namespace rro::test
