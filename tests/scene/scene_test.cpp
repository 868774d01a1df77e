#include "format/sha256.h"
#include "tests/scene/scene_files.h"

using namespace rro;
using namespace rro::test;
using Catch::Matchers::Contains;

namespace {

// Patches alternate between the materials of tiny_object.
constexpr std::size_t kWalls = 0, kLamp = 1;

std::string instance(const std::string& name, const std::string& more = "", const std::string& archive = "box.rro") {
    return "{\"name\": \"" + name + "\", \"archive\": \"" + archive + "\"" + more + "}";
}

}  // namespace

TEST_CASE("an archive is loaded once, however it is spelt", "[scene]") {
    SceneFiles files;
    std::filesystem::create_directory(files.folder / "library");
    std::filesystem::create_symlink(files.folder / "box.rro", files.folder / "library/same.rro");
    files.add_archive("other.rro", tiny_object(4));
    const Scene scene =
        files.open(files.instances(instance("a") + "," + instance("b", "", "library/../box.rro") + "," +
                                   instance("c", "", "library/same.rro") + "," + instance("d", "", "other.rro")));
    REQUIRE(scene.instances.size() == 4);
    CHECK(scene.objects.size() == 2);
    CHECK(scene.instances[0].object == scene.instances[1].object);
    CHECK(scene.instances[0].object == scene.instances[2].object);
    CHECK(scene.instances[3].object == scene.objects[1].get());
    CHECK(scene.instances[2].name == "c");
    CHECK(scene.triangle_count() == 48);
}

TEST_CASE("materials are the archive's, then those of *, then those of the exact name, field by field", "[scene]") {
    SceneFiles files;
    const Scene scene = files.open(files.instances(
        instance("plain") + "," + instance("star", R"(, "materials": {"*": {"reflectance": [0.1, 0.2, 0.3]}})") + "," +
        instance(
            "both",
            R"(, "materials": {"lamp": {"exitance": [5, 6, 7]}, "*": {"reflectance": [0.1, 0.2, 0.3], "exitance": [1, 1, 1]}})")));
    const Instance &plain = scene.instances[0], &star = scene.instances[1], &both = scene.instances[2];
    CHECK(plain.reflectance[kWalls] == Rgb{0.5f, 0.25f, 0.125f});
    CHECK(plain.exitance[kWalls] == Rgb{});
    CHECK(plain.exitance[kLamp] == Rgb{20, 18, 15.5f});
    CHECK(star.reflectance[kWalls] == Rgb{0.1f, 0.2f, 0.3f});
    CHECK(star.reflectance[kLamp] == Rgb{0.1f, 0.2f, 0.3f});
    CHECK(star.exitance[kLamp] == Rgb{20, 18, 15.5f});
    CHECK(both.exitance[kWalls] == Rgb{1, 1, 1});
    CHECK(both.exitance[kLamp] == Rgb{5, 6, 7});
    CHECK(both.reflectance[kLamp] == Rgb{0.1f, 0.2f, 0.3f});
    CHECK(both.reflectance.size() == 6);
}

TEST_CASE("an archive's exitance that single precision cannot hold is refused, unless the manifest replaces it", "[scene]") {
    SceneFiles files;
    for (const double exitance : {1e300, 1e31, 1e-31}) {
        TinyObject object = tiny_object();
        object.materials[1].exitance = {1, exitance, 1};
        files.add_archive("box.rro", object);
        const Error error = files.error(files.instances(instance("a")));
        CHECK(error.where == "room.json: /instances/0/archive");
        CHECK_THAT(error.message, Catch::Matchers::Contains("material \"lamp\" of box.rro has an exitance of "));
        const Scene scene = files.open(files.instances(instance("a", R"(, "materials": {"lamp": {"exitance": [1, 2, 3]}})")));
        CHECK(scene.instances[0].exitance[kLamp] == Rgb{1, 2, 3});
    }
}

TEST_CASE("a textured patch keeps its own reflectance until the manifest replaces it", "[scene]") {
    SceneFiles files;
    TinyObject object = tiny_object();
    object.patches[3].reflectance = {0.75f, 0.5f, 0.25f};  // of lamp, whose mean is 0
    files.add_archive("box.rro", object);
    const Scene scene = files.open(files.instances(
        instance("a") + "," + instance("b", R"(, "materials": {"lamp": {"reflectance": [0.1, 0.1, 0.1]}})")));
    CHECK(scene.instances[0].reflectance[3] == Rgb{0.75f, 0.5f, 0.25f});
    CHECK(scene.instances[1].reflectance[3] == Rgb{0.1f, 0.1f, 0.1f});
}

TEST_CASE("a reflectance below 1 stays below 1 in single precision", "[scene]") {
    SceneFiles files;
    const Scene scene =
        files.open(files.instances(instance("a", R"(, "materials": {"*": {"reflectance": [0.999999999999, 0, 0]}})")));
    CHECK(scene.instances[0].reflectance[0].x < 1);
}

TEST_CASE("a material that the archive lacks is refused with those there are", "[scene]") {
    SceneFiles files;
    const Error error =
        files.error(files.instances(instance("a") + "," + instance("b", R"(, "materials": {"wall": {}})")));
    CHECK(text_of(error) ==
          "room.json: /instances/1/materials/wall: box.rro has no material \"wall\", expected one of: walls, lamp");
    CHECK(error.hint == "did you mean \"walls\"?");
    CHECK(error.kind == ErrorKind::BadInput);
}

