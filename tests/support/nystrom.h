// The continuous radiosity of a few unit squares, from its integral equation: one more witness that shares no code with
// the project. Constant radiosity on every cell of a grid, received at 2 x 2 points of Gauss in each, by exact factors from
// there to cells (Lambert's contour formula); then ever finer grids. Squares must see each other whole: nothing between,
// none beyond another's horizon.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "format/geometry.h"

namespace rro::test {

/// corner + [0, 1] u + [0, 1] v, front along u x v; u and v unit and orthogonal.
struct UnitSquare {
    Vec3 corner, u, v;
    double reflectance = 0, exitance = 0;

    Vec3 normal() const { return cross(u, v); }
    Vec3 at(double s, double t) const { return corner + u * s + v * t; }
};

/// Share of the hemisphere about n at p that the front of a quadrilateral covers; all of it above the horizon.
inline double contour_factor(const Vec3& p, const Vec3& n, const std::array<Vec3, 4>& corner) {
    double sum = 0;
    for (std::size_t k = 0; k < 4; ++k) {
        const Vec3 a = corner[k] - p, b = corner[(k + 1) % 4] - p, across = cross(b, a);
        const double sine = length(across);
        if (sine > 0) sum += std::atan2(sine, dot(a, b)) * dot(n, across) / sine;
    }
    return sum / (2 * std::numbers::pi);
}

/// Radiosity of every cell, [square][row of v][column of u], for n x n cells a square.
inline std::vector<double> nystrom(const std::vector<UnitSquare>& squares, std::size_t n) {
    constexpr double kGauss = 0.28867513459481287;  // 1 / sqrt(12): two points of Gauss along each edge
    const std::size_t cells = n * n, all = squares.size() * cells;
    const double h = 1.0 / double(n);
    std::vector<double> factors(all * all, 0);
    for (std::size_t i = 0; i < all; ++i) {
        const UnitSquare& to = squares[i / cells];
        for (std::size_t j = 0; j < all; ++j) {
            const UnitSquare& from = squares[j / cells];
            if (i / cells == j / cells) continue;
            const double s = double(j % n) * h, t = double(j % cells / n) * h;
            const std::array<Vec3, 4> cell{from.at(s, t), from.at(s + h, t), from.at(s + h, t + h), from.at(s, t + h)};
            for (const double u : {0.5 - kGauss, 0.5 + kGauss})
                for (const double v : {0.5 - kGauss, 0.5 + kGauss})
                    factors[i * all + j] +=
                        0.25 * contour_factor(to.at((double(i % n) + u) * h, (double(i % cells / n) + v) * h), to.normal(), cell);
        }
    }
    std::vector<double> b(all), next(all);
    for (std::size_t i = 0; i < all; ++i) b[i] = squares[i / cells].exitance;
    constexpr double kSettled = 1e-10;
    for (double change = 1; change > kSettled;) {
        change = 0;
        for (std::size_t i = 0; i < all; ++i) {
            double e = 0;
            for (std::size_t j = 0; j < all; ++j) e += factors[i * all + j] * b[j];
            next[i] = squares[i / cells].exitance + squares[i / cells].reflectance * e;
            change = std::max(change, std::abs(next[i] - b[i]));
        }
        b.swap(next);
    }
    return b;
}

/// Means of a finer grid's cells over those of a grid of m x m.
inline std::vector<double> coarsened(const std::vector<double>& fine, std::size_t squares, std::size_t n, std::size_t m) {
    std::vector<double> out(squares * m * m, 0);
    const std::size_t k = n / m;
    for (std::size_t i = 0; i < fine.size(); ++i) {
        const std::size_t square = i / (n * n), row = i % (n * n) / n, column = i % n;
        out[(square * m + row / k) * m + column / k] += fine[i] / double(k * k);
    }
    return out;
}

/// Mean radiosity over m x m cells of every square; `error` bounds what is left, as the last step of the extrapolation.
struct ContinuousTruth {
    std::vector<double> cells;  // [square][m][m]
    double error = 0;

    double mean(std::size_t square, std::size_t m) const {
        double sum = 0;
        for (std::size_t k = 0; k < m * m; ++k) sum += cells[square * m * m + k];
        return sum / double(m * m);
    }
};

/// The error falls nearly as h^2 (as h^1.7 where squares meet), so two grids extrapolate to h = 0 [Richardson], and a third
/// one checks them.
inline ContinuousTruth continuous_radiosity(const std::vector<UnitSquare>& squares, std::size_t m) {
    std::array<std::vector<double>, 3> b;
    for (std::size_t level = 0; level < 3; ++level)
        b[level] = coarsened(nystrom(squares, m << level), squares.size(), m << level, m);
    ContinuousTruth truth;
    for (std::size_t k = 0; k < b[0].size(); ++k) {
        const double coarse = b[1][k] + (b[1][k] - b[0][k]) / 3, fine = b[2][k] + (b[2][k] - b[1][k]) / 3;
        truth.cells.push_back(fine);
        truth.error = std::max(truth.error, std::abs(fine - coarse));
    }
    return truth;
}

}  // namespace rro::test
