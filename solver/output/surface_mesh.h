// The solution as a surface to look at: elements with smoothly interpolated radiosity at their corners.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "solver/scene/scene.h"
#include "solver/solution.h"

namespace rro {

/// Triangles of one instance in the archive's frame, stitched without cracks or T-junctions inside the instance.
struct SurfaceMesh {
    std::vector<Vec3> positions;             // [V] archive frame
    std::vector<Vec3f> normals;              // [V] unit, archive frame
    std::vector<Rgb> radiosity;              // [V] W/m^2
    std::vector<TriangleIndices> triangles;  // [N] wound as their face
    std::vector<std::array<std::array<float, 2>, 3>> barycentric;  // [N] the corners on their own face, as in Element
    std::vector<std::uint32_t> first;        // [F + 1] triangles of face f are first[f] .. first[f + 1]
};

/// Radiosity at a vertex: area-weighted mean of what the triangles about it say, which hang together through edges whose
/// two sides face alike (cosine above 0.8, in the world) and have the same material; kept apart across creases. A leaf
/// (whole face or element) says its mean plus its slope times the way from its centre, so a linear course over a plane
/// comes out as it is; a value stays in the range of the means about it, except at borders.
///
/// source   smooth display of radiosities as in [Cohen and Greenberg 1985]
/// departs  slopes, which neighbours of unequal size and borders need; they take means alone
SurfaceMesh surface_mesh(const Instance& instance, const InstanceSolution& solution);

}  // namespace rro
