#include <cmath>
#include <nlohmann/json.hpp>

#include "format/tool/printed.h"
#include "solver/study/compare.h"

namespace rro {
namespace {

using nlohmann::json;

const char* name_of(TimingVerdict verdict) {
    switch (verdict) {
        case TimingVerdict::Faster: return "faster";
        case TimingVerdict::Slower: return "slower";
        case TimingVerdict::Same: return "no difference beyond the noise";
    }
    return "";
}

json number(double value) {
    return std::isfinite(value) ? json(value) : json(nullptr);
}

unsigned long long count(std::uint64_t n) {
    return n;
}

double change_percent(const Pairing& p) {
    return p.base > 0 ? 100 * (double(p.head) / double(p.base) - 1) : 0;
}

double change_of(const Comparison& c, const std::string& what) {
    for (const Pairing& p : c.sizes)
        if (p.what == what) return change_percent(p);
    return 0;
}

std::string percent(double share) {
    return printed("%.3g %%", 100 * share);
}

std::string archives_sentence(const Comparison& c) {
    std::string text = printed("%zu of %zu archives changed", c.changed, c.archives);
    for (const Making& m : c.made)
        if (m.base != m.head) text += "; " + m.what + ": " + m.base + " -> " + m.head;
    return text + printed("; %+.1f %% bytes.", change_of(c, "bytes of archives"));
}

std::string time_sentence(const Comparison& c) {
    const PhaseTimes& t = c.times.back();
    if (t.verdict == TimingVerdict::Same)
        return printed("no difference beyond the noise: head takes %.3f of base's time, single runs %.3f to %.3f.", t.ratio, t.low, t.high);
    return printed("head is %s: it takes %.3f of base's time, single runs %.3f to %.3f; %+.1f %% links.", name_of(t.verdict), t.ratio,
                t.low, t.high, change_of(c, "links"));
}

/// The difference of the results, and what the solves' own errors make of it: two solves that err independently differ by the
/// root of the sum of their squares.
std::string light_sentence(const Comparison& c) {
    const double difference = c.radiosity.relative_rms;
    if (difference == 0) return "the same, bit for bit.";
    const double expected = std::hypot(c.base_error, c.head_error);
    return "differs by " + percent(difference) + (difference <= expected ? ", no more than the " : ", MORE than the ") +
           percent(expected) + " that the solves' own errors allow (estimated: " + percent(c.base_error) + " and " +
           percent(c.head_error) + ").";
}

std::string where_sentence(const RadiosityDifference& r) {
    std::string text;
    if (r.largest > 0) {
        text += printed("Most, by %.3g W/m2, at triangle %u of ", r.largest, r.triangle) + r.instance;
        if (!r.worst_instance.empty())
            text += "; of whole instances, " + r.worst_instance + " by " + percent(r.worst_relative_rms);
        text += ". ";
    }
    if (r.unmatched > 0) text += printed("%llu triangle sides are in one version only. ", count(r.unmatched));
    return text;
}

/// What the thresholds say, or nothing where none was given.
std::vector<std::string> gates(const Comparison& c) {
    std::vector<std::string> lines;
    if (c.options.fail_if_slower)
        lines.push_back(printed("%s: total time, at most %.4g times the base's, found %.4g", c.too_slow ? "FAILED" : "passed",
                             *c.options.fail_if_slower, c.times.back().ratio));
    if (c.options.fail_if_differs)
        lines.push_back(printed("%s: difference of radiosity, at most %.3g, found %.3g",
                             c.too_different ? "FAILED" : "passed", *c.options.fail_if_differs, c.radiosity.relative_rms));
    return lines;
}

}  // namespace

std::string comparison_text(const Comparison& c) {
    std::string text = c.scene + ": base " + c.options.base.string() + ", head " + c.options.head.string() +
                       printed(", %d runs each, interleaved\n\n", c.options.runs);
    text += "Archives   " + archives_sentence(c) + "\nTime       " + time_sentence(c) + "\nRadiosity  " + light_sentence(c) + "\n";
    if (const std::string where = where_sentence(c.radiosity); !where.empty()) text += "           " + where + "\n";
    for (const std::string& gate : gates(c)) text += gate + "\n";
    text += printed("\n%-11s %20s %20s %11s  %-15s %s\n", "seconds", "base (spread)", "head (spread)", "head / base", "single runs",
                 "verdict");
    for (const PhaseTimes& t : c.times)
        text += printed("%-11s %10.4f (%7.4f) %10.4f (%7.4f) %11.3f  %6.3f - %6.3f %s\n", t.phase.c_str(), t.base, t.base_spread, t.head,
                     t.head_spread, t.ratio, t.low, t.high, name_of(t.verdict));
    text += printed("\n%-28s %14s %14s %9s\n", "", "base", "head", "change");
    for (const Pairing& p : c.sizes)
        text += printed("%-28s %14llu %14llu %+8.1f%%\n", p.what.c_str(), count(p.base), count(p.head), change_percent(p));
    return text + printed("%-28s %14.3g %14.3g\n", "estimated error", c.base_error, c.head_error);
}

std::string comparison_json(const Comparison& c) {
    json times = json::array(), sizes = json::array(), made = json::object();
    for (const PhaseTimes& t : c.times)
        times.push_back({{"phase", t.phase},
                         {"base", t.base},
                         {"head", t.head},
                         {"base_spread", t.base_spread},
                         {"head_spread", t.head_spread},
                         {"ratio", number(t.ratio)},
                         {"ratio_low", number(t.low)},
                         {"ratio_high", number(t.high)},
                         {"verdict", t.verdict == TimingVerdict::Same ? "same" : name_of(t.verdict)}});
    for (const Pairing& p : c.sizes) sizes.push_back({{"what", p.what}, {"base", p.base}, {"head", p.head}});
    for (const Making& m : c.made) made[m.what] = {{"base", m.base}, {"head", m.head}};
    const RadiosityDifference& r = c.radiosity;
    const json all = {{"format", "rro-comparison/1"},
                      {"scene", c.scene},
                      {"base", c.options.base.string()},
                      {"head", c.options.head.string()},
                      {"runs", c.options.runs},
                      {"archives", c.archives},
                      {"archives_changed", c.changed},
                      {"made", made},
                      {"seconds", times},
                      {"sizes", sizes},
                      {"estimated_error", {{"base", number(c.base_error)}, {"head", number(c.head_error)}}},
                      {"radiosity",
                       {{"relative_rms", number(r.relative_rms)},
                        {"largest", number(r.largest)},
                        {"instance", r.instance},
                        {"triangle", r.triangle},
                        {"worst_instance", r.worst_instance},
                        {"worst_relative_rms", number(r.worst_relative_rms)},
                        {"unmatched", r.unmatched}}},
                      {"too_slow", c.too_slow},
                      {"too_different", c.too_different},
                      {"passed", c.passed()}};
    return all.dump(2, ' ', false, json::error_handler_t::replace) + "\n";
}

std::string comparison_markdown(const Comparison& c) {
    std::string text = "### `" + c.scene + "`: `" + c.options.base.string() + "` to `" + c.options.head.string() + "`\n\n";
    text += "- **Archives:** " + archives_sentence(c) + "\n- **Time:** " + time_sentence(c) +
            printed(" %d runs each, interleaved.", c.options.runs) + "\n- **Radiosity:** " + light_sentence(c) + " " +
            where_sentence(c.radiosity) + "\n";
    for (const std::string& gate : gates(c)) text += "- " + gate + "\n";
    text += "\n| seconds | base | head | head / base | single runs | verdict |\n|---|---:|---:|---:|---:|---|\n";
    for (const PhaseTimes& t : c.times)
        text += printed("| %s | %.4f | %.4f | %.3f | %.3f - %.3f | %s |\n", t.phase.c_str(), t.base, t.head, t.ratio, t.low,
                     t.high, name_of(t.verdict));
    text += "\n| | base | head | change |\n|---|---:|---:|---:|\n";
    for (const Pairing& p : c.sizes)
        text += printed("| %s | %llu | %llu | %+.1f %% |\n", p.what.c_str(), count(p.base), count(p.head), change_percent(p));
    return text + printed("| estimated error | %.3g | %.3g | |\n", c.base_error, c.head_error);
}

}  // namespace rro
