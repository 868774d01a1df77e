// Light far stronger and weaker than any lamp, none at all, and reflectances at the ends of their range.
#include "tests/stability/sound.h"

#include "compiler/mesh_import.h"
#include "tests/support/temporary_folder.h"

namespace rro::test {
namespace {

const Vec3 kGrey{0.5, 0.5, 0.5}, kNone{}, kOne{1, 1, 1};

/// An open scene of far and near pairs: a floor, a ball over it, a panel above that faces down, another beside it.
Scene small_scene(const Vec3& reflectance, const Vec3& light, const Vec3& second = {}) {
    return make_scene({{make_quad(3, 3, false, 2), {}, reflectance, kNone, "floor"},
                       {make_sphere(1, 0.3), translation({0.3, 0.5, 0}), reflectance, kNone, "ball"},
                       {make_quad(1, 1), turned_down({0, 2, 0}), reflectance, light, "panel"},
                       {make_quad(1, 1), turned_down({1.3, 1.5, 0.2}), reflectance, second, "second"}},
                      coarse_tables());
}

template <class F>
void for_each_face(const Solution& s, const F& f) {
    for (const InstanceSolution& i : s.instances)
        for (std::size_t k = 0; k < i.radiosity.size(); ++k) f(to_double(i.radiosity[k]), to_double(i.irradiance[k]));
}

/// The largest difference of two solutions' radiosities, one of them times a factor, relative to each.
double apart(const Solution& a, const Solution& b, double times) {
    Worst worst;
    for (std::size_t i = 0; i < a.instances.size(); ++i)
        for (std::size_t f = 0; f < a.instances[i].radiosity.size(); ++f)
            for (int c = 0; c < 3; ++c)
                worst.add_relative(to_double(a.instances[i].radiosity[f])[c], times * to_double(b.instances[i].radiosity[f])[c]);
    return worst.value();
}

}  // namespace

TEST_CASE("no emitter at all", "[stability][light]") {
    Worst worst;
    const Solution s = solve_soundly("light", small_scene(kGrey, kNone), 0.1);
    for_each_face(s, [&](const Vec3& b, const Vec3& e) { worst.add(length(b) + length(e)); });
    CHECK(s.converged);
    record("light", "no emitter", "B = E = 0", 0, worst.value());
}

TEST_CASE("one channel without light, one without reflectance", "[stability][light]") {
    Worst dark, black;
    for_each_face(solve_soundly("light", small_scene(kGrey, {5, 0, 3}), 0.1),
                  [&](const Vec3& b, const Vec3& e) { dark.add(b.y + e.y), dark.add(b.x > 0 || b.z == 0 ? 0 : 1); });
    record("light", "one channel emits nothing", "B = E = 0 in it, and light in the others", 0, dark.value());
    const Solution s = solve_soundly("light", small_scene({0.5, 0, 0.5}, {5, 4, 3}), 0.1);
    for (std::size_t i = 0; i < s.instances.size(); ++i)
        for (const Rgb& b : s.instances[i].radiosity) black.add(std::abs(double(b.y) - (i == 2 ? 4 : 0)));
    record("light", "one channel is not reflected", "B = M in it", 0, black.value());
}

TEST_CASE("reflectance 0 and all but 1", "[stability][light]") {
    Worst worst;
    const Solution black = solve_soundly("light", small_scene(kNone, {5, 4, 3}), 0.1);
    for (std::size_t i = 0; i < black.instances.size(); ++i)
        for (const Rgb& b : black.instances[i].radiosity) worst.add(length(to_double(b) - (i == 2 ? Vec3{5, 4, 3} : Vec3{})));
    record("light", "reflectance 0 everywhere", "B = M", 0, worst.value());

    // A row that single precision has 1e-7 off is amplified a million times: a tenth.
    const double rho = double(static_cast<float>(1 - 1e-6)), accuracy = 0.1;
    Scene white = make_scene({{turned_inside_out(make_box(1, 1, 1, 2)), {}, kOne * rho, kOne}}, coarse_tables());
    const Solution s = solve_soundly("light", white, accuracy);
    const FurnaceError e = furnace_error(white, s, 1 / (1 - rho));
    INFO("rms " << e.rms << ", estimate " << s.estimated_error << ", sweeps " << s.iterations);
    record("light", "white furnace, reflectance 1 - 1e-6", "B = M / (1 - rho), or the estimate says how far from it", 1,
           e.worst / (3 * std::max(accuracy, s.estimated_error)));
}

TEST_CASE("exitances from 1e-30 to 1e30", "[stability][light]") {
    const Solution one = solve_soundly("light", small_scene(kGrey, {4, 3, 2}), 0.1);
    // Powers of two scale floating-point numbers without rounding.
    for (const int power : {-100, -50, 50, 100}) {
        const double times = std::ldexp(1.0, power);
        const Solution s = solve_soundly("light", small_scene(kGrey, Vec3{4, 3, 2} * times), 0.1);
        record("light", "exitance times 2^-100 to 2^100, about 1e-30 to 1e30", "B times the same", 1e-6, apart(s, one, times));
    }
    for (const double m : {1e-30, 1e30}) {
        const Solution s = solve_soundly("light", small_scene(kGrey, kOne * m), 0.1);
        const Solution unit = solve_soundly("light", small_scene(kGrey, kOne), 0.1);
        // No power of two: decisions about links may turn on the last bit, within the accuracy asked.
        Worst worst;
        for (std::size_t i = 0; i < s.instances.size(); ++i)
            for (std::size_t f = 0; f < s.instances[i].radiosity.size(); ++f)
                worst.add_relative(double(s.instances[i].radiosity[f].x) / m, double(unit.instances[i].radiosity[f].x));
        record("light", "exitance 1e-30 and 1e30", "B times the same", 0.01, worst.value());
    }
}

TEST_CASE("emitters of a contrast of 1e8", "[stability][light]") {
    constexpr double kAccuracy = 0.05;
    const Scene scene = small_scene(kGrey, kOne, kOne * 1e-8);
    const Solution both = solve_soundly("light", scene, kAccuracy), strong = solve_soundly("light", small_scene(kGrey, kOne), kAccuracy);
    Solution sum = solve_soundly("light", small_scene(kGrey, kNone, kOne * 1e-8), kAccuracy);
    for (std::size_t i = 0; i < sum.instances.size(); ++i)
        for (std::size_t f = 0; f < sum.instances[i].radiosity.size(); ++f)
            sum.instances[i].radiosity[f] = to_float(to_double(sum.instances[i].radiosity[f]) + to_double(strong.instances[i].radiosity[f]));
    // Each side of the comparison may be off by the accuracy.
    record("light", "two emitters, one 1e8 times the other", "light adds up; error over R", 2 * kAccuracy,
           compare(scene, both, sum).all.error());

    // Behind a wall nobody sees the strong one: what the weak one lights there is its own.
    const auto room = [](double x, const char* name) {
        return Placed{turned_inside_out(make_box(2, 2, 2, 2, {x, 0, 0})), {}, kGrey, kNone, name};
    };
    const auto lamp = [](double x, double m, const char* name) {
        return Placed{make_quad(0.5, 0.5), turned_down({x, 0.9, 0}), kGrey, kOne * m, name};
    };
    const Scene apart_scene = make_scene({room(-1.5, "left"), lamp(-1.5, 1e8, "left lamp"), room(1.5, "right"), lamp(1.5, 1, "right lamp")},
                                         coarse_tables());
    const Scene alone = make_scene({room(1.5, "right"), lamp(1.5, 1, "right lamp")}, coarse_tables());
    const Solution two = solve_soundly("light", apart_scene, kAccuracy), one = solve_soundly("light", alone, kAccuracy);
    double e2 = 0, e1 = 0;
    for (const auto& [s, i, e] : {std::tuple(&two, 2, &e2), std::tuple(&one, 0, &e1)})
        for (const Rgb& v : s->instances[static_cast<std::size_t>(i)].irradiance) *e += double(v.y);
    // No error is promised for so small a share of all light, so that it may be left out; but a leak of a part in 1e8 would
    // double it.
    record("light", "two closed rooms, lamps of 1e8 and 1", "the dim one has no light but its own; excess", 0.25,
           std::max(0.0, e2 / e1 - 1));
}

TEST_CASE("emitters of no area and of next to none", "[stability][light]") {
    TemporaryFolder folder;
    const auto lamp = [&](const char* name, const std::string& more) {
        std::ofstream(folder / name) << "v -0.5 2 -0.5\nv 0.5 2 -0.5\nv 0.5 2 0.5\nv -0.5 2 0.5\nv 0 1 0\n"
                                     << "f 1 2 3\nf 1 3 4\n" << more;
        auto imported = import_mesh(folder / name, {});
        REQUIRE(imported);
        decide_sides(imported->mesh, TwoSided::No, false, imported->report);
        return imported->mesh;
    };
    const auto solve = [&](const Mesh& mesh) {
        const Scene scene = make_scene({{make_quad(3, 3, false, 2), {}, kGrey, kNone}, {mesh, {}, kNone, kOne * 5}}, coarse_tables());
        return solve_soundly("light", scene, 0.1);
    };
    const Solution plain = solve(lamp("plain.obj", "")), nothing = solve(lamp("nothing.obj", "f 1 1 2\nf 5 5 5\nf 1 2 1\n"));
    record("light", "an emitter with faces of no area", "the same as without them", 0, apart(nothing, plain, 1));

    // A square of 1e-6 m that emits 1e12 times as much, far away for its size: its light is that of a point.
    const double side = 1e-6, height = 1;
    const Scene scene = make_scene({{make_quad(0.02, 0.02), {}, kGrey, kNone},
                                    {make_quad(side, side), turned_down({0, height, 0}), kNone, kOne / (side * side)}},
                                   coarse_tables());
    const Solution s = solve_soundly("light", scene, 0.01);
    // Over the receiver's 2 cm the cosines and distances vary by 1e-4.
    record("light", "an emitter of 1e-6 m, exitance 1e12", "E = M A / (pi d^2)", 0.01 + 2e-4,
           std::abs(irradiance(scene, s, 0).mean * std::numbers::pi * height * height - 1));
}

}  // namespace rro::test
