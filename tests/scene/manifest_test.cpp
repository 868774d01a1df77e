#include "tests/scene/scene_files.h"

using namespace rro;
using namespace rro::test;
using Catch::Matchers::Contains;

namespace {

/// What users wrote for format 1: it must stay readable.
const char* const kFirstManifest = R"({
  "format": "rro-scene/1",
  "instances": [
    { "name": "desk", "archive": "library/desk.rro",
      "transform": { "translate": [0, 0, 1.2], "rotate": { "axis": [0, 1, 0], "degrees": 90 }, "scale": 1 },
      "materials": { "*": { "reflectance": [0.6, 0.5, 0.4] }, "lamp": { "exitance": [20, 18, 15], "group": "evening" } } },
    { "name": "bust", "archive": { "path": "library/bust.rro", "content": "9f86d081" },
      "transform": { "matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1] } }
  ],
  "sky": { "radiance": [0.2, 0.3, 0.5] },
  "sun": { "direction": [0.3, -0.8, 0.5], "irradiance": [800, 780, 700], "angular_diameter": 0.53 },
  "lights": [ { "name": "spot", "type": "spot", "position": [0, 2.5, 0], "direction": [0, -1, 0], "intensity": [50, 50, 45], "cone_degrees": 60 } ],
  "groups": { "walls": ["room", "door/panel"] },
  "camera": { "position": [0, 1.6, 4], "target": [0, 1, 0], "up": [0, 1, 0], "vertical_fov": 45, "exposure": 0 },
  "accuracy": 0.02,
  "extras": {}
})";

/// What is said about one instance of these fields.
Error instance_error(SceneFiles& files, const std::string& fields) {
    return files.error(files.instances("{\"name\": \"a\", \"archive\": \"box.rro\", " + fields + "}"));
}

Affine3 placed(SceneFiles& files, const std::string& transform) {
    auto read =
        read_manifest(files.instances("{\"name\": \"a\", \"archive\": \"box.rro\", \"transform\": " + transform + "}"));
    if (!read) FAIL(text_of(read.error()));
    return read->instances.at(0).to_world;
}

}  // namespace

TEST_CASE("a manifest of the first version is read", "[manifest]") {
    SceneFiles files;
    const std::string text = kFirstManifest;
    const auto read = read_manifest(files.manifest(text));
    REQUIRE(read);
    REQUIRE(read->instances.size() == 2);
    CHECK(read->instances[0].archive == files.folder / "library/desk.rro");
    REQUIRE(read->instances[0].materials.size() == 2);
    CHECK(read->instances[0].materials[0].first == "*");
    CHECK(read->instances[0].materials[0].second.reflectance == Vec3{0.6, 0.5, 0.4});
    CHECK_FALSE(read->instances[0].materials[0].second.exitance);
    CHECK(read->instances[0].materials[1].second.exitance == Vec3{20, 18, 15});
    CHECK(read->instances[1].content == "9f86d081");
    CHECK(read->instances[1].to_world == Affine3{});
    CHECK(read->camera->position == Vec3{0, 1.6, 4});
    CHECK(read->camera->exposure == 0.0);
    CHECK(read->accuracy == 0.02);
    CHECK(read->instances[0].materials[1].second.group == "evening");
    CHECK(read->sky->radiance == Vec3{0.2, 0.3, 0.5});
    CHECK_FALSE(read->sky->ground);
    CHECK(length(read->sun->direction - normalised({0.3, -0.8, 0.5})) < 1e-15);
    CHECK(read->sun->irradiance == Vec3{800, 780, 700});
    CHECK(read->sun->angular_diameter == 0.53);
    REQUIRE(read->lights.size() == 1);
    CHECK(read->lights[0].name == "spot");
    CHECK(read->lights[0].type == LightEntry::Type::Spot);
    CHECK(read->lights[0].direction == Vec3{0, -1, 0});
    CHECK(read->lights[0].intensity == Vec3{50, 50, 45});
    CHECK(read->lights[0].cone_degrees == 60);
    REQUIRE(read->groups.size() == 1);
    CHECK(read->groups[0].name == "walls");
    CHECK(read->groups[0].members == std::vector<std::string>{"room", "door/panel"});
}

