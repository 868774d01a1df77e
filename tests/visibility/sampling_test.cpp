#include <catch2/catch.hpp>

#include "tests/support/shafts.h"

using namespace rro;
using namespace rro::test;

namespace {

/// A shaft between points on a line, and who passes: those of which the first coordinate lies below `share`.
Shaft unit_shaft(std::uint64_t seed) {
    Shaft s;
    s.seed = seed;
    s.segment = [](const std::array<float, 4>& u) { return Segment{{double(u[0]), double(u[2]), 0}, {}, {}, {}}; };
    return s;
}

auto below(double share) {
    return [share](const Segment& s) { return s.p.x < share ? 1.0 : 0.0; };
}

Demand demand_of(StopRule rule, double deviation, LinePoints points = LinePoints::Sobol) {
    Demand d;
    d.rule = rule;
    d.deviation = deviation;
    d.points = points;
    return d;
}

}  // namespace

TEST_CASE("rounds are the paper's squares up to the limit", "[visibility][sampling]") {
    const Demand d = demand_of(StopRule::Paper, 0);
    std::uint32_t drawn = 0;
    for (std::uint32_t root = 4; root <= 12; ++root) {
        drawn = next_round(d, drawn);
        CHECK(drawn == root * root);
    }
    CHECK(next_round(d, drawn) == drawn);
}

TEST_CASE("the paper's rule believes rays that agree, Laplace's does not", "[visibility][sampling]") {
    const auto rays = [&](StopRule rule, double deviation) {
        return sample(unit_shaft(1), demand_of(rule, deviation), below(2)).rays;
    };
    CHECK(rays(StopRule::Paper, 0.05) == 16);
    // v = 17/18 at 16 rays: a deviation of 0.057; v = 26/27 at 25: 0.038.
    CHECK(rays(StopRule::Laplace, 0.05) == 25);
    CHECK(rays(StopRule::Laplace, 0.06) == 16);
}

TEST_CASE("adaptive sampling stops where the deviation asked is reached", "[visibility][sampling]") {
    // Half pass: 0.5 / sqrt(m) is below 0.07 from 64 on (51 needed); Sobol points halve it there exactly.
    for (const StopRule rule : {StopRule::Paper, StopRule::Laplace}) {
        const Tally t = sample(unit_shaft(7), demand_of(rule, 0.07), below(0.5));
        CHECK(t.rays == 64);
        CHECK(outcome(demand_of(rule, 0.07), t).mean == 0.5);
    }
}

TEST_CASE("independent points err by the binomial deviation, Owen-scrambled ones by less", "[visibility][sampling]") {
    constexpr int kTrials = 2000;
    const auto error = [&](LinePoints points) {
        double squares = 0, variance = 0;
        for (int k = 0; k < kTrials; ++k) {
            const Demand d = fixed_rays(64, points);
            // What passes depends on two coordinates: an edge that runs across.
            const auto passes = [](const Segment& s) { return s.p.x + s.p.y < 0.9 ? 1.0 : 0.0; };
            const Transmittance t = outcome(d, sample(unit_shaft(mix64(static_cast<std::uint64_t>(k))), d, passes));
            squares += std::pow(t.mean - 0.405, 2) / kTrials;
            variance += t.variance / kTrials;
        }
        return std::array{std::sqrt(squares), std::sqrt(variance)};
    };
    const double binomial = std::sqrt(0.405 * 0.595 / 64);
    const auto random = error(LinePoints::Independent), sobol = error(LinePoints::Sobol);
    // 2000 squares: right to 1.6 % in the root; three of those, and Laplace's rule within 1 %.
    CHECK(random[0] == Approx(binomial).epsilon(0.05));
    CHECK(random[1] == Approx(random[0]).epsilon(0.06));
    CHECK(sobol[0] < 0.6 * binomial);
    CHECK(sobol[1] > sobol[0]);  // the estimate is on the safe side of it
}

TEST_CASE("rays that agree are doubted beside others that do not", "[visibility][sampling]") {
    std::vector<Tally> tallies(5);
    for (Tally& t : tallies) t.drawn = t.rays = 16;
    tallies[0].passed = tallies[1].passed = 16;  // open, open, edge, dark, dark
    tallies[2].passed = 7;
    const std::vector<std::vector<std::uint32_t>> line{{1}, {0, 2}, {1, 3}, {2, 4}, {3}};
    CHECK(doubtful(tallies, line) == std::vector<std::uint32_t>{1, 3});
    tallies[2].passed = 16;
    CHECK(doubtful(tallies, line) == std::vector<std::uint32_t>{2, 3});
    for (Tally& t : tallies) t.drawn = t.rays = 36;
    CHECK(doubtful(tallies, line).empty());
}

TEST_CASE("segments that do not face one another ask no ray", "[visibility][sampling]") {
    Shaft s = unit_shaft(1);
    s.segment = [](const std::array<float, 4>& u) {
        Segment line{{double(u[0]), 0, 0}, {}, {}, {}};
        line.weight = double(u[0]) - 0.5;
        return line;
    };
    const Tally t = sample(s, fixed_rays(64), below(0.75));
    CHECK(t.rays == 32);
    // Weighted: the integral of x - 1/2 from 1/2 to 3/4 over that to 1.
    CHECK(outcome(fixed_rays(64), t).mean == Approx(0.25).margin(0.02));
}
