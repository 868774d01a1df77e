#include "solver/factors/closure.h"

#include <catch2/catch.hpp>
#include <cmath>

using namespace rro;

namespace {

Factors matrix(const std::vector<double>& area, const std::vector<std::vector<double>>& values, double error = 1e-3) {
    Factors f;
    f.area = area;
    for (std::size_t i = 0; i < area.size(); ++i) {
        f.names.push_back(std::string(1, static_cast<char>('a' + i)));
        f.rows.emplace_back();
        for (std::uint32_t j = 0; j < area.size(); ++j)
            if (values[i][j] != 0) f.rows[i].push_back({j, static_cast<float>(error), values[i][j]});
    }
    return f;
}

double value(const Factors& f, std::uint32_t i, std::uint32_t j) {
    for (const Factor& factor : f.rows[i])
        if (factor.to == j) return factor.value;
    return 0;
}

}  // namespace

TEST_CASE("closure and reciprocity are measured as they are", "[factors][closure]") {
    const Factors f = matrix({1, 2}, {{0, 0.9}, {0.5, 0.5}});
    const ClosureReport report = measure_closure(f);
    CHECK(report.row_sum[0] == Approx(0.9));
    CHECK(report.largest_defect == Approx(0.1));
    CHECK(report.worst_row == 0);
    CHECK(report.mean_defect == Approx(0.1 / 3));
    CHECK(report.largest_asymmetry == Approx(0.1));  // 0.9 against 1, by the smaller area 1
}

// Rows of a perturbed enclosure come back to 1; exchanges stay symmetric and not negative; zeros stay; and what closed
// before does not move.
TEST_CASE("closing keeps reciprocity, zeros and signs", "[factors][closure]") {
    Factors f = matrix({1, 2, 4}, {{0, 0.301, 0.7}, {0.15, 0, 0.852}, {0.174, 0.424, 0.4}});
    auto closing = close_rows(f);
    REQUIRE(closing);
    for (std::uint32_t i = 0; i < 3; ++i) {
        double sum = 0;
        for (std::uint32_t j = 0; j < 3; ++j) {
            sum += value(f, i, j);
            CHECK(value(f, i, j) >= 0);
            CHECK(f.area[i] * value(f, i, j) == Approx(f.area[j] * value(f, j, i)).epsilon(1e-12));
        }
        CHECK(sum == Approx(1).epsilon(1e-9));
        CHECK(closing->moved[i] < 0.01);
        CHECK(closing->moved[i] > 0);
    }
    CHECK(value(f, 0, 0) == 0);
    CHECK(value(f, 1, 1) == 0);
    Factors again = f;
    auto second = close_rows(again);
    REQUIRE(second);
    CHECK(second->largest_move < 1e-9);
}

// By hand: one exchange K = 0.8 between equal areas 1, and each group with itself 0.1. Minimal sum (K' - K)^2 / K with
// K' = K (1 + m_i + m_j), m equal by symmetry: 0.9 (1 + 2 m) = 1.
TEST_CASE("closing moves all exchanges of a symmetric pair alike", "[factors][closure]") {
    Factors f = matrix({1, 1}, {{0.1, 0.8}, {0.8, 0.1}});
    REQUIRE(close_rows(f));
    CHECK(value(f, 0, 1) == Approx(0.8 / 0.9).epsilon(1e-12));
    CHECK(value(f, 0, 0) == Approx(0.1 / 0.9).epsilon(1e-12));
}

// Two groups of unlike areas that see each other alone cannot both be enclosed.
TEST_CASE("what cannot close is refused by name", "[factors][closure]") {
    Factors f = matrix({1, 2}, {{0, 0.9}, {0.45, 0}});
    const auto closing = close_rows(f);
    REQUIRE(!closing);
    CHECK(closing.error().kind == ErrorKind::Failed);
    CHECK(closing.error().message.find("row of") != std::string::npos);
}

// Two estimates of one exchange are averaged by the inverse of their variances before they close.
TEST_CASE("the better of two estimates counts for more", "[factors][closure]") {
    Factors f = matrix({1, 1}, {{0.5, 0.5}, {0.6, 0.5}});
    f.rows[0][1].standard_error = 1e-4f;
    f.rows[1][0].standard_error = 1e-2f;
    REQUIRE(close_rows(f));
    CHECK(value(f, 0, 1) == Approx(0.5).epsilon(1e-4));
}
