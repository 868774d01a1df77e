// Small meshes with known areas, sides decided. Metres; all of one material `default` (reflectance 0.5).
#pragma once

#include <cmath>
#include <cstdint>
#include <map>
#include <utility>

#include "compiler/mesh.h"

namespace rro::test {

/// Half a turn about x.
inline const Mat3 kUpsideDown{{Vec3{1, 0, 0}, Vec3{0, -1, 0}, Vec3{0, 0, -1}}};

/// No triangles yet, one material.
inline Mesh empty_mesh(bool closed) {
    Mesh mesh;
    mesh.materials.push_back({"default", {0.5, 0.5, 0.5}, {}, false});
    mesh.closed = closed;
    return mesh;
}

inline void add_triangle(Mesh& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c, bool two_sided = false) {
    mesh.triangles.push_back({a, b, c});
    mesh.source_triangle.push_back(mesh.source_triangles++);
    mesh.material.push_back(0);
    mesh.two_sided.push_back(two_sided ? 1 : 0);
}

/// The parallelogram corner + [0, 1] u + [0, 1] v in divisions^2 cells of two triangles; its front is along u x v.
inline void add_parallelogram(Mesh& mesh, const Vec3& corner, const Vec3& u, const Vec3& v, int divisions = 1,
                              bool two_sided = false) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    const auto row = static_cast<std::uint32_t>(divisions + 1);
    for (int j = 0; j <= divisions; ++j)
        for (int i = 0; i <= divisions; ++i)
            mesh.positions.push_back(corner + u * (double(i) / divisions) + v * (double(j) / divisions));
    for (std::uint32_t j = 0; j + 1 < row; ++j)
        for (std::uint32_t i = 0; i + 1 < row; ++i) {
            const std::uint32_t a = first + j * row + i;
            add_triangle(mesh, a, a + 1, a + 1 + row, two_sided);
            add_triangle(mesh, a, a + 1 + row, a + row, two_sided);
        }
}

/// Closed, outward, one-sided box; 12 divisions^2 triangles. Corners are not shared between its six sides, as in most
/// files.
inline Mesh make_box(double x, double y, double z, int divisions = 1, const Vec3& centre = {}) {
    Mesh mesh = empty_mesh(true);
    const Vec3 lo = centre - Vec3{x, y, z} * 0.5, hi = centre + Vec3{x, y, z} * 0.5;
    const Vec3 ex{x, 0, 0}, ey{0, y, 0}, ez{0, 0, z};
    add_parallelogram(mesh, lo, ez, ey, divisions);    // -x
    add_parallelogram(mesh, lo, ex, ez, divisions);    // -y
    add_parallelogram(mesh, lo, ey, ex, divisions);    // -z
    add_parallelogram(mesh, hi, -ey, -ez, divisions);  // +x
    add_parallelogram(mesh, hi, -ez, -ex, divisions);  // +y
    add_parallelogram(mesh, hi, -ex, -ey, divisions);  // +z
    return mesh;
}

/// Closed, outward, one-sided: an icosahedron whose triangles are quartered `subdivisions` times, 20 * 4^s triangles.
inline Mesh make_sphere(int subdivisions, double radius = 1, const Vec3& centre = {}) {
    const double g = (1 + std::sqrt(5.0)) / 2;
    std::vector<Vec3> points{{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                             {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
    std::vector<TriangleIndices> triangles{{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                           {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                           {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                           {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
    for (Vec3& p : points) p = normalised(p);
    for (int s = 0; s < subdivisions; ++s) {
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
        const auto middle = [&](std::uint32_t a, std::uint32_t b) {
            const auto [at, is_new] = middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(points.size()));
            if (is_new) points.push_back(normalised(points[a] + points[b]));
            return at->second;
        };
        std::vector<TriangleIndices> finer;
        for (const auto& [a, b, c] : triangles) {
            const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
            finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
        }
        triangles = std::move(finer);
    }
    Mesh mesh = empty_mesh(true);
    for (const Vec3& p : points) mesh.positions.push_back(centre + p * radius);
    for (const auto& [a, b, c] : triangles) add_triangle(mesh, a, b, c);
    return mesh;
}

/// Open rectangle in the plane y = 0 about the origin, `width` along x and `depth` along z, front up (+y).
inline Mesh make_quad(double width, double depth, bool two_sided = false, int divisions = 1) {
    Mesh mesh = empty_mesh(false);
    add_parallelogram(mesh, {-width / 2, 0, -depth / 2}, {0, 0, depth}, {width, 0, 0}, divisions, two_sided);
    return mesh;
}

/// Both meshes in one; the materials of `b` are those of `a`.
inline Mesh merged(Mesh a, const Mesh& b) {
    const auto offset = static_cast<std::uint32_t>(a.positions.size());
    a.positions.insert(a.positions.end(), b.positions.begin(), b.positions.end());
    for (std::size_t t = 0; t < b.triangles.size(); ++t) {
        const auto& [i, j, k] = b.triangles[t];
        add_triangle(a, offset + i, offset + j, offset + k, b.two_sided[t] != 0);
        a.material.back() = b.material[t];
    }
    a.closed = a.closed && b.closed;
    return a;
}

/// Two boxes of edges `edge` side by side along x, `gap` apart, about the origin.
inline Mesh make_two_boxes(double edge, double gap, int divisions = 1) {
    const double x = (edge + gap) / 2;
    return merged(make_box(edge, edge, edge, divisions, {-x, 0, 0}), make_box(edge, edge, edge, divisions, {x, 0, 0}));
}

/// The same surface wound the other way: a box becomes a room seen from inside.
inline Mesh turned_inside_out(Mesh mesh) {
    for (TriangleIndices& t : mesh.triangles) std::swap(t[1], t[2]);
    return mesh;
}

inline Mesh translated(Mesh mesh, const Vec3& by) {
    for (Vec3& p : mesh.positions) p += by;
    return mesh;
}

}  // namespace rro::test
