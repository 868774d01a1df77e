// What `tradeoff` runs: every method at every accuracy, and at one accuracy each knob of the reusable method alone.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "format/result.h"
#include "solver/scene/manifest.h"
#include "solver/solve_scene.h"

namespace rro {

/// What is to be swept.
struct SweepOptions {
    std::vector<double> accuracies = {0.3, 0.2, 0.1, 0.05};  // each in (0, 1]
    std::vector<Method> methods = {Method::Reusable, Method::Hierarchical, Method::Reference};
    std::vector<std::filesystem::path> variants;  // folders of archives, or folders of such folders
    std::optional<double> knobs_at;               // accuracy at which knobs are swept; one in the middle where not given
    bool knobs = true;
};

/// One thing to run, as often as is asked.
struct Trial {
    Method method = Method::Reusable;
    std::string knob, value;        // empty: the method as it is
    std::filesystem::path library;  // where its archives are; empty: where the manifest says
    SolveOptions solve;             // accuracy, method and knob
};

/// "hierarchical at 0.1", "reusable at 0.1, grid 6".
std::string name_of(const Trial& trial);
/// The word on the command line.
std::string name_of(Method method);

/// A knob that is not swept, or a library that is not, and why.
struct NotSwept {
    std::string what, why;
};

/// All that is to be run.
struct Sweep {
    std::vector<Trial> trials;  // from rough to fine; knobs last
    double knobs_at = 0;        // accuracy
    std::vector<NotSwept> not_swept;
};

/// Looks at the archives of the scene and of all variants: a variant is named by how its tables differ from the scene's.
///
/// errors   Usage: an accuracy out of range, or none; BadInput: a folder that is none; a scene whose archives cannot be
///          opened
Result<Sweep> plan_sweep(const Manifest& manifest, const SweepOptions& options);

}  // namespace rro
