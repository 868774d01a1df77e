#include "solver/edit/manifest_edit.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <random>

#include "solver/edit/edit_arguments.h"
#include "solver/edit/json_text.h"
#include "solver/scene/manifest.h"
#include "tests/scene/scene_files.h"

using namespace rro;
using namespace rro::test;
using nlohmann::json;

namespace {

constexpr unsigned kSeed = 20240917;

std::string space(std::mt19937& random) {
    static const char* const kinds[] = {"", " ", "\n", "\r\n\t", "   ", "\n\n  "};
    return kinds[random() % 6];
}

/// JSON text of a value, with odd white space wherever JSON allows any, and escapes where there is a choice.
std::string odd_text(const nlohmann::ordered_json& value, std::mt19937& random) {
    std::string out;
    if (value.is_object() || value.is_array()) {
        out = value.is_object() ? "{" : "[";
        bool first = true;
        for (const auto& [key, member] : value.items()) {
            out += (first ? "" : ",") + space(random);
            if (value.is_object()) {
                std::string name = json(key).dump();
                if (random() % 4 == 0 && name.size() == 6) name.replace(1, 1, name[1] == 's' ? "\\u0073" : name.substr(1, 1));
                out += name + space(random) + ":" + space(random);
            }
            out += odd_text(member, random) + space(random);
            first = false;
        }
        return out + (first ? space(random) : "") + (value.is_object() ? "}" : "]");
    }
    return value.dump();
}

nlohmann::ordered_json random_manifest(std::mt19937& random) {
    auto instances = nlohmann::ordered_json::array();
    const std::size_t count = random() % 5;
    for (std::size_t i = 0; i < count; ++i) {
        nlohmann::ordered_json instance;
        instance["extras"] = {{"note", "a \"name\": [}]{, \\"}, {"name", "not a name"}, {"instances", {1, 2.50, "\\"}}};
        instance["name"] = "i" + std::to_string(i);
        instance["archive"] = "box.rro";
        if (random() % 2) instance["transform"] = {{"translate", {1.5, 0, -2}}, {"extras", {{"scale", 3}}}};
        instances.push_back(instance);
    }
    nlohmann::ordered_json document;
    document["extras"] = {{"instances", {{{"name", "i0"}}}}, {"text", "]}\\\""}};
    document["format"] = "rro-scene/1";
    document["instances"] = instances;
    document["accuracy"] = 0.125;
    return document;
}

/// What two texts do not share at the begin and the end.
std::pair<std::string, std::string> difference(const std::string& a, const std::string& b) {
    std::size_t head = 0, tail = 0;
    while (head < std::min(a.size(), b.size()) && a[head] == b[head]) ++head;
    while (tail < std::min(a.size(), b.size()) - head && a[a.size() - 1 - tail] == b[b.size() - 1 - tail]) ++tail;
    return {a.substr(head, a.size() - head - tail), b.substr(head, b.size() - head - tail)};
}

ManifestText manifest(const std::string& instances) {
    return {"room.json", "{\"format\": \"rro-scene/1\", \"instances\": [" + instances + "]}"};
}

}  // namespace

TEST_CASE("edits change what they say and no other byte, however the text is laid out", "[edit]") {
    std::mt19937 random(kSeed);
    for (int round = 0; round < 400; ++round) {
        const auto document = random_manifest(random);
        const ManifestText before{"room.json", space(random) + odd_text(document, random) + space(random)};
        INFO(before.text);
        REQUIRE(parse_manifest(before.text, before.path));
        const std::size_t count = document["instances"].size();

        const auto placed = with_instance(before, {"new", "\"b.rro\"", "{\"scale\": 2}", ""});
        REQUIRE(placed);
        auto expected = document;
        expected["instances"].push_back({{"name", "new"}, {"archive", "b.rro"}, {"transform", {{"scale", 2}}}});
        CHECK(json::parse(*placed) == json(expected));
        CHECK(difference(before.text, *placed).first.empty());  // only something new

        // Deleting what was placed gives back every byte, but for the space in an empty list.
        const auto restored = without_instance({"room.json", *placed}, "new");
        REQUIRE(restored);
        CHECK(*restored == before.text);

        if (count == 0) continue;
        const std::size_t which = random() % count;
        const std::string name = "i" + std::to_string(which);
        const auto deleted = without_instance(before, name);
        REQUIRE(deleted);
        expected = document;
        expected["instances"].erase(which);
        CHECK(json::parse(*deleted) == json(expected));
        CHECK(difference(before.text, *deleted).second.empty());  // only something less

        const auto moved = with_transform_parts(before, name, {{7, 8, 9}, {}, {}, {}});
        REQUIRE(moved);
        expected = document;
        expected["instances"][which]["transform"]["translate"] = {7, 8, 9};
        CHECK(json::parse(*moved) == json(expected));
        // The bytes that go are those of the old translation: nothing but digits, points, signs, space and brackets.
        CHECK(difference(before.text, *moved).first.find_first_not_of("[]0123456789.,- \t\r\n") == std::string::npos);
    }
}

