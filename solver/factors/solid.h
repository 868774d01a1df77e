// Closed convex sets of faces, which block as one: their shadow is bounded by the edges between faces that are
// turned to the eye and faces that are not.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "solver/factors/polygon.h"

namespace rro {

/// A closed convex body. Lengths in metres.
struct Solid {
    /// An edge, counter-clockwise about the face on its left.
    struct Edge {
        std::uint32_t from = 0, to = 0;  // into corners
        std::uint32_t left = 0, right = 0;  // into planes
    };
    struct Plane {
        Vec3 normal;
        double offset = 0;
    };
    std::vector<Vec3> corners;
    std::vector<Plane> planes;
    std::vector<Edge> edges;
    double rounding = 0;

    bool empty() const { return edges.empty(); }

    /// Is all of it in front of a plane?
    bool in_front_of(const Vec3& normal, double offset) const;

    /// Is a point behind all its faces, or on them?
    bool contains(const Vec3& p) const;

    /// Inner normals of the planes through x and the edges of its outline as seen from x, which is outside.
    void outline(const Vec3& x, std::vector<std::uint8_t>& turned, std::vector<Vec3>& inner) const;
    /// The part in front of a plane, closed by a face in the plane.
    Solid in_front(const Vec3& normal, double offset) const;
};

/// The solid that faces make up, known to be convex; empty where they are not closed edge to edge. Corners that are one
/// are equal.
Solid make_solid(std::span<const Polygon* const> faces);

/// Faces that hang together by edges that two of them share: lists of their numbers, ascending.
std::vector<std::vector<std::uint32_t>> joined_by_edges(std::span<const Polygon* const> faces);

/// Is nothing of the faces in front of one of them, but for rounding?
bool are_convex(std::span<const Polygon* const> faces);

}  // namespace rro
