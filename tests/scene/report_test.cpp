#include <limits>
#include <nlohmann/json.hpp>

#include "format/tool/json_document.h"
#include "schemas/report_schema.h"
#include "solver/output/output.h"
#include "tests/scene/scene_files.h"

using namespace rro;
using namespace rro::test;
using Catch::Matchers::Contains;

namespace {

Solution example() {
    Solution s;
    s.effects = {{"emitters", true, "lamp: exitance 20 W/m^2 at material bulb", 0.25}, {"self", false, "none", 0}};
    s.links = {10, 20, 30, 4000};
    s.energy.emitted = {100, 90, 80};
    s.energy.escaped = {1, -0.5, 0};
    s.rays = 12345678901;
    s.accuracy = 0.02;
    s.estimated_error = 0.015;
    s.converged = true;
    s.iterations = 7;
    s.warnings = {"something \"odd\""};
    return s;
}

}  // namespace

TEST_CASE("a report fits its schema and holds what the solution says", "[report]") {
    SceneFiles files;
    const Scene scene = files.open(files.instances(R"({"name": "a", "archive": "box.rro"})"));
    REQUIRE(write_report(scene, example(), files.folder / "report.json"));
    const auto report = read_json(files.folder / "report.json");
    REQUIRE(report);
    const auto fits = check_schema(*report, report_schema, "report.json");
    if (!fits) FAIL(text_of(fits.error()));
    CHECK((*report)["links"]["total"] == 60);
    CHECK((*report)["triangles"] == 12);
    CHECK((*report)["rays"] == 12345678901);
    CHECK((*report)["energy"]["escaped"] == nlohmann::json{1, -0.5, 0});
    CHECK((*report)["effects"][0]["reason"] == "lamp: exitance 20 W/m^2 at material bulb");
    CHECK((*report)["warnings"][0] == "something \"odd\"");
    CHECK((*report)["memory_peak_bytes"].get<std::uint64_t>() > 1000000);
}

TEST_CASE("a residual without end is still a number", "[report]") {
    SceneFiles files;
    Solution solution = example();
    solution.residual = std::numeric_limits<double>::infinity();
    solution.estimated_error = std::numeric_limits<double>::quiet_NaN();
    REQUIRE(write_report(files.open(files.instances("")), solution, files.folder / "report.json"));
    CHECK(check_schema(*read_json(files.folder / "report.json"), report_schema, "report.json"));
}

TEST_CASE("the report's schema refuses what it does not know", "[report]") {
    SceneFiles files;
    REQUIRE(write_report(files.open(files.instances("")), example(), files.folder / "report.json"));
    auto report = *read_json(files.folder / "report.json");
    report["energy"]["lost"] = 1;
    const auto fits = check_schema(report, report_schema, "report.json");
    REQUIRE_FALSE(fits);
    CHECK_THAT(text_of(fits.error()), Contains("report.json: /energy/lost: unknown key \"lost\""));
}
