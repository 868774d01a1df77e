#include "solver/study/reference.h"

#include <catch2/catch.hpp>

#include "format/parallel.h"
#include "tests/support/scenes.h"

using namespace rro;
using namespace rro::test;

namespace {

Solution solve(const Scene& scene, std::uint32_t samples, double accuracy = 0.02) {
    ReferenceOptions options;
    options.samples = samples;
    options.accuracy = accuracy;
    auto solution = solve_reference(scene, options);
    REQUIRE(solution);
    return std::move(*solution);
}

Placed floor_panel(double reflectance, double exitance) {
    return panel({0, 0, 0}, {0, 0, 1}, {1, 0, 0}, reflectance, exitance);
}
Placed ceiling_panel(double exitance) {
    return panel({0, 1, 0}, {1, 0, 0}, {0, 0, 1}, 0, exitance);
}

}  // namespace

// With M = 1 on the emitter, and the receiver black, the receiver's mean irradiance is its form factor to the emitter.
// Samples of E lie in [0, 1] with a standard deviation of at most 0.4, stratified; two faces of 2^15 samples each give
// a standard error below 0.4 / 256 = 0.0016. Tolerance: 0.005, three of them; seed fixed.
TEST_CASE("irradiance under a unit emitter is the exact form factor", "[reference]") {
    constexpr std::uint32_t kSamples = 1 << 15;
    const auto factor = [&](std::vector<Placed> placed) {
        const Scene scene = make_scene(placed, least_tables());
        return irradiance(scene, solve(scene, kSamples), 0).mean;
    };
    SECTION("facing unit squares (Howell C-11)") {
        CHECK(factor({floor_panel(0, 0), ceiling_panel(1)}) == Approx(0.199824895698387).margin(0.005));
    }
    SECTION("unit squares at right angles with a common edge (C-14)") {
        CHECK(factor({floor_panel(0, 0), panel({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 0, 1)}) ==
              Approx(0.200043776075403).margin(0.005));
    }
    SECTION("facing unit squares, half a square midway: black and one-sided, its back blocks as its front does") {
        const Vec3 corner{0.25, 0.5, 0.25}, x{0.5, 0, 0}, z{0, 0, 0.5};
        CHECK(factor({floor_panel(0, 0), ceiling_panel(1), panel(corner, x, z, 0, 0)}) ==
              Approx(0.0995062945989848).margin(0.005));
        CHECK(factor({floor_panel(0, 0), ceiling_panel(1), panel(corner, z, x, 0, 0)}) ==
              Approx(0.0995062945989848).margin(0.005));
    }
    SECTION("squares that turn their backs") {
        CHECK(factor({panel({0, 0, 0}, {1, 0, 0}, {0, 0, 1}, 0, 0), ceiling_panel(1)}) == 0);
        CHECK(factor({floor_panel(0, 0), panel({0, 1, 0}, {0, 0, 1}, {1, 0, 0}, 0, 1)}) == 0);
    }
}

TEST_CASE("the same factor where the objects are mirrored, sheared and stretched into place", "[reference]") {
    // The floor square, from a parallelogram twice as long, by a transform with a negative determinant.
    const Affine3 mirrored{{{Vec3{-0.5, 0.3, 0}, Vec3{0, 2, 0}, Vec3{0.25, 0, 1}}}, {1, -1, 0.5}};
    REQUIRE(mirrored.linear.determinant() < 0);
    const auto before = [&](const Vec3& p) { return mirrored.inverse().point(p); };
    // In the object the front must lie on the side that becomes the top: v x u, as mirroring turns the winding.
    const Vec3 o = before({0, 0, 0}), x = before({1, 0, 0}) - o, z = before({0, 0, 1}) - o;
    Placed receiver = panel(o, x, z, 0, 0);
    receiver.to_world = mirrored;
    const Scene scene = make_scene({receiver, ceiling_panel(1)}, least_tables());
    const Solution s = solve(scene, 1 << 15);
    CHECK(irradiance(scene, s, 0).mean == Approx(0.199824895698387).margin(0.005));
    CHECK(s.energy.emitted.x == Approx(1.0).epsilon(1e-6));  // 1 W/m^2 on 1 m^2, whatever the transform
}

TEST_CASE("inside the unit cube: opposite and adjacent walls, rows sum to 1", "[reference]") {
    // One emitting wall, five black ones, in one archive per wall.
    const Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1}, o{0, 0, 0}, c{1, 1, 1};
    const Scene scene =
        make_scene({panel(o, z, x, 0, 0), panel(o, x, y, 0, 0), panel(o, y, z, 0, 0), panel(c, -1 * y, -1 * x, 0, 0),
                    panel(c, -1 * z, -1 * y, 0, 0), panel(c, -1 * x, -1 * z, 0, 1)},
                   least_tables());
    const Solution s = solve(scene, 1 << 14);
    CHECK(irradiance(scene, s, 0).mean == Approx(0.199824895698387).margin(0.006));
    double sum = irradiance(scene, s, 0).mean;
    for (std::size_t i = 1; i < 5; ++i) {
        CHECK(irradiance(scene, s, i).mean == Approx(0.200043776075403).margin(0.006));
        sum += irradiance(scene, s, i).mean;
    }
    CHECK(sum == Approx(1.0).margin(0.01));
    CHECK(irradiance(scene, s, 5).mean == 0);  // the emitter sees only black walls
    CHECK(s.energy.escaped.x == 0);     // closed
}

