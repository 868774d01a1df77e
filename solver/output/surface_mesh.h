// The solution as a surface to look at: elements with smoothly interpolated radiosity at their corners.
#pragma once

#include <cstdint>
#include <vector>

#include "solver/scene/scene.h"
#include "solver/solution.h"

namespace rro {

/// Triangles of one instance in world space, stitched without cracks or T-junctions inside the instance.
struct SurfaceMesh {
    std::vector<Vec3> positions;             // [V] local (archive) frame
    std::vector<Vec3f> normals;              // [V] unit, local frame
    std::vector<Rgb> radiosity;              // [V] W/m^2
    std::vector<TriangleIndices> triangles;  // [N]
    std::vector<std::uint32_t> first;        // [F + 1] triangles of face f are first[f] .. first[f + 1]
};

/// Radiosity at a vertex: area-weighted mean over the elements that share it and face alike (cosine above 0.8), of the
/// same patch material; kept apart across creases. Means over each element stay as the solver gave them as nearly as
/// linear interpolation allows.
SurfaceMesh surface_mesh(const Instance& instance, const InstanceSolution& solution);

}  // namespace rro
