#include "compiler/library_build.h"

#include <catch2/catch.hpp>
#include <fstream>
#include <nlohmann/json.hpp>

#include "compiler/input_record.h"
#include "format/archive_reader.h"
#include "format/parallel.h"
#include "tests/support/temporary_folder.h"

using namespace rro;
using rro::test::file_text;
namespace fs = std::filesystem;

namespace {

constexpr const char* kTetrahedron =
    "mtllib paint.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
    "usemtl red\nf 1 3 2\nf 1 2 4\nusemtl lamp\nf 1 4 3\nf 2 3 4\n";
constexpr const char* kPaint = "newmtl red\nKd 0.8 0.1 0.1\nnewmtl lamp\nKd 0.5 0.5 0.5\nKe 1 1 1\n";

/// A folder with a mesh and its materials; libraries are written to it.
struct Workshop {
    test::TemporaryFolder folder;

    Workshop() {
        write("tetrahedron.obj", kTetrahedron);
        write("paint.mtl", kPaint);
    }
    void write(const std::string& name, const std::string& text) const { std::ofstream(folder / name) << text; }
    fs::path out() const { return folder / "out"; }

    Result<std::vector<BuildPlan>> plan(const std::string& library) const {
        write("library.json", library);
        return plan_library({folder / "library.json", out(), {}, {}});
    }
    std::vector<BuildOutcome> build(const std::string& library) const {
        const auto plans = plan(library);
        if (!plans) FAIL(plans.error().where << ": " << plans.error().message);
        return build_all(*plans);
    }
};

/// A library of one object "a" with these further keys, on the coarsest grid.
std::string library_of(const std::string& keys) {
    return R"({"format": "rro-library/1", "defaults": {"grid": 2},
              "objects": [{"name": "a", "mesh": "tetrahedron.obj")" +
           (keys.empty() ? "" : ", " + keys) + "}]}";
}

std::vector<Material> materials_of(const fs::path& archive) {
    const auto opened = Archive::open(archive);
    REQUIRE(opened);
    return opened->data().materials;
}

}  // namespace

TEST_CASE("an object's options are its own, else the defaults, else those of build", "[compiler][library]") {
    const Workshop shop;
    const auto plans = shop.plan(R"({"format": "rro-library/1", "extras": 1,
        "defaults": {"unit": "cm", "grid": 8, "two_sided": true, "extras": {}},
        "objects": [
          {"name": "a", "mesh": "m/a.obj"},
          {"name": "b", "mesh": "../b.ply", "unit": "mm", "up": "z", "two_sided": "no", "fix_winding": true, "grid": 4,
           "map": "latlong", "reflectance": [0.1, 0.25, 0], "tables": "default", "extras": []}]})");
    REQUIRE(plans);
    REQUIRE(plans->size() == 2);
    const BuildPlan &a = (*plans)[0], &b = (*plans)[1];
    CHECK(a.targets.front().mesh == shop.folder / "m/a.obj");
    CHECK(a.targets.front().archive == shop.out() / "a.rro");
    CHECK(b.targets.front().mesh == shop.folder.path().parent_path() / "b.ply");
    CHECK((a.import.unit == 0.01 && b.import.unit == 0.001));
    CHECK((!a.import.z_up && b.import.z_up));
    CHECK((a.two_sided == TwoSided::Yes && b.two_sided == TwoSided::No));
    CHECK((!a.fix_winding && b.fix_winding));
    CHECK((a.compile.grid_size == 8 && b.compile.grid_size == 4));
    CHECK((a.compile.grid_map == GridMap::Octahedral && b.compile.grid_map == GridMap::LatLong));
    CHECK((!a.import.reflectance && b.import.reflectance == Vec3{0.1, 0.25, 0}));
    CHECK((a.if_changed && b.if_changed));
}

