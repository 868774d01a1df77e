#include "solver/factors/factors_output.h"

#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <nlohmann/json.hpp>

#include "format/atomic_file.h"
#include "format/parallel.h"
#include "solver/output/csv_field.h"

namespace rro {
namespace {

using nlohmann::json;

constexpr std::size_t kRowsAtATime = 64;  // formatted in memory, before they go to the file

/// The shortest text that reads back as the same number.
template <class Number>
void append_number(std::string& out, Number value) {
    std::array<char, 32> text;
    out.append(text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr);
}

std::string json_text(const json& value) {
    return value.dump(-1, ' ', false, json::error_handler_t::replace);
}

void append_csv_row(std::string& out, const Factors& f, std::uint32_t row, const std::vector<std::string>& names,
                    std::optional<double> threshold) {
    std::string area;
    append_number(area, f.area[row]);
    const auto append = [&](std::uint32_t to, double value, float error) {
        if (threshold && value < *threshold) return;
        out += names[row] + ',' + names[to] + ',';
        append_number(out, value);
        out += ',' + area + ',';
        append_number(out, error);
        out += '\n';
    };
    std::uint32_t next = 0;
    for (const Factor& factor : f.rows[row]) {
        while (next < factor.to) append(next++, 0, 0);
        append(next++, factor.value, factor.standard_error);
    }
    while (next < f.names.size()) append(next++, 0, 0);
}

void append_json_row(std::string& out, const Factors& f, std::uint32_t row, std::optional<double> threshold) {
    std::string to, factors, errors;
    for (const Factor& factor : f.rows[row]) {
        if (threshold && factor.value < *threshold) continue;
        if (!to.empty()) to += ',', factors += ',', errors += ',';
        append_number(to, factor.to);
        append_number(factors, factor.value);
        append_number(errors, factor.standard_error);
    }
    out += "{\"from\":" + std::to_string(row) + ",\"to\":[" + to + "],\"factor\":[" + factors +
           "],\"standard_error\":[" + errors + "]}";
}

/// Writes what `append(row)` gives, row after row.
template <class Append>
Status write_rows(const std::filesystem::path& path, std::string head, const Factors& f, const Append& append,
                  const std::string& tail) {
    auto file = AtomicFile::open(path);
    if (!file) return file.error();
    if (auto written = file->write(head); !written) return written.error();
    std::vector<std::string> texts(kRowsAtATime);
    for (std::size_t begin = 0; begin < f.names.size(); begin += kRowsAtATime) {
        const std::size_t count = std::min(kRowsAtATime, f.names.size() - begin);
        parallel_for(count, 1, [&](std::size_t k) {
            texts[k].clear();
            append(texts[k], static_cast<std::uint32_t>(begin + k));
        });
        for (std::size_t k = 0; k < count; ++k)
            if (auto written = file->write(texts[k]); !written) return written.error();
    }
    if (auto written = file->write(tail); !written) return written.error();
    return file->commit();
}

std::uint64_t memory_peak_bytes() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;  // Linux counts kibibytes
}

}  // namespace

std::string_view name_of(GroupBy by) {
    return by == GroupBy::Instance ? "instance" : by == GroupBy::Material ? "material" : by == GroupBy::Group ? "group" : "auto";
}

std::string_view name_of(Sides sides) {
    return sides == Sides::Front ? "front" : "both";
}

Status write_factors_csv(const Factors& f, std::optional<double> threshold, const std::filesystem::path& path) {
    std::vector<std::string> names;
    for (const std::string& name : f.names) names.push_back(csv_field(name));
    return write_rows(path, "from,to,factor,area_from,standard_error\n", f,
                      [&](std::string& out, std::uint32_t row) { append_csv_row(out, f, row, names, threshold); }, "");
}

Status write_factors_json(const Factors& f, std::optional<double> threshold, const std::filesystem::path& path) {
    const ClosureReport closure = measure_closure(f);
    std::string head = "{\"format\":\"rro-factors/1\",\"by\":\"" + std::string(name_of(f.options.by)) +
                       "\",\"sides\":\"" + std::string(name_of(f.options.sides)) + "\",\"accuracy\":";
    append_number(head, f.options.accuracy);
    if (threshold) {
        head += ",\"threshold\":";
        append_number(head, *threshold);
    }
    head += ",\n\"groups\":[";
    for (std::size_t g = 0; g < f.names.size(); ++g) {
        head += (g ? ",\n{\"name\":" : "\n{\"name\":") + json_text(f.names[g]) + ",\"area\":";
        append_number(head, f.area[g]);
        head += ",\"row_sum\":";
        append_number(head, closure.row_sum[g]);
        head += '}';
    }
    head += "],\n\"rows\":[";
    return write_rows(path, std::move(head), f,
                      [&](std::string& out, std::uint32_t row) {
                          out += row ? ",\n" : "\n";
                          append_json_row(out, f, row, threshold);
                      },
                      "]}\n");
}

Status write_factors_report(const Factors& f, const ClosureReport& before, const std::optional<Closing>& closing,
                            const FactorSeconds& seconds, const std::filesystem::path& path) {
    json rows = json::array();
    for (std::size_t g = 0; g < f.names.size(); ++g) {
        rows.push_back({{"name", f.names[g]}, {"area", f.area[g]}, {"row_sum", before.row_sum[g]}});
        if (closing) {
            rows.back()["moved_by_close"] = closing->moved[g];
            rows.back()["row_sum_moved_by_close"] = closing->sum_moved[g];
        }
    }
    const auto name = [&](std::uint32_t g) { return g < f.names.size() ? f.names[g] : std::string(); };
    json report = {
        {"closure",
         {{"largest_defect", before.largest_defect},
          {"of", name(before.worst_row)},
          {"mean_defect", before.mean_defect}}},
        {"reciprocity",
         {{"largest_defect", before.largest_asymmetry},
          {"largest_relative_defect", before.largest_relative_asymmetry},
          {"from", name(before.asymmetric_from)},
          {"to", name(before.asymmetric_to)}}},
        {"accuracy", f.options.accuracy},
        {"by", name_of(f.options.by)},
        {"sides", name_of(f.options.sides)},
        {"pairs",
         {{"exact", f.counts.exact},
          {"cut", f.counts.cut},
          {"sampled", f.counts.sampled},
          {"above_accuracy", f.counts.missed}}},
        {"rays", f.counts.rays},
        {"polygons", f.polygons},
        {"blockers", f.blockers},
        {"seconds",
         {{"load", seconds.load},
          {"factors", seconds.factors},
          {"output", seconds.output},
          {"total", seconds.total}}},
        {"memory_peak_bytes", memory_peak_bytes()},
        {"rows", rows}};
    if (closing)
        report["close"] = {{"largest_move", closing->largest_move},
                           {"of", name(closing->worst_row)},
                           {"rounds", closing->rounds}};
    return write_file_atomically(path, report.dump(2, ' ', false, json::error_handler_t::replace) + "\n");
}

}  // namespace rro
