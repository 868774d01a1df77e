#include <catch2/catch.hpp>

#include "solver/output/output.h"
#include "tests/output/hand_made_scene.h"
#include "tests/support/temporary_folder.h"

using namespace rro;
using namespace rro::test;

namespace {

Rgb by_face(const Instance&, const Vec3&, std::uint32_t face) {
    return {1 + static_cast<float>(face), 0.1f, 1.0f / 3};
}

const std::string kHeader =
    "instance,triangle,radiosity_r,radiosity_g,radiosity_b,irradiance_r,irradiance_g,irradiance_b,"
    "back_r,back_g,back_b";

}  // namespace

TEST_CASE("rows follow the manifest, then source numbers; backs only where there are two sides", "[output][csv]") {
    Scene scene;
    Mesh one = make_quad(1, 1);
    one.source_triangle = {7, 3};  // an archive's order is its own; number 7 comes second
    one.source_triangles = 8;
    add_instance(scene, "z one", one);
    add_instance(scene, "a two", make_quad(1, 1, true));
    const TemporaryFolder folder;
    REQUIRE(write_radiosity_csv(scene, solution_by(scene, by_face), folder / "b.csv"));
    // 9 significant digits give back the float: 0.1f is 0.100000001.
    CHECK(file_text(folder / "b.csv") == kHeader +
                                             "\n"
                                             "z one,3,2,0.100000001,0.333333343,4,0.200000003,0.666666687,,,\n"
                                             "z one,7,1,0.100000001,0.333333343,2,0.200000003,0.666666687,,,\n"
                                             "a two,0,1,0.100000001,0.333333343,2,0.200000003,0.666666687,"
                                             "2,0.100000001,0.333333343\n"
                                             "a two,1,3,0.100000001,0.333333343,6,0.200000003,0.666666687,"
                                             "4,0.100000001,0.333333343\n");
}

TEST_CASE("names are quoted as RFC 4180 says", "[output][csv]") {
    Scene scene;
    for (const char* name : {"plain name", "a,b", "say \"hi\"", "two\nlines"}) add_instance(scene, name, make_quad(1, 1));
    const TemporaryFolder folder;
    REQUIRE(write_radiosity_csv(scene, solution_by(scene, by_face), folder / "b.csv"));
    const std::string text = file_text(folder / "b.csv");
    CHECK(text.find("\nplain name,0,") != std::string::npos);
    CHECK(text.find("\n\"a,b\",0,") != std::string::npos);
    CHECK(text.find("\n\"say \"\"hi\"\"\",0,") != std::string::npos);
    CHECK(text.find("\n\"two\nlines\",0,") != std::string::npos);
}

TEST_CASE("standard errors bring three more columns", "[output][csv]") {
    Scene scene;
    add_instance(scene, "quad", make_quad(1, 1));
    Solution solution = solution_by(scene, by_face);
    solution.instances[0].standard_error.assign(2, {0.25f, 0.5f, 1e-12f});
    const TemporaryFolder folder;
    REQUIRE(write_radiosity_csv(scene, solution, folder / "b.csv"));
    const std::string text = file_text(folder / "b.csv");
    CHECK(text.starts_with(kHeader + ",stderr_r,stderr_g,stderr_b\n"));
    CHECK(text.find("0.666666687,,,,0.25,0.5,9.99999996e-13\n") != std::string::npos);
}

TEST_CASE("a folder that is not there is an error that names the file", "[output][csv]") {
    Scene scene;
    add_instance(scene, "quad", make_quad(1, 1));
    const TemporaryFolder folder;
    const Status status = write_radiosity_csv(scene, solution_by(scene, by_face), folder.path() / "no" / "b.csv");
    REQUIRE_FALSE(status);
    CHECK(status.error().kind == ErrorKind::Failed);
    CHECK(status.error().where.find("b.csv") != std::string::npos);
}
