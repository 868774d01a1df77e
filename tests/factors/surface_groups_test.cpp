#include "solver/factors/surface_groups.h"

#include <catch2/catch.hpp>

#include "solver/factors/surfaces.h"
#include "solver/factors/view_factors.h"
#include "tests/support/scenes.h"
#include "tests/support/shapes.h"

using namespace rro;
using namespace rro::test;

namespace {

/// A room of one material and a door, a box with the materials `default` (its first six triangles) and `panel`.
Scene room_and_door() {
    Mesh door = make_box(0.1, 0.2, 0.1, 1, {0.5, 0.5, 0.5});
    door.materials.push_back({"panel", {0.5, 0.5, 0.5}, {}, false});
    for (std::size_t t = 6; t < door.material.size(); ++t) door.material[t] = 1;
    Placed room{turned_inside_out(make_box(2, 2, 2))};
    room.name = "room";
    Placed second{door};
    second.name = "door";
    return make_scene({room, second}, least_tables());
}

Error refused(Scene& scene, std::vector<GroupEntry> groups) {
    scene.manifest.groups = std::move(groups);
    const auto found = surface_groups(scene, GroupBy::Auto);
    REQUIRE(!found);
    CHECK(found.error().kind == ErrorKind::BadInput);
    return found.error();
}

}  // namespace

TEST_CASE("groups are instances, materials or what the manifest says", "[factors][groups]") {
    Scene scene = room_and_door();
    CHECK(surface_groups(scene, GroupBy::Auto)->names == std::vector<std::string>{"room", "door"});
    CHECK(surface_groups(scene, GroupBy::Material)->names ==
          std::vector<std::string>{"room/default", "door/default", "door/panel"});
    scene.manifest.groups = {{"walls", {"room", "door/panel"}}};
    const auto groups = surface_groups(scene, GroupBy::Auto);
    REQUIRE(groups);
    CHECK(groups->names == std::vector<std::string>{"walls"});
    // The rest of the door blocks and has no row; 24 m^2 of the room and the panel's part of the door.
    const Surfaces surfaces = gather_surfaces(scene, *groups, Sides::Front);
    const Surfaces parts = gather_surfaces(scene, *surface_groups(scene, GroupBy::Material), Sides::Front);
    CHECK(surfaces.area[0] == Approx(24 + parts.area[2]).epsilon(1e-6));
    CHECK(parts.area[1] + parts.area[2] == Approx(0.1).epsilon(1e-6));
    double bodies = 0;
    for (const Body& body : surfaces.bodies) bodies += body.polygon.area;
    CHECK(bodies == Approx(24.1).epsilon(1e-6));
    // The panel is part of the enclosure; with the rest of the door it would close.
    auto factors = view_factors(scene, {});
    REQUIRE(factors);
    CHECK(factors->rows[0][0].value < 1);
    CHECK(factors->rows[0][0].value > 0.98);
}

TEST_CASE("groups that cannot be are refused by name", "[factors][groups]") {
    Scene scene = room_and_door();
    CHECK(surface_groups(scene, GroupBy::Group).error().message.find("groups") != std::string::npos);
    const Error unknown = refused(scene, {{"walls", {"rom"}}});
    CHECK(unknown.message.find("\"rom\"") != std::string::npos);
    CHECK(unknown.hint.find("room") != std::string::npos);
    CHECK(unknown.where.find("/groups/walls/0") != std::string::npos);
    CHECK(refused(scene, {{"walls", {"door/lock"}}}).message.find("default, panel") != std::string::npos);
    CHECK(refused(scene, {{"walls", {}}}).message.find("\"walls\" is empty") != std::string::npos);
    CHECK(refused(scene, {{"a", {"door"}}, {"b", {"door/panel"}}}).message.find("\"a\" already") != std::string::npos);
    CHECK(refused(scene, {{"a", {"door", "door/panel"}}}).where.find("/groups/a/1") != std::string::npos);
}

TEST_CASE("triangles in one plane become one polygon where it is convex", "[factors][surfaces]") {
    const auto polygons = [](const Mesh& mesh) {
        const Scene scene = make_scene({{mesh}}, least_tables());
        const Surfaces surfaces = gather_surfaces(scene, *surface_groups(scene, GroupBy::Auto), Sides::Front);
        double area = 0;
        for (const Polygon& p : surfaces.faces[0]) area += p.area;
        CHECK(area == Approx(surfaces.area[0]).epsilon(1e-6));
        return surfaces.faces[0].size();
    };
    CHECK(polygons(make_box(1, 2, 3, 6)) == 6);
    CHECK(polygons(make_disk(40, 1)) == 1);
    CHECK(polygons(make_tetrahedron(5)) == 4);
    CHECK(polygons(make_sphere(2)) == 320);  // no two in one plane
    CHECK(polygons(make_l_room(4)) <= 6 + 2 * 12);  // walls whole, floor and ceiling in a few convex pieces
}
