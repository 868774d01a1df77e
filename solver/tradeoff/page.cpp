// tradeoff.html: one file, without anything from elsewhere. The frame, the style and the script are page.html, which the build
// puts into the program; charts, tables and pictures are made here.
#include <cmath>
#include <map>
#include <string_view>

#include "format/tool/printed.h"
#include "solver/scene/file_bytes.h"
#include "solver/tradeoff/chart.h"
#include "solver/tradeoff/error_picture.h"
#include "solver/tradeoff/page_html.h"
#include "solver/tradeoff/tradeoff.h"

namespace rro {
namespace {

constexpr std::uint64_t kMostPictureBytes = 1 << 24;
constexpr int kRampSteps = 24;
constexpr int kStyles = 8;  // of the page's style sheet

std::string base64(std::string_view bytes) {
    constexpr char kLetters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t three = 0;
        for (std::size_t k = 0; k < 3; ++k)
            three = three << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
        for (std::size_t k = 0; k < 4; ++k)
            out += i + k <= bytes.size() ? kLetters[three >> (18 - 6 * k) & 63] : '=';
    }
    return out;
}

std::string seconds_text(const Timing& s) {
    return s.low < s.high ? printed("%.3g s (%.3g to %.3g)", s.median, s.low, s.high) : printed("%.3g s", s.median);
}

std::string picture_id(std::size_t point) {
    return "picture-" + std::to_string(point);
}

/// What a mark says when it is pointed at.
std::string mark_text(const Point& p) {
    const RunRecord& r = p.runs[0];
    std::string text = name_of(p.trial) + printed("\nerror %.3g", r.measured.error) + ", in " + seconds_text(p.seconds()) +
                       printed("\nits own estimate %.3g%s", r.estimated_error, r.converged ? "" : ", above what was asked") +
                       printed("\n%llu links, %llu rays, %zu run%s", static_cast<unsigned long long>(r.links.total()),
                            static_cast<unsigned long long>(r.rays), p.runs.size(), p.runs.size() == 1 ? "" : "s");
    if (!r.measured.worst_instance.empty())
        text += "\nworst: " + r.measured.worst_instance + printed(", error %.3g", r.measured.worst_error);
    return p.knee ? text + "\nthe knee" : text;
}

Mark mark_of(const Point& p, std::string label, std::string target) {
    const Timing s = p.seconds();
    const MeasuredError& e = p.runs[0].measured;
    return {s.median, e.error, s.low, s.high, e.low, e.high, mark_text(p), std::move(label), p.knee, std::move(target)};
}

bool has_mark(const Point& p) {
    return !p.runs.empty() && p.runs[0].measured.error > 0;
}

bool is_baseline(const Tradeoff& t, const Point& p) {
    return p.trial.method == Method::Reusable && p.trial.knob.empty() && *p.trial.solve.accuracy == t.knobs_at;
}

std::string methods_chart(const Tradeoff& t) {
    Chart chart{"methods", "Error over time of each method", "", "seconds", "error", {}, {}};
    chart.description = "A logarithmic chart. The table below holds the same numbers.";
    for (const Method method : {Method::Reusable, Method::Hierarchical, Method::Reference}) {
        Series series{name_of(method), static_cast<int>(method), true, {}};
        for (std::size_t i = 0; i < t.points.size(); ++i) {
            const Point& p = t.points[i];
            if (p.trial.method == method && p.trial.knob.empty() && has_mark(p))
                series.marks.push_back(mark_of(p, printed("%g", *p.trial.solve.accuracy), p.picture.empty() ? "" : picture_id(i)));
        }
        chart.series.push_back(std::move(series));
    }
    chart.series[2].name += " (path tracing)";
    chart.levels.push_back({t.truth_error, "standard error of the truth"});
    return chart_svg(chart);
}

std::string knobs_chart(const Tradeoff& t) {
    Chart chart{"knobs", "Error and time as each knob changes", "", "seconds", "error", {}, {}};
    chart.description = "A logarithmic chart. The table below holds the same numbers.";
    std::map<std::string, Series> by_knob;
    for (const Point& p : t.points)
        if (!p.trial.knob.empty() && has_mark(p)) by_knob[p.trial.knob].marks.push_back(mark_of(p, p.trial.value, ""));
    if (by_knob.empty()) return "";
    for (const Point& p : t.points)
        if (is_baseline(t, p) && has_mark(p)) chart.series.push_back({"as it is", 0, false, {mark_of(p, "as it is", "")}});
    int style = 0;
    for (auto& [knob, series] : by_knob)
        chart.series.push_back({knob, 1 + style++ % (kStyles - 1), false, std::move(series.marks)});
    return chart_svg(chart);
}

std::string row(const Point& p, const std::string& name) {
    const RunRecord& r = p.runs[0];
    const Timing s = p.seconds();
    const MeasuredError& e = r.measured;
    std::string out = std::string(p.knee ? "<tr class=\"knee\">" : "<tr>") + "<td>" + html_text(name) + (p.knee ? ", the knee" : "") + "</td>";
    out += printed("<td>%.4f</td><td>%.4f</td><td>%.2f</td><td>%+.4f</td>", e.error, r.estimated_error,
                e.error > 0 ? r.estimated_error / e.error : 0.0, e.bias);
    out += printed("<td>%.3g</td><td>%.3g to %.3g</td><td>%zu</td>", s.median, s.low, s.high, p.runs.size());
    return out + printed("<td>%llu</td><td>%llu</td></tr>\n", static_cast<unsigned long long>(r.links.total()),
                      static_cast<unsigned long long>(r.rays));
}

std::string header(const std::string& first) {
    std::string out = "<thead><tr><th scope=\"col\">" + first + "</th>";
    for (const char* name : {"error", "estimate", "estimate / error", "bias", "seconds", "fastest to slowest", "runs", "links", "rays"})
        out += std::string("<th scope=\"col\">") + name + "</th>";
    return out + "</tr></thead>\n";
}

std::string table(const Tradeoff& t, bool knobs) {
    std::string rows;
    for (const Point& p : t.points) {
        if (p.runs.empty()) continue;
        if (knobs && is_baseline(t, p)) rows += row(p, "as it is");
        if (p.trial.knob.empty() != knobs) rows += row(p, knobs ? p.trial.knob + " " + p.trial.value : name_of(p.trial));
    }
    return "<table>" + header(knobs ? "knob" : "method and accuracy asked") + "<tbody>\n" + rows + "</tbody></table>\n";
}

std::string knobs_part(const Tradeoff& t) {
    const std::string chart = knobs_chart(t);
    if (chart.empty()) return "";
    return printed("<h2>Each knob alone</h2>\n<p>The reusable method asked for %g, one setting changed at a time.</p>\n", t.knobs_at) + chart +
           "<div class=\"wide\">" + table(t, true) + "</div>\n";
}

std::string colour_scale() {
    std::string stops;
    for (int k = 0; k <= kRampSteps; ++k) {
        const double share = double(k) / kRampSteps;
        const auto c = error_colour(kLeastShownError * std::pow(kMostShownError / kLeastShownError, share));
        stops += printed("%srgb(%d %d %d) %.1f%%", k > 0 ? ", " : "", int(c[0]), int(c[1]), int(c[2]), 100 * share);
    }
    return "<div class=\"ramp\" role=\"img\" aria-label=\"Scale of colours: dark is little error, light is much\" style=\"background: "
           "linear-gradient(to right, " + stops + ")\"></div><div class=\"ramp-text\"><span>" +
           printed("%g and less</span><span>%.2g</span><span>%g and more</span></div>\n", kLeastShownError,
                std::sqrt(kLeastShownError * kMostShownError), kMostShownError);
}

std::string pictures_part(const Tradeoff& t) {
    std::string options, figures, first;
    for (std::size_t i = 0; i < t.points.size(); ++i) {
        const Point& p = t.points[i];
        if (p.picture.empty() || p.runs.empty()) continue;
        const auto bytes = read_bytes(p.picture, kMostPictureBytes);
        if (!bytes) continue;  // deleted since: the page does without
        const std::string name = html_text(name_of(p.trial)), id = picture_id(i);
        if (first.empty() || p.knee) first = id;
        options += "<option value=\"" + id + "\">" + name + "</option>";
        figures += "<figure id=\"" + id + "\"><img alt=\"The scene in false colours: where the error of " + name +
                   " sits\" src=\"data:image/png;base64," + base64(*bytes) + "\"><figcaption>" + name +
                   printed(": error %.3g", p.runs[0].measured.error) + "</figcaption></figure>\n";
    }
    if (figures.empty()) return "";
    return "<h2>Where the error sits</h2>\n<p class=\"chosen\" hidden><label>Show <select id=\"choice\" data-first=\"" + first + "\">" +
           options + "</select></label></p>\n" + figures + colour_scale() +
           "<p class=\"soft\">|R − R<sub>true</sub>| of each triangle, relative to the root mean square of reflected radiosity in the "
           "scene; what the truth's noise explains is left out. Grey: nothing, or a back.</p>\n";
}

std::string not_run_part(const Tradeoff& t) {
    std::string items;
    for (const Point& p : t.points)
        if (p.runs.empty()) items += "<li>" + html_text(name_of(p.trial) + ": " + p.not_run) + "</li>\n";
    for (const NotSwept& n : t.not_swept) items += "<li>" + html_text(n.what + ": not swept, " + n.why) + "</li>\n";
    return items.empty() ? "<p>Everything asked for was run.</p>" : "<ul>" + items + "</ul>";
}

std::string facts(const Tradeoff& t) {
    const MachineFacts& m = t.machine;
    const auto fact = [](const char* name, const std::string& value) {
        return std::string("<dt>") + name + "</dt><dd>" + html_text(value) + "</dd>\n";
    };
    return fact("scene", t.scene + printed(": %zu triangles in %zu instances", t.triangles, t.instances)) +
           fact("truth", t.truth_from + " (" + t.truth_note + printed("), standard error %.3g", t.truth_error)) +
           fact("runs", printed("%d of each point", t.options.repeats)) + fact("program", m.program + ", built by " + m.compiler) +
           fact("processor", m.processor + printed(", %u cores, %u threads used", m.cores, m.threads)) +
           fact("memory", printed("%.1f GB", double(m.memory) / 1e9)) + fact("system", m.system) +
           fact("other work", printed("a load of %.2f in the minute before", m.load));
}

std::string summary(const Tradeoff& t) {
    for (const Point& p : t.points)
        if (p.knee && p.trial.method == Method::Reusable)
            return printed("The knee of the reusable method: asked for %g it errs by %.3g and takes ", *p.trial.solve.accuracy,
                        p.runs[0].measured.error) +
                   seconds_text(p.seconds()) + printed(". The scene has %zu triangles in %zu instances.", t.triangles, t.instances);
    return printed("A scene of %zu triangles in %zu instances.", t.triangles, t.instances);
}

}  // namespace

std::string tradeoff_html(const Tradeoff& t) {
    const std::string title = "What accuracy costs in time: " + std::filesystem::path(t.scene).filename().string();
    const std::map<std::string_view, std::string> parts{{"title", html_text(title)},
                                                        {"summary", html_text(summary(t))},
                                                        {"methods", methods_chart(t)},
                                                        {"methods_table", table(t, false)},
                                                        {"knobs", knobs_part(t)},
                                                        {"pictures", pictures_part(t)},
                                                        {"not_run", not_run_part(t)},
                                                        {"facts", facts(t)}};
    std::string out;
    std::string_view rest = page_html;
    for (std::size_t at = rest.find("{{"); at != std::string_view::npos; at = rest.find("{{")) {
        const std::size_t end = rest.find("}}", at);
        out += rest.substr(0, at);
        out += parts.at(rest.substr(at + 2, end - at - 2));
        rest.remove_prefix(end + 2);
    }
    return out + std::string(rest);
}

}  // namespace rro
