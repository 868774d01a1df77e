// Few rays, and what they say about themselves.
#include <catch2/catch.hpp>

#include "tests/stability/sound.h"
#include "tests/support/shafts.h"

namespace rro::test {
namespace {

/// A shaft of which the share v passes: lines whose first coordinate lies below v.
Tally tally_of(double v, const Demand& demand, std::uint64_t seed) {
    Shaft shaft;
    shaft.seed = mix64(seed);
    shaft.segment = [](const std::array<float, 4>& u) { return Segment{{double(u[0]), double(u[2]), 0}, {}, {}, {}}; };
    return sample(shaft, demand, [v](const Segment& s) { return s.p.x < v ? 1.0 : 0.0; });
}

constexpr std::uint64_t kSeeds = 100;

std::vector<std::pair<std::string, Demand>> demands() {
    std::vector<std::pair<std::string, Demand>> out;
    for (const auto& [name, points] : {std::pair("Sobol", LinePoints::Sobol), std::pair("independent", LinePoints::Independent)}) {
        Demand laplace;
        laplace.rule = StopRule::Laplace;
        laplace.points = points;
        out.emplace_back(std::string("Laplace's rule, ") + name + " points", laplace);
        out.emplace_back(std::string("64 rays, ") + name + " points", fixed_rays(64, points));
    }
    out.emplace_back("a link's rule, Sobol points", link_demand(100, 2));
    return out;
}

}  // namespace

TEST_CASE("visibility of 0, 1 and nearly so", "[stability][sampling]") {
    for (const auto& [name, demand] : demands()) {
        for (const double v : {0.0, 1.0, 1e-3, 1 - 1e-3, 0.02, 0.5}) {
            double squares = 0, stated = 0;
            Worst certain, exact, outside;
            int beyond = 0;
            for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
                const Tally tally = tally_of(v, demand, seed);
                const Transmittance t = outcome(demand, tally);
                squares += std::pow(t.mean - v, 2) / double(kSeeds);
                stated += std::pow(t.error(), 2) / double(kSeeds);
                outside.add(t.mean - 1);
                outside.add(-t.mean);
                if (tally.unanimous()) certain.add(t.error() > 0 ? 0 : 1);
                if (v == 0 || v == 1) exact.add(std::abs(t.mean - v));
                beyond += std::abs(t.mean - v) > 3 * t.error();
            }
            const std::string what = name + ", seeds 1 to 100";
            // The mean of 100 squares is known to a tenth or two.
            record("sampling", what, "error over the error stated, root mean square", 1.2, std::sqrt(squares / stated));
            record("sampling", what, "more than three stated errors off; seeds", 2, beyond);
            record("sampling", what, "rays that agree are never taken for certain; seeds", 0, certain.value());
            record("sampling", what, "0 <= mean <= 1, and 0 and 1 exactly where no ray or all pass", 0, std::max(exact.value(), outside.value()));
        }
    }
}

TEST_CASE("a hole of a thousandth, and a post of a thousandth", "[stability][sampling]") {
    // A screen between two panels, with a slit of a thousandth of its width, or a blade of that width and nothing else. Lines
    // are parallel to within the panels' own coordinates: from (x, y) to (x', y'), through the middle ((x + x') / 2, ...).
    const auto scene_of = [](bool slit) {
        Mesh mesh = empty_mesh(false);
        if (slit) {
            add_parallelogram(mesh, {-1, -1, 0}, {1 - 0.0005, 0, 0}, {0, 2, 0}, 1, true);
            add_parallelogram(mesh, {0.0005, -1, 0}, {1 - 0.0005, 0, 0}, {0, 2, 0}, 1, true);
        } else {
            add_parallelogram(mesh, {-0.0005, -1, 0}, {0.001, 0, 0}, {0, 2, 0}, 1, true);
        }
        return make_scene({{mesh}}, visibility_tables());
    };
    for (const bool slit : {true, false}) {
        const Scene scene = scene_of(slit);
        const SceneRays rays(scene);
        const Visibility visibility(scene, rays, VisibilityMethod::Rays);
        // The middle of two uniform x is triangular with density 2 at 0: over a width of 0.001 the share is 0.002 (1 - 0.0005).
        const double v = slit ? 0.002 * (1 - 0.0005) : 1 - 0.002 * (1 - 0.0005);
        double mean = 0, squares = 0, stated = 0;
        for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
            const Shaft shaft = shaft_between({{0, 0, -1}, {1, 0, 0}, {0, 1, 0}}, {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}}, mix64(seed));
            const Transmittance t = visibility.transmittance(shaft, fixed_rays(64));
            mean += t.mean / double(kSeeds);
            squares += std::pow(t.mean - v, 2) / double(kSeeds);
            stated += std::pow(t.error(), 2) / double(kSeeds);
        }
        const std::string what = slit ? "a slit that lets 0.2 % pass, 100 x 64 rays" : "a blade that stops 0.2 %, 100 x 64 rays";
        // 6,400 rays: binomial deviation 5.6e-4; three of them.
        record("sampling", what, "the mean over all seeds, absolute", 3 * std::sqrt(v * (1 - v) / 6400), std::abs(mean - v));
        record("sampling", what, "error over the error stated, root mean square", 1.2, std::sqrt(squares / stated));
    }
}

