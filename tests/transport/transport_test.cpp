// Laws that the reusable method must obey, and its agreement with the Monte Carlo reference.
#include "solver/transport/transport.h"

#include <catch2/catch.hpp>

#include "format/parallel.h"
#include "solver/study/reference.h"
#include "tests/support/meshes.h"
#include "tests/support/scenes.h"
#include "tests/support/shapes.h"
#include "tests/support/solutions.h"

namespace rro::test {
namespace {

// A room with a lamp, a ball and three boxes, one of them sheared: closed, coloured, with far and near pairs.
Scene furnished_room() {
    Affine3 sheared = translation({-0.5, 0.401, 0.3});
    sheared.linear.rows[0] = {1, 0.2, 0};
    return make_scene({
        {turned_inside_out(make_box(4, 2.5, 4, 8, {0, 1.25, 0})), {}, {0.7, 0.6, 0.5}, {}, "room"},
        {make_quad(0.8, 0.8, false, 4), {kUpsideDown, {0, 2.49, 0}}, {0, 0, 0}, {10, 10, 8}, "lamp"},
        {make_sphere(3, 0.4), translation({0.9, 0.401, -0.4}), {0.3, 0.5, 0.7}, {}, "ball"},
        {make_box(0.6, 0.8, 0.6, 3), sheared, {0.8, 0.2, 0.2}, {}, "box"},
        {make_two_boxes(0.3, 0.1, 2), translation({0.2, 0.151, 1.2}), {0.5, 0.5, 0.5}, {}, "pair"},
    });
}

}  // namespace

TEST_CASE("a closed room of equal walls settles at M / (1 - rho)", "[transport]") {
    for (const double rho : {0.0, 0.5, 0.9}) {
        const Scene scene = make_scene({{turned_inside_out(make_box(1, 2, 3)), {}, {rho, rho, rho}, {1, 1, 1}}});
        const Solution s = solve_reusably(scene, 0.02);
        const double expected = 1 / (1 - rho);
        // Asked: 2 % of the reflected part root mean square, three times that for the worst triangle.
        for (const Rgb& b : s.instances[0].radiosity)
            CHECK(double(b.x) == Approx(expected).margin(3 * 0.02 * (expected - 1) + 1e-6));
        CHECK(s.converged);
    }
}

TEST_CASE("a sphere seen from inside is a furnace too", "[transport]") {
    const Scene scene = make_scene({{turned_inside_out(make_sphere(2)), {}, {0.5, 0.5, 0.5}, {1, 1, 1}}});
    const Solution s = solve_reusably(scene, 0.03);
    for (const Rgb& b : s.instances[0].radiosity) CHECK(double(b.x) == Approx(2.0).margin(3 * 0.03));
}

TEST_CASE("irradiance from an emitting square is its view factor", "[transport]") {
    // Howell C-11: facing unit squares at distance 1. The emitter shines down on a receiver that reflects nothing back.
    const Mesh quad = make_quad(1, 1);
    const Vec3 half{0.5, 0.5, 0.5}, none{}, one{1, 1, 1};
    const Affine3 turned{kUpsideDown, {0, 1, 0}};
    const double facing = 0.199824895698387;
    SECTION("unobstructed") {
        const Scene scene = make_scene({{quad, {}, half, none}, {quad, turned, none, one}});
        CHECK(irradiance(scene, solve_reusably(scene, 0.01), 0).mean == Approx(facing).epsilon(0.01));
    }
    SECTION("a square of side 1/2 midway blocks half of it") {
        const Scene scene = make_scene(
            {{quad, {}, half, none}, {quad, turned, none, one}, {make_quad(0.5, 0.5), translation({0, 0.5, 0}), none, none}});
        CHECK(irradiance(scene, solve_reusably(scene, 0.03), 0).mean == Approx(0.0995062945989848).epsilon(0.03));
    }
    SECTION("a mirrored instance receives on the same side") {
        Affine3 mirror;
        mirror.linear.rows[0] = {-1, 0, 0};
        const Scene scene = make_scene({{quad, mirror, half, none}, {quad, turned, none, one}});
        CHECK(irradiance(scene, solve_reusably(scene, 0.01), 0).mean == Approx(facing).epsilon(0.01));
    }
    SECTION("a back is black") {
        const Scene scene = make_scene({{quad, {}, half, none}, {quad, translation({0, 1, 0}), none, one}});
        CHECK(irradiance(scene, solve_reusably(scene, 0.01), 0).mean == 0);
    }
    SECTION("all lengths times three change nothing") {
        const auto scaled = [](Affine3 m) {
            for (Vec3& row : m.linear.rows) row *= 3;
            m.translation *= 3;
            return m;
        };
        const Scene scene = make_scene({{quad, scaled({}), half, none}, {quad, scaled(turned), none, one}});
        CHECK(irradiance(scene, solve_reusably(scene, 0.01), 0).mean == Approx(facing).epsilon(0.01));
    }
}

TEST_CASE("a furnished room agrees with the reference", "[transport]") {
    const Scene scene = furnished_room();
    ReferenceOptions reference;
    reference.samples = 256;
    const auto truth = solve_reference(scene, reference);
    REQUIRE(truth);
    for (const double accuracy : {0.1, 0.05}) {
        const Solution s = solve_reusably(scene, accuracy);
        const double noise = truth->estimated_error;
        const double error = std::sqrt(std::max(0.0, std::pow(difference(scene, s, *truth), 2) - noise * noise));
        INFO("asked " << accuracy << ", error " << error << ", estimate " << s.estimated_error << ", reference noise "
                      << noise << ", links " << s.links.total() << ", rays " << s.rays << ", sweeps " << s.iterations);
        CHECK(error <= 1.5 * accuracy);
        CHECK(s.converged);
    }
}

namespace {

/// A cupboard without doors: back, sides, bottom, top and two boards, both sides of each; 1.2 m wide, 2 m high, 0.4 m deep.
Mesh make_shelf(int divisions) {
    Mesh shelf = empty_mesh(false);
    const Vec3 width{1.2, 0, 0}, height{0, 2, 0}, depth{0, 0, 0.4};
    add_parallelogram(shelf, {-0.6, 0, 0}, width, height, divisions, true);
    for (const double x : {-0.6, 0.6}) add_parallelogram(shelf, {x, 0, 0}, depth, height, divisions, true);
    for (const double y : {0.0, 0.6, 1.2, 2.0}) add_parallelogram(shelf, {-0.6, y, 0}, depth, width, divisions, true);
    return shelf;
}

}  // namespace

TEST_CASE("the inside of deep objects agrees with the reference", "[transport]") {
    Affine3 lamp = translation({0.4, 2.6, 1.6});
    lamp.linear = kUpsideDown;
    const Placed light{make_quad(0.3, 0.3), lamp, {0, 0, 0}, {100, 100, 100}, "lamp"};
    Affine3 stretched = {};
    stretched.linear.rows[0] = {1.5, 0.3, 0};  // no similarity: exchange areas do not scale
    const Mesh shelf = make_shelf(8);
    struct Case {
        std::string what;
        std::vector<Placed> placed;
    };
    const std::vector<Case> cases{
        {"a shelf", {{shelf, {}, {0.7, 0.7, 0.7}, {}, "shelf"}, light}},
        {"a shelf that holds a ball, which stands between its walls",
         {{shelf, {}, {0.7, 0.7, 0.7}, {}, "shelf"},
          {make_sphere(3, 0.15, {0.1, 0.76, 0.2}), {}, {0.5, 0.5, 0.5}, {}, "ball"},
          light}},
        {"a shelf drawn out and sheared", {{shelf, stretched, {0.7, 0.7, 0.7}, {}, "shelf"}, light}},
        {"a seat under its back", {{make_seat(8), {}, {0.7, 0.7, 0.7}, {}, "seat"}, light}},
    };
    for (const Case& c : cases) {
        const Scene scene = make_scene(c.placed);
        ReferenceOptions reference;
        reference.samples = 256;
        const auto truth = solve_reference(scene, reference);
        REQUIRE(truth);
        const double noise = truth->estimated_error;
        for (const double accuracy : {0.1, 0.05}) {
            const Solution s = solve_reusably(scene, accuracy);
            const double error = std::sqrt(std::max(0.0, std::pow(difference(scene, s, *truth), 2) - noise * noise));
            INFO(c.what << ": asked " << accuracy << ", error " << error << ", reference noise " << noise << ", links "
                        << s.links.total() << ", of them within objects " << s.links.self << ", rays " << s.rays);
            CHECK(s.links.self > 0);
            CHECK(error <= 1.5 * accuracy);
        }
    }
}

TEST_CASE("effects that are switched off do not light anything", "[transport]") {
    const Scene scene = furnished_room();
    const auto without = [&](const char* effect) {
        auto plan = plan_effects(scene, {{}, {effect}});
        REQUIRE(plan);
        TransportOptions options;
        options.accuracy = 0.1;
        auto solution = solve_reusable(scene, *plan, options);
        REQUIRE(solution);
        return std::move(*solution);
    };
    const Solution direct = without("interreflection"), full = solve_reusably(scene, 0.1);
    CHECK(irradiance(scene, direct, 0).mean > 0);
    CHECK(irradiance(scene, direct, 0).mean < 0.7 * irradiance(scene, full, 0).mean);
    CHECK(without("occlusion").rays == 0);
    CHECK(without("self").links.self == 0);
}

TEST_CASE("the number of threads does not change a bit", "[transport]") {
    const Scene scene = furnished_room();
    std::vector<Solution> solutions;
    for (const unsigned threads : {1u, 2u, 5u}) {
        set_thread_count(threads);
        solutions.push_back(solve_reusably(scene, 0.1));
    }
    set_thread_count(0);
    for (std::size_t k = 1; k < solutions.size(); ++k)
        for (std::size_t i = 0; i < scene.instances.size(); ++i)
            CHECK(solutions[k].instances[i].radiosity == solutions[0].instances[i].radiosity);
}

}  // namespace rro::test
