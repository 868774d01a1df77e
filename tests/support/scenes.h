// Scenes built in memory from meshes, without files: compile, encode, read back, place. Means over their faces.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "compiler/compile_object.h"
#include "format/archive_writer.h"
#include "solver/scene/scene.h"
#include "solver/solution.h"
#include "tests/support/meshes.h"

namespace rro::test {

/// One object of a scene; all its materials get this reflectance and exitance.
struct Placed {
    Mesh mesh;
    Affine3 to_world = {};
    Vec3 reflectance = {0.5, 0.5, 0.5};
    Vec3 exitance = {};
    std::string name = {};  // "0", "1", ... by position in the list where empty
};

/// Small tables, for tests of laws that hold at any resolution.
inline CompileOptions coarse_tables() {
    CompileOptions options;
    options.image_resolution = 64;
    options.tables.hit = false;
    options.tables.atlas = false;
    return options;
}

/// As little as an archive can hold, for tests of what does not look at the tables.
inline CompileOptions least_tables() {
    CompileOptions options;
    options.image_resolution = 16;
    options.grid_size = 2;
    return options;
}

/// The parallelogram corner + [0, 1] u + [0, 1] v as an object, grey; front along u x v.
inline Placed panel(const Vec3& corner, const Vec3& u, const Vec3& v, double reflectance, double exitance, int divisions = 1) {
    Mesh mesh = empty_mesh(false);
    add_parallelogram(mesh, corner, u, v, divisions);
    return {mesh, {}, Vec3{1, 1, 1} * reflectance, Vec3{1, 1, 1} * exitance};
}

/// The mesh as an archive, opened, with its ray structure and lookups.
inline std::unique_ptr<Object> compile_to_object(const Mesh& mesh, const CompileOptions& options = {}) {
    auto compiled = compile_object(mesh, options);
    if (!compiled) throw std::runtime_error(compiled.error().message);
    auto bytes = encode_archive(compiled->data);
    if (!bytes) throw std::runtime_error(bytes.error().message);
    auto archive = Archive::from_bytes(std::move(*bytes), "in memory");
    if (!archive) throw std::runtime_error(archive.error().message);
    return make_object("in memory", std::move(*archive));
}

/// Places one more instance of `object`, which the scene must hold.
inline void add_instance(Scene& scene, const Object& object, const Affine3& to_world, const Vec3& reflectance,
                         const Vec3& exitance, std::string name = {}) {
    if (name.empty()) name = std::to_string(scene.instances.size());
    const ObjectData& data = object.data();
    Instance instance;
    instance.name = name;
    instance.object = &object;
    instance.to_world = to_world;
    instance.to_local = to_world.inverse();
    instance.determinant_sign = to_world.linear.determinant() < 0 ? -1 : 1;
    for (std::uint32_t t = 0; t < data.triangles.size(); ++t)
        for (const Vec3& corner : data.corners(t)) instance.bounds.add(to_world.point(corner));
    instance.reflectance.assign(data.patches.size(), to_float(reflectance));
    instance.exitance.assign(data.patches.size(), to_float(exitance));
    scene.bounds.add(instance.bounds);
    scene.manifest.instances.push_back({name, "in memory", {}, to_world, {{"*", {reflectance, exitance}}}});
    scene.instances.push_back(std::move(instance));
}

/// One archive per entry.
inline Scene make_scene(const std::vector<Placed>& placed, const CompileOptions& options = {}) {
    Scene scene;
    scene.manifest.path = "in memory";
    for (const Placed& p : placed) {
        scene.objects.push_back(compile_to_object(p.mesh, options));
        add_instance(scene, *scene.objects.back(), p.to_world, p.reflectance, p.exitance, p.name);
    }
    return scene;
}

inline Affine3 translation(const Vec3& by) {
    return {Mat3{}, by};
}

/// Irradiance of a unit square from another one, opposite at distance 1, that sends 1 W/m^2 through a medium. 1/m
inline double irradiance_through(double absorption) {
    constexpr int n = 14;  // midpoints of both squares: 1e-3
    double sum = 0;
    for (int i = 0; i < n * n; ++i)
        for (int j = 0; j < n * n; ++j) {
            const Vec3 p{(i % n + 0.5) / n, 0, (i / n + 0.5) / n}, q{(j % n + 0.5) / n, 1, (j / n + 0.5) / n};
            const double d2 = length2(q - p);
            sum += std::exp(-absorption * std::sqrt(d2)) / (std::numbers::pi * d2 * d2 * n * n * n * n);
        }
    return sum;
}

inline double face_area(const Instance& instance, std::size_t f) {
    return length(area_vector(instance.world_corners(instance.data().faces[f])));
}

/// Area-weighted mean of a quantity of faces and its root mean square: what a mean may be off by where each face is off by
/// a share of it.
struct Spread {
    double mean = 0, rms = 0;
};

template <class F>
Spread over_faces(const Instance& instance, const F& value) {
    double sum = 0, squares = 0, area = 0;
    for (std::size_t f = 0; f < instance.data().faces.size(); ++f) {
        const double a = face_area(instance, f), v = value(f);
        sum += a * v;
        squares += a * v * v;
        area += a;
    }
    return {sum / area, std::sqrt(squares / area)};
}

inline Spread irradiance(const Scene& scene, const Solution& s, std::size_t i) {
    return over_faces(scene.instances[i], [&](std::size_t f) { return double(s.instances[i].irradiance[f].y); });
}

}  // namespace rro::test
