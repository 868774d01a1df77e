#include "format/direction_grid.h"

#include <cmath>
#include <numbers>
#include <numeric>

#include <catch2/catch.hpp>

#include "format/sample_points.h"

using namespace rro;

namespace {

constexpr double kPi = std::numbers::pi;

/// A fixed spread of directions over the whole sphere.
Vec3 test_direction(std::uint64_t i) {
    const auto unit = [](std::uint64_t key) { return double(mix64(key) >> 11) * 0x1p-53; };
    const double y = 2 * unit(2 * i) - 1, angle = 2 * kPi * unit(2 * i + 1), r = std::sqrt(1 - y * y);
    return {r * std::cos(angle), y, r * std::sin(angle)};
}

template <class Function>
std::vector<double> table_of(const DirectionGrid& grid, const Function& f) {
    std::vector<double> table;
    for (std::uint32_t i = 0; i < grid.size(); ++i) table.push_back(f(grid.direction(i)));
    return table;
}

const auto maps = {GridMap::Octahedral, GridMap::LatLong};

}  // namespace

TEST_CASE("weights are shares, taps are nodes", "[direction_grid]") {
    for (const GridMap map : maps)
        for (const std::uint32_t n : {2u, 3u, 12u}) {
            const DirectionGrid grid(map, n);
            for (std::uint64_t i = 0; i < 2000; ++i) {
                const DirectionTaps t = grid.taps(test_direction(i));
                double sum = 0;
                for (std::size_t k = 0; k < 4; ++k) {
                    REQUIRE(t.node[k] < grid.size());
                    REQUIRE(t.weight[k] >= 0);
                    sum += t.weight[k];
                }
                REQUIRE(sum == Approx(1).epsilon(1e-6));  // four float roundings
            }
        }
}

TEST_CASE("axes, poles and seams have taps too", "[direction_grid]") {
    for (const GridMap map : maps)
        for (const std::uint32_t n : {2u, 3u, 12u}) {
            const DirectionGrid grid(map, n);
            const std::vector<double> ones(grid.size(), 1.0);
            for (int axis = 0; axis < 3; ++axis)
                for (const double sign : {1.0, -1.0}) {
                    Vec3 w{-0.0, -0.0, -0.0};
                    w[axis] = sign * 1e-3;  // need not be unit
                    REQUIRE(grid.interpolate<double>(ones, w) == Approx(1).epsilon(1e-6));
                }
        }
}

TEST_CASE("a node's own direction gives the node's own value", "[direction_grid]") {
    for (const GridMap map : maps)
        for (const std::uint32_t n : {2u, 5u, 12u}) {
            const DirectionGrid grid(map, n);
            for (std::uint32_t node = 0; node < grid.size(); ++node) {
                CHECK(length(grid.direction(node)) == Approx(1).epsilon(1e-14));
                const DirectionTaps t = grid.taps(grid.direction(node));
                double own = 0;
                for (std::size_t k = 0; k < 4; ++k) own += t.node[k] == node ? double(t.weight[k]) : 0;
                CHECK(own == Approx(1).epsilon(1e-6));
            }
        }
}

TEST_CASE("interpolation is continuous everywhere, seams and poles included", "[direction_grid]") {
    // A table of unrelated numbers jumps wherever a neighbour is wrong. A step of 1e-7 may change an interpolated value by
    // about 1e-7 * n / distance to the pole, and pairs closer than 1e-4 to a pole are rare: 1e-3 leaves room for both.
    for (const GridMap map : maps)
        for (const std::uint32_t n : {2u, 3u, 12u, 13u}) {
            const DirectionGrid grid(map, n);
            std::vector<double> table;
            for (std::uint32_t i = 0; i < grid.size(); ++i) table.push_back(double(mix64(i) % 1000) / 1000);
            const auto jump = [&](const Vec3& a, const Vec3& b) {
                return std::abs(grid.interpolate<double>(table, a) - grid.interpolate<double>(table, b));
            };
            for (int i = 0; i < 1000; ++i) {
                const double angle = 2 * kPi * (i + 0.5) / 1000, s = std::sin(angle), c = std::cos(angle), e = 1e-7;
                REQUIRE(jump({c, s, e}, {c, s, -e}) < 1e-3);   // octahedral fold, latlong seam at longitude 0 and pi
                REQUIRE(jump({e, s, c}, {-e, s, c}) < 1e-3);   // the other edges
                REQUIRE(jump({c, -e, s}, {c, e, s}) < 1e-3);   // the equator
                const double low = 1e-2;                       // a small circle about each pole, across it in longitude
                REQUIRE(jump({low * c, 1, low * s}, {low * std::cos(angle + e), 1, low * std::sin(angle + e)}) < 1e-3);
                REQUIRE(jump({e * c, 1, e * s}, {-e * c, 1, -e * s}) < 1e-3);    // over the pole
                REQUIRE(jump({e * c, -1, e * s}, {-e * c, -1, -e * s}) < 1e-3);
            }
        }
}

