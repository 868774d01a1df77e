// The reference against closed forms, one effect at a time. Seeds are fixed; tolerances are about four standard errors of
// what is sampled, or single precision's where nothing is.
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "format/sample_points.h"
#include "solver/study/reference.h"
#include "tests/support/scenes.h"

using namespace rro;
using namespace rro::test;
using std::numbers::pi;

namespace {

constexpr double kFloat = 1e-6;  // results are stored in single precision

Solution solve(const Scene& scene, std::uint32_t samples) {
    ReferenceOptions options;
    options.samples = samples;
    auto solution = solve_reference(scene, options);
    REQUIRE(solution);
    return std::move(*solution);
}

Vec3 all(double value) {
    return {value, value, value};
}

/// A square of edge 1 about the origin, front up, in divisions^2 cells.
Scene one_square(double reflectance = 0, bool two_sided = false, int divisions = 1) {
    return make_scene({{make_quad(1, 1, two_sided, divisions), {}, all(reflectance), {}}}, least_tables());
}

Side side_of(const Scene& scene, std::size_t face) {
    return scene.instances[0].data().faces[face].side();
}

Vec3 centre_of(const Scene& scene, std::size_t face) {
    return triangle_point(scene.instances[0].world_corners(scene.instances[0].data().faces[face]), 1.0 / 3, 1.0 / 3);
}

double mean_irradiance(const Solution& s, std::size_t instance = 0) {
    double sum = 0;
    for (const Rgb& e : s.instances[instance].irradiance) sum += double(e.x);
    return sum / double(s.instances[instance].irradiance.size());
}

/// Instance 0 lets tau through on both sides.
void transmit(Scene& scene, double tau) {
    scene.instances[0].transmittance.assign(scene.instances[0].data().patches.size(), to_float(all(tau)));
}

void check_balance(const Solution& s, double tolerance) {
    for (int c = 0; c < 3; ++c)
        CHECK(s.energy.absorbed[c] + s.energy.escaped[c] == Approx(s.energy.emitted[c]).epsilon(tolerance));
}

}  // namespace

TEST_CASE("a uniform sky on an unobstructed plane: E = pi L on both sides, without noise", "[reference][sky]") {
    Scene scene = one_square(0.5, true);
    scene.sky = Sky::uniform({1, 2, 3}, false);
    const Solution s = solve(scene, 32);
    for (const Rgb& e : s.instances[0].irradiance) {
        CHECK(double(e.x) == Approx(pi).epsilon(kFloat));
        CHECK(double(e.z) == Approx(3 * pi).epsilon(kFloat));
    }
    CHECK(s.estimated_error < kFloat);
    CHECK(s.energy.emitted.x == Approx(2 * pi).epsilon(kFloat));
    check_balance(s, kFloat);

    scene.sky = Sky::uniform({1, 1, 1}, true);
    const Solution above = solve(scene, 32);
    for (std::size_t f = 0; f < above.instances[0].irradiance.size(); ++f)
        CHECK(double(above.instances[0].irradiance[f].x) ==
              Approx(side_of(scene, f) == Side::Front ? pi : 0).epsilon(kFloat));
}

TEST_CASE("the CIE overcast sky: 7/9 pi L_z horizontally, pi/6 + 4/9 L_z vertically above black ground", "[reference][sky]") {
    Scene scene = one_square();
    scene.sky = Sky::cie_overcast(all(9), true);
    // L varies by a third of its mean over cosine-weighted directions: 7 pi x 0.2 / sqrt(2^13) is 0.05 without any gain from
    // stratification.
    CHECK(mean_irradiance(solve(scene, 1 << 12)) == Approx(7 * pi).margin(0.05));
    Scene wall = make_scene({{make_quad(1, 1), {Mat3{{Vec3{0, 1, 0}, Vec3{1, 0, 0}, Vec3{0, 0, -1}}}, {}}, {}, {}}}, least_tables());
    wall.sky = scene.sky;
    // Half of the directions meet the ground: a standard deviation of about 15.
    CHECK(mean_irradiance(solve(wall, 1 << 13)) == Approx(9 * (pi / 6 + 4.0 / 9)).margin(0.1));
}