TEST_CASE("lights and surroundings that make no sense are refused at their place", "[manifest]") {
    SceneFiles files;
    const auto error = [&](const std::string& more) { return text_of(files.error(files.instances("", ", " + more))); };
    const auto light = [&](const std::string& fields) {
        return error(R"("lights": [{"name": "a", "position": [0, 0, 0], )" + fields + "}]");
    };
    CHECK(error(R"("sky": {"radiance": [1, 1, 1e40]})") ==
          "room.json: /sky/radiance/2: found 1e+40, expected 0 or 1e-30 to 1e30 W/(m^2 sr)");
    CHECK(error(R"("sky": {"radiance": [1, 1, 1], "cie_overcast": [1, 1, 1]})") ==
          "room.json: /sky: found 2 of \"radiance\", \"cie_overcast\" and \"image\", expected one");
    CHECK(error(R"("sky": {"ground": true})") ==
          "room.json: /sky: found 0 of \"radiance\", \"cie_overcast\" and \"image\", expected one");
    CHECK(error(R"("sky": {"radiance": [1, 1, 1], "scale": 2})") == "room.json: /sky/scale: only an image has a scale");
    CHECK(error(R"("sun": {"direction": [0, 0, 0], "irradiance": [1, 1, 1]})") ==
          "room.json: /sun/direction: found [0,0,0], expected a direction");
    CHECK_THAT(error(R"("sun": {"direction": [0, -1, 0]})"), Contains("/sun: the key \"irradiance\" is missing"));
    CHECK_THAT(error(R"("sun": {"direction": [0, -1, 0], "irradiance": [1, 1, 1], "angular_diameter": 180})"),
               Contains("/sun/angular_diameter: found 180"));
    CHECK(light(R"("type": "point")") ==
          "room.json: /lights/0: the key \"intensity\" is missing, a light of type \"point\" needs it");
    CHECK(light(R"("type": "point", "intensity": [1, 1, 1], "cone_degrees": 60)") ==
          "room.json: /lights/0/cone_degrees: a light of type \"point\" has no \"cone_degrees\"");
    CHECK_THAT(light(R"("type": "spot", "intensity": [1, 1, 1], "cone_degrees": 60)"),
               Contains("\"direction\" is missing"));
    CHECK_THAT(light(R"("type": "ies")"), Contains("\"file\" is missing"));
    CHECK_THAT(light(R"("type": "area")"), Contains("/lights/0/type: found \"area\""));
    CHECK_THAT(error(R"("lights": [{"name": "a", "type": "point", "position": [0, 1e200, 0], "intensity": [1, 1, 1]}])"),
               Contains("/lights/0/position/1: found 1e+200"));
    const std::string good = R"({"name": "a", "type": "point", "position": [0, 0, 0], "intensity": [1, 1, 1]})";
    CHECK_THAT(error("\"lights\": [" + good + "," + good + "]"),
               Contains("/lights/1/name: found \"a\", the name of /lights/0 already"));
    CHECK_THAT(error(R"("medium": {"absorption": [1, -1, 1]})"), Contains("/medium/absorption/1: found -1"));
    CHECK_THAT(error(R"("groups": {"a": "walls"})"), Contains("/groups/a: found \"walls\", expected an array"));
    CHECK(text_of(instance_error(
              files, R"("materials": {"walls": {"reflectance": [0.5, 0.5, 0.5], "transmittance": [0.4, 0.5, 0.4]}})")) ==
          "room.json: /instances/0/materials/walls/transmittance/1: found 0.5 beside a reflectance of 0.5, expected a sum "
          "below 1");
}

