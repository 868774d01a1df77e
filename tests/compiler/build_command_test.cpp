#include "compiler/build_command.h"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>

#include "compiler/inspect.h"
#include "format/archive_reader.h"
#include "format/parallel.h"

using namespace rro;
namespace fs = std::filesystem;

namespace {

/// A folder of its own that goes when the test ends.
struct Folder {
    fs::path path = fs::temp_directory_path() / ("rro_build_command_" + std::to_string(getpid()));
    Folder() {
        fs::remove_all(path);
        fs::create_directories(path);
    }
    ~Folder() { fs::remove_all(path); }

    fs::path write(const std::string& name, const std::string& text) const {
        std::ofstream(path / name) << text;
        return path / name;
    }
};

std::string text_of(const fs::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

// A unit square in z-up centimetres, one triangle degenerate, materials with a name that CSV must quote.
constexpr const char* kSquare =
    "v 0 0 0\nv 100 0 0\nv 100 100 0\nv 0 100 0\nusemtl a,\"b\nf 1 2 3\nf 1 1 2\nusemtl other\nf 1 3 4\n";

BuildRequest request_for(const fs::path& mesh, const fs::path& out) {
    BuildRequest request;
    request.meshes = {mesh};
    request.out = out;
    request.unit = "cm";
    request.up = "z";
    return request;
}

BuildOutcome built(const BuildRequest& request) {
    const auto plan = plan_build(request);
    REQUIRE(plan);
    return build_target(plan->targets.front(), *plan);
}

}  // namespace

TEST_CASE("wrong values of options are usage errors", "[compiler][build]") {
    const Folder folder;
    BuildRequest request = request_for("a.obj", folder.path / "a.rro");
    REQUIRE(plan_build(request));
    SECTION("grid") {
        request.grid = 1;
    }
    SECTION("map") {
        request.map = "cube";
    }
    SECTION("sides") {
        request.two_sided = "maybe";
    }
    SECTION("unit") {
        request.unit = "km";
    }
    SECTION("up") {
        request.up = "x";
    }
    SECTION("reflectance of one") {
        request.reflectance = "0.5,1,0.5";
    }
    SECTION("reflectance below zero") {
        request.reflectance = "-0.1,0.5,0.5";
    }
    SECTION("reflectance of two channels") {
        request.reflectance = "0.5,0.5";
    }
    SECTION("reflectance with a tail") {
        request.reflectance = "0.5,0.5,0.5,0.5";
    }
    SECTION("no tables") {
        request.tables = "";
    }
    SECTION("an unknown table") {
        request.tables = "area,volume";
    }
    SECTION("a missing name of a table") {
        request.tables = "area,";
    }
    SECTION("all among other tables") {
        request.tables = "area,all";
    }
    SECTION("errors of tables that are not stored") {
        request.tables = "errors,area";
    }
    SECTION("equal stems") {
        request.meshes = {"x/a.obj", "y/a.ply"};
        request.out = folder.path;
    }
    SECTION("several meshes into one file") {
        request.meshes = {"a.obj", "b.obj"};
        request.out = folder.write("a.rro", "");
    }
    SECTION("over the mesh") {
        request.out = "a.obj";
    }
    const auto plan = plan_build(request);
    REQUIRE(!plan);
    CHECK(plan.error().kind == ErrorKind::Usage);
}

TEST_CASE("a folder gets one archive per mesh, named by its stem", "[compiler][build]") {
    const Folder folder;
    BuildRequest request = request_for("x/a.obj", folder.path / "library");
    request.meshes.push_back("y/b.c.ply");
    const auto plan = plan_build(request);
    REQUIRE(plan);
    CHECK(plan->targets[0].archive == folder.path / "library/a.rro");
    CHECK(plan->targets[1].archive == folder.path / "library/b.c.rro");
    CHECK(fs::is_directory(folder.path / "library"));
}

TEST_CASE("build, inspect, and build again if changed", "[compiler][build]") {
    const Folder folder;
    const fs::path mesh = folder.write("my square.obj", kSquare), archive = folder.path / "square.rro";
    BuildRequest request = request_for(mesh, archive);
    request.if_changed = true;
    const BuildOutcome first = built(request);
    REQUIRE(!first.error);
    CHECK(!first.unchanged);
    CHECK(first.triangles == 2);
    CHECK(first.faces == 4);  // open: two-sided
    CHECK(first.meta.area == Approx(2));
    CHECK(first.import.dropped_degenerate == 1);

    const auto opened = Archive::open(archive);
    REQUIRE(opened);
    CHECK(opened->data().meta.source_name == "my square.obj");
    CHECK(triangles_csv(opened->data()) ==
          "triangle,material,ax,ay,az,bx,by,bz,cx,cy,cz\n"
          "0,\"a,\"\"b\",0,0,0,1,0,0,1,0,-1\n"
          "2,other,0,0,0,1,0,-1,0,0,-1\n");
    const auto inspected = nlohmann::json::parse(inspection_json(*opened, "square.rro"));
    CHECK(inspected["counts"]["triangles"] == 2);
    CHECK(inspected["counts"]["source_triangles"] == 3);
    CHECK(inspected["sections"].size() == opened->sections().size());

    CHECK(built(request).unchanged);
    request.grid = 8;
    CHECK(!built(request).unchanged);
    folder.write("my square.obj", std::string(kSquare) + "v 1 2 3\n");
    CHECK(!built(request).unchanged);
    CHECK(built(request).unchanged);
    folder.write("square.rro", "not an archive");
    CHECK(!built(request).unchanged);
}

TEST_CASE("an archive holds the tables that --tables names, and says so", "[compiler][build]") {
    const Folder folder;
    const fs::path mesh = folder.write("square.obj", kSquare), archive = folder.path / "square.rro";
    struct Case {
        std::string tables, said;
        std::set<std::string> optional;  // sections beyond those of every archive
    };
    const std::vector<Case> cases{
        {"default", "default", {"area", "visibility", "errors", "hbv", "hit", "atlas"}},
        {"all", "all", {"area", "visibility", "errors", "hbv", "hit", "atlas"}},
        {"selflinks,atlas,hit,errors,visibility,area", "default", {"area", "visibility", "errors", "hbv", "hit", "atlas"}},
        {"visibility,area", "area,visibility", {"area", "visibility", "hbv"}},
        {"area", "area", {"area", "hbv"}},
        {"visibility", "visibility", {"visibility", "hbv"}},
        {"errors,area,visibility", "area,visibility,errors", {"area", "visibility", "errors", "hbv"}},
        {"hit", "hit", {"hbv", "hit"}},
        {"atlas,atlas", "atlas", {"hbv", "atlas"}},
        {"selflinks", "selflinks", {"hbv"}},
    };
    for (const Case& example : cases) {
        INFO("--tables " << example.tables);
        BuildRequest request = request_for(mesh, archive);
        request.tables = example.tables;
        request.grid = 2;
        REQUIRE(!built(request).error);
        const auto opened = Archive::open(archive);
        REQUIRE(opened);
        CHECK_THAT(opened->data().meta.options, Catch::Matchers::Contains(" tables=" + example.said + " "));
        std::set<std::string> optional;
        for (const SectionInfo& section : opened->sections()) optional.insert(section.name);
        for (const char* always : {"meta", "mesh", "materials", "patches", "clusters", "source"})
            CHECK(optional.erase(always) == 1);
        CHECK(optional == example.optional);
        CHECK(opened->data().intrinsic_hit.empty() == (example.tables != "all"));
        CHECK(!inspection_text(*opened, "square.rro").empty());
    }
}

TEST_CASE("tables: all is for every node, default for the largest", "[compiler][build]") {
    const Folder folder;
    // A sheet of 1,500 steps: more clusters and volumes than the largest thousand.
    std::string steps;
    for (int i = 0; i <= 3000; ++i)
        for (int j = 0; j < 2; ++j)
            steps += "v " + std::to_string(i) + " " + std::to_string(i / 2 % 2 * 2 + i % 2) + " " + std::to_string(j) + "\n";
    for (int i = 0; i < 3000; ++i) {
        const int a = 2 * i + 1;
        steps += "f " + std::to_string(a) + " " + std::to_string(a + 1) + " " + std::to_string(a + 3) + " " +
                 std::to_string(a + 2) + "\n";
    }
    BuildRequest request = request_for(folder.write("steps.obj", steps), folder.path / "steps.rro");
    request.grid = 2;
    for (const char* tables : {"default", "all"}) {
        request.tables = tables;
        REQUIRE(!built(request).error);
        const auto archive = Archive::open(folder.path / "steps.rro");
        REQUIRE(archive);
        const ObjectData& d = archive->data();
        REQUIRE(std::min(d.clusters.size(), d.volumes.size()) > 1024);
        CHECK(d.area_clusters.size() == (request.tables == "all" ? d.clusters.size() : 1024));
        CHECK(d.hit_volumes.size() == (request.tables == "all" ? d.volumes.size() : 1024));
        CHECK(d.intrinsic_area.size() == d.area_clusters.size() * 4);
        CHECK(d.whole_area_error.size() == d.area_clusters.size());
        CHECK(d.intrinsic_hit.size() == (request.tables == "all" ? d.volumes.size() * 2 : 0));
    }
}

TEST_CASE("an archive's bytes do not depend on threads or on when it is made", "[compiler][build]") {
    const Folder folder;
    const fs::path mesh = folder.write("square.obj", kSquare);
    std::string first;
    for (const unsigned threads : {1u, 2u, 3u}) {
        set_thread_count(threads);
        const fs::path archive = folder.path / (std::to_string(threads) + ".rro");
        REQUIRE(!built(request_for(mesh, archive)).error);
        if (first.empty()) first = text_of(archive);
        CHECK(!first.empty());
        CHECK(text_of(archive) == first);
    }
    set_thread_count(0);
}

TEST_CASE("a mesh that cannot be read is an outcome, and reported", "[compiler][build]") {
    const Folder folder;
    const BuildOutcome outcome = built(request_for(folder.path / "none.obj", folder.path / "none.rro"));
    REQUIRE(outcome.error);
    CHECK(outcome.error->kind == ErrorKind::BadInput);
    CHECK(!fs::exists(folder.path / "none.rro"));
    const auto report = nlohmann::json::parse(build_report({outcome}));
    CHECK(report["archives"][0]["state"] == "failed");
    CHECK(depfile_text({outcome}).empty());
}

TEST_CASE("depfiles escape what make would misread", "[compiler][build]") {
    BuildOutcome outcome;
    outcome.target = {"a b.obj", "out $1/a b.rro"};
    outcome.inputs = {"a b.obj", "c#.mtl"};
    CHECK(depfile_text({outcome}) == "out\\ $$1/a\\ b.rro: \\\n  a\\ b.obj \\\n  c\\#.mtl\n");
}
