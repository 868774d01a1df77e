// Meshes as they come: slivers, overlaps, gaps, contacts, flipped faces, very flat and very long ones.
//
// Most stand in a furnace: in a closed room where every surface emits 1 - rho the radiosity is 1 wherever light gets to,
// whatever hides whatever. Faces that another surface covers may be anything between their exitance and 1.
#include "tests/stability/sound.h"
#include "tests/stability/wide.h"

#include <functional>
#include <random>

#include "compiler/mesh_import.h"
#include "format/direction_grid.h"
#include "tests/support/temporary_folder.h"

namespace rro::test {
namespace {

constexpr double kAccuracy = 0.1;

/// Centres of faces decide which ones are exposed.
using Exposed = std::function<bool(std::size_t instance, const Vec3& centre)>;

Placed room() { return furnace(turned_inside_out(make_box(2, 2, 2, 2)), 0.5); }

/// Objects, then their room. A5: root mean square within the accuracy, every triangle within three times that.
void check_in_furnace(const std::string& what, std::vector<Placed> placed, const Exposed& exposed = {}) {
    placed.push_back(room());
    const Scene scene = make_scene(placed, coarse_tables());
    const Solution s = solve_soundly("geometry", scene, kAccuracy);
    const FurnaceError e = furnace_error(scene, s, 1, [&](std::size_t i, std::size_t f) {
        const TriangleCorners c = scene.instances[i].world_corners(scene.instances[i].data().faces[f]);
        return !exposed || exposed(i, (c[0] + c[1] + c[2]) / 3);
    });
    INFO(what << ": links " << s.links.total() << ", rays " << s.rays << ", estimate " << s.estimated_error);
    record("geometry", what + ", in a furnace", "B = 1; root mean square over R", kAccuracy, e.rms);
    record("geometry", what + ", in a furnace", "B = 1; worst triangle over R", 3 * kAccuracy, e.worst);
}

Mesh all_two_sided(Mesh mesh) {
    std::fill(mesh.two_sided.begin(), mesh.two_sided.end(), std::uint8_t{1});
    mesh.closed = false;
    return mesh;
}

/// A box whose six sides are divided each its own way: corners of one lie on edges of another.
Mesh box_with_t_junctions(double edge) {
    Mesh mesh = empty_mesh(false);
    const Vec3 lo = Vec3{1, 1, 1} * (-edge / 2), hi = -lo, x{edge, 0, 0}, y{0, edge, 0}, z{0, 0, edge};
    add_parallelogram(mesh, lo, z, y, 1);
    add_parallelogram(mesh, lo, x, z, 2);
    add_parallelogram(mesh, lo, y, x, 3);
    add_parallelogram(mesh, hi, -y, -z, 4);
    add_parallelogram(mesh, hi, -z, -x, 3);
    add_parallelogram(mesh, hi, -x, -y, 5);
    return mesh;
}

double mean_irradiance(const Scene& scene, const Solution& s, std::size_t i) { return irradiance(scene, s, i).mean; }

}  // namespace

TEST_CASE("slivers of an aspect of 1e6", "[stability][geometry]") {
    Mesh striped = empty_mesh(false);
    for (const auto& [from, to] : {std::pair{-0.5, 0.0}, {0.0, 1e-6}, {1e-6, 2e-6}, {2e-6, 0.5}})
        add_parallelogram(striped, {from, 0.2, -0.5}, {to - from, 0, 0}, {0, 0, 1}, 1, true);
    check_in_furnace("a sheet with strips 1e-6 wide", {furnace(striped, 0.7)});
    check_in_furnace("a blade 1 by 1e-6", {furnace(make_parallelogram({-0.5, 0, 0}, {1, 0, 0}, {0, 1e-6, 0}, 1, true), 0.7)});
}

TEST_CASE("faces of no area, and faces twice", "[stability][geometry]") {
    TemporaryFolder folder;
    const std::string corners = "v -0.3 -0.3 -0.3\nv 0.3 -0.3 -0.3\nv 0.3 0.3 -0.3\nv -0.3 0.3 -0.3\n"
                                "v -0.3 -0.3 0.3\nv 0.3 -0.3 0.3\nv 0.3 0.3 0.3\nv -0.3 0.3 0.3\nv 0 0 -0.3\n";
    const std::string faces = "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    const auto imported = [&](const std::string& more) {
        std::ofstream(folder / "box.obj") << corners << faces << more;
        auto mesh = import_mesh(folder / "box.obj", {});
        REQUIRE(mesh);
        decide_sides(mesh->mesh, TwoSided::Auto, false, mesh->report);
        return mesh->mesh;
    };
    // Corners in a row, the same corner twice.
    check_in_furnace("a box with faces of no area", {furnace(imported("f 1 9 3\nf 1 1 2\nf 7 7 7\n"), 0.7)});
    // Two sides once more as they are, one turned; and a hole, so that all are two-sided: neither of two would hide the other.
    check_in_furnace("a box with two sides twice", {furnace(imported("f 4 3 2 1\nf 5 6 7 8\n"), 0.7)});
    check_in_furnace("a box with two sides twice, one turned", {furnace(imported("f 4 3 2 1\nf 5 8 7 6\n"), 0.7)});
}

