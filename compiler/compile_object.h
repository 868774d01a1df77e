// The compile pipeline, in order: the table of contents of this folder.
//
// Paper = M. Ouhyoung, Y.-Y. Chuang, R.-H. Liang, "Reusable Radiosity Object", 1997.
#pragma once

#include <cstdint>
#include <functional>
#include <string_view>
#include <vector>

#include "compiler/cluster_tree.h"
#include "compiler/mesh.h"
#include "compiler/table_choice.h"
#include "format/object_data.h"
#include "format/result.h"

namespace rro {

/// What decides an archive's content besides the mesh.
struct CompileOptions {
    std::uint32_t grid_size = 12;
    GridMap grid_map = GridMap::Octahedral;
    std::uint32_t image_resolution = 256;  // pixels along each direction image
    double patch_area_divisor = 2000;      // a patch holds at most object area / this
    double patch_cone_cosine = 0.8;        // smallest cosine between a patch's mean normal and its faces'
    ClusterWeights cluster_weights;
    TableChoice tables;
};

/// The compiled object with the vectors its views point into.
struct CompiledObject {
    ObjectData data;
    std::vector<Vec3f> positions;
    std::vector<TriangleIndices> triangles;
    std::vector<std::uint32_t> source_triangle;
    std::vector<Face> faces;
    std::vector<Patch> patches;
    std::vector<Cluster> clusters;
    std::vector<Volume> volumes;
    std::vector<std::uint32_t> volume_triangles;
    std::vector<std::uint32_t> area_clusters;
    std::vector<std::uint8_t> whole_area, intrinsic_area, visibility;
    std::vector<float> whole_area_scale, intrinsic_area_scale;
    std::vector<float> whole_area_error, intrinsic_area_error, visibility_error;
    std::vector<std::uint8_t> self_steps, self_visibility;
    std::vector<float> self_exchange, self_escape, self_received, self_black;
    std::vector<std::uint32_t> hit_volumes;
    std::vector<std::uint8_t> whole_hit, intrinsic_hit, atlas_coverage;
    std::uint32_t dropped_by_rounding = 0;  // triangles without an area in single precision; they have no row

    CompiledObject() = default;
    CompiledObject(CompiledObject&&) = default;  // vectors keep their storage, so views stay valid
    CompiledObject& operator=(CompiledObject&&) = default;
};

/// Told the phase and the share of the work done, from one thread at a time; may be empty.
using CompileProgress = std::function<void(std::string_view phase, double done)>;

/// Mesh in (checked, sides decided), archive content out. Deterministic for any number of threads. The caller fills
/// source name, source hash and the options' text of the meta data.
///
/// errors   BadInput: the object's extent is beyond single precision, or no triangle has an area in it
Result<CompiledObject> compile_object(const Mesh& mesh, const CompileOptions& options,
                                      const CompileProgress& progress = {});

}  // namespace rro
