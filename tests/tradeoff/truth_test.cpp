#include "solver/tradeoff/truth.h"

#include <fstream>

#include "solver/output/output.h"
#include "tests/support/solutions.h"
#include "tests/support/temporary_folder.h"

using namespace rro;
using namespace rro::test;
using Catch::Matchers::Contains;

namespace {

/// A two-sided square, whose name needs quotes, over a box that shines.
Scene square_over_box() {
    return make_scene({{make_quad(2, 2, true, 2), {}, {0.5, 0.4, 0.3}, {}, "a, \"b\""},
                       {make_box(1, 1, 1, 1, {0, -2, 0}), {}, {0.5, 0.5, 0.5}, {2, 2, 2}, "lamp"}},
                      least_tables());
}

/// Reflected radiosity `r` on every face, known to `noise`.
Solution uniform(const Scene& scene, float r, float noise = 0) {
    Solution s;
    for (const Instance& instance : scene.instances) {
        InstanceSolution& out = s.instances.emplace_back();
        for (std::size_t f = 0; f < instance.data().faces.size(); ++f) {
            const float b = instance.exitance[instance.object->patch_of_face[f]].x + r;
            out.radiosity.push_back({b, b, b});
            out.irradiance.push_back({2 * r, 2 * r, 2 * r});
            out.standard_error.push_back({noise, noise, noise});
        }
    }
    return s;
}

}  // namespace

TEST_CASE("truth: error is relative to what is reflected, and the truth's variance is subtracted", "[truth]") {
    const Scene scene = square_over_box();
    const Truth exact = truth_of(scene, uniform(scene, 1));
    CHECK(measure_error(scene, uniform(scene, 1), exact).error == 0);
    const MeasuredError tenth = measure_error(scene, uniform(scene, 1.1f), exact);
    CHECK(tenth.error == Approx(0.1).epsilon(1e-5));  // floats
    CHECK(tenth.low == tenth.high);                   // no noise, no doubt
    CHECK(tenth.bias == Approx(0.1).epsilon(1e-5));
    CHECK(tenth.worst_error == Approx(0.1).epsilon(1e-5));
    // R_true^2 = 1 - 0.09, off^2 = 0.25 - 0.09.
    const Truth noisy = truth_of(scene, uniform(scene, 1, 0.3f));
    const MeasuredError noisy_error = measure_error(scene, uniform(scene, 1.5f), noisy);
    CHECK(noisy_error.error == Approx(std::sqrt(0.16 / 0.91)).epsilon(1e-5));
    CHECK(noisy_error.low < noisy_error.error);
    CHECK(noisy_error.high > noisy_error.error);
    CHECK(standard_error(scene, noisy) == Approx(std::sqrt(0.09 / 0.91)).epsilon(1e-5));
    // Where all of the difference is noise, nothing is left.
    CHECK(measure_error(scene, uniform(scene, 1.3f), noisy).error == Approx(0).margin(1e-3));
}

TEST_CASE("truth: errors of faces are shares of the scene's root mean square", "[truth]") {
    const Scene scene = square_over_box();
    const auto errors = face_errors(scene, uniform(scene, 2.5f), truth_of(scene, uniform(scene, 2)));
    REQUIRE(errors.size() == 2);
    CHECK(errors[0].size() == scene.instances[0].data().faces.size());
    for (const auto& of_instance : errors)
        for (const float e : of_instance) CHECK(e == Approx(0.25).epsilon(1e-5));
}

TEST_CASE("truth: two references with other random numbers differ by their standard errors", "[truth]") {
    const Scene scene = make_scene({{make_box(2, 2, 2, 4), {}, {0.5, 0.5, 0.5}, {}, "outer"},
                                    {make_box(1, 1, 1, 2, {3, 0, 0}), {}, {0.5, 0.5, 0.5}, {1, 1, 1}, "lamp"}},
                                   least_tables());
    const auto paths = [&](std::uint32_t samples, std::uint64_t seed) {
        auto solved = solve_reference(scene, {0.02, samples, seed});
        REQUIRE(solved);
        return std::move(*solved);
    };
    const Truth truth = truth_of(scene, paths(512, 1));
    const Solution rough = paths(32, 2);
    // The sum runs over some 100 lit faces: its square has a standard deviation of 14 %, the error one of 7 %. Three of them.
    CHECK(measure_error(scene, rough, truth).error == Approx(standard_error(scene, truth_of(scene, rough))).epsilon(0.21));
}

TEST_CASE("truth: its file gives back every number, and can be the radiosity CSV of the reference", "[truth]") {
    const TemporaryFolder folder;
    const Scene scene = square_over_box();
    Solution s = uniform(scene, 1, 0.25f);
    s.instances[0].standard_error[3] = {0.1f, 0.2f, 0.3f};
    s.instances[0].radiosity[5] = {1.0f / 3, 1e-7f, 12345.678f};
    const Truth truth = truth_of(scene, s);
    REQUIRE(write_truth(truth, folder / "truth.csv"));
    const auto again = read_truth(folder / "truth.csv", scene);
    REQUIRE(again);
    for (std::size_t i = 0; i < 2; ++i)
        for (std::size_t k = 0; k < truth.instances[i].faces.size(); ++k) {
            const auto &a = truth.instances[i].faces[k], &b = again->instances[i].faces[k];
            REQUIRE(a.has_value() == b.has_value());
            if (!a) continue;
            CHECK(to_double(a->radiosity) == to_double(b->radiosity));
            CHECK(to_double(a->standard_error) == to_double(b->standard_error));
        }
    // The radiosity CSV has standard errors of fronts only.
    REQUIRE(write_radiosity_csv(scene, uniform(scene, 1, 0.25f), folder / "run.csv"));
    const auto of_run = read_truth(folder / "run.csv", scene);
    REQUIRE(of_run);
    CHECK(standard_error(scene, *of_run) == Approx(standard_error(scene, truth_of(scene, uniform(scene, 1, 0.25f)))));
}

TEST_CASE("truth: a file of something else is refused, with its row", "[truth]") {
    const TemporaryFolder folder;
    const Scene scene = square_over_box();
    const auto refusal = [&](const std::string& text) {
        std::ofstream(folder / "x.csv") << text;
        const auto read = read_truth(folder / "x.csv", scene);
        REQUIRE(!read);
        CHECK(read.error().kind == ErrorKind::BadInput);
        return read.error().where + ": " + read.error().message;
    };
    const std::string header =
        "instance,triangle,radiosity_r,radiosity_g,radiosity_b,back_r,back_g,back_b,stderr_r,stderr_g,stderr_b\n";
    CHECK_THAT(refusal(""), Contains("no columns"));
    CHECK_THAT(refusal("instance,triangle,radiosity_r,radiosity_g,radiosity_b\n"), Contains("stderr"));
    CHECK_THAT(refusal(header + "chair,0,1,1,1,,,,0,0,0\n"), Contains("row 2"));
    CHECK_THAT(refusal(header + "lamp,9999,1,1,1,,,,0,0,0\n"), Contains("row 2"));
    CHECK_THAT(refusal(header + "lamp,0,1,nan,1,,,,0,0,0\n"), Contains("row 2"));
    CHECK_THAT(refusal(header + "lamp,0,1,1,1,,,,0,0\n"), Contains("row 2"));
    CHECK_THAT(refusal(header + "lamp,0,1,1,1,,,,0,0,0\n"), Contains("nothing about triangle"));
}
