// Instances placed by maps that mirror, shear, stretch and all but flatten.
#include "tests/stability/sound.h"

#include "solver/scene/manifest.h"
#include "solver/scene/transform.h"

namespace rro::test {
namespace {

constexpr double kAccuracy = 0.1;

Mat3 diagonal(double x, double y, double z) { return {{Vec3{x, 0, 0}, Vec3{0, y, 0}, Vec3{0, 0, z}}}; }
const Mat3 kTurn = compose({{}, {1, 2, 3}, 40, {1, 1, 1}}).linear;
const Mat3 kSheared{{Vec3{1, 0.8, -0.5}, Vec3{0, 1, 0.6}, Vec3{0, 0, 1}}};

struct Map {
    const char* name;
    Affine3 map;
};

std::vector<Map> maps() {
    return {{"mirrored", {diagonal(-1, 1, 1), {3, 2, 1}}},
            {"turned and mirrored", {kTurn * diagonal(1, -1, 1), {}}},
            {"sheared", {kSheared, {}}},
            {"scales 0.1 x 1 x 10", {diagonal(0.1, 1, 10), {}}},
            {"scales 1e-3 x 1 x 1e3", {diagonal(1e-3, 1, 1e3), {}}},
            {"scales 1e-3 x 1 x 1e3, turned", {kTurn * diagonal(1e-3, 1, 1e3), {}}}};
}

/// A room of a millimetre by a kilometre is all near pairs: millions of links.
constexpr double kMostOfRooms = 1e3;  // condition number

}  // namespace

TEST_CASE("furnaces under maps", "[stability][transforms]") {
    // A closed room stays closed under any map, and so do bodies in it: B = 1 as before.
    const Scene plain = make_scene({furnace(turned_inside_out(make_box(2, 2, 2, 2)), 0.5), furnace(make_box(0.5, 0.7, 0.4, 2), 0.7)},
                                   coarse_tables());
    for (const auto& [name, map] : maps()) {
        if (condition_number(map.linear) > kMostOfRooms) continue;
        Scene scene;
        scene.objects = plain.objects;
        for (std::size_t i = 0; i < 2; ++i)
            add_instance(scene, *scene.objects[i], map, to_double(plain.instances[i].reflectance[0]),
                         to_double(plain.instances[i].exitance[0]));
        const Solution s = solve_soundly("transforms", scene, kAccuracy);
        const FurnaceError e = furnace_error(scene, s, 1);
        INFO(name << ": rms " << e.rms << ", worst " << e.worst << ", links " << s.links.total());
        record("transforms", std::string("a box in a furnace, ") + name, "B = 1; root mean square over R", kAccuracy, e.rms);
        record("transforms", std::string("a box in a furnace, ") + name, "B = 1; worst triangle over R", 3 * kAccuracy, e.worst);
    }
}

TEST_CASE("an archive under a map is the archive of the mapped mesh", "[stability][transforms]") {
    const Mesh seat = translated(make_seat(1), {0, -0.6, 0}), panel = transformed(make_quad(1.5, 1.5, true), translation({0.6, 2, 0.3}));
    const Vec3 grey{0.6, 0.6, 0.6}, light{5, 5, 5};
    for (const auto& [name, map] : maps()) {
        const Scene placed = make_scene({{seat, map, grey, {}}, {panel, map, {}, light}}, coarse_tables());
        const Scene baked = make_scene({{transformed(seat, map), {}, grey, {}}, {transformed(panel, map), {}, {}, light}}, coarse_tables());
        const Solution a = solve_soundly("transforms", placed, kAccuracy), b = solve_soundly("transforms", baked, kAccuracy);
        Solution same;
        for (std::size_t i = 0; i < 2; ++i)
            same.instances.push_back(renumbered(placed.instances[i].data(), a.instances[i], baked.instances[i].data()));
        // Each may be off by one and a half times the accuracy (target A4).
        record("transforms", std::string("a seat and a panel, ") + name, "as the mapped meshes' archives give; error over R",
               3 * kAccuracy, compare(baked, same, b).all.error());
    }
}

TEST_CASE("a glowing body under maps, seen from afar", "[stability][transforms]") {
    // The light of a convex body is that of its projection: E = M S(w) / (pi d^2), and by itself its irradiance sums up to
    // H S(w) where it is lit from there. Far away each errs by (r / d)^2.
    const Mesh ball = make_sphere(2, 0.5);
    for (const Mat3& m : {diagonal(1, 4, 1), kTurn * diagonal(0.3, 1, 2), kSheared, diagonal(-1, 1, 3)})
        for (const Vec3& w : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}, normalised({1, 2, 3})}) {
            const double d = 200;
            const Vec3 u = normalised(cross(w, Vec3{0.3, 0.5, -0.8})), v = cross(u, w);
            const Mesh plate = make_parallelogram(w * d - 0.5 * (u + v), u, v);  // looks at the origin
            double projected = 0;
            for (const TriangleCorners& t : all_corners(transformed(ball, {m, {}}))) projected += std::max(0.0, dot(area_vector(t), w));
            const Vec3 grey{0.5, 0.5, 0.5}, none{}, one{1, 1, 1};
            const Scene glowing = make_scene({{ball, {m, {}}, none, one}, {plate, {}, grey, none}}, coarse_tables());
            const Scene lit = make_scene({{ball, {m, {}}, grey, none}, {plate, {}, none, one}}, coarse_tables());
            const double h = 1 / (std::numbers::pi * d * d);
            // Stretched four times, a ball's light varies fast over a grid of 12 x 12 directions.
            record("transforms", "a glowing ball under maps, 200 m away", "E = M S(w) / (pi d^2)", 0.1,
                   std::abs(irradiance(glowing, solve_soundly("transforms", glowing, 0.3), 1).mean / (projected * h) - 1));
            const Solution s = solve_soundly("transforms", lit, 0.3);
            double received = 0;
            for (std::size_t f = 0; f < s.instances[0].irradiance.size(); ++f)
                received += double(s.instances[0].irradiance[f].x) * face_area(lit.instances[0], f);
            record("transforms", "a ball under maps, lit from 200 m away", "it receives H S(w)", 0.1, std::abs(received / (projected * h) - 1));
        }
}

