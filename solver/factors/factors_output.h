// Files of factors: CSV, JSON and the report. All appear whole or not at all; rows are written one by one.
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

#include "format/atomic_file.h"
#include "format/result.h"
#include "solver/factors/closure.h"

namespace rro {

/// Wall time, s.
struct FactorSeconds {
    double load = 0, factors = 0, total = 0;  // factors: with writing them
};

/// The JSON's "format".
inline constexpr std::string_view kFactorsFormat = "rro-factors/1";

/// A file of factors that is written row after row.
class FactorsFile {
  public:
    /// threshold  factors below it are left out
    /// closed     said in the file: its factors have been moved
    ///
    /// errors     Failed: the file cannot be written
    static Result<FactorsFile> open(const std::filesystem::path& path, std::optional<double> threshold, bool closed);

    /// The next rows, beginning with row `first`.
    /// errors     Failed: disk full, and the like; here and below
    Status add(const FactorTable& table, std::uint32_t first, std::span<const FactorRow> rows);
    /// After the last row, with the whole table.
    Status finish(const FactorTable& table);

  private:
    explicit FactorsFile(AtomicFile&& file) : file_(std::move(file)) {}
    Status write(std::string_view text) { return file_.write(text); }

    AtomicFile file_;
    bool json_ = false, closed_ = false;
    std::optional<double> threshold_;
    std::vector<std::string> names_;  // as a field and its comma
};

/// `from,to,factor,area_from,standard_error` for all ordered pairs; with a threshold only those whose factor is at least
/// that. Numbers are written so that they read back as the same doubles.
///
/// JSON (a name ending in .json): {"format": "rro-factors/1", ..., "rows": [{"from", "to", "factor", "standard_error"}],
/// "groups": [{"name", "area", "row_sum"}], "instances": [...]}: per row lists of the same length, "to" holds group
/// numbers; what is missing is 0. Instances are there to tell later what has changed (previous_factors.h).
///
/// errors   Failed: cannot be written
Status write_factors(const Factors& factors, std::optional<double> threshold, bool closed,
                     const std::filesystem::path& path);

/// What was done, as JSON: closure and reciprocity first, as before `--close`, and what that moved.
/// It follows schemas/factors_report.schema.json.
/// errors   Failed: cannot be written
Status write_factors_report(const FactorTable& factors, const std::optional<Closing>& closing, const FactorSeconds& seconds,
                            const std::filesystem::path& path);

/// The word on the command line.
std::string_view name_of(GroupBy by);
/// The same.
std::string_view name_of(Sides sides);

}  // namespace rro