TEST_CASE("what is placed follows the layout of the file", "[edit]") {
    const ManifestText lines{"room.json",
                             "{\r\n  \"format\": \"rro-scene/1\",\r\n  \"instances\": [\r\n    {\r\n      \"name\": \"a\",\r\n"
                             "      \"archive\": \"a.rro\"\r\n    }\r\n  ]\r\n}\r\n"};
    const auto placed = with_instance(lines, {"b", "\"b.rro\"", "", ""});
    REQUIRE(placed);
    CHECK(difference(lines.text, *placed).second.find("\r\n      \"name\": \"b\",\r\n      \"archive\": \"b.rro\"\r\n    }") !=
          std::string::npos);
    const ManifestText compact = manifest("\n  { \"name\": \"a\", \"archive\": \"a.rro\" }");
    CHECK(*with_instance(compact, {"b", "\"b.rro\"", "", ""}) ==
          manifest("\n  { \"name\": \"a\", \"archive\": \"a.rro\" },\n  { \"name\": \"b\", \"archive\": \"b.rro\" }").text);
}

TEST_CASE("moving replaces the parts given", "[edit]") {
    const ManifestText scene =
        manifest("{\"name\":\"a\",\"archive\":\"a.rro\",\"transform\":{\"scale\":2,\"translate\":[1,2,3]}},"
                 "{\"name\":\"m\",\"archive\":\"a.rro\",\"transform\":{\"matrix\":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]}},"
                 "{\"name\":\"plain\",\"archive\":\"a.rro\"}");
    const auto transform = [](const std::string& text, int i) { return json::parse(text)["instances"][i]["transform"]; };
    const TransformChange turn{{}, {0, 1, 0, 90}, {}, {}};
    CHECK(transform(*with_transform_parts(scene, "a", turn), 0) ==
          json{{"scale", 2}, {"translate", {1, 2, 3}}, {"rotate", {{"axis", {0, 1, 0}}, {"degrees", 90}}}});
    CHECK(transform(*with_transform_parts(scene, "plain", turn), 2).size() == 1);
    const auto parts = with_transform_parts(scene, "m", turn);
    REQUIRE_FALSE(parts);
    CHECK(parts.error().where == "room.json: /instances/1/transform/matrix");
    CHECK(parts.error().hint == "move it with --matrix");
    const TransformChange matrix{{}, {}, {}, {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1}};
    for (const char* name : {"a", "m"})
        CHECK(transform(*with_transform_parts(scene, name, matrix), name[0] == 'a' ? 0 : 1)["matrix"][0] == 2);
}

TEST_CASE("unknown names and taken ones are refused with a way out", "[edit]") {
    const ManifestText scene = manifest("{\"name\":\"desk\",\"archive\":\"a.rro\"}");
    for (const auto& refused : {with_transform(scene, "dest", "{}"), without_instance(scene, "dest")}) {
        REQUIRE_FALSE(refused);
        CHECK(refused.error().kind == ErrorKind::BadInput);
        CHECK(refused.error().hint == "did you mean \"desk\"?");
    }
    const auto taken = with_instance(scene, {"desk", "\"a.rro\"", "", ""});
    REQUIRE_FALSE(taken);
    CHECK(taken.error().where == "room.json: /instances/0/name");
}

