// OBJ (tinyobjloader, double), glTF/GLB (tinygltf), PLY, OFF, STL -> Mesh.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "compiler/mesh.h"
#include "format/result.h"

namespace rro {

struct ImportOptions {
    double unit = 1;                        // metres per source unit (m 1, cm 0.01, mm 0.001, in 0.0254)
    bool z_up = false;                      // maps (x, y, z) to (x, z, -y)
    std::optional<Vec3> reflectance;        // fills only what is missing
};

enum class TwoSided { Auto, Yes, No };

/// What was dropped, merged or assumed. Counts are of source triangles.
struct ImportReport {
    std::uint32_t source_triangles = 0;
    std::uint32_t dropped_not_finite = 0;      // a corner is NaN or infinite
    std::uint32_t dropped_degenerate = 0;      // repeated corner or no area
    std::uint32_t polygons_triangulated = 0;   // faces of more than three corners
    std::uint32_t polygons_ear_clipped = 0;    // of those, not convex and planar
    std::uint32_t reflectance_clamped = 0;     // materials whose reflectance was above 0.95
    std::uint32_t components = 0, closed_components = 0;
    std::uint32_t one_sided_triangles = 0, two_sided_triangles = 0;
    std::uint32_t winding_fixed = 0;           // triangles turned by --fix-winding
    std::vector<std::string> warnings;
};

struct ImportedMesh {
    Mesh mesh;
    ImportReport report;
    std::string sha256;                             // over the mesh file and every file it refers to, in order of use
    std::vector<std::filesystem::path> files;       // the mesh first; for depfiles
};

/// Reads one mesh; numbering, materials, units as the contract says. Drops bad triangles and counts them.
///
/// errors   BadInput naming the file (and line or index): missing, unreadable, unknown ending, broken, an index out of
///          range, no triangle with an area
Result<ImportedMesh> import_mesh(const std::filesystem::path& path, const ImportOptions& options);

/// Decides per triangle whether it is two-sided, by the OpenMesh structure over welded positions: with Auto, closed and
/// consistently wound components are one-sided as wound, everything else is two-sided. With fix_winding, orientable
/// components are made consistent and closed ones outward, and turned triangles are counted.
/// (Duplicate or non-manifold faces make a component two-sided, never an error.)
void decide_sides(Mesh& mesh, TwoSided mode, bool fix_winding, ImportReport& report);

}  // namespace rro