TEST_CASE("T-junctions", "[stability][geometry]") {
    check_in_furnace("a box with T-junctions", {furnace(box_with_t_junctions(0.7), 0.7)});
    const Scene scene = make_scene({furnace(turned_inside_out(box_with_t_junctions(1)), 0.9)}, coarse_tables());
    const Solution s = solve_soundly("geometry", scene, kAccuracy);
    const FurnaceError e = furnace_error(scene, s, 1);
    record("geometry", "a room with T-junctions, a furnace", "B = 1; root mean square over R", kAccuracy, e.rms);
    record("geometry", "a room with T-junctions, a furnace", "B = 1; worst triangle over R", 3 * kAccuracy, e.worst);
    // In corners elements feed one another: rows beyond 1 / rho there would grow with every bounce.
    Worst element;
    REQUIRE(!s.instances[0].elements.empty());
    for (const Element& part : s.instances[0].elements) element.add((double(part.radiosity.x) - 1) / 0.9);
    record("geometry", "a room with T-junctions, a furnace", "B = 1; excess of the brightest element over R", 3 * kAccuracy, element.value());
}

TEST_CASE("objects in one another", "[stability][geometry]") {
    // Halves inside the other body are in the dark.
    const Vec3 centre{0.25, 0.25, 0.25};
    check_in_furnace("a ball halfway in a box",
                     {furnace(make_box(0.5, 0.5, 0.5, 2), 0.7), furnace(make_sphere(1, 0.2, centre), 0.6)},
                     [&](std::size_t i, const Vec3& c) {
                         if (i == 0) return length(c - centre) > 0.35;
                         return i == 2 || max_component(c) > 0.33;
                     });
}

TEST_CASE("objects exactly on the floor, and in its plane", "[stability][geometry]") {
    const auto apart = [](std::size_t i, const Vec3& c) { return i == 1 ? c.y > -0.999 : i != 0 || c.y > -0.999; };
    check_in_furnace("a box exactly on the floor", {furnace(translated(make_box(0.5, 0.6, 0.4, 2), {0.1, -0.7, 0}), 0.7)}, apart);
    // Floor and box alike: what the floor got both from the box and from what the box hides would lie above the bound.
    check_in_furnace("a wide box exactly on the floor", {furnace(make_box(1.6, 0.3, 1.6, 2, {0, -0.85, 0}), 0.5)}, apart);
    check_in_furnace("a sheet in the floor's plane", {furnace(transformed(make_quad(0.8, 0.8), translation({0, -1, 0})), 0.7)}, apart);
    check_in_furnace("two sheets that overlap in one plane",
                     {furnace(make_quad(0.8, 0.8, true), 0.7), furnace(translated(make_quad(0.8, 0.8, true), {0.4, 0, 0.3}), 0.6)},
                     [](std::size_t i, const Vec3&) { return i == 2; });
}

TEST_CASE("half of the faces flipped", "[stability][geometry]") {
    Mesh mesh = make_sphere(1, 0.5);
    for (std::size_t t = 0; t < mesh.triangles.size(); t += 2) std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
    check_in_furnace("a ball with every other face flipped", {furnace(all_two_sided(mesh), 0.7)});
}

TEST_CASE("objects of one triangle", "[stability][geometry]") {
    const Mesh triangle = make_triangle({-0.3, 0, -0.2}, {0.4, 0.1, 0}, {0, 0.3, 0.5});
    check_in_furnace("a triangle, both sides of it", {furnace(all_two_sided(triangle), 0.7)});
    const Scene alone = make_scene({{triangle, {}, {0.5, 0.5, 0.5}, {1, 2, 3}}}, coarse_tables());
    const Solution s = solve_soundly("geometry", alone, kAccuracy);
    record("geometry", "a triangle and nothing else", "B = M, E = 0", 0,
           length(to_double(s.instances[0].radiosity[0]) - Vec3{1, 2, 3}) + length(to_double(s.instances[0].irradiance[0])));
}

