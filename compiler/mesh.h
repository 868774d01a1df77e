// A mesh as the compiler works on it: double precision, in the archive's frame (source coordinates after --unit and
// --up, nothing else), metres.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "format/geometry.h"
#include "format/object_data.h"

namespace rro {

/// T triangles over V positions. Only triangles that have an area are kept; numbers are those of the source.
struct Mesh {
    std::vector<Vec3> positions;                     // [V]
    std::vector<TriangleIndices> triangles;          // [T]
    std::vector<std::uint32_t> source_triangle;      // [T]
    std::vector<std::uint32_t> material;             // [T] into materials
    std::vector<Rgb> reflectance;                    // [T] averaged texture, or empty where no material is textured
    std::vector<Material> materials;                 // in the order of first use in the source
    std::vector<std::uint8_t> two_sided;             // [T] 1 where both sides reflect; filled by decide_sides
    std::uint32_t source_triangles = 0;              // dropped ones included
    bool closed = false;                             // filled by decide_sides
    std::vector<TriangleIndices> slits;              // dropped, without area, but joining kept ones: no hole is there
};

}  // namespace rro
