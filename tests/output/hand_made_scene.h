// Scenes from meshes without the compiler's tables (which pictures and files do not need), and solutions by formula.
#pragma once

#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include "format/archive_writer.h"
#include "solver/scene/scene.h"
#include "solver/solution.h"
#include "tests/support/meshes.h"
#include "tests/support/tiny_object.h"

namespace rro::test {

/// One patch per face, faces in the order of the triangles, front before back.
inline std::unique_ptr<Object> hand_made_object(const Mesh& mesh, const Vec3& origin = {}) {
    TinyObject o = tiny_object();
    const ObjectMeta meta = o.meta;
    o = TinyObject{};
    o.meta = meta;
    o.meta.bounds = {};
    o.meta.closed = mesh.closed;
    o.meta.source_triangles = mesh.source_triangles;
    o.origin = origin;
    o.materials = mesh.materials;
    Box3 local;
    for (const Vec3& p : mesh.positions) {
        o.positions.push_back(to_float(p));
        local.add(p);
        o.meta.bounds.add(origin + p);
    }
    o.triangles = mesh.triangles;
    o.source_triangle = mesh.source_triangle;
    o.meta.area = 0;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const auto& [a, b, c] = mesh.triangles[t];
        const Vec3 front = area_vector(mesh.positions[a], mesh.positions[b], mesh.positions[c]);
        for (const Side side : {Side::Front, Side::Back}) {
            if (side == Side::Back && !mesh.two_sided[t]) continue;
            const auto face = static_cast<std::uint32_t>(o.faces.size());
            o.faces.push_back(Face::make(t, side));
            const Vec3 area = side == Side::Front ? front : -front;
            o.patches.push_back({face, 1, mesh.material[t], static_cast<float>(length(area)), {0.5f, 0.5f, 0.5f},
                                 to_float((mesh.positions[a] + mesh.positions[b] + mesh.positions[c]) / 3),
                                 to_float(normalised(area)), 1});
            o.meta.area += length(area);
        }
        o.volume_triangles.push_back(t);
    }
    add_clusters(o, 0, static_cast<std::uint32_t>(o.patches.size()), to_float(local.hi));
    for (Cluster& c : o.clusters) c.lo = to_float(local.lo);
    o.volumes = {{to_float(local.lo), to_float(local.hi), 0, static_cast<std::uint32_t>(o.triangles.size()), 0}};
    o.visibility.assign(o.patches.size() * 9, 255);

    auto bytes = encode_archive(o.data());
    if (!bytes) throw std::runtime_error(bytes.error().message);
    auto archive = Archive::from_bytes(std::move(*bytes), "hand-made");
    if (!archive) throw std::runtime_error(archive.error().where + ": " + archive.error().message);
    return make_object("hand-made", std::move(*archive));
}

/// Adds an instance of a mesh (an object of its own) to a scene.
inline void add_instance(Scene& scene, const std::string& name, const Mesh& mesh, const Affine3& to_world = {},
                         const Vec3& origin = {}) {
    scene.objects.push_back(hand_made_object(mesh, origin));
    Instance i;
    i.name = name;
    i.object = scene.objects.back().get();
    i.to_world = to_world;
    i.to_local = to_world.inverse();
    i.determinant_sign = to_world.linear.determinant() < 0 ? -1 : 1;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
        for (const Vec3& p : i.data().corners(t)) i.bounds.add(to_world.point(p));
    i.reflectance.assign(i.data().patches.size(), {0.5f, 0.5f, 0.5f});
    i.exitance.assign(i.data().patches.size(), {});
    scene.bounds.add(i.bounds);
    scene.instances.push_back(std::move(i));
}

inline Affine3 translation(const Vec3& by) { return {Mat3{}, by}; }

/// Every face of every instance: radiosity(instance, world centre, face) and irradiance twice that.
template <class Formula>
Solution solution_by(const Scene& scene, const Formula& radiosity) {
    Solution s;
    for (const Instance& i : scene.instances) {
        InstanceSolution& of = s.instances.emplace_back();
        for (std::uint32_t f = 0; f < i.data().faces.size(); ++f) {
            const TriangleCorners c = i.world_corners(i.data().faces[f]);
            const Rgb b = radiosity(i, (c[0] + c[1] + c[2]) / 3.0, f);
            of.radiosity.push_back(b);
            of.irradiance.push_back({2 * b.x, 2 * b.y, 2 * b.z});
        }
    }
    return s;
}

/// Replaces a face by its quadtree elements `levels` deep; radiosity(world centre of the element).
template <class Formula>
void subdivide(const Instance& instance, InstanceSolution& solution, std::uint32_t face, int levels,
               const Formula& radiosity) {
    using Point = std::array<float, 2>;
    std::vector<std::array<Point, 3>> parts{{{{0, 0}, {1, 0}, {0, 1}}}};
    const auto middle = [](Point a, Point b) { return Point{0.5f * (a[0] + b[0]), 0.5f * (a[1] + b[1])}; };
    for (int level = 0; level < levels; ++level) {
        std::vector<std::array<Point, 3>> finer;
        for (const auto& [a, b, c] : parts) {
            const Point ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
            finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {bc, ca, ab}});
        }
        parts = std::move(finer);
    }
    const TriangleCorners corners = instance.data().corners(instance.data().faces[face]);
    for (const auto& part : parts) {
        Vec3 centre;
        for (const Point& p : part)
            centre += (corners[0] + (corners[1] - corners[0]) * p[0] + (corners[2] - corners[0]) * p[1]) / 3.0;
        const Rgb b = radiosity(instance.to_world.point(centre));
        solution.elements.push_back({face, part, b, b});
    }
}

}  // namespace rro::test
