#include "solver/study/compare.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/support/scenes.h"
#include "tests/support/temporary_folder.h"

using namespace rro;
using namespace rro::test;
using Catch::Matchers::Contains;

namespace {

/// A box in which every face reflects `reflected` W/m^2, and takes `seconds` to solve.
SolvedScene solved(double reflected, double seconds = 1) {
    SolvedScene s{make_scene({{make_box(1, 2, 3), {}, {0.5, 0.5, 0.5}, {2, 2, 2}, "box"}}, least_tables()), {}, 1000};
    const auto b = static_cast<float>(2 + reflected);
    s.solution.instances.resize(1);
    s.solution.instances[0].radiosity.assign(s.scene.instances[0].data().faces.size(), Rgb{b, b, b});
    s.solution.seconds.total = seconds;
    s.solution.links.near = 7;
    return s;
}

/// A folder with an archive of this name, which nobody reads.
void add_archive(const std::filesystem::path& folder, const std::string& name) {
    std::filesystem::create_directories(folder);
    std::ofstream(folder / name) << "archive";
}

Manifest manifest_of_box() {
    Manifest manifest;
    manifest.path = "room.json";
    manifest.instances.push_back({"box", "somewhere/box.rro", "0123456789abcdef", {}, {}});
    return manifest;
}

}  // namespace

TEST_CASE("compare: a phase is slower only where every neighbouring pair of runs says so", "[compare]") {
    CHECK(phase_times("x", {1, 1.1, 0.9}, {2, 2.1, 1.9}).verdict == TimingVerdict::Slower);
    CHECK(phase_times("x", {2, 2.1, 1.9}, {1, 1.1, 0.9}).verdict == TimingVerdict::Faster);
    CHECK(phase_times("x", {1, 2, 1}, {1.5, 1.5, 1.5}).verdict == TimingVerdict::Same);
    CHECK(phase_times("x", {1}, {2}).verdict == TimingVerdict::Same);  // one run tells nothing of noise
    CHECK(phase_times("x", {0, 0}, {0, 0}).ratio == 1);
    const PhaseTimes t = phase_times("x", {1, 2, 4, 3}, {2, 2, 2, 2});
    CHECK(t.base == 2.5);
    CHECK(t.base_spread == 3);
    CHECK(t.ratio == 0.8);
    CHECK(t.low == 0.5);
    CHECK(t.high == 2);
    // Eight runs: one outlier at each end does not count.
    CHECK(phase_times("x", std::vector<double>(8, 1.0), {2, 2, 2, 0.5, 2, 2, 2, 9}).verdict == TimingVerdict::Slower);
}

TEST_CASE("compare: the difference of reflected radiosity is relative to the base, by area", "[compare]") {
    // Exitance is no part of it: 2 + 1 and 2 + 1.1 W/m^2 differ by a tenth of what is reflected.
    CHECK(radiosity_difference(solved(1), solved(1)).relative_rms == 0);
    const RadiosityDifference all = radiosity_difference(solved(1), solved(1.1));
    CHECK(all.relative_rms == Approx(0.1).epsilon(1e-5));  // floats
    CHECK(all.largest == Approx(0.1).epsilon(1e-5));
    CHECK(all.unmatched == 0);
    CHECK(std::isinf(radiosity_difference(solved(0), solved(1)).relative_rms));
    // One source triangle alone: its share of the area, and its number.
    SolvedScene other = solved(1);
    const ObjectData& data = other.scene.instances[0].data();
    other.solution.instances[0].radiosity[3].y += 0.5f;
    const double area = length(area_vector(data.corners(data.faces[3])));
    const RadiosityDifference one = radiosity_difference(solved(1), other);
    CHECK(one.relative_rms == Approx(std::sqrt(0.25 * area / (3 * data.meta.area))).epsilon(1e-5));
    CHECK(one.triangle == data.source_triangle[data.faces[3].triangle()]);
    CHECK(one.instance == "box");
    CHECK(one.worst_instance == "box");
}

TEST_CASE("compare: triangles are matched by their numbers in the source", "[compare]") {
    // A finer box has the first 12 numbers in common with the coarse one, and more besides.
    SolvedScene fine{make_scene({{make_box(1, 2, 3, 2), {}, {0.5, 0.5, 0.5}, {2, 2, 2}, "box"}}, least_tables()), {}, 0};
    fine.solution.instances.resize(1);
    fine.solution.instances[0].radiosity.assign(48, Rgb{3, 3, 3});
    const RadiosityDifference d = radiosity_difference(solved(1), fine);
    CHECK(d.unmatched == 36);
    CHECK(d.relative_rms == Approx(0).margin(1e-6));
}

