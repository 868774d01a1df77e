// An archive serves under every affine map: it must give what the archive of the mapped mesh itself gives.
#include <catch2/catch.hpp>

#include <random>

#include "tests/support/shapes.h"
#include "tests/support/solutions.h"

namespace rro::test {
namespace {

class RandomMaps {
  public:
    /// strength  1: edges up to 3 times as long or as short, sheared by up to 1; 0: shapes are kept
    explicit RandomMaps(double strength) : strength_(strength) {}

    /// Turned, stretched, sheared, mirrored every other time, of a size from 1e-3 to 1e3.
    Affine3 next() {
        Mat3 map = turn() * Mat3{{Vec3{stretch(), 0, 0}, Vec3{0, stretch(), 0}, Vec3{0, 0, stretch()}}};
        map = map * Mat3{{Vec3{1, shear(), shear()}, Vec3{0, 1, shear()}, Vec3{0, 0, 1}}} * turn();
        if (++count_ % 2 == 0) map = map * Mat3{{Vec3{-1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}};
        const double size = std::pow(10.0, 6 * uniform() - 3);
        for (Vec3& row : map.rows) row *= size;
        return {map, Vec3{uniform(), uniform(), uniform()} * (10 * size)};
    }

  private:
    // By hand from the bits: the standard's distributions differ between libraries.
    double uniform() { return double(bits_() >> 11) * 0x1p-53; }
    double stretch() { return std::pow(3.0, strength_ * (2 * uniform() - 1)); }
    double shear() { return strength_ * (2 * uniform() - 1); }
    Mat3 turn() {
        const Vec3 x = normalised({uniform() - 0.5, uniform() - 0.5, uniform() - 0.5});
        const Vec3 y = normalised(cross(x, {uniform() - 0.5, uniform() - 0.5, uniform() - 0.5}));
        return {{x, y, cross(x, y)}};
    }

    std::mt19937_64 bits_{20};
    double strength_;
    int count_ = 0;
};

/// What the map is made of: size, and how far from a similarity.
std::string described(const Affine3& map) {
    const double size = std::cbrt(std::abs(map.linear.determinant()));
    double longest = 0;
    for (int c = 0; c < 3; ++c) longest = std::max(longest, length(map.linear.column(c)));
    return "size " + std::to_string(size) + ", longest column over size " + std::to_string(longest / size) +
           (map.linear.determinant() < 0 ? ", mirrored" : "");
}

void check_under_maps(const std::string& what, const Mesh& mesh, double strength, int maps) {
    constexpr double kAccuracy = 0.1;
    const Mesh floor = translated(make_quad(4, 4, false, 2), {0, -1.3, 0});
    const Mesh panel = transformed(make_quad(1.5, 1.5, true), translation({0.6, 2, 0.3}));
    const Vec3 grey{0.6, 0.6, 0.6}, light{5, 5, 5};
    Scene placed;  // its archives stay, its instances move
    placed.manifest.path = "in memory";
    for (const Mesh* m : {&mesh, &floor, &panel}) placed.objects.push_back(compile_to_object(*m, coarse_tables()));
    RandomMaps random(strength);
    int apart = 0;
    double furthest = 0;
    std::string where;
    for (int k = 0; k < maps; ++k) {
        const Affine3 map = random.next();
        placed.manifest.instances.clear();
        placed.instances.clear();
        placed.bounds = {};
        add_instance(placed, *placed.objects[0], map, grey, {}, "object");
        add_instance(placed, *placed.objects[1], map, grey, {}, "floor");
        add_instance(placed, *placed.objects[2], map, {}, light, "panel");
        const Scene baked = make_scene({{transformed(mesh, map), {}, grey, {}, "object"},
                                        {transformed(floor, map), {}, grey, {}, "floor"},
                                        {transformed(panel, map), {}, {}, light, "panel"}},
                                       coarse_tables());
        const Solution a = solve_reusably(placed, kAccuracy), b = solve_reusably(baked, kAccuracy);
        Solution same;
        for (std::size_t i = 0; i < 3; ++i)
            same.instances.push_back(
                renumbered(placed.instances[i].data(), a.instances[i], baked.instances[i].data()));
        const double difference = compare(baked, same, b).all.error(), allowed = a.estimated_error + b.estimated_error;
        if (difference > allowed) ++apart;
        if (difference / allowed > furthest) {
            furthest = difference / allowed;
            where = "map " + std::to_string(k) + " (" + described(map) + "): difference " + std::to_string(difference) +
                    ", estimates " + std::to_string(a.estimated_error) + " and " + std::to_string(b.estimated_error);
        }
    }
    INFO(what << ": " << apart << " of " << maps << " maps are further apart than both errors reported; furthest: " << where);
    CHECK(apart == 0);
}

}  // namespace

TEST_CASE("an archive under maps that nearly keep its shape", "[transport][affine]") {
    check_under_maps("box", make_box(1, 1.5, 0.8, 2), 0.2, 10);
    check_under_maps("seat", translated(make_seat(2), {0, -0.6, 0}), 0.2, 10);
    check_under_maps("dented sphere", make_dented_sphere(1, 0.8), 0.2, 10);
    check_under_maps("open box", make_open_box(1, 1, 1, 2), 0.2, 10);
}

TEST_CASE("an archive under any affine map: a convex body", "[transport][affine]") {
    check_under_maps("box", make_box(1, 1.5, 0.8, 2), 1, 25);
}
TEST_CASE("an archive under any affine map: a seat with its back", "[transport][affine]") {
    check_under_maps("seat", translated(make_seat(2), {0, -0.6, 0}), 1, 25);
}
TEST_CASE("an archive under any affine map: a sphere with a dent", "[transport][affine]") {
    check_under_maps("dented sphere", make_dented_sphere(1, 0.8), 1, 25);
}
TEST_CASE("an archive under any affine map: an open box, both sides of it", "[transport][affine]") {
    check_under_maps("open box", make_open_box(1, 1, 1, 2), 1, 25);
}

}  // namespace rro::test
