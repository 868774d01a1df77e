// Radiosity at vertices from means over leaves.
#pragma once

#include <cstdint>
#include <vector>

#include "solver/output/element_stitching.h"
#include "solver/output/surface_mesh.h"

namespace rro {

/// A face as it lies in the world.
struct FaceGeometry {
    Vec3 normal;      // unit; 0 where the face has no area
    double area = 0;  // m^2
    std::uint32_t material = 0;
};

/// The rule of surface_mesh.h, for a mesh whose vertices have been told apart.
///
/// mesh, parts   the same N triangles, with vertices and with points and leaves
/// area          [N] m^2, world
/// returns       [V] W/m^2
std::vector<Rgb> vertex_radiosity(const SurfaceMesh& mesh, const StitchedTriangles& parts,
                                  const std::vector<FaceGeometry>& faces, const std::vector<double>& area,
                                  const Affine3& to_world);

}  // namespace rro
