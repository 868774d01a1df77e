// More small meshes: polygons, disks, cylinders, cones, a tetrahedron, a torus, an L-shaped room, a dented sphere. Metres.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "tests/support/meshes.h"

namespace rro::test {

/// An open one-sided quadrilateral, two triangles; its front is where the corners run counter-clockwise.
inline Mesh make_quadrilateral(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    Mesh mesh = empty_mesh(false);
    mesh.positions = {a, b, c, d};
    add_triangle(mesh, 0, 1, 2);
    add_triangle(mesh, 0, 2, 3);
    return mesh;
}

/// A single triangle.
inline Mesh make_triangle(const Vec3& a, const Vec3& b, const Vec3& c) {
    Mesh mesh = empty_mesh(false);
    mesh.positions = {a, b, c};
    add_triangle(mesh, 0, 1, 2);
    return mesh;
}

/// Corners of the regular n-gon of this circumradius about the y axis, at this height, counter-clockwise from above.
inline std::vector<Vec3> ring(int n, double radius, double height) {
    std::vector<Vec3> corners;
    for (int k = 0; k < n; ++k) {
        const double angle = -2 * std::numbers::pi * k / n;
        corners.push_back({radius * std::cos(angle), height, radius * std::sin(angle)});
    }
    return corners;
}

/// The circumradius of the regular n-gon that has the area of a circle of this radius.
inline double same_area_radius(int n, double radius) {
    return radius * std::sqrt(2 * std::numbers::pi / n / std::sin(2 * std::numbers::pi / n));
}

/// A regular n-gon at this height, n triangles, front up.
inline Mesh make_disk(int n, double radius, double height = 0) {
    Mesh mesh = empty_mesh(false);
    mesh.positions = ring(n, radius, height);
    mesh.positions.push_back({0, height, 0});
    const auto count = static_cast<std::uint32_t>(n);
    for (std::uint32_t k = 0; k < count; ++k) add_triangle(mesh, count, k, (k + 1) % count);
    return mesh;
}

/// The side of an n-gonal prism about the y axis between two heights, outward, `rows` of n squares; open.
inline Mesh make_tube(int n, double radius, double low, double high, int rows = 1) {
    Mesh mesh = empty_mesh(false);
    const auto count = static_cast<std::uint32_t>(n);
    for (int j = 0; j <= rows; ++j)
        for (const Vec3& p : ring(n, radius, low + (high - low) * j / rows)) mesh.positions.push_back(p);
    for (std::uint32_t j = 0; j < static_cast<std::uint32_t>(rows); ++j)
        for (std::uint32_t k = 0; k < count; ++k) {
            const std::uint32_t a = j * count + k, b = j * count + (k + 1) % count;
            add_triangle(mesh, a, b, b + count);
            add_triangle(mesh, a, b + count, a + count);
        }
    return mesh;
}

/// The side of an n-gonal pyramid over the plane y = 0, outward; open.
inline Mesh make_cone_side(int n, double radius, double height) {
    Mesh mesh = empty_mesh(false);
    mesh.positions = ring(n, radius, 0);
    mesh.positions.push_back({0, height, 0});
    const auto count = static_cast<std::uint32_t>(n);
    for (std::uint32_t k = 0; k < count; ++k) add_triangle(mesh, k, (k + 1) % count, count);
    return mesh;
}

/// Corners of a regular tetrahedron about the origin.
inline std::vector<Vec3> tetrahedron_corners() { return {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}}; }

/// Closed, outward; each of its four faces is cut into divisions^2 triangles.
inline Mesh make_tetrahedron(int divisions = 1) {
    Mesh mesh = empty_mesh(true);
    const std::vector<Vec3> c = tetrahedron_corners();
    for (const auto& [i, j, k] : {TriangleIndices{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}}) {
        const auto first = static_cast<std::uint32_t>(mesh.positions.size());
        const auto rows = static_cast<std::uint32_t>(divisions);
        // Row r of the face has r + 1 points; row 0 is its first corner.
        for (std::uint32_t r = 0; r <= rows; ++r)
            for (std::uint32_t q = 0; q <= r; ++q)
                mesh.positions.push_back(c[i] + (c[j] - c[i]) * (double(r - q) / rows) + (c[k] - c[i]) * (double(q) / rows));
        const auto at = [&](std::uint32_t r, std::uint32_t q) { return first + r * (r + 1) / 2 + q; };
        for (std::uint32_t r = 0; r < rows; ++r)
            for (std::uint32_t q = 0; q <= r; ++q) {
                add_triangle(mesh, at(r, q), at(r + 1, q), at(r + 1, q + 1));
                if (q < r) add_triangle(mesh, at(r, q), at(r + 1, q + 1), at(r, q + 1));
            }
    }
    return mesh;
}

