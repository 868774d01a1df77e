// One finished solve of a sweep: what is kept of it, and its file, so that an interrupted sweep goes on where it was.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "format/result.h"
#include "solver/solution.h"
#include "solver/tradeoff/truth.h"

namespace rro {

/// What is kept of a solve.
struct RunRecord {
    std::string failed;     // why there is no result; all else is 0 then
    PhaseSeconds seconds;   // load is filled in, total holds it too; output is 0
    MeasuredError measured;
    double estimated_error = 0;
    bool converged = false;
    LinkCounts links;
    std::uint64_t rays = 0;
};

/// Writes it as a JSON file.
/// errors   Failed: cannot be written
Status write_run(const RunRecord& run, const std::filesystem::path& path);

/// Reads such a file. Nothing where there is none, or one that is no run: it is run again then.
std::optional<RunRecord> read_run(const std::filesystem::path& path);

}  // namespace rro