TEST_CASE("needles and plates", "[stability][geometry]") {
    check_in_furnace("a needle 1e-4 x 1e-4 x 1.5", {furnace(make_box(1e-4, 1e-4, 1.5), 0.7)});
    check_in_furnace("a plate 1.5 x 1.5 x 1e-5", {furnace(make_box(1.5, 1e-5, 1.5, 2), 0.7)});
    check_in_furnace("a stack of plates 1e-3 apart", {furnace(make_box(1, 1e-3, 1, 2), 0.7), furnace(make_box(1, 1e-3, 1, 2), 0.6, translation({0, 2e-3, 0}))});
}

TEST_CASE("a ball of thousands of triangles beside a sheet of two", "[stability][geometry]") {
    check_in_furnace("5,120 triangles beside two",
                     {furnace(make_sphere(4, 0.4), 0.7, translation({-0.4, 0, 0})), furnace(make_quad(0.1, 0.1, true), 0.6, translation({0.3, 0, 0}))});
}

TEST_CASE("a million triangles beside two", "[.][stability][commands]") {
    const Scene scene = make_scene({furnace(make_sphere(8, 0.4), 0.7, translation({-0.4, 0, 0})),
                                    furnace(make_quad(0.1, 0.1, true), 0.6, translation({0.3, 0, 0})), room()});
    const FurnaceError e = furnace_error(scene, solve_soundly("commands", scene, kAccuracy), 1);
    record("commands", "1,310,720 triangles beside two, in a furnace", "B = 1; root mean square over R", kAccuracy, e.rms);
}

TEST_CASE("closed in closed: no light gets through walls", "[stability][geometry]") {
    const Vec3 grey{0.6, 0.6, 0.6}, light{50, 50, 50};
    const Placed lit_room{turned_inside_out(make_box(4, 4, 4)), {}, grey, {}}, ball{make_sphere(0, 0.3), translation({1.4, 1.2, 0}), {}, light};
    const auto dark = [&](const std::string& what, const std::string& law, double bound, const Mesh& inner, std::size_t faces_from) {
        const Scene scene = make_scene({lit_room, ball, {inner, translation({0.2, -0.3, 0.1}), grey, {}}}, coarse_tables());
        const Solution s = solve_soundly("geometry", scene, 0.3);
        CHECK(mean_irradiance(scene, s, 0) > 0.1);
        Worst worst;
        for (std::size_t f = 0; f < s.instances[2].irradiance.size(); ++f)
            if (scene.instances[2].data().source_triangle[scene.instances[2].data().faces[f].triangle()] >= faces_from)
                worst.add(length(to_double(s.instances[2].irradiance[f])));
        record("geometry", what, law, bound, worst.value() / irradiance(scene, s, 0).mean);
    };
    const Mesh inside = turned_inside_out(make_box(1.2, 1.2, 1.2));
    dark("a closed room in a lit room", "E = 0 inside", 0, inside, 0);
    // Outside first, 12 triangles; then the inside.
    dark("a closed box with walls of 1e-5 in a lit room", "E = 0 inside", 0, merged(make_box(1.2 + 2e-5, 1.2 + 2e-5, 1.2 + 2e-5), inside), 12);
}

TEST_CASE("a wall of 1e-5 lit from one side", "[stability][geometry]") {
    const Scene scene = make_scene({{turned_inside_out(make_box(4, 2, 2, 2)), {}, {0.6, 0.6, 0.6}},
                                    {make_box(1e-5, 2, 2), {}, {0.6, 0.6, 0.6}},
                                    {make_sphere(0, 0.3), translation({-1, 0, 0}), {}, {20, 20, 20}},
                                    {make_sphere(0, 0.3), translation({1, 0, 0}), {0.6, 0.6, 0.6}}},
                                   coarse_tables());
    const Solution s = solve_soundly("geometry", scene, 0.3);
    Worst worst;
    worst.add(irradiance(scene, s, 3).rms);
    for (std::size_t f = 0; f < s.instances[1].irradiance.size(); ++f)
        if (area_vector(scene.instances[1].world_corners(scene.instances[1].data().faces[f])).x > 0.1)
            worst.add(double(s.instances[1].irradiance[f].y));
    record("geometry", "a wall of 1e-5 m between a lamp and the rest", "E = 0 behind it", 0, worst.value());
}