TEST_CASE("a library with the options of build gives the archive of build", "[compiler][library]") {
    const Workshop shop;
    REQUIRE(!shop.build(library_of(R"("unit": "cm", "up": "z")")).front().error);
    BuildRequest request;
    request.meshes = {shop.folder / "tetrahedron.obj"};
    request.out = shop.folder / "b.rro";
    request.unit = "cm";
    request.up = "z";
    request.grid = 2;
    const auto plan = plan_build(request);
    REQUIRE(plan);
    REQUIRE(!build_target(plan->targets.front(), *plan).error);
    CHECK(file_text(shop.out() / "a.rro") == file_text(request.out));
    CHECK(!fs::exists(input_record_path(request.out)));  // only where it will be asked for
}

TEST_CASE("materials: all first, then by name, field by field", "[compiler][library]") {
    const Workshop shop;
    REQUIRE(!shop.build(library_of(R"("materials": {"red": {"exitance": [3, 2, 1], "extras": 1}, "extras": {},
                                       "*": {"reflectance": [0.25, 0.5, 0.75], "exitance": [7, 7, 7]}})"))
                 .front()
                 .error);
    const auto materials = materials_of(shop.out() / "a.rro");
    REQUIRE(materials.size() == 2);
    CHECK(materials[0].name == "red");
    CHECK(materials[0].reflectance == Vec3{0.25, 0.5, 0.75});
    CHECK(materials[0].exitance == Vec3{3, 2, 1});
    CHECK(materials[1].exitance == Vec3{7, 7, 7});
    const auto opened = Archive::open(shop.out() / "a.rro");
    for (const Patch& patch : opened->data().patches) CHECK(patch.reflectance == Rgb{0.25f, 0.5f, 0.75f});
}

TEST_CASE("a material that the mesh lacks fails its object, with those there are", "[compiler][library]") {
    const Workshop shop;
    const auto outcome = shop.build(library_of(R"("materials": {"rad": {"exitance": [3, 2, 1]}})")).front();
    REQUIRE(outcome.error);
    const Error error = library_error(*outcome.error);
    CHECK(error.kind == ErrorKind::BadInput);
    CHECK(error.where == (shop.folder / "library.json").string() + ": /objects/0/materials/rad");
    CHECK(error.message.find("red, lamp") != std::string::npos);
    CHECK(error.hint == "did you mean \"red\"?");
    CHECK(!fs::exists(shop.out() / "a.rro"));
}

TEST_CASE("what decides an archive makes it anew, and nothing else does", "[compiler][library]") {
    const Workshop shop;
    const auto unchanged = [&](const std::string& keys = "") {
        const BuildOutcome outcome = shop.build(library_of(keys)).front();
        REQUIRE(!outcome.error);
        return outcome.unchanged;
    };
    CHECK(!unchanged());
    CHECK(unchanged());
    SECTION("options") {
        CHECK(!unchanged(R"("grid": 3)"));
        CHECK(unchanged(R"("grid": 3)"));
        CHECK(!unchanged(R"("grid": 3, "materials": {"red": {"reflectance": [0, 0, 0]}})"));
        CHECK(!unchanged(R"("grid": 3, "materials": {"red": {"reflectance": [0, 0, 0.5]}})"));
        CHECK(unchanged(R"("materials": {"red": {"reflectance": [0, 0, 0.5]}}, "grid": 3)"));
    }
    SECTION("the mesh") {
        shop.write("tetrahedron.obj", std::string(kTetrahedron) + "# changed\n");
        CHECK(!unchanged());
    }
    SECTION("a file that the mesh refers to") {
        shop.write("paint.mtl", std::string(kPaint) + "newmtl other\n");
        CHECK(!unchanged());
        CHECK(unchanged());
    }
    SECTION("a file that it no longer finds, and finds again") {
        fs::remove(shop.folder / "paint.mtl");
        CHECK(!unchanged());
        CHECK(unchanged());
        shop.write("paint.mtl", kPaint);
        CHECK(!unchanged());
    }
    SECTION("a texture that is found in a better place") {
        // Where the MTL says there is none, so that the one beside the MTL counts.
        shop.write("paint.mtl", std::string(kPaint) + "map_Kd textures/wood.png\n");
        shop.write("wood.png", "no picture");
        CHECK(!unchanged());
        CHECK(unchanged());
        shop.write("wood.png", "another");
        CHECK(!unchanged());
        fs::create_directory(shop.folder / "textures");
        shop.write("textures/wood.png", "in its place");
        CHECK(!unchanged());
        CHECK(unchanged());
    }
    SECTION("the archive itself") {
        std::ofstream(shop.out() / "a.rro", std::ios::app) << "tail";
        CHECK(!unchanged());
    }
    SECTION("the time of a file decides nothing") {
        fs::last_write_time(shop.folder / "tetrahedron.obj", fs::file_time_type::clock::now());
        CHECK(unchanged());
    }
    SECTION("the record is a help, never needed") {
        fs::remove(input_record_path(shop.out() / "a.rro"));
        CHECK(unchanged());
        CHECK(fs::exists(input_record_path(shop.out() / "a.rro")));
    }
}

