#include "format/sample_points.h"

#include <catch2/catch.hpp>
#include <numbers>
#include <random>
#include <set>
#include <vector>

#include "format/form_factor.h"

using namespace rro;

namespace {

using Points = std::vector<std::array<float, 4>>;

Points sobol_points(std::uint32_t count, std::uint64_t seed) {
    Points points;
    for (std::uint32_t i = 0; i < count; ++i) points.push_back(sobol4(i, seed));
    return points;
}

/// Whether every box of 2^-bits_a x 2^-bits_b in dimensions a and b holds the same number of points.
bool stratified(const Points& points, std::size_t a, int bits_a, std::size_t b, int bits_b) {
    std::vector<std::size_t> held(std::size_t{1} << (bits_a + bits_b));
    for (const auto& p : points) {
        const auto i = static_cast<std::size_t>(std::ldexp(double(p[a]), bits_a));
        const auto j = static_cast<std::size_t>(std::ldexp(double(p[b]), bits_b));
        ++held[(i << bits_b) + j];
    }
    for (const std::size_t h : held)
        if (h * held.size() != points.size()) return false;
    return true;
}

/// Whether the points are a (t, m, 2)-net in base 2 in dimensions a and b.
bool is_net(const Points& points, int m, int t, std::size_t a, std::size_t b) {
    for (int bits = 0; bits <= m - t; ++bits)
        if (!stratified(points, a, bits, b, m - t - bits)) return false;
    return true;
}

double factorial(int n) {
    return n <= 1 ? 1 : n * factorial(n - 1);
}

}  // namespace

TEST_CASE("every power-of-two prefix of the scrambled Sobol points is a net", "[format][sample_points]") {
    for (const std::uint64_t seed : {0ull, 1ull, 0x123456789abcdefull})
        for (int m = 0; m <= 12; ++m) {
            const Points points = sobol_points(1u << m, seed);
            INFO("seed " << seed << ", 2^" << m << " points");
            CHECK(is_net(points, m, 0, 0, 1));
            for (std::size_t a = 0; a < 4; ++a)
                for (std::size_t b = a + 1; b < 4; ++b) CHECK(is_net(points, m, std::min(m, 2), a, b));
            for (std::size_t d = 0; d < 4; ++d) CHECK(stratified(points, d, m, (d + 1) % 4, 0));
        }
}

TEST_CASE("the second block of Sobol points is a net as well", "[format][sample_points]") {
    // Adaptive sampling doubles its number of points; the new half must be as even as the old one.
    Points points = sobol_points(512, 5);
    points.erase(points.begin(), points.begin() + 256);
    CHECK(is_net(points, 8, 0, 0, 1));
    CHECK(is_net(points, 8, 2, 2, 3));
}

TEST_CASE("a Sobol point is uniform over the seeds, and independent between dimensions and seeds",
          "[format][sample_points]") {
    // 4096 seeds: the standard deviation of a mean is 0.2887 / 64 = 0.0045, of a correlation 1 / 64. Five of them.
    constexpr int kSeeds = 4096;
    for (const std::uint32_t index : {0u, 1u, 7u, 1000u}) {
        std::array<double, 4> mean{};
        std::array<std::array<double, 4>, 4> product{};
        std::array<double, 4> with_next_seed{};
        for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
            const auto p = sobol4(index, seed), q = sobol4(index, seed + 1);
            for (std::size_t a = 0; a < 4; ++a) {
                mean[a] += double(p[a]) / kSeeds;
                with_next_seed[a] += 12 * (double(p[a]) - 0.5) * (double(q[a]) - 0.5) / kSeeds;
                for (std::size_t b = 0; b < a; ++b)
                    product[a][b] += 12 * (double(p[a]) - 0.5) * (double(p[b]) - 0.5) / kSeeds;
            }
        }
        for (std::size_t a = 0; a < 4; ++a) {
            INFO("index " << index << ", dimension " << a);
            CHECK(std::abs(mean[a] - 0.5) < 5 * 0.0045);
            CHECK(std::abs(with_next_seed[a]) < 5.0 / 64);
            for (std::size_t b = 0; b < a; ++b) CHECK(std::abs(product[a][b]) < 5.0 / 64);
        }
    }
}

TEST_CASE("Sobol points stay below 1 and repeat for the same key", "[format][sample_points]") {
    std::set<std::array<float, 4>> distinct;
    for (const std::uint32_t index : {0u, 1u, 0x7fffffffu, 0xfffffffeu, 0xffffffffu})
        for (std::uint64_t seed = 0; seed < 1000; ++seed) {
            const auto p = sobol4(index, seed);
            REQUIRE(p == sobol4(index, seed));
            for (const float x : p) REQUIRE((x >= 0.0f && x < 1.0f));
            distinct.insert(p);
        }
    CHECK(distinct.size() == 5000);
}

