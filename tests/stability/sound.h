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
inline Affine3 turned_down(const Vec3& at) { return {kUpsideDown, at}; }

/// All numbers are numbers, none is negative, and radiosities of faces lie below M_max / (1 - rho_max), per channel.
///
/// returns  the largest excess over that, relative to it; infinity where any number of the solution is none or negative
inline double excess(const Scene& scene, const Solution& s) {
    Vec3 reflectance, exitance;
    for (const Instance& instance : scene.instances)
        for (std::size_t p = 0; p < instance.reflectance.size(); ++p)
            for (int c = 0; c < 3; ++c) {
                reflectance[c] = std::max(reflectance[c], to_double(instance.reflectance[p])[c]);
                exitance[c] = std::max(exitance[c], to_double(instance.exitance[p])[c]);
            }
    Worst worst;
    const auto check = [&](double x, double lowest) {
        if (!std::isfinite(x) || x < lowest) worst.add(std::numeric_limits<double>::infinity());
    };
    const auto check_all = [&](const Vec3& v, double lowest) { check(v.x, lowest), check(v.y, lowest), check(v.z, lowest); };
    for (const InstanceSolution& i : s.instances) {
        REQUIRE(i.radiosity.size() == i.irradiance.size());
        for (std::size_t f = 0; f < i.radiosity.size(); ++f) {
            check_all(to_double(i.radiosity[f]), 0);
            check_all(to_double(i.irradiance[f]), 0);
            for (int c = 0; c < 3; ++c) {
                const double most = exitance[c] / (1 - reflectance[c]), b = to_double(i.radiosity[f])[c];
                worst.add(most > 0 ? (b - most) / most : b > 0 ? std::numeric_limits<double>::infinity() : 0.0);
            }
        }
        for (const Element& e : i.elements) check_all(to_double(e.radiosity), 0), check_all(to_double(e.irradiance), 0);
    }
    check_all(s.energy.emitted, 0);
    check_all(s.energy.absorbed, 0);
    check_all(s.energy.escaped, -std::numeric_limits<double>::max());
    for (const double x : {s.estimated_error, s.residual}) check(x, 0);
    return worst.value();
}

/// Holds a solution to what must hold of any. A face may be three times the accuracy off, above the bound too.
inline void check_sound(const std::string& family, const Scene& scene, const Solution& s) {
    record(family, "every solution of this family", "finite, B >= 0; B beyond M_max / (1 - rho_max), over the accuracy asked", 3,
           excess(scene, s) / s.accuracy);
}

inline Solution solve_soundly(const std::string& family, const Scene& scene, double accuracy) {
    Solution s = solve_reusably(scene, accuracy);
    check_sound(family, scene, s);
    return s;
}

/// How far a furnace, where all surfaces have the radiosity b0, is from that: relative to R = B - M. Of single triangles those
/// count that make up 1e-5 of all area or more: tables are made of images, and narrower ones are lost between pixels.
struct FurnaceError {
    double rms = 0, worst = 0;
};

/// counts   (instance, face) -> whether its light is known
template <class Counts>
FurnaceError furnace_error(const Scene& scene, const Solution& s, double b0, const Counts& counts) {
    double off = 0, norm = 0, all = 0;
    for (const Instance& instance : scene.instances)
        for (std::size_t f = 0; f < instance.data().faces.size(); ++f) all += face_area(instance, f);
    Worst worst;
    for (std::size_t i = 0; i < scene.instances.size(); ++i)
        for (std::size_t f = 0; f < s.instances[i].radiosity.size(); ++f) {
            if (!counts(i, f)) continue;
            const Instance& instance = scene.instances[i];
            const double area = face_area(instance, f), difference = double(s.instances[i].radiosity[f].x) - b0;
            const double r = b0 * double(instance.reflectance[instance.object->patch_of_face[f]].x);
            off += area * difference * difference;
            norm += area * r * r;
            if (r > 0 && area >= 1e-5 * all) worst.add(std::abs(difference) / r);
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
