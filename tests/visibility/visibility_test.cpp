#include "solver/visibility/visibility.h"

#include <catch2/catch.hpp>

#include "format/parallel.h"
#include "solver/visibility/clearance.h"
#include "tests/support/shafts.h"
#include "tests/support/shapes.h"
#include "tests/support/solutions.h"

using namespace rro;
using namespace rro::test;

namespace {

constexpr std::array kMethods{VisibilityMethod::Auto, VisibilityMethod::Atlas, VisibilityMethod::Tables,
                              VisibilityMethod::Rays, VisibilityMethod::None};

Solution solve_by(const Scene& scene, VisibilityMethod method, double accuracy) {
    auto plan = plan_effects(scene, {});
    REQUIRE(plan);
    TransportOptions options;
    options.accuracy = accuracy;
    options.visibility = method;
    auto solution = solve_reusable(scene, *plan, options);
    REQUIRE(solution);
    return std::move(*solution);
}

Scene cluttered_room() {
    return make_scene({{turned_inside_out(make_box(4, 4, 4)), {}, {0.6, 0.6, 0.6}},
                       {make_torus(12, 6, 0.7, 0.25), translation({0.6, 0, 0.3}), {0.5, 0.5, 0.5}},
                       {make_dented_sphere(1, 0.4), translation({-0.9, -0.4, 0}), {0.5, 0.5, 0.5}},
                       {make_quad(0.8, 0.8), {kUpsideDown, {0, 1.9, 0}}, {}, {10, 10, 10}}});
}

}  // namespace

TEST_CASE("without visibility everything passes", "[visibility]") {
    const Scene scene = make_scene({{make_sphere(1)}}, visibility_tables());
    const SceneRays rays(scene);
    const Visibility none(scene, rays, VisibilityMethod::None);
    for (const Shaft& shaft : shafts_through(0.9, 0.5, 5)) {
        const Transmittance t = none.transmittance(shaft, {});
        CHECK(t.mean == 1);
        CHECK(t.error() == 0);
        CHECK(t.rays == 0);
    }
}

TEST_CASE("what is said to be clear meets no ray", "[visibility][clearance]") {
    const Affine3 place{{{Vec3{1, 0.4, 0}, Vec3{-0.3, 1, 0.2}, Vec3{0, 0, 0.7}}}, {0.2, -0.1, 0.3}};
    const Scene scene = make_scene({{make_torus(24, 12, 0.8, 0.15), place}}, visibility_tables());
    const SceneRays rays(scene);
    int clear = 0, open = 0;
    for (const Shaft& shaft : shafts_through(1.2, 0.2, 400)) {
        const double v = true_transmittance(scene, rays, shaft);
        if (v == 1) ++open;
        if (!certainly_clear(shaft, scene.instances[0])) continue;
        ++clear;
        CHECK(v == 1);
    }
    CHECK(open > 50);
    CHECK(clear > open / 4);  // and not too seldom: half of them, as boxes go
}

TEST_CASE("what lies behind the ends of a shaft is not in its way", "[visibility][clearance]") {
    const Scene scene = make_scene({{turned_inside_out(make_box(2, 2, 2, 4))}}, visibility_tables());
    ShaftEnd floor = parallelogram_end({0.25, -1, 0.25}, {0.5, 0, 0}, {0, 0, 0.5});
    ShaftEnd wall = parallelogram_end({-1, 0.25, 0.25}, {0, 0.5, 0}, {0, 0, 0.5});
    Shaft shaft;
    shaft.a = floor;
    shaft.b = wall;
    CHECK_FALSE(certainly_clear(shaft, scene.instances[0]));  // it touches both walls
    shaft.a.front = {0, 1, 0}, shaft.a.height = -1;
    shaft.b.front = {1, 0, 0}, shaft.b.height = -1;
    CHECK(certainly_clear(shaft, scene.instances[0]));
    // A thin wall in front of one of them is.
    const Scene thin = make_scene({{make_box(1e-5, 2, 2), translation({-1 + 1e-5, 0, 0})}});
    CHECK_FALSE(certainly_clear(shaft, thin.instances[0]));
}

TEST_CASE("visibility does not depend on the number of threads", "[visibility]") {
    const Scene scene = make_scene({{make_torus(24, 12, 0.7, 0.25)}}, visibility_tables());
    const SceneRays rays(scene);
    std::vector<Shaft> shafts = shafts_through(0.95, 0.3, 100);
    std::vector<std::vector<std::uint32_t>> neighbours(shafts.size());
    for (std::uint32_t i = 1; i < shafts.size(); ++i) neighbours[i] = {i - 1}, neighbours[i - 1].push_back(i);
    Demand demand;
    demand.rule = StopRule::Paper;
    for (const VisibilityMethod method : kMethods) {
        const Visibility visibility(scene, rays, method);
        const auto means = [&](unsigned threads) {
            set_thread_count(threads);
            std::vector<double> out;
            for (const Transmittance& t : visibility.transmittances(shafts, neighbours, demand)) out.push_back(t.mean + t.rays);
            set_thread_count(0);
            return out;
        };
        CHECK(means(1) == means(3));
    }
}