TEST_CASE("scrambled Sobol points integrate a smooth function far better than random ones", "[format][sample_points]") {
    // The integrand has variance (pi^2 / 8)^4 - 1: 1024 random points err by 0.036. Three times better would be chance,
    // six times is structure in all four dimensions.
    double squares = 0;
    for (std::uint64_t seed = 0; seed < 32; ++seed) {
        double error = -1;
        for (const auto& p : sobol_points(1024, seed)) {
            double f = 1.0 / 1024;
            for (const float x : p) f *= std::numbers::pi / 2 * std::sin(std::numbers::pi * double(x));
            error += f;
        }
        squares += error * error / 32;
    }
    CHECK(std::sqrt(squares) < 0.036 / 6);
}

TEST_CASE("the map to the triangle stays inside and keeps areas", "[format][sample_points]") {
    constexpr int kSide = 256;
    std::array<double, 3> mean{};
    int near_corner = 0;  // b1, b2 < 1/2 where b0 > 1/2: the corner triangle, a quarter of the area
    for (int i = 0; i < kSide; ++i)
        for (int j = 0; j < kSide; ++j) {
            const auto [b1, b2] = square_to_triangle((i + 0.5) / kSide, (j + 0.5) / kSide);
            REQUIRE(b1 >= 0);
            REQUIRE(b2 >= 0);
            REQUIRE(b1 + b2 <= 1);
            mean[0] += (1 - b1 - b2) / (kSide * kSide), mean[1] += b1 / (kSide * kSide),
                mean[2] += b2 / (kSide * kSide);
            near_corner += b1 + b2 < 0.5;
        }
    // A grid of 256^2 cells counts areas to about one cell along the border, 1/256 of it.
    for (const double m : mean) CHECK(m == Approx(1.0 / 3).margin(0.004));
    CHECK(near_corner == Approx(0.25 * kSide * kSide).epsilon(0.01));
    CHECK(square_to_triangle(0, 0) == std::array<double, 2>{0, 0});
    CHECK(square_to_triangle(1, 0) == std::array<double, 2>{1, 0});
    CHECK(square_to_triangle(0, 1) == std::array<double, 2>{0, 1});
}

TEST_CASE("cosine-weighted directions are unit vectors with the moments of Lambert's law", "[format][sample_points]") {
    constexpr int kSide = 200;
    Vec3 mean;
    double cosine2 = 0;
    for (int i = 0; i < kSide; ++i)
        for (int j = 0; j < kSide; ++j) {
            const Vec3 w = square_to_cosine_hemisphere((i + 0.5) / kSide, (j + 0.5) / kSide);
            REQUIRE(length(w) == Approx(1).margin(1e-14));
            REQUIRE(w.z >= 0);
            mean += w / (kSide * kSide);
            cosine2 += w.z * w.z / (kSide * kSide);
        }
    // Density cos / pi: E[cos] = 2/3, E[cos^2] = 1/2. The midpoint rule errs where cos falls to 0, by about 200^-1.5.
    CHECK(mean.x == Approx(0).margin(1e-12));
    CHECK(mean.y == Approx(0).margin(1e-12));
    CHECK(mean.z == Approx(2.0 / 3).margin(1e-3));
    CHECK(cosine2 == Approx(0.5).margin(1e-4));
    CHECK(square_to_cosine_hemisphere(0.5, 0.5) == Vec3{0, 0, 1});
    CHECK(square_to_cosine_hemisphere(1, 0.5).x == Approx(1));
    CHECK(square_to_cosine_hemisphere(0, 0).z == 0);
}

TEST_CASE("the frame about a direction is orthonormal and right-handed, at both poles too", "[format][sample_points]") {
    std::mt19937_64 random(7);
    std::normal_distribution<double> normal;
    std::vector<Vec3> directions{{0, 0, 1},
                                 {0, 0, -1},
                                 {1, 0, 0},
                                 {0, -1, 0},
                                 {1, 0, -0.0},
                                 normalised({1e-9, -1e-9, -1}),
                                 normalised({1e-200, 0, -1})};
    for (int i = 0; i < 1000; ++i) directions.push_back(normalised({normal(random), normal(random), normal(random)}));
    for (const Vec3& n : directions) {
        const auto [x, y, z] = frame_about(n);
        CHECK(z == n);
        CHECK(std::abs(dot(x, y)) < 1e-14);
        CHECK(std::abs(dot(x, z)) < 1e-14);
        CHECK(std::abs(dot(y, z)) < 1e-14);
        CHECK(std::abs(length(x) - 1) < 1e-14);
        CHECK(length(cross(x, y) - z) < 1e-14);
    }
}