TEST_CASE("broken JSON is refused with line and column", "[manifest]") {
    SceneFiles files;
    const auto error = [&](const std::string& text) { return text_of(files.error(files.manifest(text))); };
    CHECK(error("{\n  // a note\n}") == "room.json: line 2, column 3: found a comment; JSON has none");
    CHECK_THAT(error("{\"format\": /* rro */ 1}"), Contains("line 1, column 12: found a comment"));
    CHECK_THAT(error("{\n\"format\": \"rro-scene/1\",\n}"), Contains("room.json: line 3, column 1: not valid JSON"));
    CHECK_THAT(error(""), Contains("room.json: line 1, column 1: not valid JSON"));
    CHECK_THAT(error("{\"accuracy\": NaN}"), Contains("line 1") && Contains("not valid JSON"));
    CHECK_THAT(error("{\"accuracy\": 1e999}"), Contains("line 1") && Contains("1e999"));
    CHECK_THAT(error("{\"format\": \"\xff\"}"), Contains("not valid JSON"));
    CHECK_THAT(error(std::string(100000, '[')), Contains("nested deeper than 256 levels"));
    CHECK(
        error(
            "{\"format\": \"rro-scene/1\", \"instances\": [{\"name\": \"a\"}, {\"name\": \"a\", \"name\": \"b\"}]}") ==
        "room.json: /instances/1: the key \"name\" appears twice");
    CHECK_THAT(text_of(files.error(files.folder / "no.json")), Contains("no.json: cannot be read: No such file"));
    CHECK_THAT(files.error(files.folder.path()).message, Contains("is a folder"));
}

TEST_CASE("a value of the wrong kind is named with what was expected", "[manifest]") {
    SceneFiles files;
    const auto error = [&](const std::string& text) { return text_of(files.error(files.manifest(text))); };
    CHECK(error("[]") ==
          "room.json: found an array of 0, expected an object: which archives stand where, and what lights them");
    CHECK(error("{\"format\": \"rro-scene/2\", \"instances\": []}") ==
          "room.json: /format: found \"rro-scene/2\", expected \"rro-scene/1\"");
    CHECK(error("{\"format\": \"rro-scene/1\"}") ==
          "room.json: the key \"instances\" is missing, expected an array of instances");
    CHECK(error("{\"format\": \"rro-scene/1\", \"instances\": {}}") ==
          "room.json: /instances: found an object, expected an array of instances");
    CHECK(text_of(files.error(files.instances("{\"name\": \"a\"}"))) ==
          "room.json: /instances/0: the key \"archive\" is missing, expected the path of an archive, or an object with "
          "\"path\" and \"content\"");
    CHECK(text_of(files.error(files.instances("{\"name\": \"a\", \"archive\": 7}"))) ==
          "room.json: /instances/0/archive: found 7, expected the path of an archive, or an object with \"path\" and "
          "\"content\"");
    CHECK(text_of(files.error(
              files.instances("{\"name\": \"a\", \"archive\": {\"path\": \"x\", \"content\": \"9f86\"}}"))) ==
          "room.json: /instances/0/archive/content: found \"9f86\", expected 8 to 64 hexadecimal digits, the start of "
          "the "
          "file's SHA-256");
    CHECK(text_of(instance_error(files, "\"materials\": {\"walls\": {\"reflectance\": 0.5}}")) ==
          "room.json: /instances/0/materials/walls/reflectance: found 0.5, expected three numbers [r, g, b], each at "
          "least "
          "0 and below 1");
    CHECK(text_of(instance_error(files, "\"materials\": {\"walls\": {\"exitance\": [1, 2]}}")) ==
          "room.json: /instances/0/materials/walls/exitance: found an array of 2, expected three numbers [r, g, b], "
          "each at "
          "least 0");
    CHECK_THAT(text_of(files.error(files.instances("", ", \"accuracy\": \"high\""))),
               Contains("/accuracy: found \"high\", expected a relative error above 0 and at most 1"));
}

TEST_CASE("an unknown key is named with those allowed and the nearest", "[manifest]") {
    SceneFiles files;
    const Error error = instance_error(files, "\"transfrom\": {}");
    CHECK(text_of(error) ==
          "room.json: /instances/0/transfrom: unknown key \"transfrom\", expected one of: archive, extras, "
          "materials, name, transform");
    CHECK(error.hint == "did you mean \"transform\"?");
    CHECK(error.kind == ErrorKind::BadInput);
    CHECK_THAT(instance_error(files, "\"transform\": {\"rotation\": 5}").hint, Contains("\"rotate\""));
    CHECK_THAT(
        instance_error(files, "\"transform\": {\"matrix\": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1], \"scale\": 2}").hint,
        Contains("\"matrix\" alone"));
}

