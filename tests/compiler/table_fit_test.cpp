// Tables fitted to samples between their nodes.
#include "compiler/table_fit.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

using namespace rro;

namespace {

std::vector<Vec3> directions_of(const DirectionGrid& grid) {
    std::vector<Vec3> directions;
    for (std::uint32_t node = 0; node < grid.size(); ++node) directions.push_back(grid.direction(node));
    return directions;
}

/// Effective area of a box of 2 x 3 x 5 m: smooth but for its creases.
float box_area(const Vec3& w) {
    return static_cast<float>(15 * std::abs(w.x) + 10 * std::abs(w.y) + 6 * std::abs(w.z));
}

/// Root mean square over the sphere of what interpolation is off by.
double error_of(const DirectionGrid& grid, std::span<const float> nodes, float (*exact)(const Vec3&)) {
    constexpr int kDirections = 5000;
    double sum = 0;
    for (int i = 0; i < kDirections; ++i) {
        const double y = 1 - (2 * i + 1.0) / kDirections, turn = 2 * std::numbers::pi * i / std::numbers::phi;
        const double r = std::sqrt(1 - y * y);
        const Vec3 w{r * std::cos(turn), y, r * std::sin(turn)};
        const double off = grid.interpolate(nodes, w) - static_cast<double>(exact(w));
        sum += off * off;
    }
    return std::sqrt(sum / kDirections);
}

}  // namespace

TEST_CASE("samples of a table give the table back", "[compiler][table_fit]") {
    const GridMap map = GENERATE(GridMap::Octahedral, GridMap::LatLong);
    const DirectionGrid grid(map, 6), fine(map, 12);
    const std::vector<Vec3> directions = directions_of(fine);
    std::vector<float> truth, samples;
    for (std::uint32_t k = 0; k < grid.size(); ++k) truth.push_back(static_cast<float>(k * 7 % 11));
    for (const Vec3& w : directions) samples.push_back(static_cast<float>(grid.interpolate(std::span<const float>(truth), w)));
    std::vector<float> nodes(grid.size(), 5);
    TableFit(grid, directions).fit(samples, std::vector<float>(samples.size(), 1), nodes);
    double off = 0;
    for (std::size_t k = 0; k < truth.size(); ++k) off += std::pow(static_cast<double>(nodes[k] - truth[k]), 2);
    // From 5 everywhere, off by 3.2; the steps and the prior leave about a hundredth of that.
    CHECK(std::sqrt(off / static_cast<double>(truth.size())) < 0.15);
}

TEST_CASE("a fit errs less between the nodes than point samples do", "[compiler][table_fit]") {
    const GridMap map = GENERATE(GridMap::Octahedral, GridMap::LatLong);
    const std::uint32_t n = GENERATE(7u, 12u);
    const DirectionGrid grid(map, n), fine(map, 2 * n);
    const std::vector<Vec3> directions = directions_of(fine);
    std::vector<float> nodes, samples;
    for (const Vec3& w : directions_of(grid)) nodes.push_back(box_area(w));
    for (const Vec3& w : directions) samples.push_back(box_area(w));
    const double before = error_of(grid, nodes, box_area);
    TableFit(grid, directions).fit(samples, std::vector<float>(samples.size(), 1), nodes);
    INFO("n " << n << ", point samples " << before << ", fit " << error_of(grid, nodes, box_area));
    // How much less depends on where the creases lie between the nodes; least where both grids' nodes straddle them.
    CHECK(error_of(grid, nodes, box_area) < 0.95 * before);
}

TEST_CASE("nodes without samples keep what they were", "[compiler][table_fit]") {
    const DirectionGrid grid(GridMap::Octahedral, 12);
    const std::vector<Vec3> directions = directions_of(DirectionGrid(GridMap::Octahedral, 24));
    std::vector<float> samples(directions.size(), 1), weights;
    for (const Vec3& w : directions) weights.push_back(w.y > 0.3 ? 1.0f : 0.0f);
    std::vector<float> nodes(grid.size(), 0.25f);
    TableFit(grid, directions).fit(samples, weights, nodes);
    for (std::uint32_t k = 0; k < grid.size(); ++k) {
        INFO("node towards y = " << grid.direction(k).y);
        if (grid.direction(k).y < 0) CHECK(nodes[k] == 0.25f);
        if (grid.direction(k).y > 0.5) CHECK(nodes[k] == Approx(1).margin(0.01));
    }
}

TEST_CASE("no weight at all changes nothing", "[compiler][table_fit]") {
    const DirectionGrid grid(GridMap::LatLong, 4);
    const std::vector<Vec3> directions = directions_of(DirectionGrid(GridMap::LatLong, 8));
    std::vector<float> nodes(grid.size(), 0.5f);
    TableFit(grid, directions).fit(std::vector<float>(directions.size(), 1), std::vector<float>(directions.size(), 0), nodes);
    for (const float v : nodes) CHECK(v == 0.5f);
}
