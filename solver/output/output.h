// Files that a solve writes. All are written atomically.
#pragma once

#include <filesystem>
#include <optional>

#include "format/result.h"
#include "solver/scene/scene.h"
#include "solver/solution.h"
#include "solver/visibility/scene_rays.h"

namespace rro {

/// Radiosity CSV: `instance,triangle,radiosity_r..b,irradiance_r..b,back_r..b`, W/m^2, means over each source triangle; back_*
/// is the radiosity of two-sided triangles' backs, else empty. A solution with standard errors has `stderr_r..b` (of fronts)
/// besides. Rows in manifest order, then source number; 9 significant digits.
///
/// scene    with Section::Source
/// errors   Failed: cannot be written
Status write_radiosity_csv(const Scene& scene, const Solution& solution, const std::filesystem::path& path);

/// What the solve did, as JSON (schemas/report.schema.json). memory_peak_bytes is read here.
/// errors   Failed: cannot be written
Status write_report(const Scene& scene, const Solution& solution, const std::filesystem::path& path);

/// GLB: one mesh per instance, with _RADIOSITY (W/m^2) and COLOR_0 (that times the factor in asset.extras.exposure, at most
/// 1), unlit.
/// errors   Failed: cannot be written, or more than the 4 GiB that a GLB holds
Status write_glb(const Scene& scene, const Solution& solution, const std::filesystem::path& path);

/// How a picture is taken.
struct PictureOptions {
    int width = 960, height = 540;  // pixels
    int samples_per_pixel = 16;
};

/// PNG (tone-mapped) or EXR (linear radiance), by the file's ending. Without a camera one is chosen that sees the scene.
/// returns  the exposure used, in stops: the camera's, or the one that brings the log-average to 0.18; 0 for an EXR
/// errors   Usage: another ending, no pixels, no samples; Failed: cannot be encoded or written
Result<double> write_picture(const Scene& scene, const Solution& solution, const SceneRays& rays,
                             const PictureOptions& options, const std::filesystem::path& path);

}  // namespace rro