TEST_CASE("a record that says too little or too much deceives nobody", "[compiler][library]") {
    const Workshop shop;
    const fs::path archive = shop.out() / "a.rro", mesh = shop.folder / "tetrahedron.obj";
    shop.build(library_of(""));
    const auto inputs = read_recorded_inputs(archive, mesh);
    REQUIRE(inputs);
    CHECK(inputs->read == std::vector<fs::path>{mesh, shop.folder / "paint.mtl"});
    const auto opened = Archive::open(archive, Section::Meta);
    REQUIRE(opened);
    CHECK(inputs->sha256 == opened->data().meta.source_sha256);

    const std::string record = file_text(input_record_path(archive));
    shop.write("out/.a.rro.inputs", "rro-inputs/1\n");  // forgets the materials
    CHECK(read_recorded_inputs(archive, mesh)->sha256 != inputs->sha256);
    for (const char* text : {"", "rro-inputs/2\n", "rro-inputs/1\n+ gone.mtl\n", "rro-inputs/1\n- paint.mtl\n",
                             "rro-inputs/1\n+\n", "rro-inputs/1\n+ .\n"}) {
        shop.write("out/.a.rro.inputs", text);
        INFO(text);
        CHECK(!read_recorded_inputs(archive, mesh));
    }
    CHECK(shop.build(library_of("")).front().unchanged);  // by an import
    CHECK(file_text(input_record_path(archive)) == record);
}

TEST_CASE("one mesh that cannot be used does not hide the others, and results come in order", "[compiler][library]") {
    const Workshop shop;
    shop.write("broken.obj", "v 0 0 0\nf 1 2 3\n");
    std::string objects;
    for (const char* name : {"a", "b", "c", "d", "e"})
        objects += std::string(objects.empty() ? "" : ",") + R"({"name": ")" + name + R"(", "mesh": ")" +
                   (*name == 'c' ? "broken.obj" : "tetrahedron.obj") + "\"}";
    const std::string library = R"({"format": "rro-library/1", "defaults": {"grid": 2}, "objects": [)" + objects + "]}";
    std::vector<std::string> files;
    for (const unsigned threads : {1u, 8u}) {
        set_thread_count(threads);
        fs::remove_all(shop.out());
        const auto plans = shop.plan(library);
        REQUIRE(plans);
        std::vector<std::string> told;
        std::vector<double> progress;
        const auto outcomes =
            build_all(*plans, {[&](const BuildOutcome& o) { told.push_back(o.target.archive.stem()); },
                               [&](std::string_view, double done) { progress.push_back(done); }});
        CHECK(told == std::vector<std::string>{"a", "b", "c", "d", "e"});
        CHECK(progress == std::vector<double>{0, 0.2, 0.4, 0.6, 0.8});
        for (const BuildOutcome& o : outcomes) {
            const bool broken = o.target.archive.stem() == "c";
            CHECK(o.error.has_value() == broken);
            CHECK(fs::exists(o.target.archive) == !broken);
            files.push_back(file_text(o.target.archive));
        }
        CHECK(library_error(*outcomes[2].error).kind == ErrorKind::Failed);
    }
    set_thread_count(0);
    for (std::size_t i = 0; i < 5; ++i) CHECK(files[i] == files[i + 5]);
}

