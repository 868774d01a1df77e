// Files of factors: CSV, JSON and the report. All appear whole or not at all; rows are written one by one.
#pragma once

#include <filesystem>
#include <optional>

#include "format/result.h"
#include "solver/factors/closure.h"

namespace rro {

struct FactorSeconds {
    double load = 0, factors = 0, output = 0, total = 0;
};

/// `from,to,factor,area_from,standard_error` for all ordered pairs; with a threshold only those whose factor is at least
/// that. Numbers are written so that they read back as the same doubles.
Status write_factors_csv(const Factors& factors, std::optional<double> threshold, const std::filesystem::path& path);

/// {"format": "rro-factors/1", ..., "groups": [{"name", "area", "row_sum"}], "rows": [{"from", "to", "factor",
/// "standard_error"}]}: per row lists of the same length, "to" holds group numbers; what is missing is 0.
Status write_factors_json(const Factors& factors, std::optional<double> threshold, const std::filesystem::path& path);

/// What was done, as JSON: closure and reciprocity first, before and after `--close`.
Status write_factors_report(const Factors& factors, const ClosureReport& before, const std::optional<Closing>& closing,
                            const FactorSeconds& seconds, const std::filesystem::path& path);

std::string_view name_of(GroupBy by);
std::string_view name_of(Sides sides);

}  // namespace rro