TEST_CASE("a smooth function is reproduced better on a finer grid", "[direction_grid]") {
    const auto f = [](const Vec3& w) { return 1 + 0.5 * w.x - 0.3 * w.y + 0.2 * w.z + 0.4 * w.x * w.z; };
    for (const GridMap map : maps) {
        double before = 0;
        for (const std::uint32_t n : {6u, 12u, 24u}) {
            const DirectionGrid grid(map, n);
            const std::vector<double> table = table_of(grid, f);
            double sum = 0;
            const int samples = 4000;
            for (int i = 0; i < samples; ++i) {
                const Vec3 w = test_direction(static_cast<std::uint64_t>(i));
                const double error = grid.interpolate<double>(table, w) - f(w);
                sum += error * error;
            }
            const double rms = std::sqrt(sum / samples);
            // Bilinear interpolation errs by h^2 / 8 of second derivatives of order 1, h = pi / n.
            CHECK(rms < kPi * kPi / (8.0 * n * n) * 2);
            if (before > 0) CHECK(rms < before / 3);  // second order: a quarter, less the creases
            before = rms;
        }
    }
}

TEST_CASE("solid angles sum to the sphere and are those of the weights", "[direction_grid]") {
    for (const GridMap map : maps)
        for (const std::uint32_t n : {2u, 3u, 12u}) {
            const DirectionGrid grid(map, n);
            const std::vector<double> angles = grid.solid_angles();
            double sum = 0;
            Vec3 mean;
            for (std::uint32_t i = 0; i < grid.size(); ++i) {
                REQUIRE(angles[i] > 0);
                sum += angles[i];
                mean += grid.direction(i) * angles[i];
            }
            CHECK(sum == Approx(4 * kPi).epsilon(1e-14));
            // Symmetric under w -> -w up to rounding; the octahedral fold maps nodes onto nodes for even n only.
            if (map == GridMap::LatLong || n % 2 == 0) CHECK(length(mean) < 1e-12);
            // Monte Carlo with N = 200000 per grid: the deviation of a node's share p is sqrt(p / N); 6 of them.
            const int samples = 200000;
            std::vector<double> hits(grid.size(), 0);
            for (int i = 0; i < samples; ++i) {
                const DirectionTaps t = grid.taps(test_direction(static_cast<std::uint64_t>(i)));
                for (std::size_t k = 0; k < 4; ++k) hits[t.node[k]] += double(t.weight[k]) / samples;
            }
            for (std::uint32_t i = 0; i < grid.size(); ++i) {
                const double share = angles[i] / (4 * kPi);
                CHECK(std::abs(hits[i] - share) < 6 * std::sqrt(share / samples));
            }
        }
}

TEST_CASE("the octahedral grid treats x and z, and mirror images, alike", "[direction_grid]") {
    for (const std::uint32_t n : {4u, 7u, 12u}) {
        const DirectionGrid grid(GridMap::Octahedral, n);
        const std::vector<double> angles = grid.solid_angles();
        for (std::uint32_t row = 0; row < n; ++row)
            for (std::uint32_t column = 0; column < n; ++column) {
                const double here = angles[row * n + column];
                CHECK(angles[column * n + row] == Approx(here).epsilon(1e-12));
                CHECK(angles[row * n + n - 1 - column] == Approx(here).epsilon(1e-12));
                const Vec3 w = grid.direction(row * n + column), m = grid.direction(row * n + n - 1 - column);
                CHECK(length(w - Vec3{-m.x, m.y, m.z}) < 1e-15);
            }
    }
}

TEST_CASE("the latitude-longitude grid is the paper's: rows are latitudes, columns longitudes", "[direction_grid]") {
    const DirectionGrid grid(GridMap::LatLong, 12);
    for (std::uint32_t row = 0; row < 12; ++row)
        for (std::uint32_t column = 0; column < 12; ++column) {
            const Vec3 w = grid.direction(row * 12 + column);
            CHECK(std::asin(w.y) == Approx(kPi * ((row + 0.5) / 12 - 0.5)));
            CHECK(std::fmod(std::atan2(w.z, w.x) + 2 * kPi, 2 * kPi) == Approx(2 * kPi * (column + 0.5) / 12));
        }
}

TEST_CASE("a grid of even size has two nodes on each line, opposite ones, one of them in its first half",
          "[direction_grid]") {
    for (const GridMap map : {GridMap::Octahedral, GridMap::LatLong})
        for (const std::uint32_t n : {2u, 3u, 4u, 7u, 12u, 13u}) {
            const DirectionGrid grid(map, n);
            REQUIRE(grid.lines() == (n % 2 == 0 ? n * n / 2 : n * n));
            for (std::uint32_t node = 0; node < grid.size(); ++node) {
                const std::uint32_t line = grid.line(node);
                REQUIRE(line < grid.lines());
                if (node < grid.lines())
                    CHECK(line == node);
                else
                    CHECK(length(grid.direction(line) + grid.direction(node)) < 1e-14);
            }
        }
}
