#include "solver/solve_scene.h"

#include "tests/scene/scene_files.h"

using namespace rro;
using namespace rro::test;
using Catch::Matchers::Contains;

namespace {

/// One convex box: nothing to link, so that solves are instant.
constexpr const char* kBox = R"({"name": "a", "archive": "box.rro"})";

Solution solved(const Scene& scene, const SolveOptions& options) {
    auto solution = solve_scene(scene, options);
    if (!solution) FAIL(solution.error().message);
    return std::move(*solution);
}

}  // namespace

TEST_CASE("the command line's accuracy beats the manifest's, which beats 0.02", "[solve_scene]") {
    SceneFiles files;
    const Scene with = files.open(files.instances(kBox, ", \"accuracy\": 0.3"));
    const Scene without = files.open(files.instances(kBox));
    SolveOptions given;
    given.accuracy = 0.1;
    CHECK(solved(with, given).accuracy == 0.1);
    CHECK(solved(with, {}).accuracy == 0.3);
    CHECK(solved(without, {}).accuracy == 0.02);
}

TEST_CASE("a solution carries the effects and the plan's warnings", "[solve_scene]") {
    SceneFiles files;
    SolveOptions options;
    options.overrides.without = {"colour"};
    const Solution solution = solved(files.open(files.instances(kBox)), options);
    CHECK(solution.effects.size() == 12);
    REQUIRE_FALSE(solution.warnings.empty());
    CHECK_THAT(solution.warnings[0], Contains("--without colour"));
    CHECK(solution.instances.size() == 1);
    CHECK(solution.seconds.total >= solution.seconds.plan);
}

TEST_CASE("a scene without light is exactly 0 at once, and says so", "[solve_scene]") {
    SceneFiles files;
    const Scene dark = files.open(files.instances(
        R"({"name": "a", "archive": "box.rro", "materials": {"*": {"exitance": [0, 0, 0]}}})",
        R"(, "sky": {"radiance": [0, 0, 0]})"));
    for (const Method method : {Method::Reusable, Method::Reference}) {
        SolveOptions options;
        options.method = method;
        const Solution s = solved(dark, options);
        CHECK(s.converged);
        CHECK(s.estimated_error == 0);
        CHECK(s.rays == 0);
        CHECK(s.links.total() == 0);
        CHECK(s.instances[0].radiosity == std::vector<Rgb>(dark.instances[0].data().faces.size()));
        CHECK(s.instances[0].standard_error.empty() == (method == Method::Reusable));
        REQUIRE(s.warnings.size() == 1);
        CHECK_THAT(s.warnings[0], Contains("nothing gives light"));
    }
}

TEST_CASE("options that the method does not know are wrong usage", "[solve_scene]") {
    SceneFiles files;
    const Scene scene = files.open(files.instances(kBox));
    const auto message = [&](const SolveOptions& options) {
        const auto solution = solve_scene(scene, options);
        REQUIRE_FALSE(solution);
        CHECK(solution.error().kind == ErrorKind::Usage);
        return solution.error().message;
    };
    SolveOptions samples;
    samples.samples = 4;
    CHECK_THAT(message(samples), Contains("--samples is for --method reference"));
    SolveOptions blind{.method = Method::Reference, .accuracy = {}, .overrides = {}};
    blind.visibility = VisibilityMethod::None;
    CHECK_THAT(message(blind), Contains("--visibility none is for --method reusable"));
    SolveOptions parts{.method = Method::Reference, .accuracy = {}, .overrides = {}};
    parts.overrides.without = {"occlusion"};
    CHECK_THAT(message(parts), Contains("--without occlusion is for --method reusable"));
    for (const Transport transport : {Transport::Directional, Transport::Plain}) {
        SolveOptions carried{.method = Method::Reference, .accuracy = {}, .overrides = {}};
        carried.transport = transport;
        CHECK_THAT(message(carried), Contains("--transport is for --method reusable"));
    }
    SolveOptions unknown;
    unknown.overrides.with = {"magic"};
    CHECK_THAT(message(unknown), Contains("no such effect"));
}

TEST_CASE("samples asked for are the reference's whole work, else the accuracy decides", "[solve_scene]") {
    Solution rough;
    rough.converged = false;
    SolveOptions options;
    CHECK_FALSE(work_done(rough, options));
    options.method = Method::Reference;
    CHECK_FALSE(work_done(rough, options));
    options.samples = 16;
    CHECK(work_done(rough, options));
    rough.converged = true;
    CHECK(work_done(rough, {}));
}

TEST_CASE("the estimate of memory grows with the instances", "[solve_scene]") {
    SceneFiles files;
    const std::string second = std::string(",") + R"({"name": "b", "archive": "box.rro"})";
    CHECK(estimated_memory(files.open(files.instances(kBox + second))) >
          estimated_memory(files.open(files.instances(kBox))));
}
