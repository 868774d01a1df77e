#include "format/inspect.h"

#include <algorithm>

#include <catch2/catch.hpp>

#include "format/archive_writer.h"
#include "tests/support/tiny_object.h"

using namespace rro;

namespace {

Archive archive_of(const test::TinyObject& object) {
    auto bytes = encode_archive(object.data());
    REQUIRE(bytes);
    auto archive = Archive::from_bytes(*std::move(bytes), "tiny.rro");
    REQUIRE(archive);
    return *std::move(archive);
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("inspect tells source, settings, counts and every section", "[inspect]") {
    const Archive archive = archive_of(test::tiny_object());
    const std::string text = inspect_text(archive, "library/tiny.rro");
    CHECK(text.starts_with("library/tiny.rro: format 0.1, "));
    for (const char* part : {"box.obj", "aaaaaaaa", "grid=3", "octahedral", "lamp", "0.5 0.25 0.125"})
        CHECK(contains(text, part));
    for (const SectionInfo& section : archive.sections()) CHECK(contains(text, "  " + section.name + " "));
    for (const FactGroup& group : archive_facts(archive)) {
        for (const Fact& fact : group.facts) {
            if (group.name == "counts" && fact.name == "triangles") CHECK(std::get<std::uint64_t>(fact.value) == 12);
            if (group.name == "source" && fact.name == "dropped") CHECK(std::get<std::uint64_t>(fact.value) == 1);
            if (group.name == "object" && fact.name == "closed") CHECK(std::get<bool>(fact.value));
        }
    }
}

TEST_CASE("the triangle list has source numbers in order and corners in the archive's frame", "[inspect]") {
    test::TinyObject object = test::tiny_object();
    object.materials[0].name = "oak, \"dark\"";
    object.positions[1].x = 0.1f;  // the stored number, not its double expansion
    std::swap(object.source_triangle[0], object.source_triangle[11]);
    const std::string csv = triangles_csv(archive_of(object));
    CHECK(csv.starts_with("triangle,material,ax,ay,az,bx,by,bz,cx,cy,cz\n"
                          "1,lamp,0,0,3,1,2,3,0,2,3\n"
                          "2,\"oak, \"\"dark\"\"\",0,0,0,0,2,3,0,2,0\n"
                          "3,lamp,0.1,0,0,1,2,0,1,2,3\n"));
    CHECK(std::count(csv.begin(), csv.end(), '\n') == 13);
    CHECK(contains(csv, "\n12,\"oak, \"\"dark\"\"\",0,0,0,0,0,3,0,2,3\n"));

    const std::string moved = triangles_csv(archive_of(test::tiny_object(3, {1e6, 0, -0.5})));
    CHECK(contains(moved, "\n3,lamp,1000001,0,-0.5,1000001,2,-0.5,1000001,2,2.5\n"));
}
