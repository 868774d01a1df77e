#include "solver/scene/transform.h"

#include <cstdio>
#include <numbers>

namespace rro {
namespace {

constexpr double kLargestCondition = 1e9;  // beyond it, double precision no longer separates the sides

double largest_entry(const Mat3& m) {
    double largest = 0;
    for (const Vec3& row : m.rows)
        for (int c = 0; c < 3; ++c) largest = std::max(largest, std::abs(row[c]));
    return largest;
}

/// Sine and cosine of an angle in degrees; quarter turns are exact, so that they map boxes to boxes.
std::array<double, 2> sine_cosine(double degrees) {
    const double turn = std::remainder(degrees, 360);
    if (turn == 0) return {0, 1};
    if (turn == 90) return {1, 0};
    if (turn == -90) return {-1, 0};
    if (std::abs(turn) == 180) return {0, -1};
    const double radians = turn * std::numbers::pi / 180;
    return {std::sin(radians), std::cos(radians)};
}

/// Rodrigues' formula: R = c I + s [k]x + (1 - c) k k^T.
Mat3 rotation(const Vec3& axis, double degrees) {
    const double largest = std::max({std::abs(axis.x), std::abs(axis.y), std::abs(axis.z)});
    const Vec3 k = normalised({axis.x / largest, axis.y / largest, axis.z / largest});  // no overflow in the squares
    const auto [s, c] = sine_cosine(degrees);
    const double v = 1 - c;
    return {{Vec3{c + v * k.x * k.x, v * k.x * k.y - s * k.z, v * k.x * k.z + s * k.y},
             Vec3{v * k.y * k.x + s * k.z, c + v * k.y * k.y, v * k.y * k.z - s * k.x},
             Vec3{v * k.z * k.x - s * k.y, v * k.z * k.y + s * k.x, c + v * k.z * k.z}}};
}

bool is_finite(const Affine3& a) {
    return rro::is_finite(a.translation) && rro::is_finite(a.linear.rows[0]) && rro::is_finite(a.linear.rows[1]) &&
           rro::is_finite(a.linear.rows[2]);
}

}  // namespace

Affine3 compose(const TransformParts& parts) {
    Mat3 linear = rotation(parts.axis, parts.degrees);
    for (Vec3& row : linear.rows) row = hadamard(row, parts.scale);
    return {linear, parts.translate};
}

double condition_number(const Mat3& m) {
    const double largest = largest_entry(m);
    if (!(largest > 0)) return std::numeric_limits<double>::infinity();
    std::array<Vec3, 3> u;
    for (int c = 0; c < 3; ++c) {
        const Vec3 column = m.column(c);
        u[static_cast<std::size_t>(c)] = {column.x / largest, column.y / largest, column.z / largest};
    }
    // Rotate pairs of columns until all are orthogonal; their lengths are then the singular values. 3 columns settle in
    // a handful of sweeps; the bound only guards against a cycle in the last bit.
    for (int sweep = 0; sweep < 30; ++sweep) {
        bool orthogonal = true;
        for (std::size_t p = 0; p < 2; ++p)
            for (std::size_t q = p + 1; q < 3; ++q) {
                const double a = length2(u[p]), b = length2(u[q]), g = dot(u[p], u[q]);
                if (std::abs(g) <= 1e-15 * std::sqrt(a * b)) continue;
                orthogonal = false;
                const double zeta = (b - a) / (2 * g);
                const double t = std::copysign(1 / (std::abs(zeta) + std::hypot(1, zeta)), zeta);
                const double c = 1 / std::hypot(1, t);
                const Vec3 rotated = (u[p] - u[q] * t) * c;
                u[q] = (u[q] + u[p] * t) * c;
                u[p] = rotated;
            }
        if (orthogonal) break;
    }
    const std::array<double, 3> s{length(u[0]), length(u[1]), length(u[2])};
    const auto [low, high] = std::minmax_element(s.begin(), s.end());
    return *low > 0 ? *high / *low : std::numeric_limits<double>::infinity();
}

std::string transform_fault(const Affine3& to_world) {
    if (!is_finite(to_world)) return "the transform overflows double precision";
    const double condition = condition_number(to_world.linear);
    // A matrix that is singular on paper has a condition number of about 1e16 after rounding.
    if (condition > 1e15) return "the transform is singular, expected one that can be inverted";
    if (condition > kLargestCondition) {
        char text[32];
        std::snprintf(text, sizeof text, "%.3g", condition);
        return std::string("the transform has condition number ") + text + ", expected at most 1e9";
    }
    const double determinant = to_world.linear.determinant();
    if (!std::isnormal(determinant) || !is_finite(to_world.inverse()))
        return "the transform is too large or too small to be inverted in double precision";
    return {};
}

}  // namespace rro
