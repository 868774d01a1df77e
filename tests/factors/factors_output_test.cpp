#include "solver/factors/factors_output.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "format/atomic_file.h"
#include "format/tool/json_document.h"
#include "schemas/factors_report_schema.h"
#include "tests/support/temporary_folder.h"

using namespace rro;
using namespace rro::test;

namespace {

/// Two groups, one with a name that CSV must quote; the first sees the second, and nothing is seen back but by 1/3.
Factors example() {
    Factors f;
    f.names = {"a \"b\", c", "d"};
    f.area = {1, 3};
    f.rows = {{{1, 0.25f, 1.0}}, {{0, 0, 1.0 / 3}, {1, 0, 1e-9}}};
    f.closure = measure_closure(f);
    return f;
}

std::size_t files_in(const std::filesystem::path& folder) {
    std::size_t count = 0;
    for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder)) ++count;
    return count;
}

}  // namespace

TEST_CASE("the CSV has all pairs, quoted names and numbers that read back", "[factors][output]") {
    const TemporaryFolder folder;
    const auto path = folder.path() / "f.csv";
    REQUIRE(write_factors(example(), {}, false, path));
    CHECK(file_text(path) ==
          "from,to,factor,area_from,standard_error\n"
          "\"a \"\"b\"\", c\",\"a \"\"b\"\", c\",0,1,0\n"
          "\"a \"\"b\"\", c\",d,1,1,0.25\n"
          "d,\"a \"\"b\"\", c\",0.3333333333333333,3,0\n"
          "d,d,1e-09,3,0\n");
    REQUIRE(write_factors(example(), 0.01, false, path));
    CHECK(file_text(path) ==
          "from,to,factor,area_from,standard_error\n"
          "\"a \"\"b\"\", c\",d,1,1,0.25\n"
          "d,\"a \"\"b\"\", c\",0.3333333333333333,3,0\n");
}

TEST_CASE("the JSON and the report parse and say the same", "[factors][output]") {
    const TemporaryFolder folder;
    const Factors f = example();
    REQUIRE(write_factors(f, {}, false, folder.path() / "f.json"));
    const auto json = nlohmann::json::parse(file_text(folder.path() / "f.json"));
    CHECK(json["format"] == "rro-factors/1");
    CHECK(json["groups"][0]["name"] == f.names[0]);
    CHECK(json["rows"][1]["to"] == nlohmann::json({0, 1}));
    CHECK(json["rows"][1]["factor"][0] == 1.0 / 3);
    REQUIRE(write_factors_report(f, {}, {}, folder.path() / "r.json"));
    const auto report = nlohmann::json::parse(file_text(folder.path() / "r.json"));
    CHECK(report["closure"]["largest_defect"].get<double>() == Approx(2.0 / 3));
    CHECK(report["closure"]["of"] == "d");
    CHECK(report["reciprocity"]["largest_defect"] == 0);
}

TEST_CASE("a report follows its schema, closed or not, and the schema refuses others", "[factors][output]") {
    const TemporaryFolder folder;
    const auto path = folder.path() / "r.json";
    Factors f = example();
    f.options.by = GroupBy::Group;
    REQUIRE(write_factors_report(f, {}, {0.1, 0.2, 0.3}, path));
    auto report = nlohmann::json::parse(file_text(path));
    CHECK(check_schema(report, factors_report_schema, "r.json"));
    f.rows = {{{1, 0, 0.9}}, {{0, 0, 0.3}, {1, 0, 0.6}}};  // a closed scene, nearly
    f.closure = measure_closure(f);
    const auto closing = close_rows(f);
    REQUIRE(closing);
    REQUIRE(write_factors_report(f, *closing, {}, path));
    report = nlohmann::json::parse(file_text(path));
    CHECK(report.contains("close"));
    CHECK(check_schema(report, factors_report_schema, "r.json"));
    report["pairs"]["exact"] = -1;
    CHECK(!check_schema(report, factors_report_schema, "r.json"));
}

TEST_CASE("a file that is not committed leaves nothing, and the old one stays", "[factors][output]") {
    const TemporaryFolder folder;
    const auto path = folder.path() / "f.csv";
    REQUIRE(write_file_atomically(path, std::string_view("old")));
    {
        auto file = AtomicFile::open(path);
        REQUIRE(file);
        REQUIRE(file->write("half"));
        CHECK(file_text(path) == "old");
        CHECK(files_in(folder.path()) <= 2);  // what is being written may have no name yet
    }
    CHECK(files_in(folder.path()) == 1);
    CHECK(file_text(path) == "old");
    auto file = AtomicFile::open(path);
    REQUIRE(file);
    REQUIRE(file->write("ne"));
    REQUIRE(file->write("w"));
    REQUIRE(file->commit());
    CHECK(file_text(path) == "new");
    CHECK(files_in(folder.path()) == 1);
    CHECK(!AtomicFile::open(folder.path() / "none" / "f.csv"));
}