TEST_CASE("a missing or broken archive is named with its place in the manifest", "[scene]") {
    SceneFiles files;
    CHECK_THAT(text_of(files.error(files.instances(instance("a") + "," + instance("b", "", "lost/box.rro")))),
               Contains("room.json: /instances/1/archive: lost/box.rro: No such file or directory"));
    std::ofstream(files.folder / "broken.rro") << "this is no archive";
    const Error error = files.error(files.instances(instance("a") + "," + instance("b", "", "broken.rro")));
    CHECK(error.where == "room.json: /instances/1/archive");
    CHECK_THAT(error.message, Contains("broken.rro"));
    CHECK(error.kind == ErrorKind::BadInput);
}

TEST_CASE("a content pin is compared with the file's SHA-256, in either case of letters", "[scene]") {
    SceneFiles files;
    const std::string bytes = file_text(files.folder / "box.rro");
    const std::string hash = sha256_hex(std::as_bytes(std::span(bytes.data(), bytes.size())));
    const auto pinned = [&](const std::string& pin) {
        return files.instances(R"({"name": "a", "archive": {"path": "box.rro", "content": ")" + pin + "\"}}");
    };
    std::string upper = hash.substr(0, 12);
    for (char& c : upper) c = static_cast<char>(std::toupper(c));
    for (const std::string& good : {hash, hash.substr(0, 8), upper})
        CHECK(files.open(pinned(good)).instances.size() == 1);
    std::string wrong = hash.substr(0, 8);
    wrong[7] = wrong[7] == '0' ? '1' : '0';
    CHECK(text_of(files.error(pinned(wrong))) == "room.json: /instances/0/archive/content: box.rro has SHA-256 " +
                                                     hash + ", expected one that starts with " + wrong);
}

TEST_CASE("bounds are those of the placed triangles", "[scene]") {
    SceneFiles files;
    TinyObject object = tiny_object(3, {100, 0, 0});
    object.positions.push_back({1e6f, 0, 0});  // of no triangle
    files.add_archive("far.rro", object);
    // The box [100, 101] x [0, 2] x [0, 3], mirrored in x, and one at the origin turned by 45 degrees about z.
    const Scene scene =
        files.open(files.instances(instance("a", R"(, "transform": {"scale": [-1, 1, 1]})", "far.rro") + "," +
                                   instance("b", R"(, "transform": {"rotate": {"axis": [0, 0, 1], "degrees": 45}})")));
    const Instance &a = scene.instances[0], &b = scene.instances[1];
    CHECK(a.bounds.lo == Vec3{-101, 0, 0});
    CHECK(a.bounds.hi == Vec3{-100, 2, 3});
    CHECK(a.determinant_sign == -1);
    CHECK(b.determinant_sign == 1);
    const double s = std::sqrt(0.5);
    CHECK(length(b.bounds.lo - Vec3{-2 * s, 0, 0}) < 1e-15);
    CHECK(length(b.bounds.hi - Vec3{s, 3 * s, 3}) < 1e-15);
    CHECK(scene.bounds.lo.x == -101);
    CHECK(scene.bounds.hi.z == 3);
    CHECK(length(a.to_local.point(a.to_world.point({1, 2, 3})) - Vec3{1, 2, 3}) < 1e-15);
}

TEST_CASE("an instance that loses its shape far out is refused", "[scene]") {
    SceneFiles files;
    const auto at = [&](const std::string& transform) {
        return files.instances(instance("a", ", \"transform\": " + transform));
    };
    for (const char* far : {R"({"translate": [1e13, 0, 0]})", R"({"translate": [1.7e308, 1.7e308, 0], "scale": 1e90})"})
        CHECK(
            text_of(files.error(at(far))) ==
            "room.json: /instances/0/transform: places the object so far from 0 that double precision loses its shape");
    CHECK(files.open(at(R"({"translate": [1e9, 0, 0]})")).bounds.extent() == Vec3{1, 2, 3});
}

TEST_CASE("lookups lead from triangles to faces and from faces to patches", "[scene]") {
    SceneFiles files;
    const Scene scene = files.open(files.instances(instance("a")));
    const Object& object = *scene.objects[0];
    const ObjectData& data = object.data();
    for (std::uint32_t t = 0; t < data.triangles.size(); ++t) {
        CHECK(data.faces[object.front_face[t]].triangle() == t);
        CHECK(object.back_face[t] == kNoFace);
    }
    for (std::uint32_t f = 0; f < data.faces.size(); ++f) {
        const Patch& patch = data.patches[object.patch_of_face[f]];
        CHECK((f >= patch.first_face && f < patch.first_face + patch.face_count));
    }
    // Rays see the box: from 5 m in front of the wall z = 3, the way back along z.
    CHECK(object.rays->first_hit({{0.25f, 1, 8}, {0, 0, -1}, 0, 100}).t == Approx(5));
}

TEST_CASE("a scene without instances opens", "[scene]") {
    SceneFiles files;
    const Scene scene = files.open(files.instances(""));
    CHECK(scene.instances.empty());
    CHECK(scene.bounds.empty());
}

TEST_CASE("an archive without the tables that a method needs is refused by who needs them, and read by others",
          "[scene]") {
    SceneFiles files;
    TinyObject object = tiny_object();
    object.visibility.clear();
    files.add_archive("bare.rro", object);
    const auto manifest = files.instances(instance("a", "", "bare.rro"));
    const Error error = files.error(manifest);
    CHECK_THAT(text_of(error), Contains("/instances/0/archive") && Contains("bare.rro") &&
                                   Contains("has no section visibility, which --method reusable needs"));
    auto read = read_manifest(manifest);
    REQUIRE(read);
    CHECK(open_scene(std::move(*read), kGeometry | Section::Source));

    object = tiny_object();
    object.whole_area.clear();
    object.whole_area_scale.clear();
    files.add_archive("bare.rro", object);
    CHECK_THAT(text_of(files.error(manifest)), Contains("has no section area"));
}
