// The reusable solver under sky, sun, lamps, through diffuse sheets and in a medium: closed forms, and the reference.
#include <catch2/catch.hpp>

#include <numbers>

#include "solver/effects/shape.h"
#include "tests/support/shapes.h"
#include "tests/support/solutions.h"

namespace rro::test {
namespace {

using std::numbers::pi;

constexpr double kFloat = 1e-6;  // results are stored in single precision

Vec3 all(double value) { return {value, value, value}; }

Scene one_square(double reflectance, bool two_sided) {
    return make_scene({{make_quad(1, 1, two_sided), {}, all(reflectance), {}, "square"}});
}

void transmit(Scene& scene, std::size_t i, double tau) {
    scene.instances[i].transmittance.assign(scene.instances[i].data().patches.size(), to_float(all(tau)));
}

Side side_of(const Scene& scene, std::size_t i, std::size_t face) { return scene.instances[i].data().faces[face].side(); }

PointLight lamp(const Vec3& position, double intensity) {
    PointLight light;
    light.position = position;
    light.intensity = all(intensity);
    return light;
}

}  // namespace

TEST_CASE("a plane under a uniform sky: E = pi L on both sides, and no ray", "[transport][effects]") {
    Scene scene = one_square(0.5, true);
    scene.sky = Sky::uniform(all(2), false);
    const Solution s = solve_reusably(scene, 0.01);
    for (const Rgb& e : s.instances[0].irradiance) CHECK(double(e.x) == Approx(2 * pi).epsilon(kFloat));
    CHECK(s.energy.emitted.x == Approx(4 * pi).epsilon(kFloat));
    CHECK(s.energy.escaped.x == Approx(2 * pi).epsilon(kFloat));
    CHECK(s.rays == 0);
    CHECK(s.converged);
}

TEST_CASE("the sun: the cosine law, and nothing behind", "[transport][effects]") {
    for (const double degrees : {0.0, 60.0, 89.0}) {
        Scene scene = one_square(0.5, true);
        const double angle = degrees * pi / 180;
        scene.sun = Sun{{std::sin(angle), -std::cos(angle), 0}, all(700), 0};
        const Solution s = solve_reusably(scene, 0.02);
        for (std::size_t f = 0; f < s.instances[0].irradiance.size(); ++f)
            CHECK(double(s.instances[0].irradiance[f].y) ==
                  Approx(side_of(scene, 0, f) == Side::Front ? 700 * std::cos(angle) : 0).epsilon(1e-5));
    }
}

TEST_CASE("half of a floor in the shade of a screen: the shadow's edge is found", "[transport][effects]") {
    // The sun without extent, straight above: the floor's half x < 0 gets nothing.
    Scene scene = make_scene({{make_quad(2, 2, false, 1), {}, all(0.5), {}, "floor"},
                              {make_quad(4, 8, false), translation({-2, 1, 0}), all(0), {}, "screen"},
                              {make_quad(0.1, 0.1, false), translation({9, 0, 0}), all(0), {}, "far off"}});
    scene.sun = Sun{{0, -1, 0}, all(100), 0};
    const Solution s = solve_reusably(scene, 0.02);
    CHECK(irradiance(scene, s, 0).mean == Approx(50).epsilon(0.02));
    REQUIRE(!s.instances[0].elements.empty());
    std::size_t whole = 0;
    for (const Element& e : s.instances[0].elements) whole += e.irradiance.x == 0 || e.irradiance.x > 99.9f;
    CHECK(whole > s.instances[0].elements.size() / 2);
}

TEST_CASE("a lamp gives its intensity times the solid angle, far off the inverse square", "[transport][effects]") {
    for (const double height : {0.5, 1.0, 20.0}) {
        Scene scene = one_square(0.5, false);
        scene.lights = {lamp({0, height, 0}, 10)};
        const double solid_angle = 4 * std::asin(1 / (1 + 4 * height * height));  // of a unit square from above its middle
        CHECK(irradiance(scene, solve_reusably(scene, 0.01), 0).mean == Approx(10 * solid_angle).epsilon(0.01));
    }
}

TEST_CASE("a plate under the sky reflects upwards and transmits downwards", "[transport][effects]") {
    Scene scene = one_square(0.3, true);
    transmit(scene, 0, 0.4);
    scene.sky = Sky::uniform(all(1), true);
    // Half of the directions towards the plate's lower side come from the ground, so rows are exact by symmetry of halves.
    const Solution s = solve_reusably(scene, 0.01);
    for (std::size_t f = 0; f < s.instances[0].radiosity.size(); ++f)
        CHECK(double(s.instances[0].radiosity[f].x) ==
              Approx((side_of(scene, 0, f) == Side::Front ? 0.3 : 0.4) * pi).epsilon(0.01));
}

TEST_CASE("a closed diffusing shell under a uniform sky: B = tau pi L / (1 - rho) inside", "[transport][effects]") {
    Mesh shell = make_box(2, 1, 1.5, 2);
    shell.two_sided.assign(shell.two_sided.size(), 1);
    shell.closed = false;
    const double rho = 0.5, tau = 0.3, inside = tau * pi / (1 - rho);
    Scene scene = make_scene({{shell, {}, all(rho), {}, "shell"}});
    transmit(scene, 0, tau);
    scene.sky = Sky::uniform(all(1), false);
    const Solution s = solve_reusably(scene, 0.02);
    for (std::size_t f = 0; f < s.instances[0].radiosity.size(); ++f)
        CHECK(double(s.instances[0].radiosity[f].x) ==
              Approx(side_of(scene, 0, f) == Side::Back ? inside : rho * pi + tau * inside).epsilon(0.03));
    // What comes in through the walls is what they do not send back.
    CHECK(s.energy.escaped.x + s.energy.absorbed.x == Approx(s.energy.emitted.x).epsilon(1e-6));
}

TEST_CASE("Beer-Lambert between two plates", "[transport][effects]") {
    constexpr double absorption = 0.8;
    const double expected = irradiance_through(absorption);
    const Affine3 turned{kUpsideDown, {0, 1, 0}};
    Scene scene = make_scene({{make_quad(1, 1), {}, all(0.5), {}, "floor"}, {make_quad(1, 1), turned, {}, all(1), "lamp"}});
    scene.medium = Medium{all(absorption)};
    CHECK(irradiance(scene, solve_reusably(scene, 0.01), 0).mean == Approx(expected).epsilon(0.02));
    scene.medium = Medium{{absorption, 0, 3 * absorption}};  // each channel by itself
    const Solution coloured = solve_reusably(scene, 0.01);
    for (int c = 0; c < 3; ++c) {
        Scene grey = make_scene({{make_quad(1, 1), {}, all(0.5), {}, "floor"}, {make_quad(1, 1), turned, {}, all(1), "lamp"}});
        if (scene.medium->absorption[c] > 0) grey.medium = Medium{all(scene.medium->absorption[c])};
        const Solution alone = solve_reusably(grey, 0.01);
        double sum = 0, single = 0;
        for (std::size_t f = 0; f < alone.instances[0].irradiance.size(); ++f) {
            sum += to_double(coloured.instances[0].irradiance[f])[c];
            single += to_double(alone.instances[0].irradiance[f])[c];
        }
        CHECK(sum == Approx(single).epsilon(0.04));  // the error asked for is one of all channels: the darkest has a seventh
    }
    scene.medium = Medium{all(absorption)};
    scene.instances.pop_back();
    scene.manifest.instances.pop_back();
    scene.lights = {lamp({0, 20, 0}, 400)};
    CHECK(irradiance(scene, solve_reusably(scene, 0.01), 0).mean == Approx(std::exp(-16)).epsilon(0.01));
}

// Five walls of a unit cube, seen from inside: the hole is a fifth of them.
TEST_CASE("how open a room is, and what is curved, is told from its fronts", "[effects][shape]") {
    const auto object_of = [](const Mesh& mesh) { return compile_to_object(mesh); };
    Mesh room = empty_mesh(false);
    const Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
    add_parallelogram(room, {}, y, z, 2, false);
    add_parallelogram(room, x, z, y, 2, false);
    add_parallelogram(room, {}, z, x, 2, false);
    add_parallelogram(room, {}, x, y, 2, false);
    add_parallelogram(room, z, y, x, 2, false);
    CHECK(openness(object_of(room)->data()) == Approx(0.2).epsilon(1e-6));
    CHECK(openness(object_of(turned_inside_out(make_box(3, 2, 4)))->data()) == Approx(0).margin(1e-6));
    CHECK(openness(object_of(make_box(3, 2, 4))->data()) == 1);
    CHECK(is_curved(object_of(make_sphere(2, 1))->data()));
    CHECK_FALSE(is_curved(object_of(make_box(3, 2, 4, 4))->data()));
}

TEST_CASE("a closed room gets exactly nothing of sky and sun", "[transport][effects]") {
    Scene scene = make_scene({{turned_inside_out(make_box(3, 2, 4, 3)), {}, all(0.7), {}, "room"}});
    scene.sky = Sky::uniform(all(1), false);
    scene.sun = Sun{normalised({1, -2, 0.5}), all(1000), 0.0046};
    const Solution s = solve_reusably(scene, 0.02);
    for (const Rgb& b : s.instances[0].radiosity) CHECK(b == Rgb{});
    CHECK(s.energy.emitted == Vec3{});
}

TEST_CASE("sky, sun, lamps and a sheet together agree with the reference", "[transport][effects]") {
    Scene scene = make_scene({{make_quad(2, 2, true, 4), translation({0, 1, 0}), {0.4, 0.3, 0.2}, {}, "sheet"},
                              {make_quad(4, 4, false, 8), {}, {0.5, 0.5, 0.5}, {}, "floor"},
                              {make_box(0.3, 0.3, 0.3, 2), translation({0.8, 0.3, 0}), {0.2, 0.2, 0.2}, {5, 4, 3}, "box"}});
    transmit(scene, 0, 0.3);
    scene.sky = Sky::cie_overcast({1, 2, 3}, true);
    scene.sun = Sun{normalised({0.3, -1, 0.2}), {10, 9, 8}, 0.02};
    scene.lights = {lamp({-0.5, 0.5, 0.2}, 2)};
    for (const Vec3& absorption : {Vec3{}, all(0.1), Vec3{0.1, 0, 0.4}}) {
        if (absorption != Vec3{}) scene.medium = Medium{absorption};
        const Solution truth = solve_by_paths(scene, 1024);
        for (const double accuracy : {0.1, 0.03}) {
            const Solution s = solve_reusably(scene, accuracy);
            const SceneError e = compare(scene, s, truth);
            INFO("absorption " << absorption.x << " " << absorption.z << ", asked " << accuracy << ", estimate " << s.estimated_error << ", error "
                               << e.all.error() << ", reference " << e.all.truth_error() << ", worst " << e.worst_name);
            CHECK(s.converged);
            CHECK(e.all.error() <= 1.5 * accuracy);
            CHECK(e.worst <= 3 * accuracy);
        }
    }
}

}  // namespace rro::test
