// An independent witness: flatc, which has never seen our code, reads and writes the sections by schemas/rro.fbs.
#include <catch2/catch.hpp>

#include "format/archive_reader.h"
#include "format/archive_writer.h"
#include "format/layout.h"
#include "tests/support/archive_bytes.h"
#include "tests/support/flatc.h"
#include "tests/support/object_json.h"
#include "tests/support/tiny_object.h"

using namespace rro;
using test::difference;
using test::object_json;

namespace {

bool cannot_test() {
    if (test::flatc_installed()) return false;
    WARN("flatc (flatbuffers-compiler) is not installed: nothing was tested");
    return true;
}

/// flatc takes no null for a field that is left out.
test::Json without_defaults(test::Json table) {
    for (auto field = table.begin(); field != table.end();) field = field->is_null() ? table.erase(field) : std::next(field);
    return table;
}

test::TinyObject witnessed_object() {
    test::TinyObject object = test::tiny_object(3, {100, 0, -0.5});
    object.meta.grid_map = GridMap::LatLong;
    object.materials[0].name = "w\u00e4nde, \"matt\"";
    object.visibility[7] = 3;
    return object;
}

}  // namespace

TEST_CASE("flatc reads every section and finds the values that were written", "[flatc]") {
    if (cannot_test()) return;
    const test::TinyObject object = witnessed_object();
    const auto encoded = encode_archive(object.data());
    REQUIRE(encoded);
    const test::Json expected = object_json(object.data());
    for (const layout::SectionSpec& spec : layout::kSections) {
        const std::string section(spec.name);
        const test::Json found = test::flatc_to_json(test::payload_of(*encoded, section), section);
        INFO("section " << section);
        CHECK(difference(expected.at(section), found) == "");
        CHECK_FALSE(found.empty());
    }
}

TEST_CASE("sections that stock FlatBuffers wrote are read, with its alignment and its layout", "[flatc]") {
    if (cannot_test()) return;
    const test::TinyObject object = witnessed_object();
    const auto encoded = encode_archive(object.data());
    REQUIRE(encoded);
    const test::Json json = object_json(object.data());
    test::Bytes archive = *encoded;
    std::size_t differing = 0;
    for (const layout::SectionSpec& spec : layout::kSections) {
        const std::string section(spec.name);
        const test::Bytes theirs = test::flatc_to_binary(without_defaults(json.at(section)), section);
        differing += theirs != test::payload_of(archive, section);
        archive = test::with_payload(archive, section, theirs);
    }
    CHECK(differing == layout::kSections.size());  // it writes back to front: nothing of this is our own bytes
    const auto read = Archive::from_bytes(archive, "stock.rro");
    INFO((read ? "" : read.error().where + ": " + read.error().message));
    REQUIRE(read);
    CHECK(difference(object_json(object.data()), object_json(read->data())) == "");
}

TEST_CASE("an older reader skips the fields and sections that a newer minor version added", "[flatc][version]") {
    if (cannot_test()) return;
    // A later version of the schema: fields of every kind at the end of tables, and a section of its own.
    const test::TemporaryFolder folder;
    std::string schema = test::file_text(RRO_SOURCE_DIR "/schemas/rro.fbs");
    const auto append = [&](const std::string& table, const std::string& fields) {
        const std::size_t at = schema.find("}", schema.find("table " + table + " {"));
        REQUIRE(at != std::string::npos);
        schema.insert(at, fields);
    };
    append("Meta", "  watts: double; notes: [string]; nested: Later;\n");
    append("Material", "  ior: float = 1.5;\n");
    append("Mesh", "  normals: [Vec3f];\n");
    schema += "\ntable Later { name: string; numbers: [ulong]; }\n";
    std::ofstream(folder / "later.fbs") << schema;

    const test::TinyObject object = test::tiny_object(3);
    const auto encoded = encode_archive(object.data());
    REQUIRE(encoded);
    const test::Json json = object_json(object.data());
    const auto with_later = [&](test::Bytes archive, const std::string& section, const test::Json& value) {
        return test::with_payload(
            archive, section,
            test::flatc_to_binary(without_defaults(value), section, (folder / "later.fbs").string()));
    };
    test::Json meta = json["meta"], materials = json["materials"], mesh = json["mesh"];
    meta["watts"] = 60.5;
    meta["notes"] = {"one", "two"};
    meta["nested"] = {{"name", "inner"}, {"numbers", {1, 2, 3}}};
    materials["materials"][1]["ior"] = 2.5;
    mesh["normals"] = json["mesh"]["positions"];
    test::Bytes archive = with_later(*encoded, "meta", meta);
    archive = with_later(archive, "materials", materials);
    archive = with_later(archive, "mesh", mesh);
    // `errors` becomes a section that this version has never heard of.
    test::change_entry(archive, "errors", [](auto& entry) { std::memcpy(entry.name.data(), "later\0", 6); });
    test::change_header(archive, [](auto& header) { header.version_minor = layout::kVersionMinor + 1; });

    const auto read = Archive::from_bytes(archive, "later.rro");
    INFO((read ? "" : read.error().where + ": " + read.error().message));
    REQUIRE(read);
    CHECK(read->version_minor() == layout::kVersionMinor + 1);
    test::Json expected = json;
    expected["errors"] = {{"directions", 0}, {"whole", test::Json::array()}, {"intrinsic", test::Json::array()},
                          {"visibility", test::Json::array()}};
    CHECK(difference(expected, object_json(read->data())) == "");
    CHECK(read->section("later"));
}
