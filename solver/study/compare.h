// rro-solve compare: one scene with two versions of its archives. What changed in time, radiosity, links and bytes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "format/result.h"
#include "solver/progress.h"
#include "solver/scene/scene.h"
#include "solver/solution.h"

namespace rro {

/// The same manifest with its archives looked up by file name in a folder. Content pins are dropped: versions differ.
///
/// errors   BadInput naming the instance and the archive that the folder lacks
Result<Manifest> with_archives_in(Manifest manifest, const std::filesystem::path& folder);

/// One solve, as compare needs it.
struct SolvedScene {
    Scene scene;                    // with Section::Source
    Solution solution;              // seconds.load is filled in; total holds all but the load
    std::uint64_t memory = 0;       // bytes, estimated
};
/// Solves a manifest as `run` would.
using SolveOnce = std::function<Result<SolvedScene>(const Manifest&)>;

/// What `compare` is asked for.
struct CompareOptions {
    std::filesystem::path base, head;             // folders of archives
    int runs = 5;                                 // measured ones of each, interleaved, after one of each that is not
    std::optional<double> fail_if_slower = {};    // ratio of total times, above 1
    std::optional<double> fail_if_differs = {};   // relative RMS of reflected radiosity
};

/// About the times of a phase.
enum class TimingVerdict { Same, Faster, Slower };  // Same: the noise hides what difference there is

/// Wall times of a phase over the runs.
struct PhaseTimes {
    std::string phase;
    double base = 0, head = 0;                // s, medians
    double base_spread = 0, head_spread = 0;  // s, largest minus smallest
    double ratio = 1;                         // of the medians, head / base
    double low = 1, high = 1;                 // of the ratios of neighbouring runs; of 8 and more runs, without the runs / 8
                                              // largest and smallest
    TimingVerdict verdict = TimingVerdict::Same;  // Slower where even `low` is above 1, Faster where even `high` is below
};

/// Difference of reflected radiosity R = B - M over the source's triangles and sides that both versions have.
struct RadiosityDifference {
    double relative_rms = 0;   // sqrt(sum A |R' - R|^2 / sum A |R|^2); infinite where only the base is dark
    double largest = 0;        // W/m^2, of any channel
    std::string instance;      // where that is
    std::uint32_t triangle = 0;
    std::string worst_instance;  // by relative RMS of its own, among those with 0.1 % of the reflected light's square
    double worst_relative_rms = 0;
    std::uint64_t unmatched = 0;  // triangle sides that only one version has
};

/// A count or size of both versions.
struct Pairing {
    std::string what;
    std::uint64_t base = 0, head = 0;
};

/// How archives were made; a value for each that occurs, with commas between.
struct Making {
    std::string what, base, head;  // tables, compiler
};

/// All that `compare` finds.
struct Comparison {
    std::string scene;
    CompareOptions options;
    std::vector<Making> made;
    std::size_t archives = 0, changed = 0;  // of the base; those whose bytes differ in head
    std::vector<PhaseTimes> times;  // total is the last
    RadiosityDifference radiosity;
    std::vector<Pairing> sizes;     // links and their kinds, rays, bytes of links, memory (estimated), archives
    double base_error = 0, head_error = 0;  // the solver's own estimates
    bool too_slow = false, too_different = false;

    bool passed() const { return !too_slow && !too_different; }
};

/// Of neighbouring runs, s: as many of the base as of the head.
PhaseTimes phase_times(std::string phase, const std::vector<double>& base, const std::vector<double>& head);
/// Of two solutions of one manifest with two versions of its archives.
RadiosityDifference radiosity_difference(const SolvedScene& base, const SolvedScene& head);

/// Runs base, head, base, head ... and compares. Too slow: the ratio of total medians is above the threshold and the
/// verdict is Slower. Too different: above the threshold, or NaN.
///
/// errors   those of with_archives_in and of `solve`
Result<Comparison> compare_archives(const Manifest& manifest, const CompareOptions& options, const SolveOnce& solve,
                                    const Progress& progress = {});

/// As text for the terminal.
std::string comparison_text(const Comparison& comparison);
/// The same as JSON.
std::string comparison_json(const Comparison& comparison);
/// The same as Markdown.
std::string comparison_markdown(const Comparison& comparison);

}  // namespace rro