TEST_CASE("values out of range are refused at their place", "[manifest]") {
    SceneFiles files;
    CHECK(
        text_of(instance_error(files, "\"materials\": {\"*\": {\"reflectance\": [0.5, 1, 0]}}")) ==
        "room.json: /instances/0/materials/*/reflectance/1: found 1, expected a number that is at least 0 and below 1");
    CHECK_THAT(text_of(instance_error(files, "\"materials\": {\"*\": {\"reflectance\": [0.5, 0.5, -0.1]}}")),
               Contains("/reflectance/2: found -0.1"));
    CHECK_THAT(text_of(instance_error(files, "\"materials\": {\"*\": {\"exitance\": [-1, 0, 0]}}")),
               Contains("/exitance/0: found -1, expected a number that is at least 0"));
    // Results are float32: what would become 0 or infinity there is refused rather than lost.
    CHECK_THAT(text_of(instance_error(files, "\"materials\": {\"*\": {\"exitance\": [0, 1e200, 0]}}")),
               Contains("/exitance/1: found 1e+200, expected 0 or 1e-30 to 1e30"));
    for (const char* accuracy : {"0", "-0.1", "2"})
        CHECK_THAT(text_of(files.error(files.instances("", std::string(", \"accuracy\": ") + accuracy))),
                   Contains("/accuracy: found"));
}

TEST_CASE("instance names are unique, not empty and without a slash", "[manifest]") {
    SceneFiles files;
    const std::string good = "{\"name\": \"a\", \"archive\": \"box.rro\"}";
    CHECK(text_of(files.error(files.instances(good + "," + good))) ==
          "room.json: /instances/1/name: found \"a\", the name of /instances/0 already; expected another");
    for (const char* name : {"", "a/b"})
        CHECK(text_of(files.error(
                  files.instances("{\"name\": \"" + std::string(name) + "\", \"archive\": \"box.rro\"}"))) ==
              "room.json: /instances/0/name: found \"" + std::string(name) +
                  "\", expected a name that is not empty and has no \"/\"");
    // A name as long as a file: no recursion over it.
    const Error error =
        files.error(files.instances("{\"name\": \"" + std::string(1 << 20, 'x') + "/\", \"archive\": \"b\"}"));
    CHECK(error.message.size() < 200);
}

TEST_CASE("extras are ignored anywhere", "[manifest]") {
    SceneFiles files;
    const std::string e = "\"extras\": {\"note\": [1, null, {\"deep\": true}]}";
    const Scene scene = files.open(files.instances(
        "{\"name\": \"a\", \"archive\": {\"path\": \"box.rro\", " + e + "}, " + e +
            ", \"transform\": {\"rotate\": {\"axis\": " + "[0, 0, 1], \"degrees\": 0, " + e + "}, " + e +
            "}, \"materials\": {\"walls\": {" + e + "}, " + e + "}}",
        ", \"camera\": {\"position\": [0, 0, 1], \"target\": [0, 0, 0], " + e + "}, \"groups\": {" + e + "}, " + e));
    CHECK(scene.instances.size() == 1);
}

TEST_CASE("a camera that cannot look is refused", "[manifest]") {
    SceneFiles files;
    const auto error = [&](const std::string& camera) {
        return text_of(files.error(files.instances("", ", \"camera\": {" + camera + "}")));
    };
    CHECK_THAT(error("\"position\": [1, 2, 3], \"target\": [1, 2, 3]"),
               Contains("/camera/target: found the camera's position, expected a point to look at"));
    CHECK_THAT(error("\"position\": [0, 5, 0], \"target\": [0, 0, 0]"),
               Contains("/camera/up: found [0,1,0], expected a direction that is not along the view"));
    CHECK_THAT(error("\"position\": [0, 5, 0], \"target\": [1, 0, 0], \"vertical_fov\": 180"),
               Contains("/vertical_fov: found 180"));
}

