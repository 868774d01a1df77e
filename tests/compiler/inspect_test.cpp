#include "compiler/inspect.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "compiler/archive_facts.h"
#include "format/archive_writer.h"
#include "tests/support/tiny_object.h"

using namespace rro;
using Catch::Matchers::Contains;

namespace {

Archive archive_of(const test::TinyObject& object) {
    auto bytes = encode_archive(object.data());
    REQUIRE(bytes);
    auto archive = Archive::from_bytes(*std::move(bytes), "tiny.rro");
    REQUIRE(archive);
    return *std::move(archive);
}

}  // namespace

TEST_CASE("inspect tells source, settings, counts and every section", "[compiler][inspect]") {
    const Archive archive = archive_of(test::tiny_object());
    const std::string text = inspection_text(archive, "library/tiny.rro");
    CHECK_THAT(text, Catch::Matchers::StartsWith("library/tiny.rro: format " + format_version(archive) + ", "));
    for (const char* part : {"box.obj", "aaaaaaaa", "grid=3", "octahedral", "lamp", "0.5 0.25 0.125",
                             "12 triangles of 13 in the source", "6 patches, 11 clusters (4 deep), 3 volumes",
                             "probabilities of 2 volumes, intrinsic ones too along 9 lines; 1 for the object's box",
                             "2 silhouettes of 2 x 2 pixels, of a sphere of 1.875 m about (0.5, 1, 1.5)"})
        CHECK_THAT(text, Contains(part));
    for (const SectionInfo& section : archive.sections()) CHECK_THAT(text, Contains("section    " + section.name));

    const auto json = nlohmann::json::parse(inspection_json(archive, "library/tiny.rro"));
    CHECK(json["file"] == "library/tiny.rro");
    CHECK(json["content"] == archive.content_sha256());
    CHECK(json["closed"] == true);
    CHECK(json["counts"]["triangles"] == 12);
    CHECK(json["materials"][1]["exitance"] == nlohmann::json{20, 18, 15.5});
    CHECK(json["counts"]["hit_volumes"] == 2);
    CHECK(json["hit"] == nlohmann::json{{"volumes", 2}, {"lines", 9}, {"intrinsic", true}, {"object", json["hit"]["object"]}});
    CHECK(json["hit"]["object"].get<double>() == Approx(1));
    CHECK(json["atlas"] == nlohmann::json{{"grid_size", 2}, {"image_size", 2}, {"centre", {0.5, 1, 1.5}}, {"radius", 1.875}});
    CHECK(json["sections"].size() == archive.sections().size());
}

TEST_CASE("the triangle list has source numbers in order and corners in the archive's frame", "[compiler][inspect]") {
    test::TinyObject object = test::tiny_object();
    object.materials[0].name = "oak, \"dark\"";
    std::swap(object.source_triangle[0], object.source_triangle[11]);
    const std::string csv = triangles_csv(object.data());
    CHECK_THAT(csv, Catch::Matchers::StartsWith("triangle,material,ax,ay,az,bx,by,bz,cx,cy,cz\n"
                                                "1,lamp,0,0,3,1,2,3,0,2,3\n"
                                                "2,\"oak, \"\"dark\"\"\",0,0,0,0,2,3,0,2,0\n"
                                                "3,lamp,1,0,0,1,2,0,1,2,3\n"));
    CHECK(std::count(csv.begin(), csv.end(), '\n') == 13);
    CHECK_THAT(csv, Contains("\n12,\"oak, \"\"dark\"\"\",0,0,0,0,0,3,0,2,3\n"));

    const std::string far = triangles_csv(test::tiny_object(3, {1e6, 0, -0.5}).data());
    CHECK_THAT(far, Contains("\n3,lamp,1000001,0,-0.5,1000001,2,-0.5,1000001,2,2.5\n"));
}
