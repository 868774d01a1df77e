#include "solver/arguments.h"

#include "solver/solve_scene.h"
#include "tests/scene/scene_files.h"

using namespace rro;
using namespace rro::test;
using Catch::Matchers::Contains;

TEST_CASE("sizes of memory are bytes or powers of 1024", "[arguments]") {
    CHECK(*parse_bytes("8G") == 8ull << 30);
    CHECK(*parse_bytes("512M") == 512ull << 20);
    CHECK(*parse_bytes("1000") == 1000);
    for (const char* wrong : {"", "G", "0", "0G", "-1", "1.5G", "8GB", "99999999999999999999", "99999999999T", " 8G"})
        CHECK_FALSE(parse_bytes(wrong));
    CHECK(parse_bytes("x").error().kind == ErrorKind::Usage);
}

TEST_CASE("picture sizes are width x height", "[arguments]") {
    CHECK(*parse_size("960x540") == std::array{960, 540});
    for (const char* wrong : {"", "960", "960x", "x540", "0x1", "-1x5", "960x540x2", "20000x1", "960 x 540"})
        CHECK_FALSE(parse_size(wrong));
}

TEST_CASE("outputs are tried before the work", "[arguments]") {
    TemporaryFolder folder;
    const auto check = [&](const std::filesystem::path& a, const std::filesystem::path& b = {}) {
        return check_outputs(std::array{a, b}, folder / "room.json");
    };
    CHECK(check(folder / "a.csv", folder / "b.csv"));
    CHECK(check("", ""));
    CHECK(check("/dev/null", "/dev/null"));
    CHECK_THAT(check(folder / "lost/a.csv").error().message, Contains("there is no folder"));
    CHECK(check(folder / "lost/a.csv").error().kind == ErrorKind::Failed);
    CHECK_THAT(check(folder.path()).error().message, Contains("it is a folder"));
    CHECK(check(folder / "a.csv", folder / "./a.csv").error().kind == ErrorKind::Usage);
    CHECK(check(folder / "room.json").error().kind == ErrorKind::Usage);
}

TEST_CASE("transports by name", "[arguments]") {
    CHECK(*parse_transport("directional") == Transport::Directional);
    CHECK(*parse_transport("plain") == Transport::Plain);
    CHECK(parse_transport("fancy").error().kind == ErrorKind::Usage);
    CHECK(parse_transport("fancy").error().message ==
          "--transport fancy: no such transport, expected directional or plain");
}

TEST_CASE("methods and visibilities by name", "[arguments]") {
    CHECK(*parse_method("reference") == Method::Reference);
    CHECK(*parse_method("hierarchical") == Method::Hierarchical);
    CHECK(parse_method("hierarchic").error().message ==
          "--method hierarchic: no such method, expected reusable, hierarchical or reference");
    CHECK(parse_method("magic").error().kind == ErrorKind::Usage);
    CHECK(*parse_visibility("none") == VisibilityMethod::None);
    CHECK(*parse_visibility("atlas") == VisibilityMethod::Atlas);
    CHECK(*parse_visibility("tables") == VisibilityMethod::Tables);
    CHECK(parse_visibility("x").error().kind == ErrorKind::Usage);
    CHECK(parse_visibility("x").error().message == "--visibility x: no such visibility, expected auto, atlas, tables, rays or none");
}
