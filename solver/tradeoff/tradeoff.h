// rro-solve tradeoff: what accuracy costs in time, on one scene. Runs a sweep, interleaved and repeated, and measures errors
// against a reference of many samples. Finished runs and the reference are kept and found again.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "format/result.h"
#include "solver/progress.h"
#include "solver/study/compare.h"
#include "solver/tradeoff/machine.h"
#include "solver/tradeoff/run_record.h"
#include "solver/tradeoff/sweep.h"

namespace rro {

/// What `tradeoff` is asked for.
struct TradeoffOptions {
    SweepOptions sweep;
    std::filesystem::path out;             // folder of results; made where it is missing
    int repeats = 3;
    std::uint32_t samples = 256;           // per face, of the truth
    std::filesystem::path reference_file;  // a truth at hand (read_truth) instead
    std::optional<double> budget;          // s: no run is begun that would probably end later. Not counted: the truth
    bool pictures = true;
    std::string program;                   // digest of the program that solves; empty: of this one
};

/// Solves as `run` would. Fills in seconds.load; keeps Section::Source.
using SolveTrial = std::function<Result<SolvedScene>(const Manifest&, const SolveOptions&, const Progress&)>;

/// Smallest, median and largest of the runs.
struct Timing {
    double low = 0, median = 0, high = 0;
};

/// A trial with what came of it.
struct Point {
    Trial trial;
    std::vector<RunRecord> runs;    // finished ones; all but the seconds are the same in each
    std::string not_run;            // why there is none
    bool knee = false;
    std::filesystem::path picture;  // where its error sits; empty where there is no picture

    Timing seconds() const;         // load and solve
};

/// All that `tradeoff` finds.
struct Tradeoff {
    std::string scene;
    std::size_t triangles = 0, instances = 0;
    TradeoffOptions options;
    MachineFacts machine;
    double truth_error = 0;        // the truth's own standard error
    std::string truth_from;        // its file
    std::string truth_note;        // how it was made, as far as is known
    double knobs_at = 0;
    std::vector<Point> points;     // in the order of the sweep
    std::vector<NotSwept> not_swept;
};

/// Runs what is missing. Order: all trials once from rough to fine, then all again, `repeats` times in all, so that other
/// work on the machine meets all alike. A run that fails (an effect that the method lacks, more memory than allowed) is a
/// point without result. Runs are found again where the program, the machine, the scene, its archives, the options and the
/// truth are the same; the truth itself where program, scene, archives and samples are.
///
/// errors   those of plan_sweep and read_truth; Failed: the folder cannot be written to
Result<Tradeoff> measure_tradeoff(const Manifest& manifest, const TradeoffOptions& options, const SolveTrial& solve,
                                  const Progress& progress = {});

/// The knee of a curve: where seconds x error^2 is least. To plain sampling that product is a constant (half the error, four
/// times the time); before the knee a curve pays less than that for accuracy, beyond it more.
///
/// points   (error, seconds); those without an error above 0 do not count
/// returns  its index, the first of equals; none where fewer than two points count
std::optional<std::size_t> knee_of(const std::vector<std::array<double, 2>>& points);

/// What came of it as files of `options.out`: tradeoff.csv, tradeoff.json (schemas/tradeoff.schema.json) and tradeoff.html.
///
/// errors   Failed: cannot be written
Status write_tradeoff(const Tradeoff& tradeoff);

/// The three files' contents.
std::string tradeoff_csv(const Tradeoff& tradeoff);
std::string tradeoff_json(const Tradeoff& tradeoff);
std::string tradeoff_html(const Tradeoff& tradeoff);

/// The points as a table, for the terminal.
std::string tradeoff_text(const Tradeoff& tradeoff);

}  // namespace rro
