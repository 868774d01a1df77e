// The same scene told otherwise: in another size, place, order, by more threads.
//
// Where every number only changes its exponent, or its place in a list, results are the same bits. Elsewhere rounding may turn
// a decision about a link, so that two solutions differ by what both may be off by.
#include "tests/stability/sound.h"

#include <map>
#include <random>

#include "format/parallel.h"
#include "solver/factors/view_factors.h"
#include "solver/scene/transform.h"

namespace rro::test {
namespace {

constexpr double kAccuracy = 0.1;

std::vector<Placed> furniture() {
    return {{make_quad(3, 3, false, 2), {}, {0.6, 0.5, 0.4}, {}, "floor"},
            {make_box(0.5, 0.8, 0.4, 2), translation({-0.4, 0.401, 0.2}), {0.8, 0.3, 0.2}, {}, "box"},
            {make_sphere(1, 0.3), translation({0.5, 0.32, -0.1}), {0.3, 0.5, 0.7}, {}, "ball"},
            {make_quad(0.8, 0.8), turned_down({0.1, 1.9, 0}), {0.2, 0.2, 0.2}, {10, 9, 7}, "lamp"}};
}

/// The same instances, moved together, of the same archives.
Scene mapped(const Scene& scene, const Affine3& map) {
    Scene out;
    out.objects = scene.objects;
    for (const Instance& i : scene.instances)
        add_instance(out, *i.object, map * i.to_world, to_double(i.reflectance[0]), to_double(i.exitance[0]), i.name);
    return out;
}

/// Radiosities of another solution of the same instances and archives, in units of what both solutions may be off by.
double apart(const Scene& scene, const Solution& a, const Solution& b) {
    return compare(scene, a, b).all.error() / (a.estimated_error + b.estimated_error);
}

std::map<std::string, std::vector<Rgb>> by_name(const Scene& scene, const Solution& s) {
    std::map<std::string, std::vector<Rgb>> out;
    for (std::size_t i = 0; i < scene.instances.size(); ++i) out[scene.instances[i].name] = s.instances[i].radiosity;
    return out;
}

/// Corners at one place become one.
Mesh welded(Mesh mesh) {
    std::map<std::array<double, 3>, std::uint32_t> at;
    std::vector<Vec3> positions;
    for (TriangleIndices& t : mesh.triangles)
        for (std::uint32_t& corner : t) {
            const Vec3 p = mesh.positions[corner];
            const auto [found, is_new] = at.try_emplace({p.x, p.y, p.z}, static_cast<std::uint32_t>(positions.size()));
            if (is_new) positions.push_back(p);
            corner = found->second;
        }
    mesh.positions = positions;
    return mesh;
}

/// Every triangle has corners of its own.
Mesh taken_apart(Mesh mesh) {
    std::vector<Vec3> positions;
    for (TriangleIndices& t : mesh.triangles)
        for (std::uint32_t& corner : t) {
            positions.push_back(mesh.positions[corner]);
            corner = static_cast<std::uint32_t>(positions.size() - 1);
        }
    mesh.positions = positions;
    return mesh;
}

Mesh shuffled(Mesh mesh) {
    std::mt19937 bits(4);
    for (std::size_t t = mesh.triangles.size(); t-- > 1;) {
        const std::size_t u = bits() % (t + 1);
        std::swap(mesh.triangles[t], mesh.triangles[u]);
        std::swap(mesh.source_triangle[t], mesh.source_triangle[u]);
    }
    return mesh;
}

}  // namespace

TEST_CASE("a scene scaled, moved, turned, mirrored", "[stability][invariance]") {
    const Scene scene = make_scene(furniture(), coarse_tables());
    const Solution s = solve_soundly("invariance", scene, kAccuracy);
    const auto again = [&](const Affine3& map) { return solve_soundly("invariance", mapped(scene, map), kAccuracy); };
    const auto scale = [](double x) { return compose({{}, {0, 1, 0}, 0, {x, x, x}}); };
    const std::string law = "the same radiosity, over what both may be off by";
    for (const int power : {-20, -10, 10, 20}) {
        Worst worst;
        const Solution other = again(scale(std::ldexp(1.0, power)));
        for (std::size_t i = 0; i < s.instances.size(); ++i)
            for (std::size_t f = 0; f < s.instances[i].radiosity.size(); ++f)
                worst.add_relative(double(other.instances[i].radiosity[f].x), double(s.instances[i].radiosity[f].x));
        record("invariance", "all lengths times 2^-20 to 2^20", "the same radiosity, relative", 1e-5, worst.value());
    }
    for (const double x : {1e-6, 1e-3, 1e3, 1e6})
        record("invariance", "all lengths times 1e-6 to 1e6", law, 1, apart(scene, again(scale(x)), s));
    for (const Vec3& by : {Vec3{1e3, 0, 0}, Vec3{1e6, -1e6, 1e6}, Vec3{0, 0, 1e8}})
        record("invariance", "all moved by 1e3 to 1e8", law, 1, apart(scene, again(translation(by)), s));
    for (const double degrees : {90.0, 37.0, 180.0})
        record("invariance", "all turned", law, 1, apart(scene, again(compose({{}, {1, 2, 3}, degrees, {1, 1, 1}})), s));
    record("invariance", "all mirrored", law, 1, apart(scene, again(compose({{}, {0, 1, 0}, 0, {-1, 1, 1}})), s));
}

TEST_CASE("instances in another order, on 1 to 8 threads", "[stability][invariance]") {
    Scene scene = make_scene(furniture(), coarse_tables());
    const auto first = by_name(scene, solve_soundly("invariance", scene, kAccuracy));
    const auto different = [&] { return by_name(scene, solve_soundly("invariance", scene, kAccuracy)) == first ? 0.0 : 1.0; };
    for (const unsigned threads : {1u, 2u, 3u, 5u, 8u}) {
        set_thread_count(threads);
        record("invariance", "1, 2, 3, 5 and 8 threads", "the same bits; solutions that differ", 0, different());
    }
    set_thread_count(0);
    std::sort(scene.instances.begin(), scene.instances.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
    do
        if (scene.instances[0].name != "floor")
            record("invariance", "instances in every order", "the same bits; solutions that differ", 0, different());
    while (std::next_permutation(scene.instances.begin(), scene.instances.end(),
                                 [](const auto& a, const auto& b) { return a.name < b.name; }));
}

TEST_CASE("triangles in another order, corners welded or apart", "[stability][invariance]") {
    const Scene scene = make_scene(furniture(), coarse_tables());
    const Solution s = solve_soundly("invariance", scene, kAccuracy);
    const auto told_otherwise = [&](const auto& change) {
        std::vector<Placed> placed = furniture();
        for (Placed& p : placed) p.mesh = change(p.mesh);
        const Scene other = make_scene(placed, coarse_tables());
        Solution t = solve_soundly("invariance", other, kAccuracy);
        for (std::size_t i = 0; i < t.instances.size(); ++i)
            t.instances[i] = renumbered(other.instances[i].data(), t.instances[i], scene.instances[i].data());
        return apart(scene, t, s);
    };
    const std::string law = "the same radiosity, over what both may be off by";
    record("invariance", "triangles in another order", law, 1, told_otherwise(shuffled));
    record("invariance", "corners welded", law, 0, told_otherwise(welded));
    record("invariance", "every triangle with corners of its own", law, 0, told_otherwise(taken_apart));
}

TEST_CASE("view factors scaled, moved, turned", "[stability][invariance]") {
    const Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
    const Scene scene = make_scene({{make_parallelogram({}, x, y)}, {make_parallelogram(z, y, x)}, {make_parallelogram(z * 0.5 + x * 0.3, y, x * 0.3)},
                                    {make_parallelogram({}, z, x)}}, coarse_tables());
    const auto factors = [](const Scene& of) {
        auto f = view_factors(of, {});
        REQUIRE(f);
        return std::move(*f);
    };
    const Factors expected = factors(scene);
    for (const double size : {1e-6, 1e-3, 1e3, 1e6})
        for (const double far : {0.0, 1e3}) {
            const Factors f = factors(mapped(scene, compose({Vec3{1, 2, 3} * (far * size), {1, 2, 3}, 37, {size, size, size}})));
            Worst worst;
            REQUIRE(f.rows.size() == expected.rows.size());
            for (std::size_t i = 0; i < f.rows.size(); ++i) {
                REQUIRE(f.rows[i].size() == expected.rows[i].size());
                for (std::size_t k = 0; k < f.rows[i].size(); ++k) worst.add(std::abs(f.rows[i][k].value - expected.rows[i][k].value));
            }
            // What is obstructed is found to 1e-3.
            record("invariance", "view factors of four squares, 1e-6 to 1e6 in size", "the same factors, absolute", 1e-3, worst.value());
        }
}

}  // namespace rro::test
