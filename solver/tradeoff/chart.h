// Log-log charts as SVG.
#pragma once

#include <string>
#include <vector>

namespace rro {

/// A point of a curve.
struct Mark {
    double x = 0, y = 0;            // above 0
    double x_low = 0, x_high = 0;   // bars; none where equal
    double y_low = 0, y_high = 0;   // y_low may be 0: the bar leaves the chart
    std::string text;               // what is read when it is pointed at or reached by keyboard
    std::string label;              // drawn beside it; may be empty
    bool ring = false;              // drawn around it
    std::string target;             // page anchor that it chooses; may be empty
};

/// A curve, or marks without a line.
struct Series {
    std::string name;
    int style = 0;  // colour and shape of the page's style sheet, 0 to 7
    bool line = true;
    std::vector<Mark> marks;
};

/// A level that means something, such as the noise of what is measured by.
struct Level {
    double y = 0;
    std::string name;
};

/// A chart of curves over two logarithmic axes.
struct Chart {
    std::string id, title, description;  // read aloud
    std::string x_name, y_name;
    std::vector<Series> series;
    std::vector<Level> levels;
};

/// One <svg> element; colours are the page's. Marks can be reached by keyboard. An empty string where there is no mark.
std::string chart_svg(const Chart& chart);

/// The values of a logarithmic axis with a tick, from `low` to `high`: 1 to 9 of each decade; 1, 2 and 5, or powers of ten
/// alone, where those would be too many.
std::vector<double> log_ticks(double low, double high);

/// &, <, > and quotes as entities.
std::string html_text(const std::string& text);

}  // namespace rro