TEST_CASE("faults of a library file are refused with their place", "[compiler][library]") {
    const Workshop shop;
    const auto [text, place, said] = GENERATE(table<std::string, std::string, std::string>({
        {"{", "library.json: line 1", "JSON"},
        {R"({"objects": []})", "library.json", "\"format\" is missing"},
        {R"({"format": "rro-library/2", "objects": []})", ": /format", "rro-library/1"},
        {R"({"format": "rro-library/1", "objects": {}})", ": /objects", "an array"},
        {R"({"format": "rro-library/1", "objects": [], "default": {}})", ": /default", "unknown key"},
        {R"({"format": "rro-library/1", "objects": [], "defaults": {"mesh": "a"}})", ": /defaults/mesh", "unknown key"},
        {library_of(R"("units": "cm")"), ": /objects/0/units", "unknown key"},
        {library_of(R"("unit": "km")"), ": /objects/0/unit", "\"cm\""},
        {library_of(R"("grid": 1)"), ": /objects/0/grid", "2 to 128"},
        {library_of(R"("two_sided": "maybe")"), ": /objects/0/two_sided", "\"auto\""},
        {library_of(R"("reflectance": [0, 0, 1])"), ": /objects/0/reflectance/2", "below 1"},
        {library_of(R"("materials": {"a": {"reflectance": [-0.5, 0, 0]}})"), "/materials/a/reflectance/0",
         "at least 0"},
        {library_of(R"("materials": {"a": {"exitance": [1e31, 0, 0]}})"), "/materials/a/exitance/0", "1e30"},
        {library_of(R"("materials": {"a/b": {"colour": 1}})"), "/materials/a~1b/colour", "unknown key"},
        {library_of(R"("name": "b")"), ": /objects/0", "twice"},
        {library_of(R"("tables": "nonsense")"), ": /objects/0", "nonsense"},
        {R"({"format": "rro-library/1", "objects": [{"mesh": "a.obj"}]})", ": /objects/0", "\"name\" is missing"},
        {R"({"format": "rro-library/1", "objects": [{"name": "a"}]})", ": /objects/0", "\"mesh\" is missing"},
        {R"({"format": "rro-library/1", "objects": [{"name": "", "mesh": "a.obj"}]})", ": /objects/0/name",
         "not empty"},
        {R"({"format": "rro-library/1", "objects": [{"name": "a/b", "mesh": "a.obj"}]})", ": /objects/0/name", "\"/\""},
        {R"({"format": "rro-library/1", "objects": [{"name": "a", "mesh": "a\u0000.obj"}]})", ": /objects/0/mesh",
         "NUL"},
        {R"({"format": "rro-library/1", "objects": [{"name": "a", "mesh": "a.obj"}, {"name": "a", "mesh": "b.obj"}]})",
         ": /objects/1/name", "/objects/0"},
    }));
    INFO(text);
    const auto plans = shop.plan(text);
    REQUIRE(!plans);
    const Error& error = plans.error();
    CAPTURE(error.where, error.message);
    CHECK(error.kind == ErrorKind::BadInput);
    CHECK(error.where.find(place) != std::string::npos);
    CHECK((error.message + error.where).find(said) != std::string::npos);
}

TEST_CASE("every archive's rule in a depfile names the library too", "[compiler][library]") {
    const Workshop shop;
    const auto outcomes = shop.build(library_of(""));
    const std::string root = shop.folder.path().string() + "/";
    CHECK(depfile_text(outcomes, shop.folder / "library.json") == root + "out/a.rro: \\\n  " + root +
                                                                      "tetrahedron.obj \\\n  " + root +
                                                                      "paint.mtl \\\n  " + root + "library.json\n");
    CHECK(depfile_text(shop.build(library_of(""))) == depfile_text(outcomes));  // unchanged: the same inputs
}