TEST_CASE("triangle rules integrate every monomial exactly up to their degree", "[format][sample_points]") {
    struct Expected {
        int points, degree;
    };
    for (const auto& [points, degree] : {Expected{1, 1}, {3, 2}, {6, 4}, {7, 5}, {12, 6}, {16, 8}}) {
        const TriangleRule rule = triangle_rule(points);
        REQUIRE(rule.nodes.size() == static_cast<std::size_t>(points));
        double worst_beyond = 0;
        for (int i = 0; i <= degree + 1; ++i)
            for (int j = 0; i + j <= degree + 1; ++j) {
                double sum = 0;
                for (const auto& [b1, b2, weight] : rule.nodes) sum += weight * std::pow(b1, i) * std::pow(b2, j);
                const double exact = 2 * factorial(i) * factorial(j) / factorial(i + j + 2);
                INFO(points << " points, b1^" << i << " b2^" << j);
                if (i + j <= degree)
                    CHECK(sum == Approx(exact).margin(4e-16));
                else
                    worst_beyond = std::max(worst_beyond, std::abs(sum - exact));
            }
        CHECK(worst_beyond > 1e-9);  // the stated degree is the true one
        for (const auto& [b1, b2, weight] : rule.nodes) CHECK((b1 > 0 && b2 > 0 && b1 + b2 < 1 && weight > 0));
    }
    CHECK(triangle_rule(0).nodes.size() == 1);
    CHECK(triangle_rule(4).nodes.size() == 6);
    CHECK(triangle_rule(13).nodes.size() == 16);
}

TEST_CASE("solid angles of triangles: an octant, the walls of a closed room, and the back", "[format][sample_points]") {
    const TriangleCorners octant{Vec3{1, 0, 0}, Vec3{0, 0, 1}, Vec3{0, 1, 0}};
    CHECK(solid_angle(octant, {}) == Approx(std::numbers::pi / 2).epsilon(1e-14));
    CHECK(solid_angle({octant[0], octant[2], octant[1]}, {}) == Approx(-std::numbers::pi / 2).epsilon(1e-14));
    CHECK(solid_angle(octant, (octant[0] + octant[1]) * 0.5) == Approx(0).margin(1e-12));  // on its edge: in its plane
    const std::array<Vec3, 4> corner{Vec3{1, 1, 1}, Vec3{1, -1, -1}, Vec3{-1, 1, -1}, Vec3{-1, -1, 1}};
    double all = 0;
    for (const auto& f : {std::array<std::size_t, 3>{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}})
        all += solid_angle({corner[f[0]], corner[f[1]], corner[f[2]]}, {0.1, 0.2, -0.15});
    CHECK(std::abs(all) == Approx(4 * std::numbers::pi).epsilon(1e-14));
}

TEST_CASE("points of a triangle as seen are spread evenly over its solid angle, however close it is", "[format][sample_points]") {
    const TriangleCorners triangle{Vec3{-1, 0, -1}, Vec3{0.5, 0, 2}, Vec3{2, 0, -1}};  // looks up
    const Vec3 up{0, 1, 0};
    constexpr std::uint32_t kPoints = 4096;
    // 4096 points of a net count any of these shapes to a hundredth.
    for (const double height : {1e-3, 0.1, 1.0, 30.0, 3000.0})
        for (const Vec3& foot : {Vec3{0.3, 0, -0.2}, Vec3{-1, 0, -1}, Vec3{1.5, 0, 1.5}}) {
            const Vec3 from = foot + up * height;
            const SeenTriangle seen(from, triangle);
            INFO("height " << height << " over " << foot.x << ", " << foot.z);
            REQUIRE(seen.solid_angle() > 0);
            // Halves by a line from the first corner, and the cosine-weighted mean: the form factor.
            const Vec3 middle = (triangle[1] + triangle[2]) * 0.5;
            const double half = solid_angle({triangle[0], triangle[1], middle}, from) / seen.solid_angle();
            const auto side = [&](const Vec3& p) { return cross(middle - triangle[0], p - triangle[0]).y; };
            double in_half = 0, factor = 0;
            for (const auto& s : sobol_points(kPoints, 3)) {
                const Vec3 p = seen.point(double(s[0]), double(s[1]));
                REQUIRE(std::abs(p.y) <= 1e-9 * (1 + height));
                in_half += (side(p) > 0) == (side(triangle[1]) > 0) ? 1.0 / kPoints : 0.0;
                factor += dot(from - p, up) / length(from - p) / kPoints * seen.solid_angle() / std::numbers::pi;
            }
            CHECK(in_half == Approx(half).margin(0.01));
            CHECK(factor == Approx(point_to_triangle(from, -up, triangle)).epsilon(0.01));
        }
}
