// The leaves of a solution (whole faces, and elements of subdivided ones) as triangles that share their corners.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "format/object_data.h"
#include "solver/solution.h"

namespace rro {

/// Weights of a face's corners 1 and 2, in the face's own winding.
using Barycentric = std::array<float, 2>;

/// N triangles over P points, ascending by face; L leaves. No point lies inside an edge of a triangle, as far as the
/// mesh itself has no such T-junctions.
struct StitchedTriangles {
    std::vector<Vec3> points;                            // [P] archive frame; vertices of equal position are one point
    std::vector<TriangleIndices> triangles;              // [N] into points, wound as their face
    std::vector<std::array<Barycentric, 3>> barycentric; // [N] the corners, on their own face
    std::vector<std::uint32_t> leaf;                     // [N]
    std::vector<std::uint32_t> first;                    // [F + 1] triangles of face f are first[f] .. first[f + 1]
    std::vector<std::uint32_t> leaf_face;                // [L]
    std::vector<Rgb> leaf_radiosity;                     // [L] W/m^2
};

/// Welds vertices of exactly equal position and splits every leaf at the corners of others that lie on its edges.
///
/// Points are told apart by what they lie on (vertex, edge and position along it, face and place inside it), not by
/// rounded coordinates, so both sides of an edge agree exactly.
StitchedTriangles stitch_elements(const ObjectData& object, const InstanceSolution& solution);

}  // namespace rro
