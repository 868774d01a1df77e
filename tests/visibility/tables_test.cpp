#include <catch2/catch.hpp>

#include "tests/support/shafts.h"
#include "tests/support/shapes.h"

using namespace rro;
using namespace rro::test;

namespace {

struct Errors {
    double rms = 0, unlike = 0;  // against the truth; the largest difference from exact rays along the same lines
};

Errors errors_of(const Scene& scene, const TableOptions& options, std::uint32_t lines) {
    const SceneRays rays(scene);
    const Visibility tables(scene, rays, VisibilityMethod::Tables, options), exact(scene, rays, VisibilityMethod::Rays);
    Errors e;
    const auto shafts = shafts_through(0.9, 0.6, 40);
    for (const Shaft& shaft : shafts) {
        const double x = tables.transmittance(shaft, fixed_rays(lines)).mean;
        e.rms += std::pow(x - true_transmittance(scene, rays, shaft), 2) / double(shafts.size());
        e.unlike = std::max(e.unlike, std::abs(x - exact.transmittance(shaft, fixed_rays(lines)).mean));
    }
    e.rms = std::sqrt(e.rms);
    return e;
}

TableOptions options_of(double tolerance, bool dice = false, bool intrinsic = true) {
    TableOptions o;
    o.tolerance = tolerance;
    o.dice = dice;
    o.intrinsic = intrinsic;
    return o;
}

Scene ring() { return make_scene({{make_torus(24, 12, 0.7, 0.25)}}, visibility_tables(true)); }

}  // namespace

TEST_CASE("the error of hit probabilities falls with the area that may be missed", "[visibility][tables]") {
    const Scene scene = ring();
    constexpr std::uint32_t kLines = 1024;  // leaves 0.01 of their own
    const double coarse = errors_of(scene, options_of(10), kLines).rms, middle = errors_of(scene, options_of(0.3), kLines).rms,
                 fine = errors_of(scene, options_of(0.01), kLines).rms;
    CAPTURE(coarse, middle, fine);
    CHECK(middle < coarse);
    CHECK(fine < middle);
    CHECK(fine < 0.01);
}

TEST_CASE("where nothing may be missed, tables and rays are the same", "[visibility][tables]") {
    const Scene scene =
        make_scene({{make_torus(24, 12, 0.7, 0.25), {{{Vec3{0, -1, 0}, Vec3{1.2, 0, 0.1}, Vec3{0, 0, 0.8}}}, {}}}}, visibility_tables());
    // Probabilities are rounded to 32 steps: a volume that is hit by more than 63 in 64 lines is taken for solid. A few
    // lines of 256 pass such a one.
    CHECK(errors_of(scene, options_of(0), 256).unlike <= 6.0 / 256);
}

TEST_CASE("a dice is right on average", "[visibility][tables]") {
    const Scene scene = ring();
    const SceneRays rays(scene);
    constexpr std::uint32_t kLines = 4096;
    const Visibility dice(scene, rays, VisibilityMethod::Tables, options_of(0.1, true));
    const Visibility chance(scene, rays, VisibilityMethod::Tables, options_of(0.1, false));
    for (const Shaft& shaft : shafts_through(0.9, 0.6, 8)) {
        const double p = chance.transmittance(shaft, fixed_rays(kLines)).mean;
        // Four binomial deviations of the dice alone, the lines being the same.
        CHECK(dice.transmittance(shaft, fixed_rays(kLines)).mean == Approx(p).margin(4 * std::sqrt(0.25 / kLines)));
    }
}

TEST_CASE("an object's own probabilities are less biased than the whole object's", "[visibility][tables]") {
    // A volume's own triangles, and any of the object's: through a box the second is never the smaller.
    const Scene scene = ring();
    const SceneRays rays(scene);
    const Visibility own(scene, rays, VisibilityMethod::Tables, options_of(0.1, false, true));
    const Visibility whole(scene, rays, VisibilityMethod::Tables, options_of(0.1, false, false));
    double sum_own = 0, sum_whole = 0;
    for (const Shaft& shaft : shafts_through(0.9, 0.6, 40)) {
        sum_own += own.transmittance(shaft, fixed_rays(64)).mean;
        sum_whole += whole.transmittance(shaft, fixed_rays(64)).mean;
    }
    CHECK(sum_whole < sum_own);
}
