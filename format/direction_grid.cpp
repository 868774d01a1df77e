#include "format/direction_grid.h"

#include <cassert>
#include <cmath>
#include <numbers>
#include <numeric>

namespace rro {
namespace {

constexpr double kPi = std::numbers::pi;

/// Points per side of a cell in the quadrature of solid angles. Even, so that the kinks of the hat functions (at cell
/// centres) lie between points; 16 leaves a relative error below 1e-4, small against u8 tables.
constexpr int kQuadraturePoints = 16;

/// A place on the grid in units of cells: node (column c, row r) lies at exactly (c, r).
struct GridPoint {
    double column, row;
};

/// Octahedral fold: |x| + |y| + |z| = 1 flattened along y. The half y >= 0 is the inner diamond of the unit square,
/// the half y < 0 its four corners.
Vec3 octahedron_point(double u, double v) {
    const double y = 1 - std::abs(u) - std::abs(v);
    if (y >= 0) return {u, y, v};
    return {std::copysign(1 - std::abs(v), u), y, std::copysign(1 - std::abs(u), v)};
}

GridPoint octahedral_place(const Vec3& w, std::uint32_t n) {
    const double scale = 1 / (std::abs(w.x) + std::abs(w.y) + std::abs(w.z));
    double u = w.x * scale, v = w.z * scale;
    if (w.y < 0) {
        const double folded = std::copysign(1 - std::abs(v), u);
        v = std::copysign(1 - std::abs(u), v);
        u = folded;
    }
    return {(u + 1) * 0.5 * n - 0.5, (v + 1) * 0.5 * n - 0.5};
}

/// Latitude about +y, longitude from +x towards +z.
GridPoint latlong_place(const Vec3& w, std::uint32_t n) {
    const double latitude = std::atan2(w.y, std::hypot(w.x, w.z));
    double longitude = std::atan2(w.z, w.x);
    if (longitude < 0) longitude += 2 * kPi;
    return {longitude / (2 * kPi) * n - 0.5, (latitude / kPi + 0.5) * n - 0.5};
}

Vec3 latlong_direction(const GridPoint& at, std::uint32_t n) {
    const double longitude = (at.column + 0.5) / n * 2 * kPi, latitude = ((at.row + 0.5) / n - 0.5) * kPi;
    return {std::cos(latitude) * std::cos(longitude), std::sin(latitude), std::cos(latitude) * std::sin(longitude)};
}

/// Node of a column and row that may lie one beyond an edge. The edge of the octahedral square is glued to itself,
/// point (1, v) to (1, -v), so a step over it lands in the mirrored place; corners take both steps.
std::uint32_t octahedral_node(int column, int row, int n) {
    if (column < 0 || column >= n) {
        column = column < 0 ? 0 : n - 1;
        row = n - 1 - row;
    }
    if (row < 0 || row >= n) {
        row = row < 0 ? 0 : n - 1;
        column = n - 1 - column;
    }
    return static_cast<std::uint32_t>(row * n + column);
}

struct ExactTaps {
    std::array<std::uint32_t, 4> node;
    std::array<double, 4> weight;
};

ExactTaps octahedral_taps(const GridPoint& at, int n) {
    const int column = static_cast<int>(std::floor(at.column)), row = static_cast<int>(std::floor(at.row));
    const double s = at.column - column, t = at.row - row;
    return {{octahedral_node(column, row, n), octahedral_node(column + 1, row, n), octahedral_node(column, row + 1, n),
             octahedral_node(column + 1, row + 1, n)},
            {(1 - s) * (1 - t), s * (1 - t), (1 - s) * t, s * t}};
}

/// Two taps along the row nearest to `row`. Beyond a pole that is the last row again, at longitude + pi, which for odd
/// n falls between other columns than the longitude itself.
void latlong_row_taps(double column, int row, double weight, int n, std::size_t first, ExactTaps& taps) {
    if (row < 0 || row >= n) {
        row = row < 0 ? 0 : n - 1;
        column += 0.5 * n;
    }
    const int left = static_cast<int>(std::floor(column));
    const double s = column - left;
    const auto node = [&](int c) { return static_cast<std::uint32_t>(row * n + (c + n) % n); };
    taps.node[first] = node(left);
    taps.node[first + 1] = node(left + 1);
    taps.weight[first] = (1 - s) * weight;
    taps.weight[first + 1] = s * weight;
}

ExactTaps latlong_taps(const GridPoint& at, int n) {
    const int row = static_cast<int>(std::floor(at.row));
    const double t = at.row - row;
    ExactTaps taps;
    latlong_row_taps(at.column, row, 1 - t, n, 0, taps);
    latlong_row_taps(at.column, row + 1, t, n, 2, taps);
    return taps;
}

ExactTaps taps_at(GridMap map, const GridPoint& at, std::uint32_t n) {
    return map == GridMap::Octahedral ? octahedral_taps(at, static_cast<int>(n)) : latlong_taps(at, static_cast<int>(n));
}

/// Direction of a place, and the solid angle of a cell there per cell area (up to a constant factor).
struct Cell {
    Vec3 direction;
    double density;
};

Cell cell_at(GridMap map, const GridPoint& at, std::uint32_t n) {
    if (map == GridMap::LatLong) {
        const Vec3 w = latlong_direction(at, n);
        return {w, std::sqrt(w.x * w.x + w.z * w.z)};
    }
    const Vec3 p = octahedron_point((at.column + 0.5) / n * 2 - 1, (at.row + 0.5) / n * 2 - 1);
    const double r = length(p);
    return {p / r, 1 / (r * r * r)};
}

}  // namespace

DirectionGrid::DirectionGrid(GridMap map, std::uint32_t n) : map_(map), n_(n) {
    assert(n >= 2);
    directions_.reserve(size());
    for (std::uint32_t row = 0; row < n; ++row)
        for (std::uint32_t column = 0; column < n; ++column)
            directions_.push_back(cell_at(map, {double(column), double(row)}, n).direction);
}

std::uint32_t DirectionGrid::line(std::uint32_t node) const {
    if (node < lines()) return node;
    const int n = static_cast<int>(n_), column = static_cast<int>(node % n_), row = static_cast<int>(node / n_);
    if (map_ == GridMap::LatLong) return static_cast<std::uint32_t>((n - 1 - row) * n + (column + n / 2) % n);
    // The opposite of (u, v) is (-sgn(u) (1 - |v|), -sgn(v) (1 - |u|)); a, b are n u, n v, odd numbers.
    const int a = 2 * column + 1 - n, b = 2 * row + 1 - n;
    const int opposite_a = (a < 0 ? 1 : -1) * (n - std::abs(b)), opposite_b = (b < 0 ? 1 : -1) * (n - std::abs(a));
    return static_cast<std::uint32_t>((opposite_b + n - 1) / 2 * n + (opposite_a + n - 1) / 2);
}

std::vector<double> DirectionGrid::solid_angles() const {
    std::vector<double> angles(size());
    const auto points = n_ * kQuadraturePoints;
    const auto place = [](std::uint32_t i) { return (i + 0.5) / kQuadraturePoints - 0.5; };
    for (std::uint32_t j = 0; j < points; ++j)
        for (std::uint32_t i = 0; i < points; ++i) {
            const GridPoint at{place(i), place(j)};
            const double density = cell_at(map_, at, n_).density;
            const ExactTaps t = taps_at(map_, at, n_);
            for (std::size_t k = 0; k < 4; ++k) angles[t.node[k]] += density * t.weight[k];
        }
    const double scale = 4 * kPi / std::accumulate(angles.begin(), angles.end(), 0.0);
    for (double& angle : angles) angle *= scale;
    return angles;
}

DirectionTaps DirectionGrid::taps(const Vec3& w) const {
    const ExactTaps t = taps_at(map_, map_ == GridMap::Octahedral ? octahedral_place(w, n_) : latlong_place(w, n_), n_);
    DirectionTaps out{t.node, {}};
    for (std::size_t k = 0; k < 4; ++k) out.weight[k] = static_cast<float>(t.weight[k]);
    return out;
}

}  // namespace rro