TEST_CASE("points are scaled, then rotated right-handed, then translated", "[manifest][transform]") {
    SceneFiles files;
    const Affine3 m =
        placed(files, R"({"translate": [10, 0, 0], "rotate": {"axis": [0, 0, 2], "degrees": 90}, "scale": [2, 3, 4]})");
    // x: scaled to 2x, turned to 2y, moved. Quarter turns are exact.
    CHECK(m.point({1, 0, 0}) == Vec3{10, 2, 0});
    CHECK(m.point({0, 1, 0}) == Vec3{7, 0, 0});
    CHECK(m.point({0, 0, 1}) == Vec3{10, 0, 4});
    CHECK(placed(files, R"({"rotate": {"axis": [0, 1, 0], "degrees": 90}})").point({0, 0, 1}) == Vec3{1, 0, 0});
    CHECK(placed(files, R"({"rotate": {"axis": [1, 0, 0], "degrees": -450}})").point({0, 0, 1}) == Vec3{0, 1, 0});
    CHECK(placed(files, R"({"scale": 3})").point({1, 2, 3}) == Vec3{3, 6, 9});
    // About the diagonal by a third of a turn: the axes change places.
    const Vec3 y = placed(files, R"({"rotate": {"axis": [1, 1, 1], "degrees": 120}})").point({1, 0, 0});
    CHECK(length(y - Vec3{0, 1, 0}) < 1e-15);
    CHECK(placed(files, R"({"matrix": [1,2,3,4, 0,5,6,7, 0,0,8,9, 0,0,0,1]})").point({1, 1, 1}) == Vec3{10, 18, 17});
    CHECK(placed(files, R"({"scale": [-1, 1, 1]})").linear.determinant() == -1);
    CHECK(placed(files, "{}") == Affine3{});
}

TEST_CASE("a transform that cannot be inverted well is refused and named", "[manifest][transform]") {
    SceneFiles files;
    const auto error = [&](const std::string& transform) {
        return text_of(instance_error(files, "\"transform\": " + transform));
    };
    CHECK(error(R"({"scale": [1, 0, 1]})") ==
          "room.json: /instances/0/transform: the transform is singular, expected one that can be inverted");
    // Rows in arithmetic progression: singular, although no entry is 0 and rounding leaves a determinant.
    CHECK_THAT(error(R"({"matrix": [0.1,0.2,0.3,0, 0.4,0.5,0.6,0, 0.7,0.8,0.9,0, 0,0,0,1]})"), Contains("is singular"));
    CHECK(error(R"({"scale": [1e5, 1, 1e-5]})") ==
          "room.json: /instances/0/transform: the transform has condition number 1e+10, expected at most 1e9");
    CHECK_THAT(error(R"({"rotate": {"axis": [1, 2, 3], "degrees": 33}, "scale": [2e9, 1, 1]})"),
               Contains("condition number 2e+09"));
    CHECK_THAT(error(R"({"scale": 1e-120})"), Contains("too large or too small"));
    CHECK_THAT(error(R"({"matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 1,0,0,1]})"),
               Contains("/transform/matrix: the last row is [1.0,0.0,0.0,1.0], expected [0,0,0,1]"));
    CHECK_THAT(error(R"({"matrix": [1,2,3]})"),
               Contains("/transform/matrix: found an array of 3, expected 16 numbers"));
    CHECK_THAT(error(R"({"rotate": {"axis": [0, 0, 0], "degrees": 1}})"), Contains("/rotate/axis: found [0,0,0]"));
    CHECK_THAT(error(R"({"rotate": {"axis": [0, 0, 1]}})"),
               Contains("/rotate: the key \"degrees\" is missing, expected a number"));
    // At the limit, and far from 1 in size, both are allowed.
    CHECK(placed(files, R"({"scale": [9.9e4, 1, 1e-4]})").linear(0, 0) == 9.9e4);
    CHECK(placed(files, R"({"scale": 1e-90})").linear(0, 0) == 1e-90);
}