TEST_CASE("white furnace: B = M / (1 - rho) on every face, and the reported errors are honest", "[reference]") {
    const double rho = GENERATE(0.0, 0.5, 0.9);
    // Exitance differs between the two bodies: M = B0 (1 - rho) gives B0 = 1 with any shadows.
    const Vec3 grey = Vec3{1, 1, 1} * rho, darker = Vec3{1, 1, 1} * (rho / 2);
    const Scene scene = make_scene({{turned_inside_out(make_box(2, 1.5, 1, 2)), {}, grey, Vec3{1, 1, 1} - grey},
                                    {make_sphere(1, 0.3), {}, darker, Vec3{1, 1, 1} - darker}},
                                   least_tables());
    const Solution s = solve(scene, 512);
    double squares = 0, worst = 0;
    int count = 0;
    for (const InstanceSolution& instance : s.instances)
        for (std::size_t f = 0; f < instance.radiosity.size(); ++f) {
            // A face that saw no noise is exact but for float rounding.
            const double error = instance.standard_error[f].x, off = instance.radiosity[f].x - 1.0;
            if (error < 1e-6) {
                CHECK(std::abs(off) < 1e-6);
                continue;
            }
            squares += off * off / (error * error);
            worst = std::max(worst, std::abs(off) / error);
            ++count;
        }
    if (rho == 0) {
        CHECK(count == 0);  // nothing is reflected, so B is known
    } else {
        REQUIRE(count > 100);
        // Mean of `count` squared deviates of t type with 63 degrees of freedom: 1.03, standard error sqrt(2.2 / 128).
        CHECK(squares / count > 0.65);
        CHECK(squares / count < 1.45);
        CHECK(worst < 4.5);  // 4 standard errors, or a little more for one of 128 faces with an estimated deviation
    }
    CHECK(s.energy.escaped.x == 0);
    CHECK(s.energy.absorbed.x == Approx(s.energy.emitted.x).epsilon(0.02));
}

TEST_CASE("energy: what is emitted is absorbed or escapes", "[reference]") {
    // An open lamp over a floor that shows its black back to nobody, and one that shows it to the lamp.
    const Scene scene =
        make_scene({floor_panel(0.5, 0), ceiling_panel(2), panel({2, 0, 0}, {1, 0, 0}, {0, 0, 1}, 0.5, 0)}, least_tables());
    const Solution s = solve(scene, 1 << 13);
    CHECK(s.energy.emitted.x == Approx(2.0).epsilon(1e-6));
    CHECK(s.energy.escaped.x > 1);
    // Shares of 2 W known to a standard error of about 0.4 / sqrt(2^14).
    CHECK(s.energy.absorbed.x + s.energy.escaped.x == Approx(2.0).margin(0.03));
}

TEST_CASE("interreflection between facing squares", "[reference]") {
    // rho = 0.5 and 0.8, M = 1 and 0; one constant each: 1.01623124088395 and 0.162454641372062 (exact). The continuous
    // solution differs from it by the radiosity's variation over the squares, well under 1 % of B here.
    const Scene scene = make_scene({floor_panel(0.5, 1), panel({0, 1, 0}, {1, 0, 0}, {0, 0, 1}, 0.8, 0)}, least_tables());
    const Solution s = solve(scene, 1 << 14);
    const auto mean = [&](std::size_t i) {
        return 0.5 * (s.instances[i].radiosity[0].x + s.instances[i].radiosity[1].x);
    };
    CHECK(mean(0) == Approx(1.01623124088395).margin(0.003));
    CHECK(mean(1) == Approx(0.162454641372062).margin(0.005));
}