/// Closed, outward, about the y axis: 2 n m triangles, n around the axis and m around the tube.
inline Mesh make_torus(int n, int m, double radius, double tube) {
    Mesh mesh = empty_mesh(true);
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < m; ++j) {
            const double u = 2 * std::numbers::pi * i / n, v = 2 * std::numbers::pi * j / m;
            const double r = radius + tube * std::cos(v);
            mesh.positions.push_back({r * std::cos(u), tube * std::sin(v), r * std::sin(u)});
        }
    const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(i % n * m + j % m); };
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < m; ++j) {
            add_triangle(mesh, at(i, j), at(i, j + 1), at(i + 1, j + 1));
            add_triangle(mesh, at(i, j), at(i + 1, j + 1), at(i + 1, j));
        }
    return mesh;
}

/// The inside of an L-shaped room, 2 x 1 x 2 m without the corner x > 1, z > 1; walls in squares of 1 / divisions.
inline Mesh make_l_room(int divisions) {
    Mesh mesh = empty_mesh(true);
    const Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
    for (const auto& [i, k] : {std::pair{0, 0}, {1, 0}, {0, 1}}) {
        const Vec3 at{double(i), 0, double(k)};
        add_parallelogram(mesh, at, z, x, divisions);      // floor, up
        add_parallelogram(mesh, at + y, x, z, divisions);  // ceiling, down
    }
    for (const double i : {0.0, 1.0}) {
        add_parallelogram(mesh, {i, 0, 0}, x, y, divisions);           // the wall z = 0, towards +z
        add_parallelogram(mesh, {0, 0, i}, y, z, divisions);           // x = 0, towards +x
    }
    add_parallelogram(mesh, {2, 0, 0}, z, y, divisions);  // x = 2, towards -x
    add_parallelogram(mesh, {1, 0, 1}, z, y, divisions);  // x = 1 beyond the corner
    add_parallelogram(mesh, {0, 0, 2}, y, x, divisions);  // z = 2, towards -z
    add_parallelogram(mesh, {1, 0, 1}, y, x, divisions);  // z = 1 beyond the corner
    return mesh;
}

/// A unit sphere with a dent as deep as `depth` around +y; closed, outward, not convex.
inline Mesh make_dented_sphere(int subdivisions, double depth) {
    Mesh mesh = make_sphere(subdivisions);
    for (Vec3& p : mesh.positions) p *= 1 - depth * std::pow(std::max(0.0, p.y), 4);
    return mesh;
}

/// A seat under a back, both 0.05 m thick; one archive, two closed boxes.
inline Mesh make_seat(int divisions) {
    return merged(make_box(0.5, 0.05, 0.5, divisions, {0, 0.45, 0}),
                  make_box(0.5, 0.6, 0.05, divisions, {0, 0.78, -0.226}));
}

/// A box without its top, both sides of its walls.
inline Mesh make_open_box(double x, double y, double z, int divisions) {
    Mesh mesh = empty_mesh(false);
    const Vec3 lo{-x / 2, 0, -z / 2}, ex{x, 0, 0}, ey{0, y, 0}, ez{0, 0, z};
    add_parallelogram(mesh, lo, ex, ez, divisions, true);
    add_parallelogram(mesh, lo, ez, ey, divisions, true);
    add_parallelogram(mesh, lo, ey, ex, divisions, true);
    add_parallelogram(mesh, lo + ex, ey, ez, divisions, true);
    add_parallelogram(mesh, lo + ez, ex, ey, divisions, true);
    return mesh;
}

inline std::vector<TriangleCorners> all_corners(const Mesh& mesh) {
    std::vector<TriangleCorners> corners;
    for (const auto& [a, b, c] : mesh.triangles)
        corners.push_back({mesh.positions[a], mesh.positions[b], mesh.positions[c]});
    return corners;
}

/// The mesh under an affine map; where the map mirrors, triangles turn so that fronts stay on their side.
inline Mesh transformed(Mesh mesh, const Affine3& by) {
    for (Vec3& p : mesh.positions) p = by.point(p);
    return by.linear.determinant() < 0 ? turned_inside_out(std::move(mesh)) : mesh;
}

}  // namespace rro::test
