// What an archive holds, as plain views over contiguous arrays. The compiler fills one from its own vectors and
// hands it to `write_archive`; `Archive` (archive_reader.h) gives one over a verified file, in place.
//
// Terms, used everywhere:
//   triangle   one triangle of the mesh; both sides block light
//   face       one side of a triangle that emits, reflects and receives: (triangle, side). A one-sided triangle has one
//              face (its front), a two-sided one has two. Faces are stored in the depth-first order of the cluster
//              tree, so every patch and every cluster is a contiguous range of faces.
//   patch      a few nearly coplanar faces of one material: the leaf of the cluster tree
//   cluster    a node of the binary tree over patches; stored in preorder, left child = own index + 1
//   volume     a node of the HBV tree, the bounding volume hierarchy over triangles (paper, section 5)
//
// All positions are float32 relative to `origin` (double, metres, archive frame).
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "format/direction_grid.h"
#include "format/geometry.h"

namespace rro {

/// Which side of its triangle a face is.
enum class Side : std::uint32_t { Front = 0, Back = 1 };

/// A face: triangle number and side, packed as on disk.
struct Face {
    std::uint32_t packed = 0;  // triangle * 2 + side

    static Face make(std::uint32_t triangle, Side side) { return {triangle * 2 + static_cast<std::uint32_t>(side)}; }
    std::uint32_t triangle() const { return packed >> 1; }
    Side side() const { return static_cast<Side>(packed & 1); }
};
static_assert(sizeof(Face) == 4);

/// On-disk record of a patch. Normals are unit, outward on the face's side.
struct Patch {
    std::uint32_t first_face;
    std::uint32_t face_count;
    std::uint32_t material;
    float area;          // m^2
    Rgb reflectance;     // textures averaged; equals the material's where it has none
    Vec3f centre;        // area-weighted, relative to origin
    Vec3f normal;        // area-weighted mean
    float cone_cosine;   // smallest dot(normal, face normal)
};
static_assert(sizeof(Patch) == 56);

/// On-disk record of a cluster (preorder: left child is the next record).
struct Cluster {
    std::uint32_t first_patch;
    std::uint32_t patch_count;
    std::uint32_t right_child;  // 0 for a leaf, which is exactly one patch
    float area;                 // m^2, sum over faces
    float radius;               // about the box's centre, over all corners
    Vec3f lo, hi;               // bounding box
    Vec3f normal;               // unit mean of the area vectors, or 0 where they cancel
    float cone_cosine;          // smallest dot(normal, face normal); -1 where normal is 0

    Vec3 centre() const { return 0.5 * (to_double(lo) + to_double(hi)); }
};
static_assert(sizeof(Cluster) == 60);

/// On-disk record of an HBV volume (preorder: left child is the next record).
struct Volume {
    Vec3f lo, hi;
    std::uint32_t first;        // into ObjectData::volume_triangles
    std::uint32_t count;        // of triangles below
    std::uint32_t right_child;  // 0 for a leaf
};
static_assert(sizeof(Volume) == 36);

/// A material of the source, with what the mesh's own files say about it.
struct Material {
    std::string name;
    Vec3 reflectance{0.5, 0.5, 0.5};  // per channel, [0, 1); textures averaged
    Vec3 exitance;                    // W/m^2
    bool textured = false;            // patches carry their own reflectance
};

/// How the archive was made, and facts about the whole object.
struct ObjectMeta {
    std::string tool_version;    // of the compiler that wrote it
    std::string source_name;     // file name of the mesh, without folders
    std::string source_sha256;   // of the mesh and every file it refers to, hex
    std::string options;         // canonical text of the compile options that decide bytes
    GridMap grid_map = GridMap::Octahedral;
    std::uint32_t grid_size = 12;       // directions = grid_size^2
    std::uint32_t image_resolution = 0;  // pixels along a direction image
    std::uint32_t source_triangles = 0;  // triangles of the source, dropped ones included
    Box3 bounds;                 // archive frame, double
    double area = 0;             // m^2, sum over faces
    bool closed = false;         // every component is closed and consistently wound
    bool convex = false;         // closed, outward, and no face sees another
};

/// Everything in an archive. Spans are owned elsewhere (by the compiler's vectors or by Archive).
/// P patches, C = 2P - 1 clusters, T triangles, F faces, D = grid_size^2 directions on H lines (DirectionGrid::lines).
struct ObjectData {
    ObjectMeta meta;
    std::vector<Material> materials;

