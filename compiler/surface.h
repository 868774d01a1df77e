// The mesh as an archive will hold it: float32 positions relative to an origin, and the faces that reflect.
//
// Every later step computes from these rounded positions, so that what is stored about the geometry holds exactly.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "compiler/mesh.h"
#include "format/object_data.h"
#include "format/result.h"

namespace rro {

/// T triangles over V positions with F faces: one per one-sided triangle, two per two-sided one.
struct Surface {
    Vec3 origin;
    std::vector<Vec3f> positions;                // [V] relative to origin
    std::vector<TriangleIndices> triangles;      // [T]
    std::vector<std::uint32_t> source_triangle;  // [T]
    std::vector<Face> faces;                     // [F] in triangle order, front before back
    std::vector<Vec3> area_vector;               // [F] outward on the face's side, m^2; never 0
    std::vector<std::uint32_t> material;         // [F]
    std::vector<Vec3> reflectance;               // [F]
    std::uint32_t dropped_by_rounding = 0;       // triangles without an area in single precision
    bool closed = false;

    TriangleCorners corners(std::uint32_t triangle) const {
        const TriangleIndices& t = triangles[triangle];
        return {to_double(positions[t[0]]), to_double(positions[t[1]]), to_double(positions[t[2]])};
    }
};

/// Rounds a mesh to the archive's precision and lists its faces. The origin is 0 unless the object lies further than 16
/// of its own extents from 0; then it is the centre of its box.
///
/// errors   BadInput: larger or smaller than single precision can hold (names the extent found); nothing left
Result<Surface> make_surface(const Mesh& mesh);

/// For every position the number of the first one at the same place. [V]
std::vector<std::uint32_t> weld(std::span<const Vec3f> positions);

/// Pairs of faces that meet at an edge of the welded surface and continue one another: each walks the edge against the
/// other. Lists of neighbours, face f's being neighbour[first[f] .. first[f + 1]).
struct FaceAdjacency {
    std::vector<std::uint32_t> first;      // [F + 1]
    std::vector<std::uint32_t> neighbour;  // ascending within a face
};

/// smallest_cosine   between the normals of neighbours; sharper edges join nothing
FaceAdjacency face_adjacency(const Surface& surface, double smallest_cosine);

}  // namespace rro
