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

/// What one mesh may take of memory and time, however little of either its files seem to ask for. What goes beyond is
/// refused. Honest meshes within these stay within the memory and time of ContainmentLimits (import_process.h) too, which
/// refuse what hostile ones still find.
struct ImportLimits {
    std::uint64_t file_bytes = std::uint64_t{1} << 29;       // of the mesh and all it refers to, each as often as read
    std::uint64_t corners = std::uint64_t{1} << 25;          // of all faces, and as many vertices: 11 million triangles
    std::uint64_t json_values = std::uint64_t{1} << 21;      // of a glTF document; the library takes up to 2 kB for one
    std::uint64_t image_pixels = std::uint64_t{1} << 26;     // of a texture: 8192 x 8192
    std::uint64_t texture_pixels = std::uint64_t{1} << 28;   // of all textures together, 3 bytes each
    std::uint64_t texture_samples = std::uint64_t{1} << 30;  // of all triangles; above a million of them get fewer each
    std::uint64_t polygon_steps = std::uint64_t{1} << 31;    // comparisons of corners while polygons are cut up
};

/// How a source is read.
struct ImportOptions {
    double unit = 1;                        // metres per source unit (m 1, cm 0.01, mm 0.001, in 0.0254)
    bool z_up = false;                      // maps (x, y, z) to (x, z, -y)
    std::optional<Vec3> reflectance;        // fills only what is missing
    ImportLimits limits;
};

/// Which triangles reflect on both sides: --two-sided.
enum class TwoSided { Auto, Yes, No };

/// What was dropped, merged or assumed. Counts are of source triangles where nothing else is said.
struct ImportReport {
    std::uint32_t source_triangles = 0;
    std::uint32_t dropped_not_finite = 0;      // a corner is NaN or infinite
    std::uint32_t dropped_degenerate = 0;      // repeated corner or no area
    std::uint32_t ignored_faces = 0;           // of fewer than three corners; they have no triangles
    std::uint32_t duplicate_triangles = 0;      // lie exactly on an earlier one, by decide_sides (mesh_duplicates.h)
    std::uint32_t welded_vertices = 0;         // vertices in use at the very place of an earlier one
    std::uint32_t polygons_triangulated = 0;   // faces of more than three corners
    std::uint32_t polygons_ear_clipped = 0;    // of those, not convex and planar
    std::uint32_t reflectance_clamped = 0;     // materials whose reflectance was above 0.95
    std::uint32_t reflectance_assumed = 0;     // materials without one: that of the options, or 0.5
    std::uint32_t textures_not_read = 0;       // counted once per name or use; a colour stands for each
    std::uint32_t components = 0, closed_components = 0;
    std::uint32_t open_edges = 0;              // with one triangle; none where a surface is closed
    std::uint32_t non_manifold_edges = 0;      // with more than two
    std::uint32_t one_sided_triangles = 0, two_sided_triangles = 0;
    std::uint32_t winding_fixed = 0;           // triangles turned by --fix-winding
    Vec3 extent;                               // of what is kept, metres
    std::vector<std::string> warnings;
    std::vector<std::filesystem::path> absent;  // files looked for in vain; with them the mesh may be another
};

/// A mesh, and what came of its files.
struct ImportedMesh {
    Mesh mesh;
    ImportReport report;
    std::string sha256;                             // over the mesh file and every file it refers to, in order of use
    std::vector<std::filesystem::path> files;       // the mesh first; for depfiles
};

/// Reads one mesh, in metres and y up. Triangles are numbered in the order of the file, those of a polygon one after the other,
/// before bad ones are dropped and counted.
///
/// errors   BadInput naming the file (and line or index): missing, unreadable, unknown ending, broken, an index out of
///          range, no triangle with an area, beyond a limit
Result<ImportedMesh> import_mesh(const std::filesystem::path& path, const ImportOptions& options);

/// Decides per triangle whether it is two-sided, by the OpenMesh structure over welded positions: with Auto, closed and
/// consistently wound components are one-sided as wound, everything else is two-sided. With fix_winding, orientable
/// components are made consistent and closed ones outward, and turned triangles are counted.
/// (Non-manifold faces make a component two-sided, never an error.) Duplicates are dropped and counted: those that look the
/// same way before, those that lie on another two-sided triangle afterwards.
void decide_sides(Mesh& mesh, TwoSided mode, bool fix_winding, ImportReport& report);

}  // namespace rro