TEST_CASE("a picture with a bright pixel lights as its integral says, with little noise", "[reference][sky]") {
    std::vector<Rgb> pixels(32 * 16, Rgb{0.5f, 0.5f, 0.5f});
    pixels[3 * 32 + 9] = {2000, 1000, 500};
    Scene scene = one_square();
    scene.sky = Sky::image(32, 16, pixels, false);
    double expected = 0;  // midpoints, 8 x 8 in each pixel: 1e-4 of the bright one
    const int rows = 16 * 8, columns = 32 * 8;
    for (int r = 0; r < rows / 2; ++r)
        for (int c = 0; c < columns; ++c) {
            const double polar = pi * (r + 0.5) / rows, longitude = pi - 2 * pi * (c + 0.5) / columns;
            const Vec3 from{std::sin(polar) * std::sin(longitude), std::cos(polar), std::sin(polar) * std::cos(longitude)};
            const double solid_angle = (std::cos(pi * r / rows) - std::cos(pi * (r + 1) / rows)) * 2 * pi / columns;
            expected += scene.sky->radiance(from).x * from.y * solid_angle;
        }
    const Solution s = solve(scene, 1 << 12);
    CHECK(mean_irradiance(s) == Approx(expected).epsilon(0.01));
    // The bright pixel has 4 % of the cosine-weighted directions' share 1 in 200: chance alone would leave noise of 20 %.
    scene.instances[0].reflectance.assign(scene.instances[0].reflectance.size(), to_float(all(0.5)));
    CHECK(solve(scene, 1 << 12).estimated_error < 0.01);
}

TEST_CASE("the sun: cosine law, exact where it has no extent, and nothing behind", "[reference][sun]") {
    for (const double degrees : {0.0, 30.0, 60.0, 89.0}) {
        Scene scene = one_square(0.5, true);
        const double angle = degrees * pi / 180;
        scene.sun = Sun{{std::sin(angle), -std::cos(angle), 0}, {800, 700, 600}, 0};
        const Solution s = solve(scene, 16);
        for (std::size_t f = 0; f < s.instances[0].irradiance.size(); ++f)
            CHECK(double(s.instances[0].irradiance[f].y) ==
                  Approx(side_of(scene, f) == Side::Front ? 700 * std::cos(angle) : 0).epsilon(kFloat));
        check_balance(s, 1e-5);
    }
}

TEST_CASE("the sun's half shadow is as wide as its disc asks, and falls as the disc is covered", "[reference][sun]") {
    // A screen at height 1 covers x < 0; the sun stands above with a half angle whose tangent is 0.5.
    const double radius = std::atan(0.5), reach = std::sin(radius);
    Scene scene = make_scene({{make_quad(2, 0.1, false, 20), {}, {}, {}},
                              {make_quad(4, 8), translation({-2, 1, 0}), {}, {}}},
                             least_tables());
    scene.sun = Sun{{0, -1, 0}, all(1000), radius};
    const Solution s = solve(scene, 256);
    // E at x: the share of the disc with x + dx / dy > 0, by midpoints of its unit square.
    const auto expected = [&](double x) {
        constexpr int steps = 200;
        double lit = 0, of = 0;
        for (int i = 0; i < steps; ++i)
            for (int j = 0; j < steps; ++j) {
                const double u = 2 * (i + 0.5) / steps - 1, v = 2 * (j + 0.5) / steps - 1;
                if (u * u + v * v > 1) continue;
                ++of;
                if (x + reach * u / std::sqrt(1 - reach * reach * (u * u + v * v)) > 0) ++lit;
            }
        return 1000 * lit / of;
    };
    std::array<double, 20> columns{};  // mean of each column of cells, 0.1 wide, from x = -1
    for (std::size_t f = 0; f < s.instances[0].irradiance.size(); ++f)
        columns[std::size_t((centre_of(scene, f).x + 1) / 0.1)] += double(s.instances[0].irradiance[f].x) / 40;
    for (std::size_t i = 0; i < columns.size(); ++i) {
        const double x = -1 + 0.1 * double(i);
        if (x + 0.1 < -0.5) CHECK(columns[i] == 0);
        if (x > 0.5) CHECK(columns[i] == Approx(1000).epsilon(1e-5));
        // 40 faces of 256 samples: 500 / sqrt(10240) = 5 at most, less by stratification.
        const double mean = (expected(x + 0.01) + expected(x + 0.03) + expected(x + 0.05) + expected(x + 0.07) + expected(x + 0.09)) / 5;
        CHECK(columns[i] == Approx(mean).margin(20));
    }
}

TEST_CASE("a point light gives its intensity times the solid angle", "[reference][lights]") {
    for (const double height : {0.5, 1.0, 2.0, 20.0}) {
        Scene scene = one_square();
        PointLight light;
        light.position = {0, height, 0};
        light.intensity = all(10);
        scene.lights = {light};
        const double solid_angle = 4 * std::asin(1 / (1 + 4 * height * height));  // of a unit square from above its middle
        const double e = mean_irradiance(solve(scene, 1 << 12));
        CHECK(e == Approx(10 * solid_angle).epsilon(0.005));
        if (height == 20.0) CHECK(e == Approx(10 / 400.0).epsilon(0.005));  // the inverse square
    }
}