TEST_CASE("both sides of a two-sided panel emit and reflect", "[reference]") {
    Mesh panel = make_quad(1, 1, true);
    const Scene scene = make_scene(
        {{panel, {}, {0.5, 0.5, 0.5}, {1, 1, 1}}, {turned_inside_out(make_box(4, 4, 4)), {}, {0.5, 0.5, 0.5}, {}}},
        least_tables());
    const Solution s = solve(scene, 256);
    REQUIRE(s.instances[0].radiosity.size() == 4);
    CHECK(s.energy.emitted.x == Approx(2.0).epsilon(1e-6));  // 2 M A
    // The room is symmetric about the panel, so all four faces agree; noise of rho E with E < 0.1.
    for (const Rgb& b : s.instances[0].radiosity) CHECK(b.x == Approx(s.instances[0].radiosity[0].x).margin(0.02));
    CHECK(s.instances[0].radiosity[0].x > 1.0);
}

TEST_CASE("the same numbers for any number of threads, others for another seed", "[reference]") {
    const Scene scene = make_scene({{turned_inside_out(make_box(2, 1.5, 1, 2)), {}, {0.5, 0.6, 0.7}, {}, "room"},
                                    {make_sphere(1, 0.3), {}, {0.3, 0.3, 0.3}, {1, 2, 3}, "lamp"}},
                                   least_tables());
    const auto with_threads = [&](unsigned threads) {
        set_thread_count(threads);
        const Solution s = solve(scene, 32);
        set_thread_count(0);
        return s;
    };
    const Solution one = with_threads(1), two = with_threads(2);
    for (std::size_t i = 0; i < one.instances.size(); ++i) {
        CHECK(one.instances[i].radiosity == two.instances[i].radiosity);
        CHECK(one.instances[i].standard_error == two.instances[i].standard_error);
    }
    CHECK(one.rays == two.rays);
    CHECK(one.energy.escaped == two.energy.escaped);

    ReferenceOptions other;
    other.samples = 32;
    other.seed = 2;
    CHECK((*solve_reference(scene, other)).instances[0].radiosity != one.instances[0].radiosity);
}

TEST_CASE("samples double until the accuracy asked is reached", "[reference]") {
    const Scene scene = make_scene({{turned_inside_out(make_box(2, 1.5, 1)), {}, {0.5, 0.5, 0.5}, {}},
                                    {make_box(0.3, 0.3, 0.3), {}, {0.2, 0.2, 0.2}, {1, 1, 1}}},
                                   least_tables());
    const Solution coarse = solve(scene, 0, 0.1), fine = solve(scene, 0, 0.02);
    CHECK(coarse.converged);
    CHECK(coarse.estimated_error <= 0.1);
    CHECK(fine.converged);
    CHECK(fine.estimated_error <= 0.02);
    CHECK(fine.rays > coarse.rays);
    // Errors are independent between two seeds: their difference must have the size that they claim together.
    ReferenceOptions options;
    options.accuracy = 0.02, options.seed = 9;
    const Solution again = std::move(*solve_reference(scene, options));
    double difference = 0, signal = 0;
    for (std::size_t i = 0; i < 2; ++i)
        for (std::size_t f = 0; f < fine.instances[i].radiosity.size(); ++f) {
            const double area =
                length(area_vector(scene.instances[i].world_corners(scene.instances[i].data().faces[f])));
            const double emitted = i == 0 ? 0 : 1, a = fine.instances[i].radiosity[f].x - emitted;
            difference += area * std::pow(a + emitted - again.instances[i].radiosity[f].x, 2);
            signal += area * a * a;
        }
    const double claimed = std::hypot(fine.estimated_error, again.estimated_error);
    // 24 faces dominated by the room's 12: the ratio's own deviation is about 1 / sqrt(24).
    CHECK(std::sqrt(difference / signal) < 1.7 * claimed);
    CHECK(std::sqrt(difference / signal) > 0.4 * claimed);
}

TEST_CASE("a scene without light is dark and done", "[reference]") {
    const Scene scene = make_scene({floor_panel(0.5, 0)}, least_tables());
    const Solution s = solve(scene, 0);
    CHECK(s.converged);
    CHECK(s.estimated_error == 0);
    for (const Rgb& b : s.instances[0].radiosity) CHECK(b == Rgb{0, 0, 0});
}

TEST_CASE("a senseless accuracy is refused", "[reference]") {
    ReferenceOptions options;
    options.accuracy = 0;
    CHECK_FALSE(solve_reference(make_scene({floor_panel(0.5, 0)}, least_tables()), options));
}
