#include "solver/tradeoff/chart.h"

#include <catch2/catch.hpp>
#include <string>

#include "solver/tradeoff/error_picture.h"

using namespace rro;
using Catch::Matchers::Contains;

namespace {

double number_after(const std::string& text, const std::string& what, std::size_t from = 0) {
    const std::size_t at = text.find(what, from);
    REQUIRE(at != std::string::npos);
    return std::stod(text.substr(at + what.size()));
}

Chart chart_of(std::vector<Mark> marks) {
    return {"c", "A title", "", "x", "y", {{"curve", 0, true, std::move(marks)}}, {}};
}

}  // namespace

TEST_CASE("chart: ticks are readable numbers, fewer where there would be many", "[chart]") {
    CHECK(log_ticks(0.75, 2.5) == std::vector<double>{0.8, 0.9, 1, 2});
    CHECK(log_ticks(0.3, 6) == std::vector<double>{0.5, 1, 2, 5});
    CHECK(log_ticks(1e-4, 1e4).size() == 9);
}

TEST_CASE("chart: equal factors are equal steps, and less error is lower", "[chart]") {
    const std::string svg = chart_svg(chart_of({{1, 0.4, 1, 1, 0.4, 0.4, "a", "", false, ""},
                                                {10, 0.2, 10, 10, 0.2, 0.2, "b", "", false, ""},
                                                {100, 0.1, 100, 100, 0.1, 0.1, "c", "", false, ""}}));
    std::size_t at = 0;
    double x[3], y[3];
    for (int k = 0; k < 3; ++k) {
        at = svg.find("class=\"hit\"", at + 1);
        x[k] = number_after(svg, "cx=\"", at);
        y[k] = number_after(svg, "cy=\"", at);
    }
    CHECK(x[1] - x[0] == Approx(x[2] - x[1]).margin(0.2));  // places have one decimal
    CHECK(y[1] - y[0] == Approx(y[2] - y[1]).margin(0.2));
    CHECK(x[1] > x[0]);
    CHECK(y[1] > y[0]);  // SVG counts from the top
}

TEST_CASE("chart: texts are escaped, marks can be reached by keyboard, labels do not cover one another", "[chart]") {
    const Mark mark{1, 1, 1, 1, 1, 1, "say \"<hi>\"", "same", false, ""};
    const std::string svg = chart_svg(chart_of(std::vector<Mark>(20, mark)));
    CHECK_THAT(svg, Contains("say &quot;&lt;hi&gt;&quot;") && Contains("tabindex=\"0\"") && Contains("aria-label=\"A title\""));
    std::size_t labels = 0;
    for (std::size_t at = svg.find(">same<"); at != std::string::npos; at = svg.find(">same<", at + 1)) ++labels;
    CHECK(labels >= 1);
    CHECK(labels <= 6);  // the places around one mark
    CHECK(chart_svg(chart_of({})).empty());
}

TEST_CASE("error picture: lightness grows with the error, and ends are held", "[chart]") {
    double last = -1;
    for (double e = kLeastShownError; e <= kMostShownError; e *= 1.1) {
        const auto c = error_colour(e);
        const double lightness = 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
        CHECK(lightness > last);
        last = lightness;
    }
    CHECK(error_colour(0) == error_colour(kLeastShownError));
    CHECK(error_colour(1e9) == error_colour(kMostShownError));
}
