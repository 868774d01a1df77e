// Polygons -> triangles.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "format/geometry.h"

namespace rro {

struct PolygonTriangles {
    std::vector<std::array<std::uint32_t, 3>> triangles;  // k - 2 corner triples, wound as the polygon
    bool ear_clipped = false;
};

/// Triangles of a polygon of k >= 3 corners: a fan from its first corner where it is convex, planar and all triangles
/// of the fan have an area; else by ear clipping in its mean plane. Corners that repeat, run straight or cross are
/// allowed: there are always k - 2 triangles, some of them without an area. A corner that is not finite gives a fan.
PolygonTriangles triangulate_polygon(std::span<const Vec3> corners);

}  // namespace rro
