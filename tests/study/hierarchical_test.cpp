#include "solver/study/hierarchical.h"

#include <catch2/catch.hpp>

#include "format/parallel.h"
#include "solver/study/reference.h"
#include "tests/support/scenes.h"
#include "tests/support/shapes.h"

using namespace rro;
using namespace rro::test;

namespace {

Solution solve(const Scene& scene, double accuracy, bool colour = false) {
    HierarchicalOptions options;
    options.accuracy = accuracy;
    options.colour = colour;
    auto solution = solve_hierarchical(scene, options);
    REQUIRE(solution);
    CHECK(solution->converged);
    return std::move(*solution);
}

Placed floor_panel() { return panel({0, 0, 0}, {0, 0, 1}, {1, 0, 0}, 0.5, 0); }
Placed ceiling_panel() { return panel({0, 1, 0}, {1, 0, 0}, {0, 0, 1}, 0, 1); }

/// The error of the reflected radiosity against a reference, without that one's own noise.
double error(const Scene& scene, const Solution& s, const Solution& truth) {
    double difference = 0, noise = 0, all = 0;
    for (std::size_t i = 0; i < scene.instances.size(); ++i)
        for (std::size_t f = 0; f < truth.instances[i].radiosity.size(); ++f) {
            const Instance& instance = scene.instances[i];
            const double a = face_area(instance, f);
            const Vec3 exitance = to_double(instance.exitance[instance.object->patch_of_face[f]]);
            const Vec3 b = to_double(truth.instances[i].radiosity[f]);
            difference += a * length2(to_double(s.instances[i].radiosity[f]) - b);
            noise += a * length2(to_double(truth.instances[i].standard_error[f]));
            all += a * length2(b - exitance);
        }
    return std::sqrt(std::max(0.0, difference - noise) / (all - noise));
}

/// A lamp, a table and a ball in a room of three reflectances.
Scene small_room() {
    const Mesh room = turned_inside_out(make_box(4, 2.5, 3, 2, {0, 1.25, 0}));
    return make_scene({{room, {}, {0.7, 0.6, 0.5}, {}, "room"},
                       {make_box(0.8, 0.04, 0.8, 1, {0, 2.3, 0}), {}, {0.2, 0.2, 0.2}, {20, 18, 14}, "lamp"},
                       {make_box(1.4, 0.06, 0.8, 2, {0.5, 0.75, 0.2}), {}, {0.5, 0.4, 0.2}, {}, "table"},
                       {make_sphere(1, 0.3), translation({-1, 0.4, 0.5}), {0.3, 0.5, 0.7}, {}, "ball"}},
                      least_tables());
}

}  // namespace