TEST_CASE("a field of a material is set, the others stay", "[edit]") {
    ManifestText scene = manifest("{\"name\":\"a\",\"archive\":\"a.rro\"}");
    for (const auto& [material, field, value] :
         {std::array{"*", "reflectance", "[0, 0, 0]"}, std::array{"*", "exitance", "[1, 1, 1]"},
          std::array{"x/\"y", "exitance", "[2, 2, 2]"}, std::array{"*", "reflectance", "[0.5, 0, 0]"}})
        scene.text = *with_material_field(scene, "a", material, field, value);
    CHECK(json::parse(scene.text)["instances"][0]["materials"] ==
          json{{"*", {{"reflectance", {0.5, 0, 0}}, {"exitance", {1, 1, 1}}}}, {"x/\"y", {{"exitance", {2, 2, 2}}}}});
}

TEST_CASE("a manifest that an edit would spoil stays as it is", "[edit]") {
    SceneFiles files;
    const auto path = files.instances("{\"name\": \"a\", \"archive\": \"box.rro\"}");
    const std::string before = file_text(path);
    const auto refused = [&](const Status& status, const std::string& what) {
        REQUIRE_FALSE(status);
        CHECK(status.error().kind == ErrorKind::BadInput);
        CHECK_THAT(text_of(status.error()), Catch::Contains(what));
        CHECK(file_text(path) == before);
    };
    refused(move_in_file(path, "a", {{}, {}, {0}, {}}), "singular");
    refused(move_in_file(path, "b", {{}, {}, {2}, {}}), "no instance");
    refused(place_in_file(path, "b", files.folder / "none.rro", {}), "none.rro");
    refused(place_in_file(path, "a", files.folder / "box.rro", {}), "taken");
    refused(place_in_file(path, "b/c", files.folder / "box.rro", {}), "/instances/1/name");
    refused(place_in_file(path, "\xff", files.folder / "box.rro", {}), "UTF-8");
    refused(delete_in_file(path, ""), "no instance");
}

TEST_CASE("a placed archive is found from the manifest", "[edit]") {
    SceneFiles files;
    std::filesystem::create_directory(files.folder / "library");
    std::filesystem::rename(files.folder / "box.rro", files.folder / "library/box.rro");
    const auto path = files.instances("");
    REQUIRE(place_in_file(path, "b", files.folder / "library/../library/box.rro", {{1, 2, 3}, {}, {}, {}}));
    CHECK(json::parse(file_text(path))["instances"][0]["archive"] == "library/box.rro");
    CHECK(files.open(path).instances[0].to_world.translation == Vec3{1, 2, 3});
    REQUIRE(delete_in_file(path, "b"));
    CHECK(json::parse(file_text(path))["instances"].empty());
}

TEST_CASE("relative paths lead to the same files from another folder", "[edit]") {
    SceneFiles files;
    std::filesystem::create_directory(files.folder / "sub");
    const auto path = files.instances("{\"name\":\"a\",\"archive\":\"box.rro\"},{\"name\":\"b\",\"archive\":{\"path\":\"sub/../box.rro\"}}");
    const std::string moved = moved_to_folder({path, file_text(path)}, files.folder / "sub");
    CHECK(json::parse(moved)["instances"][0]["archive"] == "../box.rro");
    CHECK(json::parse(moved)["instances"][1]["archive"]["path"] == "../box.rro");
}

TEST_CASE("transforms on the command line", "[edit]") {
    const auto good = parse_transform({"1,-2.5,+3e2", "0,1,0,90", "2", {}});
    REQUIRE(good);
    CHECK(good->translate == std::vector<double>{1, -2.5, 300});
    CHECK(transform_json(*good) ==
          R"({ "translate": [1, -2.5, 300], "rotate": { "axis": [0, 1, 0], "degrees": 90 }, "scale": 2 })");
    CHECK(parse_transform({"", "", "", {"1,0,0,0", "0,1,0,0", "0,0,1,0", "0,0,0,1"}}));
    for (const char* bad : {"1,2", "1,2,3,4", "1,2,x", "1,,3", "1,2,nan", "1,2,inf", "1,2,1e999", "1 2 3", ","}) {
        INFO(bad);
        const auto refused = parse_transform({bad, "", "", {}});
        REQUIRE_FALSE(refused);
        CHECK(refused.error().kind == ErrorKind::Usage);
    }
    CHECK_FALSE(parse_transform({"1,2,3", "", "", {"1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1"}}));
}