TEST_CASE("a spot lights what lies in its cone, an IES lamp by its table", "[reference][lights]") {
    Scene scene = one_square(0, false, 16);
    PointLight light;
    light.position = {0, 1, 0};
    light.intensity = all(10);
    light.cone_cosine = std::cos(std::atan(0.3));  // a circle of radius 0.3 on the square
    scene.lights = {light};
    const auto check = [&](const auto& expected, double inside, double outside) {
        const Solution s = solve(scene, 64);
        int checked = 0;
        for (std::size_t f = 0; f < s.instances[0].irradiance.size(); ++f) {
            const Vec3 c = centre_of(scene, f);
            const double r = std::hypot(c.x, c.z), cosine = 1 / std::hypot(1, r);
            if (r > inside && r < outside) continue;
            // E varies by 10 % within a cell of 1/16 at most; the mean of 64 samples by 1 %.
            CHECK(double(s.instances[0].irradiance[f].x) == Approx(expected(r) * std::pow(cosine, 3)).epsilon(0.02));
            ++checked;
        }
        CHECK(checked > 100);
    };
    constexpr double cell = 1.0 / 16;
    check([](double r) { return r < 0.3 ? 10.0 : 0.0; }, 0.3 - cell, 0.3 + cell);
    // 0 at the axis, rising with the angle to its brightest at 90 degrees.
    scene.lights[0].cone_cosine = -1;
    scene.lights[0].measured = std::make_shared<IesDistribution>(IesDistribution{{0, 90}, {0}, {100, 300}});
    check([](double r) { return 10 * (1.0 / 3 + 2.0 / 3 * std::atan(r) / (pi / 2)); }, 2, 2);
}

TEST_CASE("a point light in a closed room: all of 4 pi I is absorbed", "[reference][lights]") {
    Scene scene = make_scene({{turned_inside_out(make_box(3, 2, 4, 2)), {}, all(0.5), {}}}, least_tables());
    PointLight light;
    light.position = {0.3, 0.2, -0.4};
    light.intensity = {1, 2, 3};
    scene.lights = {light};
    const Solution s = solve(scene, 1 << 10);
    // 48 faces of 1024 samples; E varies by less than 3 within a face: 3 / sqrt(49152) = 1.4 %.
    CHECK(s.energy.emitted.y == Approx(8 * pi).epsilon(0.02));
    CHECK(s.energy.escaped == Vec3{});
    check_balance(s, 0.02);
}

TEST_CASE("a plate under the sky reflects upwards and transmits downwards", "[reference][transmission]") {
    Scene scene = one_square(0.3, true);
    transmit(scene, 0.4);
    scene.sky = Sky::uniform(all(1), true);
    const Solution s = solve(scene, 32);
    for (std::size_t f = 0; f < s.instances[0].radiosity.size(); ++f)
        CHECK(double(s.instances[0].radiosity[f].x) ==
              Approx((side_of(scene, f) == Side::Front ? 0.3 : 0.4) * pi).epsilon(kFloat));
    check_balance(s, kFloat);
}

TEST_CASE("a closed diffusing shell under a uniform sky: B = tau pi L / (1 - rho) inside, whatever its shape",
          "[reference][transmission]") {
    // Inside, every point sees radiosity B only: B = tau pi L + rho B. Outside B = rho pi L + tau B_inside.
    Mesh shell = make_box(2, 1, 1.5, 2);
    shell.two_sided.assign(shell.two_sided.size(), 1);
    shell.closed = false;
    const double rho = 0.5, tau = 0.3, inside = tau * pi / (1 - rho);
    Scene scene = make_scene({{shell, {}, all(rho), {}}}, least_tables());
    transmit(scene, tau);
    scene.sky = Sky::uniform(all(1), false);
    const Solution s = solve(scene, 1 << 10);
    double squares = 0;
    for (std::size_t f = 0; f < s.instances[0].radiosity.size(); ++f) {
        const double expected = side_of(scene, f) == Side::Back ? inside : rho * pi + tau * inside;
        const double off = double(s.instances[0].radiosity[f].x) - expected;
        const double error = double(s.instances[0].standard_error[f].x);
        CHECK(error > 0);
        CHECK(error < 0.05);
        squares += off * off / (error * error);
    }
    // 96 faces, t-distributed with 127 degrees of freedom; both sides of a triangle share their samples' noise, so a
    // standard deviation of up to sqrt(2 * 2 / 96) about 1.02.
    squares /= double(s.instances[0].radiosity.size());
    CHECK(squares > 0.5);
    CHECK(squares < 1.7);
    check_balance(s, 0.01);
}

