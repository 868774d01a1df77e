#include "solver/factors/factors_output.h"

#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <nlohmann/json.hpp>

#include "format/parallel.h"
#include "format/tool/csv_field.h"

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

/// names   fields with their commas
void append_csv_row(std::string& out, double area_from, std::uint32_t row, std::span<const Factor> factors,
                    const std::vector<std::string>& names, std::optional<double> threshold) {
    std::string area = ",";
    append_number(area, area_from);
    area += ',';
    const std::string zero = "0" + area + "0\n";
    std::uint32_t next = 0;
    const auto append_zeros = [&](std::uint32_t end) {
        if (threshold && 0 < *threshold) return;
        for (; next < end; ++next) out.append(names[row]).append(names[next]).append(zero);
    };
    for (const Factor& factor : factors) {
        append_zeros(factor.to);
        next = factor.to + 1;
        if (threshold && factor.value < *threshold) continue;
        out.append(names[row]).append(names[factor.to]);
        append_number(out, factor.value);
        out.append(area);
        append_number(out, factor.standard_error);
        out += '\n';
    }
    append_zeros(static_cast<std::uint32_t>(names.size()));
}

void append_json_row(std::string& out, std::uint32_t row, std::span<const Factor> row_factors,
                     std::optional<double> threshold) {
    std::string to, factors, errors;
    for (const Factor& factor : row_factors) {
        if (threshold && factor.value < *threshold) continue;
        if (!to.empty()) to += ',', factors += ',', errors += ',';
        append_number(to, factor.to);
        append_number(factors, factor.value);
        append_number(errors, factor.standard_error);
    }
    out += row ? ",\n" : "\n";
    out += "{\"from\":" + std::to_string(row) + ",\"to\":[" + to + "],\"factor\":[" + factors + "],\"standard_error\":[" +
           errors + "]}";
}

/// What a file begins with, but for the rows.
std::string json_head(const FactorTable& f, std::optional<double> threshold, bool closed) {
    std::string head = "{\"format\":\"" + std::string(kFactorsFormat) + "\",\"by\":\"" + std::string(name_of(f.options.by)) +
                       "\",\"sides\":\"" + std::string(name_of(f.options.sides)) + "\",\"accuracy\":";
    append_number(head, f.options.accuracy);
    if (threshold) {
        head += ",\"threshold\":";
        append_number(head, *threshold);
    }
    if (closed) head += ",\"closed\":true";
    return head + ",\n\"rows\":[";
}

json record_json(const InstanceRecord& instance) {
    const Box3& box = instance.bounds;
    json groups = json::array();
    for (const std::uint32_t group : instance.groups) groups.push_back(group == kNoGroup ? json() : json(group));
    return {{"name", instance.name},
            {"content", instance.content},
            {"to_world", instance.to_world},
            {"bounds", {box.lo.x, box.lo.y, box.lo.z, box.hi.x, box.hi.y, box.hi.z}},
            {"groups", groups}};
}

std::string json_tail(const FactorTable& f) {
    std::string tail = "],\n\"groups\":[";
    for (std::size_t g = 0; g < f.names.size(); ++g) {
        tail += (g ? ",\n{\"name\":" : "\n{\"name\":") + json_text(f.names[g]) + ",\"area\":";
        append_number(tail, f.area[g]);
        tail += ",\"row_sum\":";
        append_number(tail, f.closure.row_sum[g]);
        tail += '}';
    }
    tail += "],\n\"instances\":[";
    for (std::size_t i = 0; i < f.instances.size(); ++i) tail += (i ? ",\n" : "\n") + json_text(record_json(f.instances[i]));
    return tail + "]}\n";
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

Result<FactorsFile> FactorsFile::open(const std::filesystem::path& path, std::optional<double> threshold, bool closed) {
    auto file = AtomicFile::open(path);
    if (!file) return file.error();
    FactorsFile factors(*std::move(file));
    factors.json_ = path.extension() == ".json";
    factors.threshold_ = threshold;
    factors.closed_ = closed;
    return factors;
}

Status FactorsFile::add(const FactorTable& f, std::uint32_t first, std::span<const FactorRow> rows) {
    if (first == 0) {
        for (const std::string& name : f.names) names_.push_back(csv_field(name) + ',');
        const std::string head = json_ ? json_head(f, threshold_, closed_) : "from,to,factor,area_from,standard_error\n";
        if (auto written = write(head); !written) return written.error();
    }
    std::vector<std::string> texts(kRowsAtATime);
    for (std::size_t begin = 0; begin < rows.size(); begin += kRowsAtATime) {
        const std::size_t count = std::min(kRowsAtATime, rows.size() - begin);
        parallel_for(count, 1, [&](std::size_t k) {
            texts[k].clear();
            const auto row = static_cast<std::uint32_t>(first + begin + k);
            if (json_)
                append_json_row(texts[k], row, rows[begin + k], threshold_);
            else
                append_csv_row(texts[k], f.area[row], row, rows[begin + k], names_, threshold_);
        });
        for (std::size_t k = 0; k < count; ++k)
            if (auto written = write(texts[k]); !written) return written.error();
    }
    return Done{};
}

Status FactorsFile::finish(const FactorTable& f) {
    if (json_)
        if (auto written = write(json_tail(f)); !written) return written.error();
    return file_.commit();
}

Status write_factors(const Factors& factors, std::optional<double> threshold, bool closed,
                     const std::filesystem::path& path) {
    auto file = FactorsFile::open(path, threshold, closed);
    if (!file) return file.error();
    if (auto added = file->add(factors, 0, factors.rows); !added) return added.error();
    return file->finish(factors);
}

Status write_factors_report(const FactorTable& f, const std::optional<Closing>& closing, const FactorSeconds& seconds,
                            const std::filesystem::path& path) {
    const ClosureReport& before = f.closure;
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
          {"reused", f.counts.reused},
          {"above_accuracy", f.counts.missed}}},
        {"rays", f.counts.rays},
        {"polygons", f.polygons},
        {"blockers", f.blockers},
        {"seconds",
         {{"load", seconds.load},
          {"factors", seconds.factors},
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
