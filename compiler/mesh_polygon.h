// Polygons -> triangles.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "format/geometry.h"

namespace rro {

/// The triangles of one polygon.
struct PolygonTriangles {
    std::vector<std::array<std::uint32_t, 3>> triangles;  // k - 2 corner triples, wound as the polygon
    bool ear_clipped = false;
};

/// Triangles of a polygon of k >= 3 corners: a fan from its first corner where it is convex, planar and all triangles
/// of the fan have an area; else by ear clipping in its mean plane. Corners that repeat, run straight or cross are
/// allowed: there are always k - 2 triangles, some of them without an area. A corner that is not finite gives a fan.
///
/// steps     comparisons of two corners that may be made; those made are taken off. Ear clipping needs some k^2 of them,
///           and up to k^3 where corners are placed against it
/// returns   none where the steps do not suffice
std::optional<PolygonTriangles> triangulate_polygon(std::span<const Vec3> corners, std::uint64_t& steps);

}  // namespace rro