TEST_CASE("Beer-Lambert between two plates", "[reference][medium]") {
    constexpr double absorption = 0.8;
    const double expected = irradiance_through(absorption);
    Mesh lamp = make_quad(1, 1);
    const Affine3 turned{kUpsideDown, {0, 1, 0}};
    Scene scene = make_scene({{make_quad(1, 1), {}, {}, {}}, {lamp, turned, {}, all(1)}}, least_tables());
    scene.medium = Medium{{absorption, 0, 2 * absorption}};
    const Solution s = solve(scene, 1 << 13);
    CHECK(mean_irradiance(s, 0) == Approx(expected).margin(0.002));
    CHECK(double(s.instances[0].irradiance[0].y) == Approx(0.199824895698387).margin(0.004));  // clear: Howell C-11
    CHECK(s.energy.absorbed.x + s.energy.escaped.x == Approx(1).margin(0.01));
    CHECK(s.energy.escaped.x == 0);  // the medium ends what misses
    CHECK(s.energy.escaped.y > 0.7);
}

TEST_CASE("a medium weakens lamps by distance, and sky and sun to nothing", "[reference][medium]") {
    Scene scene = one_square();
    PointLight light;
    light.position = {0, 20, 0};
    light.intensity = all(400);
    scene.lights = {light};
    scene.medium = Medium{{0.1, 0, 0.2}};
    const Solution s = solve(scene, 64);
    CHECK(double(s.instances[0].irradiance[0].x) == Approx(std::exp(-2)).epsilon(0.002));
    CHECK(double(s.instances[0].irradiance[0].y) == Approx(1).epsilon(0.002));
    CHECK(double(s.instances[0].irradiance[0].z) == Approx(std::exp(-4)).epsilon(0.002));
    scene.lights.clear();
    scene.sky = Sky::uniform(all(1), false);
    scene.sun = Sun{{0, -1, 0}, all(100), 0};
    const Solution far = solve(scene, 64);
    CHECK(far.instances[0].irradiance[0].x == 0);
    CHECK(double(far.instances[0].irradiance[0].y) == Approx(100 + pi).epsilon(kFloat));
    CHECK(far.energy.emitted.x == 0);
}

TEST_CASE("a closed room gets exactly nothing of sky and sun", "[reference][sky]") {
    Scene scene = make_scene({{turned_inside_out(make_box(3, 2, 4, 3)), {}, all(0.7), {}}}, least_tables());
    scene.sky = Sky::uniform(all(1), false);
    scene.sun = Sun{normalised({1, -2, 0.5}), all(1000), 0.0046};
    const Solution s = solve(scene, 256);
    for (const Rgb& b : s.instances[0].radiosity) CHECK(b == Rgb{});
    CHECK(s.energy.emitted == Vec3{});
    CHECK(s.energy.escaped == Vec3{});
}

TEST_CASE("all effects together balance, and two seeds differ as their errors say", "[reference][effects]") {
    Scene scene = make_scene({{make_quad(2, 2, true, 2), translation({0, 1, 0}), {0.4, 0.3, 0.2}, {}},
                              {make_quad(4, 4, false, 3), {}, {0.5, 0.5, 0.5}, {}},
                              {make_box(0.3, 0.3, 0.3), translation({0.8, 0.3, 0}), {0.2, 0.2, 0.2}, {5, 4, 3}}},
                             least_tables());
    transmit(scene, 0.3);
    scene.sky = Sky::cie_overcast({1, 2, 3}, true);
    scene.sun = Sun{normalised({0.3, -1, 0.2}), {10, 9, 8}, 0.02};
    PointLight light;
    light.position = {-0.5, 0.5, 0.2};
    light.intensity = {2, 2, 2};
    scene.lights = {light};
    const Solution one = solve(scene, 512);
    check_balance(one, 0.03);
    scene.medium = Medium{{0.1, 0, 0.3}};
    check_balance(solve(scene, 512), 0.03);
    scene.medium.reset();
    ReferenceOptions options;
    options.samples = 512, options.seed = 5;
    const Solution other = std::move(*solve_reference(scene, options));
    double squares = 0;
    int count = 0;
    for (std::size_t i = 0; i < one.instances.size(); ++i)
        for (std::size_t f = 0; f < one.instances[i].radiosity.size(); ++f) {
            const double off = double(one.instances[i].radiosity[f].y) - double(other.instances[i].radiosity[f].y);
            const double error = std::hypot(double(one.instances[i].standard_error[f].y), double(other.instances[i].standard_error[f].y));
            if (error < 1e-6) continue;
            squares += off * off / (error * error);
            ++count;
        }
    REQUIRE(count > 30);
    // About 46 squares of deviates, half of them in pairs of sides: 1 with a standard deviation of 0.3.
    CHECK(squares / count > 0.3);
    CHECK(squares / count < 2.2);
}
