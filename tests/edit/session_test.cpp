#include "solver/session.h"

#include <cstdio>
#include <limits>
#include <memory>

#include "compiler/compile_object.h"
#include "tests/scene/scene_files.h"
#include "tests/support/meshes.h"

using namespace rro;
using namespace rro::test;

namespace {

/// Two boxes and a lit one above them.
class SessionFiles : public SceneFiles {
  public:
    SessionFiles() {
        const auto compiled = compile_object(make_box(1, 1, 1), {});
        REQUIRE(compiled);
        REQUIRE(write_archive(compiled->data, folder / "box.rro"));
        path = instances(R"({"name": "low", "archive": "box.rro"},
                            {"name": "beside", "archive": "box.rro", "transform": {"translate": [1.5, 0, 0]}},
                            {"name": "lamp", "archive": "box.rro", "transform": {"translate": [0, 2, 0]},
                             "materials": {"*": {"exitance": [10, 10, 10], "group": "evening"}}})",
                         R"(, "accuracy": 0.2)");
    }
    std::filesystem::path path;
};

double top(const SceneSession& session) {
    double sum = 0;
    for (std::uint32_t triangle = 0; triangle < 12; ++triangle) {
        const auto light = session.radiosity("low", triangle);
        REQUIRE(light);
        sum += light->y;
    }
    return sum;
}

}  // namespace

TEST_CASE("a session edits, solves and reads", "[session]") {
    const SessionFiles files;
    auto session = SceneSession::open(files.path);
    REQUIRE(session);
    CHECK_FALSE(session->radiosity("low", 0));  // nothing is solved yet
    REQUIRE(session->solve());
    const double before = top(*session);

    // Light falls off with distance, and comes back.
    REQUIRE(session->move("lamp", {Mat3{}, {0, 3, 0}}));
    REQUIRE(session->solve());
    CHECK(top(*session) < 0.7 * before);
    REQUIRE(session->move("lamp", {Mat3{}, {0, 2, 0}}));
    REQUIRE(session->solve());
    CHECK(top(*session) == Approx(before).epsilon(0.2 * 0.15));  // a tenth of the accuracy, and half as much again

    REQUIRE(session->dim("evening", 0.5));
    REQUIRE(session->solve());
    CHECK(top(*session) == Approx(0.5 * before).epsilon(0.2 * 0.15));
    REQUIRE(session->dim("evening", 1));

    REQUIRE(session->set_exitance("lamp", "*", {0, 0, 0}));
    REQUIRE(session->solve());
    CHECK(top(*session) == 0);
    REQUIRE(session->set_exitance("lamp", "*", {20, 20, 20}));
    REQUIRE(session->set_reflectance("beside", "*", {0, 0, 0}));
    REQUIRE(session->place("third", files.folder / "box.rro", {Mat3{}, {-1.5, 0, 0}}));
    REQUIRE(session->solve());
    CHECK(session->scene().instances.size() == 4);
    REQUIRE(session->remove("third"));
    REQUIRE(session->solve());
    CHECK(session->scene().instances.size() == 3);
    CHECK(top(*session) > 1.5 * before);
}

TEST_CASE("a session refuses what makes no scene, and stays", "[session]") {
    const SessionFiles files;
    auto session = SceneSession::open(files.path);
    REQUIRE(session);
    REQUIRE(session->solve());
    const double before = top(*session);
    CHECK_FALSE(session->move("nobody", {}));
    CHECK_FALSE(session->move("low", {Mat3{{Vec3{}, Vec3{}, Vec3{}}}, {}}));
    CHECK_FALSE(session->remove("nobody"));
    CHECK_FALSE(session->place("low", files.folder / "box.rro", {}));
    CHECK_FALSE(session->place("a/b", files.folder / "box.rro", {}));
    CHECK_FALSE(session->set_reflectance("low", "*", {1, 0, 0}));
    CHECK_FALSE(session->set_exitance("low", "*", {-1, 0, 0}));
    CHECK_FALSE(session->dim("evening", -1));
    CHECK_FALSE(session->radiosity("low", 12));
    REQUIRE(session->place("missing", files.folder / "none.rro", {}));
    CHECK_FALSE(session->solve());
    CHECK(top(*session) == before);
    REQUIRE(session->remove("missing"));
    CHECK(session->solve());
}

TEST_CASE("a session refuses the transforms that a manifest refuses, though they can be inverted", "[session]") {
    const SessionFiles files;
    auto session = SceneSession::open(files.path);
    REQUIRE(session);
    const auto scaled = [](double x) { return Affine3{Mat3{{Vec3{x, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}}, {}}; };
    CHECK(session->move("low", scaled(0.9e9)));
    const auto moved = session->move("low", scaled(1.1e9));
    REQUIRE_FALSE(moved);
    CHECK(moved.error().message == "the transform has condition number 1.1e+09, expected at most 1e9");
    CHECK_FALSE(session->place("flat", files.folder / "box.rro", scaled(1e-10)));
    CHECK_FALSE(session->move("low", {Mat3{}, {std::numeric_limits<double>::infinity(), 0, 0}}));
}

TEST_CASE("the sample of the C++ interface runs", "[session]") {
    const SessionFiles files;
    const std::string command = std::string(RRO_EDIT_SCENE) + " " + files.path.string() + " low";
    const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
    REQUIRE(pipe);
    std::string text;
    for (int c = std::fgetc(pipe.get()); c != EOF; c = std::fgetc(pipe.get())) text += static_cast<char>(c);
    CHECK(std::count(text.begin(), text.end(), '\n') == 4);
    CHECK(text.find("x = 0.40 m") != std::string::npos);
}
