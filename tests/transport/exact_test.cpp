// Scenes whose solution is known without solving: factors in closed form, furnaces, and squares by the method of Nystrom.
//
// The accuracy asked bounds the area-weighted root mean square of the error of R. So where only one surface reflects, the
// mean of its irradiance is off by no more than the accuracy times the irradiance's own root mean square (Cauchy-Schwarz).
#include <catch2/catch.hpp>

#include "format/form_factor.h"
#include "tests/support/nystrom.h"
#include "tests/support/shapes.h"
#include "tests/support/solutions.h"

namespace rro::test {
namespace {

const Vec3 kX{1, 0, 0}, kY{0, 1, 0}, kZ{0, 0, 1}, kNone{}, kOne{1, 1, 1}, kHalf{0.5, 0.5, 0.5};
/// Gives light, reflects none.
Placed emitter(Mesh mesh) { return {std::move(mesh), {}, kNone, kOne, "emitter"}; }
/// Reflects half of what it receives, so that its irradiance is what the solver is asked for.
Placed receiver(Mesh mesh) { return {std::move(mesh), {}, kHalf, kNone, "receiver"}; }
/// Neither.
Placed blocker(Mesh mesh) { return {std::move(mesh), {}, kNone, kNone, "blocker"}; }

/// corner + [0, 1] u + [0, 1] v, front along u x v.
Mesh square(const Vec3& corner, const Vec3& u, const Vec3& v, int divisions = 1) {
    Mesh mesh = empty_mesh(false);
    add_parallelogram(mesh, corner, u, v, divisions);
    return mesh;
}

std::string facts(const Solution& s) {
    return "asked " + std::to_string(s.accuracy) + ", estimate " + std::to_string(s.estimated_error) + ", links " +
           std::to_string(s.links.total()) + ", rays " + std::to_string(s.rays);
}

/// The mean irradiance of instance 0 is the factor, as well as the accuracy promises.
void check_factor(const std::string& what, const std::vector<Placed>& placed, double factor, double accuracy,
                  const std::vector<std::string>& without = {}, double mesh_error = 0) {
    const Scene scene = make_scene(placed);
    const Solution s = solve_reusably(scene, accuracy, without);
    const Spread e = irradiance(scene, s, 0);
    INFO(what << ": expected " << factor << ", got " << e.mean << ", off by " << (e.mean - factor) / factor << "; "
              << facts(s));
    CHECK(std::abs(e.mean - factor) <= accuracy * e.rms + mesh_error * factor);
    CHECK(s.converged);
}

}  // namespace

TEST_CASE("irradiance under an emitting square: planar factors in closed form", "[transport][exact]") {
    const Mesh floor = square({0, 0, 0}, kZ, kX);
    const auto ceiling = [](double x, double z) { return emitter(square({x, 1, z}, kX, kZ)); };
    const auto wedge = [&](double degrees) {
        const double a = degrees * std::numbers::pi / 180;
        return emitter(square({0, 0, 0}, {std::cos(a), std::sin(a), 0}, kZ));
    };
    constexpr double kAccuracy = 0.03;
    check_factor("facing, distance 1 (C-11)", {receiver(floor), ceiling(0, 0)}, 0.199824895698387, kAccuracy);
    check_factor("shifted by (1, 0)", {receiver(floor), ceiling(1, 0)}, 0.0860504891523273, kAccuracy);
    check_factor("shifted by (1, 1)", {receiver(floor), ceiling(1, 1)}, 0.0433274095741047, kAccuracy);
    check_factor("common edge, 90 degrees (C-14)", {receiver(floor), wedge(90)}, 0.200043776075403, kAccuracy);
    check_factor("common edge, 45 degrees (C-16)", {receiver(floor), wedge(45)}, 0.483347695478878, kAccuracy);
    check_factor("common edge, 60 degrees (C-16)", {receiver(floor), wedge(60)}, 0.370905321150051, kAccuracy);
    check_factor("common edge, 120 degrees (C-16)", {receiver(floor), wedge(120)}, 0.0866150011182761, kAccuracy);
}

TEST_CASE("a square of side 1/2 midway takes half of the light between facing squares", "[transport][exact]") {
    const double left = 0.0995062945989848;  // open factor less a quarter of that from the small to a square of side 3/2
    const Mesh floor = square({0, 0, 0}, kZ, kX);
    const Placed light = emitter(square({0, 1, 0}, kX, kZ));
    check_factor("front up", {receiver(floor), light, blocker(square({0.25, 0.5, 0.25}, 0.5 * kZ, 0.5 * kX))}, left, 0.05);
    check_factor("front down", {receiver(floor), light, blocker(square({0.25, 0.5, 0.25}, 0.5 * kX, 0.5 * kZ))}, left,
                 0.05);
}

TEST_CASE("inside the unit cube: opposite and adjacent walls", "[transport][exact]") {
    // One wall gives, one receives, four are black.
    const Vec3 o{}, c{1, 1, 1};
    const std::vector<Mesh> walls{square(o, kZ, kX),  square(o, kX, kY),  square(o, kY, kZ),
                                  square(c, -kX, -kZ), square(c, -kY, -kX), square(c, -kZ, -kY)};
    for (const std::size_t giving : {1u, 3u, 5u}) {
        std::vector<Placed> placed{receiver(walls[0])};
        for (std::size_t k = 1; k < walls.size(); ++k) placed.push_back(k == giving ? emitter(walls[k]) : blocker(walls[k]));
        for (std::size_t k = 1; k < walls.size(); ++k) placed[k].name = "wall " + std::to_string(k);
        check_factor("wall " + std::to_string(giving), placed, giving == 3 ? 0.199824895698387 : 0.200043776075403, 0.03);
    }
}

TEST_CASE("coaxial disks at distance 1, as polygons of the same area", "[transport][exact]") {
    // What is left of the polygon's own error at n = 24 is below 1e-3 of the factor.
    constexpr int n = 24;
    const auto disk = [&](double radius) { return make_disk(n, same_area_radius(n, radius)); };
    const auto facing_down = [&](double radius) { return transformed(disk(radius), {kUpsideDown, {0, 1, 0}}); };
    check_factor("radii 1 and 1 (C-41)", {receiver(disk(1)), emitter(facing_down(1))}, 0.381966011250105, 0.01, {}, 1e-3);
    check_factor("from radius 2 to radius 1", {receiver(disk(1)), emitter(facing_down(2))}, 0.763932022500210, 0.01, {},
                 1e-3);
    check_factor("from radius 1 to radius 2", {receiver(disk(2)), emitter(facing_down(1))}, 0.763932022500210 / 4, 0.01, {},
                 1e-3);
}

TEST_CASE("inscribed polygons approach the disk's factor as 1 / n^2", "[transport][exact]") {
    const auto deficit = [](int n) {
        const Scene scene =
            make_scene({receiver(make_disk(n, 1)), emitter(transformed(make_disk(n, 1), {kUpsideDown, {0, 1, 0}}))});
        return (3 - std::sqrt(5.0)) / 2 - irradiance(scene, solve_reusably(scene, 0.002), 0).mean;
    };
    const double six = deficit(6), twelve = deficit(12);
    INFO("deficits " << six << " and " << twelve);
    // A quarter but for the next order, 1 / n^4 with a coefficient like the first one's, and the accuracy asked: together
    // a tenth of the smaller deficit.
    CHECK(six / twelve == Approx(4.0).epsilon(0.15));
}

TEST_CASE("inside a cylinder with ends, radius 1, height 2", "[transport][exact]") {
    // Direct light alone: the side sees itself. 24-gons of the same area; the side's area is 0.3 % too large then.
    constexpr int n = 24;
    const double r = same_area_radius(n, 1);
    const Mesh side = turned_inside_out(make_tube(n, r, 0, 2, 2)), bottom = make_disk(n, r),
               top = transformed(make_disk(n, r), {kUpsideDown, {0, 2, 0}});
    const Placed dark_side = blocker(side), dark_bottom = blocker(bottom);
    constexpr double kMesh = 0.006;
    Placed glowing = receiver(side);
    glowing.exitance = kOne;
    check_factor("end to end", {receiver(bottom), emitter(top), dark_side}, 0.171572875253810, 0.1, {}, kMesh);
    check_factor("side to end", {receiver(bottom), emitter(side)}, 0.828427124746190, 0.1, {}, kMesh);
    check_factor("end to side", {receiver(side), emitter(top), dark_bottom}, 0.207106781186548, 0.04, {"interreflection"},
                 kMesh);
    check_factor("side to side", {glowing, dark_bottom}, 0.585786437626905, 0.1, {"interreflection"}, kMesh);
}

TEST_CASE("inside a tetrahedron and a cone", "[transport][exact]") {
    const std::vector<Vec3> c = tetrahedron_corners();
    const Placed inside[4] = {receiver(make_triangle(c[0], c[2], c[1])), emitter(make_triangle(c[0], c[1], c[3])),
                              blocker(make_triangle(c[0], c[3], c[2])), blocker(make_triangle(c[1], c[2], c[3]))};
    for (std::size_t k = 1; k < 4; ++k) {
        std::vector<Placed> placed{inside[0]};
        for (std::size_t j = 1; j < 4; ++j) {
            placed.push_back(inside[j]);
            placed.back().exitance = j == k ? kOne : kNone;
            placed.back().name = "face " + std::to_string(j);
        }
        check_factor("face " + std::to_string(k), placed, 1.0 / 3, 0.1);
    }
    // The side sees the base by A_base / A_side, for a mesh by its own areas.
    const Mesh side = turned_inside_out(make_cone_side(12, 1, 2)), base = make_disk(12, 1);
    const double in_radius = std::cos(std::numbers::pi / 12);
    check_factor("cone", {receiver(side), emitter(base)}, in_radius / std::hypot(in_radius, 2.0), 0.1, {"interreflection"});
}

TEST_CASE("a convex body in a closed shell", "[transport][exact]") {
    // By areas of the meshes, whatever their shapes and places; direct light alone, as the shell sees itself.
    const Mesh body = make_sphere(1, 0.5, {0.1, 0.05, -0.1}), shell = turned_inside_out(make_box(2, 2, 2, 2));
    double area = 0;
    for (const TriangleCorners& t : all_corners(body)) area += length(area_vector(t));
    const double share = area / 24;
    Placed glowing = receiver(shell);
    glowing.exitance = kOne;
    const std::vector<std::string> direct{"interreflection"};
    check_factor("body to shell: all of it", {receiver(body), emitter(shell)}, 1, 0.02, direct);
    check_factor("shell to body", {receiver(shell), emitter(body)}, share, 0.02, direct);
    check_factor("shell to itself past the body", {glowing, blocker(body)}, 1 - share, 0.02, direct);
}

TEST_CASE("a sphere sees a unit disk at distance 1 alike at any radius", "[transport][exact]") {
    const Mesh disk = transformed(make_disk(24, same_area_radius(24, 1)), {kUpsideDown, {0, 1, 0}});
    for (const double radius : {0.3, 0.6}) {
        const Mesh sphere = make_sphere(2, radius);
        // The mesh's own factor, triangle by triangle: nothing stands between them.
        double exchange = 0, area = 0;
        for (const TriangleCorners& s : all_corners(sphere)) {
            area += length(area_vector(s));
            for (const TriangleCorners& d : all_corners(disk)) exchange += exchange_area(s, d, 1e-5);
        }
        CHECK(exchange / area == Approx((1 - 1 / std::sqrt(2.0)) / 2).epsilon(0.01));
        check_factor("radius " + std::to_string(radius), {receiver(sphere), emitter(disk)}, exchange / area, 0.03);
    }
}

// ---- furnaces --------------------------------------------------------------------------------------------------------

namespace {

/// With M = B0 (1 - rho) on every surface B is B0 everywhere. RMS of R within the accuracy asked, every triangle within
/// three times that (of its own R), where there is an R.
void check_furnace(const std::string& what, const std::vector<Placed>& placed, double b0, double accuracy) {
    const Scene scene = make_scene(placed);
    const Solution s = solve_reusably(scene, accuracy);
    double off = 0, norm = 0, worst = 0;
    for (std::size_t i = 0; i < placed.size(); ++i) {
        const double r = b0 * placed[i].reflectance.x;
        for (std::size_t f = 0; f < s.instances[i].radiosity.size(); ++f) {
            const double area = face_area(scene.instances[i], f);
            const double difference = double(s.instances[i].radiosity[f].x) - b0;
            off += area * difference * difference;
            norm += area * r * r;
            if (r > 0) worst = std::max(worst, std::abs(difference) / r);
            else CHECK(std::abs(difference) <= 1e-6 * b0);
        }
    }
    const double error = norm > 0 ? std::sqrt(off / norm) : 0;
    INFO(what << ": error " << error << ", worst triangle " << worst << "; " << facts(s));
    CHECK(error <= accuracy);
    CHECK(worst <= 3 * accuracy);
    CHECK(s.converged);
}

void check_white(const std::string& what, const Mesh& inside, double accuracy) {
    for (const double rho : {0.0, 0.5, 0.9, 0.99}) {
        const Placed shell{inside, {}, kOne * rho, kOne, "shell"};
        check_furnace(what + ", rho " + std::to_string(rho), {shell}, 1 / (1 - rho), accuracy);
    }
}

/// Surfaces of these reflectances and exitances 1 - rho.
Placed furnace(Mesh mesh, double rho, const std::string& name) {
    return {std::move(mesh), {}, kOne * rho, kOne * (1 - rho), name};
}

}  // namespace

TEST_CASE("white furnace: a cube", "[transport][furnace]") {
    check_white("cube", turned_inside_out(make_box(1, 1, 1, 2)), 0.02);
}
TEST_CASE("white furnace: a tetrahedron", "[transport][furnace]") {
    check_white("tetrahedron", turned_inside_out(make_tetrahedron(3)), 0.02);
}
TEST_CASE("white furnace: a sphere", "[transport][furnace]") {
    check_white("sphere", turned_inside_out(make_sphere(2)), 0.02);
}
TEST_CASE("white furnace: an L-shaped room", "[transport][furnace]") { check_white("L", make_l_room(2), 0.05); }
TEST_CASE("white furnace: a torus", "[transport][furnace]") {
    check_white("torus", turned_inside_out(make_torus(16, 8, 1, 0.4)), 0.05);
}

TEST_CASE("generalised furnace: M = 1 - rho gives B = 1 with any shadows", "[transport][furnace]") {
    const Mesh room = turned_inside_out(make_box(2, 2, 2, 3));
    check_furnace("a box in a box", {furnace(room, 0.5, "room"), furnace(make_box(0.6, 0.8, 0.5, 2), 0.8, "box")}, 1, 0.05);
    check_furnace("a white room around a dark box",
                  {furnace(room, 0.95, "room"), furnace(make_box(0.6, 0.8, 0.5, 2), 0.1, "box")}, 1, 0.05);
    check_furnace("two bodies that hide one another",
                  {furnace(room, 0.7, "room"), furnace(make_box(0.6, 0.8, 0.5, 2, {-0.5, -0.4, 0}), 0.3, "box"),
                   furnace(make_sphere(2, 0.3, {0.35, 0, 0.1}), 0.9, "ball")},
                  1, 0.05);
}

TEST_CASE("generalised furnace: a seat 5 mm below its back", "[transport][furnace]") {
    const Mesh room = turned_inside_out(make_box(2, 2, 2, 3)), seat = translated(make_seat(2), {0, -0.6, 0});
    check_furnace("a seat 5 mm below its back", {furnace(room, 0.7, "room"), furnace(seat, 0.6, "seat")}, 1, 0.05);
}

// ---- squares whose continuous solution is computed by other means ------------------------------------------------------

namespace {

std::vector<UnitSquare> grey_cube() {
    const Vec3 o{}, c{1, 1, 1};
    return {{o, kZ, kX, 0.5, 0},   {c, -kX, -kZ, 0.5, 1}, {o, kX, kY, 0.5, 0},
            {o, kY, kZ, 0.5, 0}, {c, -kY, -kX, 0.5, 0}, {c, -kZ, -kY, 0.5, 0}};
}

constexpr std::size_t kCells = 4;  // along a side

/// The error of solver/accuracy.md over cells of two triangles each, against the continuous truth: at most 1.5 times the accuracy asked,
/// for a single square three times.
void check_squares(const std::string& what, const std::vector<UnitSquare>& squares, const ContinuousTruth& truth,
                   double accuracy) {
    std::vector<Placed> placed;
    for (const UnitSquare& s : squares)
        placed.push_back({square(s.corner, s.u, s.v, int(kCells)), {}, kOne * s.reflectance, kOne * s.exitance});
    const Scene scene = make_scene(placed);
    const Solution s = solve_reusably(scene, accuracy);
    double difference = 0, norm = 0;
    for (std::size_t i = 0; i < squares.size(); ++i) {
        // Source triangles 2k and 2k + 1 make cell k.
        std::vector<double> cells(kCells * kCells, 0);
        const ObjectData& data = scene.instances[i].data();
        for (std::size_t f = 0; f < data.faces.size(); ++f)
            cells[data.source_triangle[data.faces[f].triangle()] / 2] += 0.5 * double(s.instances[i].radiosity[f].x);
        double own_difference = 0, own_norm = 0;
        for (std::size_t k = 0; k < cells.size(); ++k) {
            const double b = truth.cells[i * cells.size() + k];
            own_difference += (cells[k] - b) * (cells[k] - b);
            own_norm += (b - squares[i].exitance) * (b - squares[i].exitance);
        }
        INFO(what << ", square " << i << ": mean B " << radiosity(scene, s, i).mean << ", truth " << truth.mean(i, kCells));
        CHECK(std::sqrt(own_difference / own_norm) <= 3 * accuracy);
        difference += own_difference;
        norm += own_norm;
    }
    INFO(what << ": error " << std::sqrt(difference / norm) << "; " << facts(s));
    CHECK(std::sqrt(difference / norm) <= 1.5 * accuracy);
}

}  // namespace

TEST_CASE("facing grey squares: the continuous solution", "[transport][exact]") {
    const double f = 0.199824895698387;
    // One constant each, in closed form: B1 = 1 + 0.5 F B2, B2 = 0.8 F B1.
    const double b1 = 1 / (1 - 0.4 * f * f), b2 = 0.8 * f * b1;
    CHECK(b1 == Approx(1.01623124088395).epsilon(1e-12));
    CHECK(b2 == Approx(0.162454641372062).epsilon(1e-12));
    const std::vector<UnitSquare> squares{{{}, kZ, kX, 0.5, 1}, {{0, 1, 0}, kX, kZ, 0.8, 0}};
    const ContinuousTruth truth = continuous_radiosity(squares, kCells);
    CHECK(truth.error < 1e-5);
    // The light of the second square gathers in its middle, which the middle of the first one sees best, so each gets
    // a little more back than from constants: 1.3 % of R of the first.
    INFO("continuous " << truth.mean(0, kCells) << " and " << truth.mean(1, kCells));
    CHECK((truth.mean(0, kCells) - 1) / (b1 - 1) == Approx(1.0133).margin(0.001));
    CHECK(truth.mean(1, kCells) / b2 == Approx(1.0004).margin(0.0002));
    for (const double accuracy : {0.05, 0.01}) check_squares("facing squares", squares, truth, accuracy);
}

TEST_CASE("a grey cube under a glowing ceiling: the continuous solution", "[transport][exact]") {
    // One constant per wall, from the three equations of floor, sides and ceiling with M = 1, rho = 0.5 and the factors of
    // opposite and adjacent walls.
    const double o = 0.199824895698387, a = 0.200043776075403;
    double floor = 0, side = 0, ceiling = 1;
    for (int k = 0; k < 100; ++k) {
        const double f = 0.5 * (o * ceiling + 4 * a * side), s = 0.5 * (a * (floor + ceiling) + (2 * a + o) * side);
        ceiling = 1 + 0.5 * (o * floor + 4 * a * side);
        floor = f;
        side = s;
    }
    CHECK(floor == Approx(0.181745826107788).epsilon(1e-12));
    CHECK(side == Approx(0.181836268946129).epsilon(1e-12));
    CHECK(ceiling == Approx(1.09090909810770).epsilon(1e-12));
    const ContinuousTruth truth = continuous_radiosity(grey_cube(), kCells);
    CHECK(truth.error < 5e-4);
    INFO("continuous: floor " << truth.mean(0, kCells) << ", sides " << truth.mean(2, kCells) << ", ceiling "
                              << truth.mean(1, kCells) << ", to " << truth.error);
    // The upper parts of the sides take most of the ceiling's light, and give it back there rather than to the floor: with
    // constants the floor gets 6 % too much, and the ceiling 13 % too little.
    CHECK(floor / truth.mean(0, kCells) == Approx(1.061).margin(0.002));
    CHECK((ceiling - 1) / (truth.mean(1, kCells) - 1) == Approx(0.871).margin(0.002));
    for (const double accuracy : {0.05, 0.02}) check_squares("grey cube", grey_cube(), truth, accuracy);
}

// ---- laws of scale, energy and colour ---------------------------------------------------------------------------------

namespace {

/// A lamp above a ball, a box and a seat in a grey room.
std::vector<Placed> small_room(const Vec3& reflectance, const Vec3& exitance) {
    return {{turned_inside_out(make_box(3, 2, 3, 2)), {}, reflectance, {}, "room"},
            {make_quad(0.6, 0.6), {kUpsideDown, {0, 0.95, 0}}, reflectance, exitance, "lamp"},
            {make_sphere(1, 0.3, {0.7, -0.6, 0.2}), {}, reflectance, {}, "ball"},
            {make_box(0.5, 0.7, 0.5, 2, {-0.6, -0.6, -0.3}), {}, reflectance, {}, "box"},
            {make_seat(2), translation({0, -0.95, 0.7}), reflectance, {}, "seat"}};
}

}  // namespace

TEST_CASE("light times any factor is the same solution times that factor", "[transport][laws]") {
    // Powers of two scale floating-point numbers exactly, and nothing in the solver may compare light with a constant.
    const auto solve_at = [](double factor) {
        const Scene scene = make_scene(small_room(kHalf, Vec3{4, 3, 2} * factor));
        return solve_reusably(scene, 0.1);
    };
    const Solution one = solve_at(1);
    for (const double factor : {0x1p-20, 0x1p20}) {
        const Solution other = solve_at(factor);
        CHECK(other.links.total() == one.links.total());
        CHECK(other.estimated_error == Approx(one.estimated_error).epsilon(1e-5));
        double worst = 0;
        for (std::size_t i = 0; i < one.instances.size(); ++i)
            for (std::size_t f = 0; f < one.instances[i].radiosity.size(); ++f) {
                const double b = double(one.instances[i].radiosity[f].y);
                worst = std::max(worst, std::abs(double(other.instances[i].radiosity[f].y) / factor - b) / b);
            }
        CHECK(worst <= 1e-5);
    }
}

TEST_CASE("surfaces that reflect next to nothing cost no more than grey ones", "[transport][laws]") {
    // One bounce alone, the easier problem: R = rho E from direct light.
    const Solution grey = solve_reusably(make_scene(small_room(kHalf, kOne)), 0.1);
    for (const double rho : {1e-3, 1e-6}) {
        const Solution dark = solve_reusably(make_scene(small_room(kOne * rho, kOne)), 0.1);
        INFO("rho " << rho << ": links " << dark.links.total() << " against " << grey.links.total() << ", rays "
                    << dark.rays << " against " << grey.rays);
        CHECK(dark.links.total() <= 2 * grey.links.total());
        CHECK(dark.rays <= 2 * grey.rays);
        CHECK(dark.converged);
    }
}

TEST_CASE("glowing surfaces that reflect next to nothing cost no more than grey ones", "[transport][laws]") {
    // R is below the rounding of B then, so that it cannot be had as B - M in single precision.
    const auto glowing = [](double rho) {
        return make_scene({{make_quad(2, 2, false, 2), {}, kOne * rho, kOne, "floor"},
                           {make_seat(2), translation({0, -0.3, 0}), kOne * rho, kOne, "seat"}});
    };
    const Scene grey_scene = glowing(0.5);
    const Solution grey = solve_reusably(grey_scene, 0.1);
    for (const double rho : {1e-3, 1e-6, 1e-8}) {
        const Scene dark_scene = glowing(rho);
        const Solution dark = solve_reusably(dark_scene, 0.1);
        INFO("rho " << rho << ": links " << dark.links.total() << " against " << grey.links.total() << ", rays "
                    << dark.rays << " against " << grey.rays);
        CHECK(dark.links.total() <= 2 * grey.links.total());
        CHECK(dark.rays <= 2 * grey.rays);
        CHECK(dark.converged);
    }
}

TEST_CASE("a closed scene absorbs what is emitted", "[transport][laws]") {
    for (const double accuracy : {0.1, 0.05}) {
        const Scene scene = make_scene(small_room({0.7, 0.5, 0.3}, {4, 3, 2}));
        const Solution s = solve_reusably(scene, accuracy);
        for (int c = 0; c < 3; ++c) {
            // absorbed = sum A (1 - rho) / rho R: off by at most sqrt(sum A ((1 - rho) / rho)^2) accuracy sqrt(sum A R^2).
            const double rho = Vec3{0.7, 0.5, 0.3}[c];
            double area = 0, squares = 0;
            for (std::size_t i = 0; i < scene.instances.size(); ++i)
                for (std::size_t f = 0; f < s.instances[i].radiosity.size(); ++f) {
                    const double a = face_area(scene.instances[i], f);
                    area += a;
                    squares += a * length2(reflected(scene.instances[i], s.instances[i], f));
                }
            INFO("asked " << accuracy << ", channel " << c << ": emitted " << s.energy.emitted[c] << ", absorbed "
                          << s.energy.absorbed[c] << "; " << facts(s));
            CHECK(std::abs(s.energy.escaped[c]) <= (1 - rho) / rho * std::sqrt(area * squares) * accuracy);
            CHECK(s.energy.escaped[c] == Approx(s.energy.emitted[c] - s.energy.absorbed[c]).margin(1e-9));
        }
    }
}

TEST_CASE("channels do not mix", "[transport][laws]") {
    const Vec3 reflectance{0.7, 0.5, 0.3};
    const Scene scene = make_scene(small_room(reflectance, {4, 3, 2}));
    const Solution all = solve_reusably(scene, 0.1);
    SECTION("red light alone leaves green and blue dark") {
        const Solution red = solve_reusably(make_scene(small_room(reflectance, {4, 0, 0})), 0.1);
        for (const InstanceSolution& s : red.instances)
            for (const Rgb& b : s.radiosity) {
                CHECK(b.y == 0);
                CHECK(b.z == 0);
                CHECK(b.x > 0);
            }
    }
    SECTION("channels in another order give their results in that order") {
        const Solution turned = solve_reusably(make_scene(small_room({0.3, 0.7, 0.5}, {2, 4, 3})), 0.1);
        double worst = 0;
        for (std::size_t i = 0; i < all.instances.size(); ++i)
            for (std::size_t f = 0; f < all.instances[i].radiosity.size(); ++f) {
                const Rgb a = all.instances[i].radiosity[f], b = turned.instances[i].radiosity[f];
                worst = std::max({worst, std::abs(double(b.y / a.x) - 1), std::abs(double(b.z / a.y) - 1),
                                  std::abs(double(b.x / a.z) - 1)});
            }
        // Sums over channels round differently, and that may turn the decision about a link or two.
        CHECK(worst <= 0.01);
    }
}

TEST_CASE("a grey scene has the same bits in one channel and in three", "[transport][laws]") {
    // Where channels are alike their mean is their very value: what rounds, and what is decided by it, is the same.
    const auto solve_in = [](const Scene& scene, std::size_t channels, double accuracy) {
        auto plan = plan_effects(scene, {channels == 3 ? std::vector<std::string>{"colour"} : std::vector<std::string>{}, {}});
        REQUIRE((plan && plan->channels == static_cast<int>(channels)));
        TransportOptions options;
        options.accuracy = accuracy;
        auto solution = solve_reusable(scene, *plan, options);
        REQUIRE(solution);
        return std::move(*solution);
    };
    const auto all = [](double value) { return Vec3{value, value, value}; };
    for (const double rho : {0.6, 0.37}) {
        Scene scene = make_scene(small_room(all(rho), all(50)));
        PointLight lamp;
        lamp.position = {0.3, 0.2, 0.1};
        lamp.intensity = all(0.7);
        if (rho < 0.5) scene.lights = {lamp};
        for (const double accuracy : {0.1, 0.05}) {
            const Solution one = solve_in(scene, 1, accuracy), three = solve_in(scene, 3, accuracy);
            INFO("rho " << rho << ", asked " << accuracy);
            CHECK(one.links.total() == three.links.total());
            CHECK(one.rays == three.rays);
            CHECK(one.estimated_error == three.estimated_error);
            std::size_t differ = 0;
            for (std::size_t i = 0; i < one.instances.size(); ++i)
                for (std::size_t f = 0; f < one.instances[i].radiosity.size(); ++f)
                    if (one.instances[i].radiosity[f] != three.instances[i].radiosity[f] ||
                        one.instances[i].irradiance[f] != three.instances[i].irradiance[f])
                        ++differ;
            CHECK(differ == 0);
        }
    }
}

}  // namespace rro::test
