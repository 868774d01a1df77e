// The command line of rro-solve: its commands and options, and from words to what the pipeline takes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "format/result.h"
#include "solver/edit/edit_arguments.h"
#include "solver/factors/view_factors.h"
#include "solver/output/output.h"
#include "solver/solve_scene.h"
#include "solver/study/compare.h"
#include "solver/tradeoff/tradeoff.h"

namespace rro {

/// All that the words may say. Each command has some of it.
struct Arguments {
    std::string command;  // run, explain, factors, compare, tradeoff, place, move, delete or live
    std::filesystem::path scene, out, picture, radiosity, report;
    std::string size = "960x540", method = "reusable", transport, visibility = "auto", memory;
    std::optional<double> accuracy;
    std::uint32_t samples = 0;
    std::uint64_t seed = 1;
    unsigned threads = 0;
    EffectOverrides overrides;
    bool quiet = false, verbose = false, json = false;
    std::string by, sides = "front";
    std::string name;
    std::filesystem::path archive;
    TransformOptions transform;
    std::optional<double> threshold;
    bool close = false;
    std::filesystem::path reuse;
    CompareOptions compare;
    TradeoffOptions tradeoff;
    std::vector<std::string> methods = {"reusable", "hierarchical", "reference"};
    bool no_knobs = false, no_pictures = false;
    std::filesystem::path json_file, markdown_file;
};

/// The words as they stand; nothing where they asked for --help or --version, which is printed.
/// errors   Usage: an unknown word, an option without its value, a command without what it needs
Result<std::optional<Arguments>> parse_command_line(int argc, char** argv);

/// errors   Usage: not above 0 and at most 1
Status check_accuracy(const Arguments& a);

/// The options of `run` as the pipeline takes them.
struct Job {
    SolveOptions solve;
    PictureOptions picture;
    std::uint64_t memory = 0;
};

/// errors   Usage: a value that no option has
Result<Job> job_of(const Arguments& a);

/// The options of `factors` as the pipeline takes them.
struct FactorsJob {
    FactorOptions options;
    std::uint64_t memory = 0;
};

/// errors   Usage, likewise
Result<FactorsJob> factors_job_of(const Arguments& a);

/// The sweep that `tradeoff` was asked for.
/// errors   Usage: no such method
Result<TradeoffOptions> tradeoff_options_of(const Arguments& a);

}  // namespace rro