TEST_CASE("one object in the other's hollow", "[stability][geometry]") {
    const Mesh cup = translated(make_open_box(0.8, 0.8, 0.8, 2), {0, -0.6, 0});
    check_in_furnace("a ball in an open box", {furnace(cup, 0.7), furnace(make_sphere(1, 0.2), 0.6, translation({0.05, -0.2, 0}))});

    // Around a glowing ball as around a point: the cup's inside gets all of its light but what leaves by the opening, which
    // fills asin(1 / (1 + 4 (h / s)^2)) * 4 / (4 pi) of all directions, s its width, h the height above the ball.
    const double h = 0.4, width = 0.8, r = h / (width / 2);
    const Scene scene = make_scene({{make_open_box(width, 0.8, width, 2), {}, {0.5, 0.5, 0.5}, {}},
                                    {make_sphere(2, 0.15), translation({0, 0.8 - h, 0}), {}, {1, 1, 1}}}, coarse_tables());
    double sent = 0;
    for (const Face face : scene.instances[1].data().faces) sent += length(area_vector(scene.instances[1].world_corners(face)));
    const double leaves = std::asin(1 / (1 + r * r)) / std::numbers::pi;
    for (const double accuracy : {kAccuracy, 0.5}) {
        const Solution s = solve_reusably(scene, accuracy, {"interreflection"});
        double received = 0;
        for (std::size_t f = 0; f < s.instances[0].irradiance.size(); ++f)
            received += double(s.instances[0].irradiance[f].x) * face_area(scene.instances[0], f);
        record("geometry", "a bulb in an open box", "it receives all but what leaves by the opening", kAccuracy,
               std::abs(received / sent / (1 - leaves) - 1));
    }
}

TEST_CASE("an emitter that touches a receiver", "[stability][geometry]") {
    const Vec3 none{}, half{0.5, 0.5, 0.5}, one{1, 1, 1};
    const Mesh floor = make_parallelogram({0, 0, 0}, {0, 0, 1}, {1, 0, 0});
    const double corner = 0.200043776075403, opposite = 0.199824895698387;
    const auto off = [&](const Mesh& emitter, double factor) {
        const Scene scene = make_scene({{floor, {}, half, none}, {emitter, {}, none, one}}, coarse_tables());
        const Spread e = irradiance(scene, solve_soundly("geometry", scene, 0.03), 0);
        return std::abs(e.mean - factor) / e.rms;
    };
    // By Cauchy and Schwarz the mean is off by no more than the accuracy times the irradiance's root mean square.
    record("geometry", "an emitting square on the receiver's edge", "E = M F (Howell C-14), over its root mean square", 0.03,
           off(make_parallelogram({0, 0, 0}, {0, 1, 0}, {0, 0, 1}), corner));
    record("geometry", "an emitting square 1 m above", "E = M F (Howell C-11), over its root mean square", 0.03,
           off(make_parallelogram({0, 1, 0}, {1, 0, 0}, {0, 0, 1}), opposite));
    // A glowing cube stands on the floor's middle: the floor under it sees its bottom or nothing, the rest its sides.
    const Scene scene = make_scene({{make_quad(1, 1, false, 4), {}, half, none}, {make_box(0.5, 0.5, 0.5, 1, {0, 0.25, 0}), {}, none, one}},
                                   coarse_tables());
    const Solution s = solve_soundly("geometry", scene, kAccuracy);
    CHECK(irradiance(scene, s, 0).mean > 0.05);
}