TEST_CASE("solutions by every method do not depend on the number of threads", "[visibility][solver]") {
    const Scene scene = cluttered_room();
    for (const VisibilityMethod method : kMethods) {
        const auto radiosities = [&](unsigned threads) {
            set_thread_count(threads);
            const Solution s = solve_by(scene, method, 0.5);
            set_thread_count(0);
            std::vector<float> out;
            for (const InstanceSolution& i : s.instances)
                for (const Rgb& b : i.radiosity) out.push_back(b.y);
            return out;
        };
        CHECK(radiosities(1) == radiosities(2));
    }
}

TEST_CASE("every method finds about the same light", "[visibility][solver]") {
    const Scene scene = cluttered_room();
    const Solution by_rays = solve_by(scene, VisibilityMethod::Rays, 0.15);
    for (const VisibilityMethod method : {VisibilityMethod::Atlas, VisibilityMethod::Tables, VisibilityMethod::Auto}) {
        const SceneError e = compare(scene, solve_by(scene, method, 0.15), by_rays);
        CAPTURE(static_cast<int>(method));
        CHECK(e.all.error() < 0.21);  // each within 0.15 of the truth by its own estimate
    }
}

TEST_CASE("a closed room inside a closed room lets nothing in, to the last bit", "[visibility]") {
    const double turn = 0.4, thin = 1e-5, size = 1.2;
    const Affine3 askew{{{Vec3{std::cos(turn), 0, std::sin(turn)}, Vec3{0, 1, 0}, Vec3{-std::sin(turn), 0, std::cos(turn)}}},
                        {0.2, -0.3, 0.1}};
    const Mesh inner = merged(make_box(size, size, size, 2),
                              turned_inside_out(make_box(size - 2 * thin, size - 2 * thin, size - 2 * thin, 2)));
    const Scene scene = make_scene({{turned_inside_out(make_box(4, 4, 4, 2))}, {inner, askew}}, visibility_tables());
    const SceneRays rays(scene);
    std::uint64_t state = 3;
    for (int k = 0; k < 200; ++k) {
        // From the middle, a wall, an edge or a corner of the inner room to anywhere between the two.
        const double half = size / 2 - 2 * thin;
        const auto place = [&] { return half * std::clamp(4 * uniform(state) - 2, -1.0, 1.0); };
        const Vec3 inside = askew.point({place(), place(), place()});
        const Vec3 outside = askew.translation + random_direction(state) * (1.1 + 0.4 * uniform(state));
        const double width = k % 4 == 0 ? 0.4 : 1e-6;  // the wide ones from the middle
        const Shaft shaft = shaft_between(square(k % 4 == 0 ? askew.translation : inside, random_direction(state), width),
                                          square(outside, random_direction(state), width), mix64(state));
        for (const VisibilityMethod method : kMethods)
            if (method != VisibilityMethod::None)
                CHECK(Visibility(scene, rays, method).transmittance(shaft, fixed_rays(64)).mean == 0);
    }
}

TEST_CASE("a closed room inside a lit room stays dark to the last bit", "[visibility][solver]") {
    const Scene scene = make_scene({{turned_inside_out(make_box(4, 4, 4)), {}, {0.6, 0.6, 0.6}},
                                    {turned_inside_out(make_box(1.2, 1.2, 1.2)), translation({0.2, -0.3, 0.1}), {0.7, 0.7, 0.7}},
                                    {make_sphere(0, 0.3), translation({1.4, 1.2, 0}), {}, {50, 50, 50}}});
    const Solution s = solve_by(scene, VisibilityMethod::Auto, 0.3);
    CHECK(irradiance(scene, s, 0).mean > 0.1);
    CHECK(irradiance(scene, s, 1).rms == 0);
}

TEST_CASE("a wall of a hundredth of a millimetre lit from one side leaks nothing", "[visibility][solver]") {
    constexpr double kThin = 1e-5;
    // The wall divides the room along an edge of the room's own triangles; each half has a sphere in it.
    const Scene scene = make_scene({{turned_inside_out(make_box(4, 2, 2, 2)), {}, {0.6, 0.6, 0.6}},
                                    {make_box(kThin, 2, 2), {}, {0.6, 0.6, 0.6}},
                                    {make_sphere(0, 0.3), translation({1, 0, 0}), {0.6, 0.6, 0.6}},
                                    {make_sphere(0, 0.3), translation({-1, 0, 0}), {}, {20, 20, 20}}});
    for (const VisibilityMethod method :
         {VisibilityMethod::Rays, VisibilityMethod::Auto, VisibilityMethod::Atlas, VisibilityMethod::Tables}) {
        CAPTURE(static_cast<int>(method));
        const Solution s = solve_by(scene, method, 0.3);
        CHECK(irradiance(scene, s, 2).rms == 0);
        double dark = 0, lit = 0;
        const Instance& wall = scene.instances[1];
        for (std::uint32_t f = 0; f < wall.data().faces.size(); ++f) {
            const Vec3 normal = area_vector(wall.world_corners(wall.data().faces[f]));
            if (normal.x > 0.5 * length(normal)) dark += double(s.instances[1].irradiance[f].y);
            if (normal.x < -0.5 * length(normal)) lit += double(s.instances[1].irradiance[f].y);
        }
        CHECK(dark == 0);
        CHECK(lit > 1);
    }
}