TEST_CASE("ends within an object's hull", "[stability][sampling]") {
    // Between two squares amid a hollow object is nothing of it, although every line through them goes on to meet it: tables know
    // of whole lines.
    const std::vector<std::pair<std::string, Mesh>> hollow{
        {"a hollow ball", make_sphere(3)}, {"a hollow box", make_box(2, 2, 2, 3)}, {"the hole of a torus", make_torus(24, 12, 1, 0.2)}};
    for (const auto& [name, mesh] : hollow) {
        const Scene scene = make_scene({{mesh}}, visibility_tables());
        const SceneRays rays(scene);
        for (const VisibilityMethod method : {VisibilityMethod::Rays, VisibilityMethod::Tables, VisibilityMethod::Atlas, VisibilityMethod::Auto}) {
            const Visibility visibility(scene, rays, method);
            Worst stopped;
            std::uint64_t state = 7;
            for (int k = 0; k < 100; ++k) {
                // Half sides of 0.1 and centres within 0.5 stay clear of all three.
                const auto end = [&] { return square(random_direction(state) * (0.5 * std::cbrt(uniform(state))), random_direction(state), 0.2); };
                const Panel a = end(), b = end();
                const Transmittance t = visibility.transmittance(shaft_between(a, b, mix64(state)), fixed_rays(16));
                stopped.add(1 - t.mean);
            }
            record("sampling", "squares within " + name + ", every method", "nothing is between; share of the light stopped", 0, stopped.value());
        }
    }
}

TEST_CASE("solutions of a hundred seeds", "[stability][sampling]") {
    // A floor half in the shadow of a screen: what seeds differ in is what rays are asked.
    constexpr double kAccuracy = 0.2;
    const Scene scene = make_scene({{make_quad(2, 2, false, 2), {}, {0.5, 0.5, 0.5}, {}},
                                    {make_quad(1, 1, true), translation({0.2, 0.5, 0.1}), {0.5, 0.5, 0.5}, {}},
                                    {make_quad(0.6, 0.6), turned_down({0, 1.5, 0}), {}, {5, 5, 5}}},
                                   coarse_tables());
    const auto plan = plan_effects(scene, {{}, {}});
    REQUIRE(plan);
    std::vector<Solution> solutions;
    for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
        TransportOptions options;
        options.accuracy = kAccuracy;
        options.seed = seed;
        auto s = solve_reusable(scene, *plan, options);
        REQUIRE(s);
        check_sound("sampling", scene, *s);
        solutions.push_back(std::move(*s));
    }
    Solution mean = solutions[0];
    for (std::size_t i = 0; i < mean.instances.size(); ++i)
        for (std::size_t f = 0; f < mean.instances[i].radiosity.size(); ++f) {
            Vec3 sum;
            for (const Solution& s : solutions) sum += to_double(s.instances[i].radiosity[f]);
            mean.instances[i].radiosity[f] = to_float(sum / double(kSeeds));
        }
    Worst worst;
    double stated = 0, squares = 0;
    for (const Solution& s : solutions) {
        const double error = compare(scene, s, mean).all.error();
        worst.add(error / kAccuracy);
        squares += error * error;
        stated += s.estimated_error * s.estimated_error;
    }
    record("sampling", "a floor half in shadow, seeds 1 to 100", "each within the accuracy of their mean; worst", 1, worst.value());
    record("sampling", "a floor half in shadow, seeds 1 to 100", "deviation over the error estimated, root mean square", 1,
           std::sqrt(squares / stated));
}

}  // namespace rro::test