TEST_CASE("parts of an object between its other parts", "[stability][geometry]") {
    // Three plates of one mesh, all glowing: the middle one hides the outer ones from each other, or they would receive half as
    // much again.
    Mesh plates = make_parallelogram({0, 0, 0}, {0, 0, 1}, {1, 0, 0}, 8);
    add_parallelogram(plates, {0, 0.5, 0}, {0, 0, 1}, {1, 0, 0}, 8, true);
    add_parallelogram(plates, {0, 1, 0}, {1, 0, 0}, {0, 0, 1}, 8);
    constexpr double kRho = 0.01;
    const Scene scene = make_scene({{plates, {}, {kRho, kRho, kRho}, {1, 1, 1}}}, coarse_tables());
    const Solution s = solve_soundly("geometry", scene, kAccuracy);
    const double f = wide_facing(1, 1, 0.5), expected = f * (1 + kRho * f);  // one bounce, to rho^2
    Worst off;
    double lower = 0, upper = 0;
    for (std::size_t k = 0; k < s.instances[0].irradiance.size(); ++k) {
        const TriangleCorners c = scene.instances[0].world_corners(scene.instances[0].data().faces[k]);
        const double e = double(s.instances[0].irradiance[k].x) * face_area(scene.instances[0], k);
        if (c[0].y < 0.25) lower += e;
        if (c[0].y > 0.75) upper += e;
    }
    off.add_relative(lower, expected);
    off.add_relative(upper, expected);
    record("geometry", "three plates of one mesh, the middle one between", "E = M F of neighbours (Howell C-11), mean", kAccuracy, off.value());
}

TEST_CASE("directions at poles, seams and creases", "[stability][geometry]") {
    std::mt19937 bits(5);
    std::vector<Vec3> directions;
    for (const double x : {-1.0, -0.0, 0.0, 1.0, 1e-17, -1e-300, 0.5})
        for (const double y : {-1.0, -0.0, 0.0, 1.0, 1e-17, 0.5})
            for (const double z : {-1.0, -0.0, 0.0, 1.0, -1e-17, 0.5})
                if (x != 0 || y != 0 || z != 0) directions.push_back({x, y, z});
    Worst sums, ranges, jumps;
    for (const GridMap map : {GridMap::Octahedral, GridMap::LatLong})
        for (const std::uint32_t n : {2u, 5u, 12u, 16u}) {
            const DirectionGrid grid(map, n);
            std::vector<double> table(grid.size());
            for (double& v : table) v = double(bits() % 1000) / 1000;
            for (const Vec3& w : directions) {
                const DirectionTaps t = grid.taps(w);
                double sum = 0;
                for (std::size_t k = 0; k < 4; ++k) {
                    sum += double(t.weight[k]);
                    ranges.add(t.node[k] < grid.size() ? 0 : 1);
                    ranges.add(double(-t.weight[k]));
                }
                sums.add(std::abs(sum - 1));
                if (length(w) < 0.1) continue;
                for (const Vec3& step : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}, Vec3{1, -1, 1}})
                    jumps.add(std::abs(grid.interpolate<double>(table, w + step * 1e-6) - grid.interpolate<double>(table, w - step * 1e-6)));
            }
        }
    record("geometry", "grids at axes, poles, seams, creases, signed zeros", "weights sum to 1", 1e-6, sums.value());
    record("geometry", "grids at axes, poles, seams, creases, signed zeros", "nodes exist, weights are not negative", 0, ranges.value());
    // Longitudes turn by 2e-6 over the distance to the pole's axis, 1e-6 here: right at a pole all of a row may be passed, but
    // there its values have been made one. Elsewhere n / 2 cells per radian and unit values: 2e-6 * 16.
    record("geometry", "grids at axes, poles, seams, creases, signed zeros", "values 2e-6 rad apart are alike", 1e-4, jumps.value());

    // A ball far from a lamp that looks at it: light comes along the very directions of axes, edges and corners.
    std::vector<double> means;
    for (int x = -1; x <= 1; ++x)
        for (int y = -1; y <= 1; ++y)
            for (int z = -1; z <= 1; ++z) {
                if (x == 0 && y == 0 && z == 0) continue;
                const Vec3 w = normalised({double(x), double(y), double(z)}), u = normalised(cross(w, std::abs(w.x) < 0.9 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
                const Mesh lamp = make_parallelogram(w * 10 - u * 0.5 - cross(u, w) * 0.5, u, cross(u, w));
                const Scene scene = make_scene({{make_sphere(1, 0.5), {}, {0.5, 0.5, 0.5}, {}}, {lamp, {}, {}, {100, 100, 100}}}, coarse_tables());
                means.push_back(irradiance(scene, solve_soundly("geometry", scene, 0.03), 0).mean);
            }
    REQUIRE(means[0] > 0);
    double mean = 0;
    for (const double m : means) mean += m / double(means.size());
    Worst spread;
    for (const double m : means) spread.add(std::abs(m / mean - 1));
    // The silhouette of a ball of 80 triangles differs by 1.5 % between directions; each solve may be off by 3 %.
    record("geometry", "a ball lit along 26 axes, edges and diagonals", "the same mean irradiance", 0.05, spread.value());
}

}  // namespace rro::test