TEST_CASE("almost singular maps are refused with the number", "[stability][transforms]") {
    Worst accepted, refused, named;
    for (const double ratio : {1.0, 1e3, 1e6, 0.99e9}) accepted.add(transform_fault({kTurn * diagonal(ratio, 1, 1), {}}).empty() ? 0 : 1);
    for (const double ratio : {1.01e9, 1e10, 3e12}) {
        const std::string fault = transform_fault({kTurn * diagonal(1, 1, ratio) * kTurn, {}});
        refused.add(fault.empty() ? 1 : 0);
        const auto at = fault.find("condition number ");
        named.add(at == std::string::npos ? 1 : std::abs(std::stod(fault.substr(at + 17)) / ratio - 1));
    }
    for (const Mat3& m : {diagonal(0, 1, 1), Mat3{{Vec3{1, 2, 3}, Vec3{2, 4, 6}, Vec3{0, 0, 1}}}, diagonal(1e-200, 1e-200, 1e-200)})
        refused.add(transform_fault({m, {}}).empty() ? 1 : 0);
    const auto manifest = parse_manifest(R"({"format": "rro-scene/1", "instances": [{"name": "flat", "archive": "a.rro",
        "transform": {"scale": [1, 1, 1e-10]}}]})", "room.json");
    REQUIRE(!manifest);
    CHECK_THAT(manifest.error().where + manifest.error().message, Catch::Contains("1e+10") && Catch::Contains("/instances/0"));
    record("transforms", "condition numbers below 1e9", "accepted", 0, accepted.value());
    record("transforms", "condition numbers above 1e9, singular maps", "refused", 0, refused.value());
    // The smallest singular value is known to 1e-16 times the condition number, and three digits are shown.
    record("transforms", "condition numbers above 1e9", "the message names the number; relative", 6e-3, named.value());
}

}  // namespace rro::test