    Vec3 origin;                                         // added to every position
    std::span<const Vec3f> positions;                    // [V]
    std::span<const TriangleIndices> triangles;          // [T], in the order of their first face
    std::span<const std::uint32_t> source_triangle;      // [T] number in the source file
    std::span<const Face> faces;                         // [F]
    std::span<const Patch> patches;                      // [P]
    std::span<const Cluster> clusters;                   // [C]
    std::span<const Volume> volumes;                     // HBV, preorder
    std::span<const std::uint32_t> volume_triangles;     // [T] leaf order of the HBV

    // Effective areas of K clusters (the largest): value = table[k * D + direction] * scale[k] / 255, m^2.
    std::span<const std::uint32_t> area_clusters;        // [K] cluster numbers, ascending
    std::span<const std::uint8_t> whole_area;            // [K * D] seen from outside, occluded by the whole object
    std::span<const float> whole_area_scale;             // [K]
    std::span<const std::uint8_t> intrinsic_area;        // [K * D] occluded by the cluster itself only
    std::span<const float> intrinsic_area_scale;         // [K]

    // Share of a patch's unoccluded projected area that is seen from outside: value = visibility / 255.
    std::span<const std::uint8_t> visibility;            // [P * D]

    // How far the tables are off between their nodes: root mean square, over `error_directions` directions off the grid,
    // of (interpolated - measured), divided by that of the measured value. Per cluster with areas.
    std::uint32_t error_directions = 0;
    std::span<const float> whole_area_error;             // [K]
    std::span<const float> intrinsic_area_error;         // [K]
    std::span<const float> visibility_error;             // [K] of the seen area of the cluster's patches, each for itself

    // Self links (format/self_links.h): steps of the pair tree in preorder, and two numbers for each of its L links.
    std::span<const std::uint8_t> self_steps;
    std::span<const float> self_exchange;                // [L] m^2, nothing between
    std::span<const std::uint8_t> self_visibility;       // [L] share of it that the object leaves, / 255
    // Where a patch's light goes, as shares: it escapes (by its visibility table), or meets a face (by the self links),
    // or a black back (by rays). The three sum to 1 but for errors of tables and links.
    std::span<const float> self_escape;                  // [P]
    std::span<const float> self_received;                // [P]
    std::span<const float> self_black;                   // [P]

    // Hit probabilities of Q volumes (the largest, each with all above it): of the lines along a direction that meet the
    // volume's box, the share that hits the object; the same both ways. Value = table[q * H + line] / 255.
    std::span<const std::uint32_t> hit_volumes;          // [Q] volume numbers, ascending
    std::span<const std::uint8_t> whole_hit;             // [Q * H] any triangle of the object: before, in, behind the box
    std::span<const std::uint8_t> intrinsic_hit;         // [Q * H] the volume's own triangles only; often empty

    // Silhouettes: the share of each pixel that the object covers, value / 255, along the lines of the octahedral grid of
    // n = atlas_grid_size (even; so n^2 / 2 images), each of m^2 pixels, m = atlas_image_size, over the square [-r, r]^2
    // about the centre. Pixel (column, row), at (line * m + row) * m + column, spans x from r (2 column / m - 1) along
    // frame_about(w)[0] and y from r (2 row / m - 1) along frame_about(w)[1], w the line's direction. Seen along -w the
    // first axis is the same and the second one opposite: rows run the other way.
    Vec3f atlas_centre;                                  // relative to origin
    float atlas_radius = 0;                              // m, > 0: no vertex is farther from the centre
    std::uint32_t atlas_grid_size = 0, atlas_image_size = 0;
    std::span<const std::uint8_t> atlas_coverage;        // [n^2 / 2 * m^2]

    std::uint32_t directions() const { return meta.grid_size * meta.grid_size; }
    std::uint32_t lines() const { return meta.grid_size % 2 == 0 ? directions() / 2 : directions(); }
    TriangleCorners corners(std::uint32_t triangle) const {
        const TriangleIndices& t = triangles[triangle];
        return {origin + to_double(positions[t[0]]), origin + to_double(positions[t[1]]),
                origin + to_double(positions[t[2]])};
    }
    /// Corners so that they run counter-clockwise as seen from the face's side.
    TriangleCorners corners(Face face) const {
        TriangleCorners c = corners(face.triangle());
        if (face.side() == Side::Back) std::swap(c[1], c[2]);
        return c;
    }
};

}  // namespace rro
