#include "format/sample_points.h"

#include <algorithm>
#include <cassert>
#include <numbers>

namespace rro {
namespace {

constexpr int kBits = 32;
constexpr int kDimensions = 4;

/// One 32-bit number per dimension; arithmetic is element by element.
using PerDimension = std::uint32_t __attribute__((vector_size(4 * kDimensions)));

template <class Bits>
constexpr Bits reversed_bits(Bits x) {
    x = (x >> 16) | (x << 16);
    x = ((x & 0xff00ff00u) >> 8) | ((x & 0x00ff00ffu) << 8);
    x = ((x & 0xf0f0f0f0u) >> 4) | ((x & 0x0f0f0f0fu) << 4);
    x = ((x & 0xccccccccu) >> 2) | ((x & 0x33333333u) << 2);
    return ((x & 0xaaaaaaaau) >> 1) | ((x & 0x55555555u) << 1);
}

/// A primitive polynomial over GF(2) of degree s, its inner coefficients a, and the first s direction integers m.
struct SobolDimension {
    int s;
    std::uint32_t a;
    std::array<std::uint32_t, 3> m;
};

/// Dimensions 2 to 4 of [Joe and Kuo 2008], new-joe-kuo-6; dimension 1 is van der Corput's sequence.
constexpr std::array<SobolDimension, kDimensions - 1> kJoeKuo{{{1, 0, {1}}, {2, 1, {1, 3}}, {3, 1, {1, 3, 1}}}};

/// [bit of the index], each direction number with its first binary digit in bit 0, where the scramble wants it.
std::array<PerDimension, kBits> reversed_direction_numbers() {
    std::array<PerDimension, kBits> reversed{};
    for (std::size_t i = 0; i < kBits; ++i) reversed[i][0] = 1u << i;
    for (std::size_t d = 1; d < kDimensions; ++d) {
        const auto& [s, a, m] = kJoeKuo[d - 1];
        std::array<std::uint32_t, kBits> v{};
        for (int i = 0; i < kBits; ++i) {
            auto& vi = v[static_cast<std::size_t>(i)];
            if (i < s) {
                vi = m[static_cast<std::size_t>(i)] << (kBits - 1 - i);
            } else {
                const std::uint32_t oldest = v[static_cast<std::size_t>(i - s)];
                vi = oldest ^ (oldest >> s);
                for (int k = 1; k < s; ++k)
                    if ((a >> (s - 1 - k)) & 1u) vi ^= v[static_cast<std::size_t>(i - k)];
            }
            reversed[static_cast<std::size_t>(i)][d] = reversed_bits(vi);
        }
    }
    return reversed;
}

const std::array<PerDimension, kBits> kReversedDirections = reversed_direction_numbers();

/// Owen's scramble of a number whose first binary digit is bit 0: whether a bit flips depends on the bits below it
/// only, because every factor is even. Constants of [Burley 2020].
template <class Bits>
Bits scramble_reversed(Bits x, Bits seed) {
    x += seed;
    x ^= x * 0x6c50b47cu;
    x ^= x * 0xb82f1e52u;
    x ^= x * 0xc7afe638u;
    x ^= x * 0x8d22f6e6u;
    return x;
}

/// The first 24 binary digits, all that a float below 1 holds without rounding up to 1.
constexpr float to_unit_float(std::uint32_t x) {
    return static_cast<float>(x >> 8) * 0x1p-24f;
}

using Node = TriangleRule::Node;

constexpr std::array<Node, 1> kRule1{{{1.0 / 3, 1.0 / 3, 1.0}}};

/// The three nodes with two equal barycentric coordinates `a`.
template <std::size_t N>
constexpr void put_three(std::array<Node, N>& rule, std::size_t at, double weight, double a) {
    const double b = 1 - 2 * a;
    rule[at] = {a, a, weight};
    rule[at + 1] = {a, b, weight};
    rule[at + 2] = {b, a, weight};
}

/// The six nodes with barycentric coordinates a, b and 1 - a - b in any order.
template <std::size_t N>
constexpr void put_six(std::array<Node, N>& rule, std::size_t at, double weight, double a, double b) {
    const double c = 1 - a - b;
    rule[at] = {a, b, weight};
    rule[at + 1] = {b, a, weight};
    rule[at + 2] = {b, c, weight};
    rule[at + 3] = {c, b, weight};
    rule[at + 4] = {c, a, weight};
    rule[at + 5] = {a, c, weight};
}

// Dunavant prints 15 digits; these solve his moment equations to the last digit of a double.
constexpr auto kRule3 = [] {
    std::array<Node, 3> rule{};
    put_three(rule, 0, 1.0 / 3, 1.0 / 6);
    return rule;
}();

constexpr auto kRule6 = [] {
    std::array<Node, 6> rule{};
    put_three(rule, 0, 0.223381589678011466, 0.445948490915964886);
    put_three(rule, 3, 0.109951743655321868, 0.0915762135097707435);
    return rule;
}();

constexpr auto kRule7 = [] {
    std::array<Node, 7> rule{};
    rule[0] = {1.0 / 3, 1.0 / 3, 0.225};
    put_three(rule, 1, 0.132394152788506181, 0.470142064105115090);
    put_three(rule, 4, 0.125939180544827153, 0.101286507323456339);
    return rule;
}();

constexpr auto kRule12 = [] {
    std::array<Node, 12> rule{};
    put_three(rule, 0, 0.116786275726379366, 0.249286745170910421);
    put_three(rule, 3, 0.0508449063702068169, 0.0630890144915022283);
    put_six(rule, 6, 0.0828510756183735752, 0.0531450498448169474, 0.310352451033784405);
    return rule;
}();

constexpr auto kRule16 = [] {
    std::array<Node, 16> rule{};
    rule[0] = {1.0 / 3, 1.0 / 3, 0.144315607677787168};
    put_three(rule, 1, 0.0950916342672846248, 0.459292588292723156);
    put_three(rule, 4, 0.103217370534718250, 0.170569307751760207);
    put_three(rule, 7, 0.0324584976231980803, 0.0505472283170309755);
    put_six(rule, 10, 0.0272303141744349943, 0.00839477740995760534, 0.263112829634638113);
    return rule;
}();

}  // namespace

std::array<float, kDimensions> sobol4(std::uint32_t index, std::uint64_t seed) {
    const std::uint64_t key0 = mix64(seed), key1 = mix64(key0), key2 = mix64(key1);
    const auto low = [](std::uint64_t key) { return static_cast<std::uint32_t>(key); };
    const auto high = [](std::uint64_t key) { return static_cast<std::uint32_t>(key >> kBits); };

    // Shuffling the order the same way as the coordinates keeps every aligned power-of-two block together, so prefixes
    // stay nets, and makes two sequences of different seeds independent point by point.
    const std::uint32_t shuffled = reversed_bits(scramble_reversed(reversed_bits(index), low(key2)));
    PerDimension x{};
    for (std::size_t bit = 0; bit < kBits; ++bit) x ^= kReversedDirections[bit] & (0u - ((shuffled >> bit) & 1u));
    x = reversed_bits(scramble_reversed(x, PerDimension{low(key0), high(key0), low(key1), high(key1)}));
    return {to_unit_float(x[0]), to_unit_float(x[1]), to_unit_float(x[2]), to_unit_float(x[3])};
}

std::array<double, 2> square_to_triangle(double u, double v) {
    if (v > u) return {0.5 * u, v - 0.5 * u};
    return {u - 0.5 * v, 0.5 * v};
}

Vec3 square_to_cosine_hemisphere(double u, double v) {
    const double a = 2 * u - 1, b = 2 * v - 1;
    if (a == 0 && b == 0) return {0, 0, 1};
    const bool a_leads = std::abs(a) > std::abs(b);
    const double radius = a_leads ? a : b;
    const double angle =
        a_leads ? std::numbers::pi / 4 * (b / a) : std::numbers::pi / 2 - std::numbers::pi / 4 * (a / b);
    return {radius * std::cos(angle), radius * std::sin(angle), std::sqrt(std::max(0.0, 1 - radius * radius))};
}

std::array<Vec3, 3> frame_about(const Vec3& n) {
    const double sign = std::copysign(1.0, n.z);
    const double a = -1 / (sign + n.z);
    const double b = n.x * n.y * a;
    return {Vec3{1 + sign * n.x * n.x * a, sign * b, -sign * n.x}, Vec3{b, sign + n.y * n.y * a, -n.y}, n};
}

double solid_angle(const TriangleCorners& t, const Vec3& p) {
    const Vec3 a = t[0] - p, b = t[1] - p, c = t[2] - p;
    const double la = length(a), lb = length(b), lc = length(c);
    const double volume = dot(a, cross(b, c));  // negative from the front
    const double scale = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb;
    return -2 * std::atan2(volume, scale);
}

SeenTriangle::SeenTriangle(const Vec3& from, const TriangleCorners& t) : from_(from), triangle_(t) {
    solid_angle_ = rro::solid_angle(t, from);
    for (std::size_t k = 0; k < 3; ++k) corner_[k] = normalised(t[k] - from);
    const Vec3 to_second = cross(corner_[0], corner_[1]), to_third = cross(corner_[0], corner_[2]);
    const double angle = std::atan2(length(cross(to_second, to_third)), dot(to_second, to_third));
    cos_angle_ = std::cos(angle);
    sin_angle_ = std::sin(angle);
    cos_side_ = dot(corner_[0], corner_[1]);
}

Vec3 SeenTriangle::point(double u, double v) const {
    constexpr double kSmall = 1e-4;  // sr; below, the sphere is flat, and the angles' sum too close to pi
    const auto by_area = [&] {
        const auto b = square_to_triangle(u, v);
        return triangle_point(triangle_, b[0], b[1]);
    };
    if (!(solid_angle_ > kSmall) || !(sin_angle_ > 0)) return by_area();
    // The third corner moves along its side until the part of the triangle has the share u of the solid angle.
    const double part = u * solid_angle_, angle = std::atan2(sin_angle_, cos_angle_);
    const double s = std::sin(part - angle), t = std::cos(part - angle);
    const double x = t - cos_angle_, y = s + sin_angle_ * cos_side_;
    const double below = (y * s + x * t) * sin_angle_;
    const double along = below != 0 ? std::clamp(((y * t - x * s) * cos_angle_ - y) / below, -1.0, 1.0) : 1.0;
    const auto beside = [](const Vec3& a, const Vec3& b) { return normalised(a - b * dot(a, b)); };
    const Vec3 moved = corner_[0] * along + beside(corner_[2], corner_[0]) * std::sqrt(std::max(0.0, 1 - along * along));
    const double z = 1 - v * (1 - dot(moved, corner_[1]));
    const Vec3 direction = corner_[1] * z + beside(moved, corner_[1]) * std::sqrt(std::max(0.0, 1 - z * z));
    const Vec3 normal = area_vector(triangle_);
    const double towards = dot(normal, direction);
    return towards < 0 ? from_ + direction * (dot(normal, triangle_[0] - from_) / towards) : by_area();
}

TriangleRule triangle_rule(int points) {
    assert(points <= 16);
    if (points <= 1) return {kRule1};
    if (points <= 3) return {kRule3};
    if (points <= 6) return {kRule6};
    if (points <= 7) return {kRule7};
    if (points <= 12) return {kRule12};
    return {kRule16};
}

}  // namespace rro
