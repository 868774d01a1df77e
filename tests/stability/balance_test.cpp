// Where light can go nowhere else: furnaces, energy, sums of rows.
//
// Accuracy bounds the root mean square of R's error over the scene; single triangles are held to three times that.
#include "solver/factors/closure.h"
#include "solver/factors/view_factors.h"
#include "tests/stability/sound.h"

namespace rro::test {
namespace {

struct Shape {
    const char* name;
    Mesh inside;
};

Mesh cylinder() {
    Mesh mesh = merged(make_tube(10, 1, 0, 2), make_disk(10, 1, 2));
    mesh = merged(std::move(mesh), transformed(make_disk(10, 1), turned_down({})));
    mesh.closed = true;
    return mesh;
}

std::vector<Shape> shapes() {
    return {{"cube", turned_inside_out(make_box(1, 1, 1))},
            {"tetrahedron", turned_inside_out(make_tetrahedron(2))},
            {"sphere", turned_inside_out(make_sphere(1))},
            {"L-shaped room", make_l_room(1)},
            {"torus", turned_inside_out(make_torus(10, 6, 1, 0.4))},
            {"cylinder", turned_inside_out(cylinder())},
            {"dented sphere", turned_inside_out(make_dented_sphere(1, 0.7))},
            {"corridor 1 x 1 x 30", turned_inside_out(make_box(1, 1, 30, 3))},
            {"gap 1 x 1 x 0.01", turned_inside_out(make_box(1, 1, 0.01, 2))}};
}

}  // namespace

TEST_CASE("white furnaces of all kinds, up to a reflectance of 0.9999", "[stability][balance]") {
    constexpr double kAccuracy = 0.05;
    for (const Shape& shape : shapes()) {
        Scene scene = make_scene({{shape.inside}}, coarse_tables());
        for (const double rho : {0.0, 0.5, 0.9, 0.99, 0.9999}) {
            for (Rgb& r : scene.instances[0].reflectance) r = to_float({rho, rho, rho});
            for (Rgb& m : scene.instances[0].exitance) m = {1, 1, 1};
            const double as_stored = double(scene.instances[0].reflectance[0].x);
            const Solution s = solve_soundly("balance", scene, kAccuracy);
            const FurnaceError e = furnace_error(scene, s, 1 / (1 - as_stored));
            INFO(shape.name << ", rho " << rho << ": rms " << e.rms << ", worst " << e.worst << ", estimate "
                            << s.estimated_error << ", sweeps " << s.iterations << ", links " << s.links.total());
            CHECK(s.converged);
            const std::string what = std::string("white furnace, ") + shape.name + ", rho 0 to 0.9999";
            record("balance", what, "B = M / (1 - rho); root mean square over R", kAccuracy, e.rms);
            record("balance", what, "B = M / (1 - rho); worst triangle over R", 3 * kAccuracy, e.worst);
        }
    }
}

TEST_CASE("furnished rooms absorb what they emit, and nothing leaves twice", "[stability][balance]") {
    constexpr double kAccuracy = 0.1;
    const Vec3 rho{0.9, 0.5, 0.1}, light{4, 3, 2};
    const std::vector<Placed> furniture{{make_box(0.5, 0.7, 0.4, 2), translation({0.4, -0.5, 0.2}), rho, {}, "box"},
                                        {make_sphere(1, 0.3), translation({-0.4, 0.1, 0}), rho, {}, "ball"},
                                        {make_quad(0.6, 0.6), turned_down({0, 0.95, 0}), rho, light, "lamp"}};
    std::vector<Placed> closed = furniture;
    closed.push_back({turned_inside_out(make_box(2, 2, 2, 2)), {}, rho, {}, "room"});
    for (const bool is_closed : {true, false}) {
        const Scene scene = make_scene(is_closed ? closed : furniture, coarse_tables());
        const Solution s = solve_soundly("balance", scene, kAccuracy);
        for (int c = 0; c < 3; ++c) {
            double emitted = 0, absorbed = 0, area = 0, squares = 0;
            for (std::size_t i = 0; i < scene.instances.size(); ++i)
                for (std::size_t f = 0; f < s.instances[i].radiosity.size(); ++f) {
                    const Instance& instance = scene.instances[i];
                    const std::size_t p = instance.object->patch_of_face[f];
                    const double a = face_area(instance, f);
                    emitted += a * to_double(instance.exitance[p])[c];
                    absorbed += a * (1 - to_double(instance.reflectance[p])[c]) * to_double(s.instances[i].irradiance[f])[c];
                    area += a;
                    squares += a * length2(reflected(instance, s.instances[i], f));
                }
            Worst worst;
            worst.add_relative(s.energy.emitted[c], emitted);
            worst.add(std::abs(s.energy.absorbed[c] - absorbed) / emitted);
            worst.add(std::abs(s.energy.emitted[c] - s.energy.absorbed[c] - s.energy.escaped[c]) / emitted);
            // Single precision of the radiosities.
            record("balance", "energy of furnished rooms, closed and without walls",
                   "emitted and absorbed as summed over faces, escaped the rest", 1e-6, worst.value());
            // absorbed = sum A (1 - rho) / rho R: off by at most that, by Cauchy and Schwarz.
            const double most = (1 - rho[c]) / rho[c] * std::sqrt(area * squares) * kAccuracy;
            if (is_closed)
                record("balance", "energy of a furnished closed room", "escaped over what the accuracy asked allows", 1,
                       std::abs(s.energy.escaped[c]) / most);
            else
                record("balance", "energy of furniture without walls", "escaped is not negative; excess over emitted", 0,
                       std::max(0.0, -s.energy.escaped[c] / emitted));
        }
    }
}

TEST_CASE("what nothing receives escapes", "[stability][balance]") {
    const Scene scene = make_scene({{make_sphere(1), {}, {0.5, 0.5, 0.5}, {1, 2, 3}}}, coarse_tables());
    const Solution s = solve_soundly("balance", scene, 0.1);
    Worst worst;
    for (int c = 0; c < 3; ++c) worst.add_relative(s.energy.escaped[c], s.energy.emitted[c]);
    record("balance", "a lone convex body", "all it emits escapes", 0, worst.value());
}

TEST_CASE("rows of factors of closed scenes sum to 1", "[stability][balance]") {
    const auto defect = [](const std::vector<Placed>& placed) {
        const Scene scene = make_scene(placed, coarse_tables());
        const auto factors = view_factors(scene, {});
        REQUIRE(factors);
        return measure_closure(*factors).largest_defect;
    };
    // Targets A3: 1e-5 where nothing obstructs, 1e-3 where something does.
    for (const double size : {1e-3, 1.0, 1e3})
        record("balance", "factors of a cube's six walls, 1 mm to 1 km", "rows sum to 1", 1e-5, [&] {
            std::vector<Placed> walls;
            const Vec3 lo{}, hi = Vec3{1, 1, 1} * size, x{size, 0, 0}, y{0, size, 0}, z{0, 0, size};
            for (const auto& [at, u, v] : {std::array{lo, z, x}, {lo, x, y}, {lo, y, z}, {hi, -x, -z}, {hi, -y, -x}, {hi, -z, -y}})
                walls.push_back({make_parallelogram(at, u, v)});
            return defect(walls);
        }());
    record("balance", "factors of a box in a box", "rows sum to 1", 1e-3,
           defect({{turned_inside_out(make_box(2, 2, 2))}, {make_box(0.6, 0.8, 0.5)}}));
}

}  // namespace rro::test
