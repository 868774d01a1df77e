// Files that a solve writes. All are written atomically.
#pragma once

#include <filesystem>
#include <optional>

#include "format/result.h"
#include "solver/scene/scene.h"
#include "solver/solution.h"
#include "solver/visibility/scene_rays.h"

namespace rro {

/// Radiosity CSV: means over each source triangle, rows in manifest order, then source number.
Status write_radiosity_csv(const Scene& scene, const Solution& solution, const std::filesystem::path& path);

/// report.json (schemas/report.schema.json). memory_peak_bytes is read here.
Status write_report(const Scene& scene, const Solution& solution, const std::filesystem::path& path);

/// GLB: one mesh per instance, _RADIOSITY, COLOR_0, unlit; exposure factor in asset.extras.exposure.
Status write_glb(const Scene& scene, const Solution& solution, const std::filesystem::path& path);

struct PictureOptions {
    int width = 960, height = 540;
    int samples_per_pixel = 16;
};

/// PNG (tone-mapped) or EXR (linear radiance), by the file's ending. Without a camera one is chosen that sees the scene.
/// returns  the exposure used, in stops: the camera's, or the one that brings the log-average to 0.18; 0 for an EXR
/// errors   Usage: another ending, no pixels; Failed: cannot be encoded or written
Result<double> write_picture(const Scene& scene, const Solution& solution, const SceneRays& rays,
                             const PictureOptions& options, const std::filesystem::path& path);

}  // namespace rro
