// What a sweep's results are judged by: a reference solution with its standard errors, by triangles of the sources, and
// errors against it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "format/result.h"
#include "solver/scene/scene.h"
#include "solver/solution.h"

namespace rro {

/// One side of a source triangle.
struct TruthFace {
    Rgb radiosity, standard_error;  // W/m^2
};

/// By source triangles, so that it holds for every version of the archives.
struct Truth {
    struct OfInstance {
        std::string name;
        std::vector<std::optional<TruthFace>> faces;  // [2 * source triangle + side]
    };
    std::vector<OfInstance> instances;  // in manifest order
};

/// A solution by --method reference as a truth.
///
/// scene    with Section::Source
Truth truth_of(const Scene& scene, const Solution& reference);

/// Writes the columns of a radiosity CSV (output.h) without irradiance, and `back_stderr_*` at the end.
/// errors   Failed: cannot be written
Status write_truth(const Truth& truth, const std::filesystem::path& path);

/// Reads that, or the CSV that `rro-solve run --method reference --radiosity` writes: it says nothing of the standard errors of
/// backs, which are taken to be those of their fronts.
///
/// errors   BadInput: not such a CSV (line); an instance or a face of the scene that it lacks
Result<Truth> read_truth(const std::filesystem::path& path, const Scene& scene);

/// How far a solution is from the truth. The truth's own variance is subtracted.
struct MeasuredError {
    double error = 0;           // sqrt(sum A |R - R_true|^2 / sum A |R_true|^2), R = B - M; over all faces and channels
    double low = 0, high = 0;   // two standard errors to either side, as far as the truth's noise makes it uncertain
    double bias = 0;            // area-weighted mean of R - R_true, over that of R_true
    std::string worst_instance;  // of those with 0.1 % of the reflected power; empty where there is no light
    double worst_error = 0;      // its own error
};
/// Over all faces of the scene.
MeasuredError measure_error(const Scene& scene, const Solution& solution, const Truth& truth);

/// The truth's own relative standard error, area-weighted.
double standard_error(const Scene& scene, const Truth& truth);

/// |R - R_true| of every face, without what the truth's noise explains, over the root mean square of R_true.
///
/// returns  [instances][F]
std::vector<std::vector<float>> face_errors(const Scene& scene, const Solution& solution, const Truth& truth);

}  // namespace rro
