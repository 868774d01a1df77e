#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "format/atomic_file.h"
#include "format/tool/csv_field.h"
#include "format/tool/interrupt.h"
#include "format/tool/printed.h"
#include "solver/tradeoff/tradeoff.h"

namespace rro {
namespace {

using nlohmann::json;

std::string number(double value) {
    return printed("%.6g", value);
}

/// Medians of the phases over the runs.
PhaseSeconds median_phases(const std::vector<RunRecord>& runs) {
    const auto median = [&](double PhaseSeconds::*phase) {
        std::vector<double> all;
        for (const RunRecord& run : runs) all.push_back(run.seconds.*phase);
        std::sort(all.begin(), all.end());
        return 0.5 * (all[(all.size() - 1) / 2] + all[all.size() / 2]);
    };
    return {median(&PhaseSeconds::load),       median(&PhaseSeconds::plan),    median(&PhaseSeconds::links),
            median(&PhaseSeconds::visibility), median(&PhaseSeconds::iterate), 0, median(&PhaseSeconds::total)};
}

json point_json(const Point& p) {
    json out = {{"method", name_of(p.trial.method)},
                {"accuracy", *p.trial.solve.accuracy},
                {"knob", p.trial.knob},
                {"value", p.trial.value},
                {"library", p.trial.library.string()},
                {"runs", p.runs.size()},
                {"not_run", p.not_run},
                {"knee", p.knee}};
    if (p.runs.empty()) return out;
    const RunRecord& r = p.runs[0];
    const PhaseSeconds s = median_phases(p.runs);
    const Timing spread = p.seconds();
    out["seconds"] = {{"median", spread.median}, {"low", spread.low},   {"high", spread.high},
                      {"load", s.load},          {"plan", s.plan},      {"links", s.links},
                      {"visibility", s.visibility}, {"iterate", s.iterate}};
    out["error"] = {{"value", r.measured.error}, {"low", r.measured.low}, {"high", r.measured.high}};
    out["estimated_error"] = r.estimated_error;
    out["converged"] = r.converged;
    out["bias"] = r.measured.bias;
    out["worst"] = {{"instance", r.measured.worst_instance}, {"error", r.measured.worst_error}};
    out["links"] = {{"far", r.links.far}, {"near", r.links.near}, {"self", r.links.self},
                    {"total", r.links.total()}, {"bytes", r.links.bytes}};
    out["rays"] = r.rays;
    return out;
}

}  // namespace

std::string tradeoff_json(const Tradeoff& t) {
    json points = json::array(), not_swept = json::array();
    for (const Point& p : t.points) points.push_back(point_json(p));
    for (const NotSwept& n : t.not_swept) not_swept.push_back({{"what", n.what}, {"why", n.why}});
    const MachineFacts& m = t.machine;
    const json all = {{"format", "rro-tradeoff/1"},
                      {"scene", t.scene},
                      {"triangles", t.triangles},
                      {"instances", t.instances},
                      {"truth", {{"file", t.truth_from}, {"made", t.truth_note}, {"standard_error", t.truth_error}}},
                      {"repeats", t.options.repeats},
                      {"knobs_at", t.knobs_at},
                      {"machine",
                       {{"processor", m.processor},
                        {"cores", m.cores},
                        {"threads", m.threads},
                        {"memory_bytes", m.memory},
                        {"system", m.system},
                        {"load", m.load},
                        {"program", m.program},
                        {"compiler", m.compiler}}},
                      {"points", points},
                      {"not_swept", not_swept}};
    return all.dump(2, ' ', false, json::error_handler_t::replace) + "\n";
}

std::string tradeoff_csv(const Tradeoff& t) {
    std::string text =
        "method,accuracy,knob,value,library,runs,seconds,seconds_low,seconds_high,load,plan,links_seconds,visibility,iterate,"
        "error,error_low,error_high,estimated_error,converged,bias,worst_instance,worst_error,links,rays,link_bytes,knee,"
        "not_run\n";
    for (const Point& p : t.points) {
        text += name_of(p.trial.method) + "," + number(*p.trial.solve.accuracy) + "," + csv_field(p.trial.knob) + "," +
                csv_field(p.trial.value) + "," + csv_field(p.trial.library.string()) + "," + std::to_string(p.runs.size());
        if (p.runs.empty()) {
            text += ",,,,,,,,,,,,,,,,,,,,0," + csv_field(p.not_run) + "\n";
            continue;
        }
        const RunRecord& r = p.runs[0];
        const PhaseSeconds s = median_phases(p.runs);
        const Timing spread = p.seconds();
        const MeasuredError& e = r.measured;
        for (const double v : {spread.median, spread.low, spread.high, s.load, s.plan, s.links, s.visibility, s.iterate,
                               e.error, e.low, e.high, r.estimated_error})
            text += "," + number(v);
        text += std::string(",") + (r.converged ? "1" : "0") + "," + number(e.bias) + "," + csv_field(e.worst_instance) + "," +
                number(e.worst_error) + "," + std::to_string(r.links.total()) + "," + std::to_string(r.rays) + "," +
                std::to_string(r.links.bytes) + (p.knee ? ",1,\n" : ",0,\n");
    }
    return text;
}

std::string tradeoff_text(const Tradeoff& t) {
    std::string text = t.scene + printed(": %zu triangles, %zu instances; truth: ", t.triangles, t.instances) + t.truth_from +
                       printed(", standard error %.3g\n\n", t.truth_error);
    text += printed("%-46s %8s %8s %9s %9s %9s %5s  %s\n", "", "error", "estimate", "seconds", "fastest", "slowest", "runs", "");
    for (const Point& p : t.points) {
        if (p.runs.empty()) {
            text += printed("%-46s ", name_of(p.trial).c_str()) + "not run: " + p.not_run + "\n";
            continue;
        }
        const Timing s = p.seconds();
        text += printed("%-46s %8.4f %8.4f %9.3f %9.3f %9.3f %5zu  %s\n", name_of(p.trial).c_str(), p.runs[0].measured.error,
                     p.runs[0].estimated_error, s.median, s.low, s.high, p.runs.size(), p.knee ? "knee" : "");
    }
    for (const NotSwept& n : t.not_swept) text += "not swept: " + n.what + ": " + n.why + "\n";
    return text;
}

Status write_tradeoff(const Tradeoff& t) {
    const DeferInterrupts until_written;
    const std::array<std::pair<const char*, std::string>, 3> files{{{"tradeoff.csv", tradeoff_csv(t)},
                                                                    {"tradeoff.json", tradeoff_json(t)},
                                                                    {"tradeoff.html", tradeoff_html(t)}}};
    for (const auto& [name, text] : files)
        if (auto written = write_file_atomically(t.options.out / name, text); !written) return written.error();
    return Done{};
}

}  // namespace rro