TEST_CASE("hierarchical: exact form factors of squares", "[hierarchical]") {
    // Howell C-11 and C-14. Links of a share of the power each may err by kLinkError of it: at accuracy 0.01 the mean is
    // good to 0.5 %, as there is nothing between and the errors of points against areas nearly cancel.
    SECTION("facing") {
        const Scene scene = make_scene({floor_panel(), ceiling_panel()}, least_tables());
        CHECK(irradiance(scene, solve(scene, 0.01), 0).mean == Approx(0.199824895698387).epsilon(0.005));
    }
    SECTION("at right angles with a common edge") {
        const Scene scene = make_scene({floor_panel(), panel({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 0, 1)}, least_tables());
        CHECK(irradiance(scene, solve(scene, 0.01), 0).mean == Approx(0.200043776075403).epsilon(0.005));
    }
    SECTION("half a square midway blocks by its front and by its back") {
        // The shadow's edges are met by 8 rays each: 2 %.
        const Vec3 corner{0.25, 0.5, 0.25}, x{0.5, 0, 0}, z{0, 0, 0.5};
        for (const auto& [u, v] : {std::pair{x, z}, std::pair{z, x}}) {
            const Scene scene = make_scene({floor_panel(), ceiling_panel(), panel(corner, u, v, 0, 0)}, least_tables());
            CHECK(irradiance(scene, solve(scene, 0.01), 0).mean == Approx(0.0995062945989848).epsilon(0.02));
        }
    }
    SECTION("turned away") {
        const Scene scene = make_scene({panel({0, 0, 0}, {1, 0, 0}, {0, 0, 1}, 0.5, 0), ceiling_panel()}, least_tables());
        const Solution s = solve(scene, 0.01);
        CHECK(s.links.total() == 0);
        CHECK(irradiance(scene, s, 0).mean == 0);
    }
}

TEST_CASE("hierarchical: a closed room of one radiosity", "[hierarchical]") {
    // B = M / (1 - rho) everywhere; a row of form factors sums to 1 within the links' error, which bounces multiply.
    const double rho = GENERATE(0.0, 0.5, 0.8);
    const Scene scene = make_scene({{turned_inside_out(make_box(2, 1.5, 1, 2)), {}, Vec3{1, 1, 1} * rho, {1, 1, 1}}}, least_tables());
    const Solution s = solve(scene, 0.02);
    for (const Rgb& b : s.instances[0].radiosity) CHECK(double(b.x) * (1 - rho) == Approx(1).margin(0.03 * rho / (1 - rho) + 1e-6));
    CHECK(s.energy.absorbed.x == Approx(s.energy.emitted.x).epsilon(0.03 / (1 - rho)));
}

TEST_CASE("hierarchical: meets the accuracy asked for against the reference", "[hierarchical]") {
    const Scene scene = small_room();
    ReferenceOptions exact;
    exact.samples = 2048;
    const auto truth = solve_reference(scene, exact);
    REQUIRE(truth);
    double before = 1;
    for (const double accuracy : {0.2, 0.05}) {
        const Solution s = solve(scene, accuracy, true);
        const double found = error(scene, s, *truth);
        INFO("accuracy " << accuracy << ", links " << s.links.total() << ", estimated " << s.estimated_error);
        CHECK(found < accuracy);
        CHECK(found < before);
        before = found;
    }
}

TEST_CASE("hierarchical: elements tile their faces and carry their light", "[hierarchical]") {
    Scene scene = small_room();
    scene.instances[2].to_world.linear.rows[0].x *= -1;  // a mirrored table: its elements keep the archive's corners
    scene.instances[2].to_local = scene.instances[2].to_world.inverse();
    scene.instances[2].determinant_sign = -1;
    const Solution s = solve(scene, 0.1, true);
    std::uint64_t leaves = 0;
    for (const InstanceSolution& instance : s.instances) {
        std::vector<double> area(instance.radiosity.size(), 0), light(instance.radiosity.size(), 0);
        for (const Element& e : instance.elements) {
            const auto& [a, b, c] = e.corner;
            const double share = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
            CHECK(share > 0);  // in the face's own winding
            area[e.face] += share;
            light[e.face] += share * double(e.radiosity.y);
        }
        for (std::size_t f = 0; f < area.size(); ++f) {
            if (area[f] == 0) ++leaves;
            else CHECK(light[f] == Approx(double(instance.radiosity[f].y)).epsilon(1e-5));
            CHECK((area[f] == 0 || area[f] == Approx(1)));
        }
        leaves += instance.elements.size();
    }
    CHECK(s.elements == leaves);
}

TEST_CASE("hierarchical: the same numbers on any number of threads", "[hierarchical]") {
    const Scene scene = small_room();
    set_thread_count(1);
    const Solution one = solve(scene, 0.2, true);
    set_thread_count(0);
    const Solution all = solve(scene, 0.2, true);
    CHECK(one.links.total() == all.links.total());
    CHECK(one.rays == all.rays);
    for (std::size_t i = 0; i < one.instances.size(); ++i) CHECK(one.instances[i].radiosity == all.instances[i].radiosity);
}

TEST_CASE("hierarchical: refuses what memory does not hold, with an estimate", "[hierarchical]") {
    HierarchicalOptions options;
    options.memory = 10000;
    const auto refused = solve_hierarchical(small_room(), options);
    REQUIRE(!refused);
    CHECK(refused.error().kind == ErrorKind::Failed);
    CHECK(refused.error().message.find("MB of memory") != std::string::npos);
}
