#include "solver/tradeoff/chart.h"
#include "format/tool/printed.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace rro {
namespace {

// In units of the view box.
constexpr double kWidth = 760, kHeight = 440, kLeft = 74, kRight = 20, kTop = 16, kBottom = 58;
constexpr double kRadius = 5;
constexpr double kMargin = 1.25;          // of the axes beyond the outermost marks, as a factor
constexpr std::size_t kMostTicks = 8;  // more labels would touch where they are dense
constexpr double kLegendRow = 20;
constexpr double kLetter = 7.5, kLetterHeight = 14;  // of labels, about

/// One axis: values to places.
struct Axis {
    double low = std::numeric_limits<double>::infinity(), high = 0;
    double from = 0, to = 0;  // places of low and high

    void add(double value) {
        if (!(value > 0) || !std::isfinite(value)) return;
        low = std::min(low, value), high = std::max(high, value);
    }
    void widen() { low /= kMargin, high *= kMargin; }
    double place(double value) const {
        const double share = std::log(std::max(value, low) / low) / std::log(high / low);
        return from + (to - from) * std::min(share, 1.0);
    }
};

std::string tick_text(double value) {
    return value >= 1e-3 && value < 1e4 ? printed("%g", value) : printed("%.0e", value);
}

std::string grid(const Chart& chart, const Axis& x, const Axis& y) {
    std::string out = "<g class=\"grid\">";
    for (const double v : log_ticks(x.low, x.high))
        out += printed("<path d=\"M%.1f %.1fV%.1f\"/><text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">%s</text>", x.place(v), y.to,
                    y.from, x.place(v), y.from + 18, tick_text(v).c_str());
    for (const double v : log_ticks(y.low, y.high))
        out += printed("<path d=\"M%.1f %.1fH%.1f\"/><text x=\"%.1f\" y=\"%.1f\" text-anchor=\"end\">%s</text>", x.from, y.place(v), x.to,
                    x.from - 8, y.place(v) + 4, tick_text(v).c_str());
    out += printed("<text class=\"name\" x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">", (x.from + x.to) / 2, y.from + 42) +
           html_text(chart.x_name) + "</text>";
    out += printed("<text class=\"name\" transform=\"translate(18 %.1f) rotate(-90)\" text-anchor=\"middle\">", (y.from + y.to) / 2) +
           html_text(chart.y_name) + "</text></g>";
    return out;
}

/// Shapes tell series apart where colours do not.
std::string shape(int style, double x, double y) {
    const double r = kRadius;
    switch (style % 3) {
        case 0: return printed("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"%.1f\"/>", x, y, r);
        case 1: return printed("<path d=\"M%.1f %.1fl%.1f %.1fh%.1fz\"/>", x, y - 1.2 * r, 1.2 * r, 2.2 * r, -2.4 * r);
        default: return printed("<rect x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\"/>", x - 0.9 * r, y - 0.9 * r, 1.8 * r, 1.8 * r);
    }
}

/// Labels beside marks, none over another or over a mark; one without room is left out, as pointing at the mark tells it.
class Labels {
  public:
    void keep_clear(double x0, double y0, double x1, double y1) { taken_.push_back({x0, y0, x1, y1}); }

    std::string place(const std::string& label, double x, double y) {
        if (label.empty()) return "";
        const double width = kLetter * static_cast<double>(label.size());
        for (const bool left : {false, true})
            for (const double below : {-8.0, 18.0, 5.0}) {
                const double start = left ? x - 12 - width : x + 12, base = y + below;
                const Area area{start, base - kLetterHeight, start + width, base + 3};
                if (area.x0 < kLeft || area.x1 > kWidth || area.y1 > kHeight - kBottom || meets_any(area)) continue;
                taken_.push_back(area);
                return printed("<text x=\"%.1f\" y=\"%.1f\"%s>", left ? x - 12 : x + 12, base, left ? " text-anchor=\"end\"" : "") +
                       html_text(label) + "</text>";
            }
        return "";
    }

  private:
    struct Area {
        double x0, y0, x1, y1;
    };
    bool meets_any(const Area& a) const {
        return std::any_of(taken_.begin(), taken_.end(), [&](const Area& b) {
            return a.x0 < b.x1 && b.x0 < a.x1 && a.y0 < b.y1 && b.y0 < a.y1;
        });
    }
    std::vector<Area> taken_;
};

std::string levels(const Chart& chart, const Axis& x, const Axis& y, Labels& labels) {
    std::string out;
    for (const Level& level : chart.levels) {
        if (level.y < y.low || level.y > y.high) continue;
        out += printed("<path class=\"level\" d=\"M%.1f %.1fH%.1f\"/>", x.from, y.place(level.y), x.to);
        out += printed("<text class=\"level\" x=\"%.1f\" y=\"%.1f\" text-anchor=\"end\">", x.to - 4, y.place(level.y) - 5) +
               html_text(level.name) + "</text>";
        labels.keep_clear(x.to - 4 - kLetter * static_cast<double>(level.name.size()), y.place(level.y) - 5 - kLetterHeight, x.to, y.place(level.y));
    }
    return out;
}

std::string mark_svg(const Mark& m, int style, const Axis& ax, const Axis& ay, Labels& labels) {
    const double x = ax.place(m.x), y = ay.place(m.y);
    const std::string text = html_text(m.text);
    std::string out = "<g class=\"mark\" tabindex=\"0\" role=\"" + std::string(m.target.empty() ? "img" : "button") + "\" aria-label=\"" +
                      text + "\" data-text=\"" + text + "\"";
    if (!m.target.empty()) out += " data-target=\"" + html_text(m.target) + "\"";
    out += printed("><circle class=\"hit\" cx=\"%.1f\" cy=\"%.1f\" r=\"12\"/>", x, y);
    if (m.x_high > m.x_low) out += printed("<path class=\"bar\" d=\"M%.1f %.1fH%.1f\"/>", ax.place(m.x_low), y, ax.place(m.x_high));
    if (m.y_high > m.y_low) out += printed("<path class=\"bar\" d=\"M%.1f %.1fV%.1f\"/>", x, ay.place(m.y_low), ay.place(m.y_high));
    out += shape(style, x, y);
    if (m.ring) out += printed("<circle class=\"ring\" cx=\"%.1f\" cy=\"%.1f\" r=\"11\"/>", x, y);
    return out + labels.place(m.label, x, y) + "</g>";
}

std::string series_svg(const Series& s, const Axis& x, const Axis& y, Labels& labels) {
    std::string out = printed("<g class=\"series s%d\">", s.style);
    if (s.line) {
        out += "<path class=\"line\" d=\"";
        for (std::size_t i = 0; i < s.marks.size(); ++i)
            out += printed("%c%.1f %.1f", i == 0 ? 'M' : 'L', x.place(s.marks[i].x), y.place(s.marks[i].y));
        out += "\"/>";
    }
    for (const Mark& m : s.marks) out += mark_svg(m, s.style, x, y, labels);
    return out + "</g>";
}

std::string legend(const Chart& chart) {
    std::string out;
    double y = kHeight + 4;
    for (const Series& s : chart.series) {
        if (s.marks.empty()) continue;
        out += printed("<g class=\"series s%d\">", s.style) + shape(s.style, kLeft + 8, y) +
               printed("<text x=\"%.1f\" y=\"%.1f\">", kLeft + 22, y + 4) + html_text(s.name) + "</text></g>";
        y += kLegendRow;
    }
    return out;
}

}  // namespace

std::string html_text(const std::string& text) {
    std::string out;
    for (const char c : text) {
        if (c == '&') out += "&amp;";
        else if (c == '<') out += "&lt;";
        else if (c == '>') out += "&gt;";
        else if (c == '"') out += "&quot;";
        else if (c == '\'') out += "&#39;";
        else out += c;
    }
    return out;
}

std::vector<double> log_ticks(double low, double high) {
    const std::vector<std::vector<double>> steps = {{1, 2, 3, 4, 5, 6, 7, 8, 9}, {1, 2, 5}, {1}};
    std::vector<double> ticks;
    for (const std::vector<double>& digits : steps) {
        ticks.clear();
        for (int decade = static_cast<int>(std::floor(std::log10(low))); std::pow(10.0, decade) <= high; ++decade)
            for (const double digit : digits)
                if (const double v = digit * std::pow(10.0, decade); v >= low && v <= high) ticks.push_back(v);
        if (ticks.size() <= kMostTicks) break;
    }
    return ticks;
}

std::string chart_svg(const Chart& chart) {
    Axis x, y;
    std::size_t named = 0;
    for (const Series& s : chart.series) {
        named += s.marks.empty() ? 0 : 1;
        for (const Mark& m : s.marks) {
            for (const double v : {m.x, m.x_low, m.x_high}) x.add(v);
            for (const double v : {m.y, m.y_high}) y.add(v);
            if (m.y_low > 0.3 * m.y) y.add(m.y_low);  // a longer bar may leave the chart
        }
    }
    if (x.high <= 0 || y.high <= 0) return "";
    for (const Level& level : chart.levels) y.add(level.y);
    x.widen(), y.widen();
    x.from = kLeft, x.to = kWidth - kRight;
    y.from = kHeight - kBottom, y.to = kTop;
    std::string out = "<svg id=\"" + chart.id + "\" class=\"chart\" role=\"group\" aria-label=\"" + html_text(chart.title) +
                      "\" aria-describedby=\"" + chart.id + "-text\" " +
                      printed("viewBox=\"0 0 %.0f %.0f\">", kWidth, kHeight + kLegendRow * static_cast<double>(named));
    out += "<desc id=\"" + chart.id + "-text\">" + html_text(chart.description) + "</desc>";
    Labels beside;
    out += grid(chart, x, y) + levels(chart, x, y, beside);
    for (const Series& s : chart.series)
        for (const Mark& m : s.marks) {
            const double px = x.place(m.x), py = y.place(m.y);
            beside.keep_clear(px - kRadius, py - kRadius, px + kRadius, py + kRadius);
        }
    for (const Series& s : chart.series) out += series_svg(s, x, y, beside);
    return out + legend(chart) + "</svg>\n";
}

}  // namespace rro