TEST_CASE("compare: archives are looked up by file name, without their pins", "[compare]") {
    const TemporaryFolder folder;
    add_archive(folder / "base", "box.rro");
    const auto found = with_archives_in(manifest_of_box(), folder / "base");
    REQUIRE(found);
    CHECK(found->instances[0].archive == folder / "base" / "box.rro");
    CHECK(found->instances[0].content.empty());
    const auto missing = with_archives_in(manifest_of_box(), folder / "head");
    REQUIRE(!missing);
    CHECK(missing.error().kind == ErrorKind::BadInput);
    CHECK_THAT(missing.error().where + missing.error().message, Contains("head") && Contains("box.rro"));
}

TEST_CASE("compare: runs alternate, the first of each is not timed, and thresholds decide", "[compare]") {
    const TemporaryFolder folder;
    add_archive(folder / "base", "box.rro");
    add_archive(folder / "head", "box.rro");
    std::string order;
    const auto compared = [&](std::optional<double> slower, std::optional<double> differs) {
        order.clear();
        auto c = compare_archives(manifest_of_box(), {folder / "base", folder / "head", 3, slower, differs},
                                  [&](const Manifest& m) -> Result<SolvedScene> {
                                      const bool head = m.instances[0].archive.parent_path().filename() == "head";
                                      order += head ? 'B' : 'A';
                                      if (order.size() <= 2) return solved(head ? 1.1 : 1, 100);
                                      return solved(head ? 1.1 : 1, head ? 1.5 : 1);
                                  });
        REQUIRE(c);
        return std::move(*c);
    };
    const Comparison c = compared({}, {});
    CHECK(order == "ABABABAB");
    CHECK(c.times.back().base == 1);
    CHECK(c.times.back().ratio == 1.5);
    CHECK(c.passed());
    CHECK(compared(1.6, 0.2).passed());
    CHECK(compared(1.1, 0.2).too_slow);
    CHECK(compared(1.6, 0.01).too_different);

    const Comparison failing = compared(1.1, 0.2);
    const auto json = nlohmann::json::parse(comparison_json(failing));
    CHECK(json["passed"] == false);
    CHECK(json["seconds"].back()["ratio"] == 1.5);
    CHECK(json["radiosity"]["relative_rms"].get<double>() == Approx(0.1).epsilon(1e-5));
    CHECK(json["archives_changed"] == 0);
    CHECK(json["made"]["tables"]["head"] == "2 x 2 octahedral");
    CHECK_THAT(comparison_text(failing), Contains("0 of 1 archives changed") && Contains("head is slower: it takes 1.500"));
    CHECK_THAT(comparison_text(failing), Contains("slower") && Contains("FAILED: total time") && Contains("passed: difference"));
    CHECK_THAT(comparison_markdown(failing), Contains("| total | 1.0000 | 1.5000 | 1.500 |") && Contains("| links | 7 | 7 | +0.0 % |"));
}

TEST_CASE("compare: a difference is held against what two solves may err by", "[compare]") {
    Comparison c;
    c.times.push_back(phase_times("total", {1, 1}, {1, 1}));
    c.base_error = 0.03, c.head_error = 0.04;  // independent: 0.05 together
    c.radiosity.relative_rms = 0.049;
    CHECK_THAT(comparison_text(c), Contains("differs by 4.9 %, no more than the 5 %"));
    c.radiosity.relative_rms = 0.051;
    CHECK_THAT(comparison_text(c), Contains("differs by 5.1 %, MORE than the 5 %"));
    c.radiosity.relative_rms = 0;
    CHECK_THAT(comparison_text(c), Contains("the same, bit for bit"));
    c.archives = 3, c.changed = 2;
    c.made = {{"tables", "6 x 6 octahedral", "12 x 12 octahedral"}, {"compiler", "1", "1"}};
    CHECK_THAT(comparison_markdown(c), Contains("2 of 3 archives changed; tables: 6 x 6 octahedral -> 12 x 12 octahedral;") &&
                                           !Contains("compiler"));
}
