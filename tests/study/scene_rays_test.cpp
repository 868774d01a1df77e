#include "solver/visibility/scene_rays.h"

#include <catch2/catch.hpp>
#include <random>

#include "format/sample_points.h"
#include "tests/support/scenes.h"

using namespace rro;
using namespace rro::test;

namespace {

/// Uniform numbers with a fixed seed.
class Random {
  public:
    explicit Random(std::uint32_t seed) : engine_(seed) {}
    double operator()(double lo = 0, double hi = 1) { return std::uniform_real_distribution<double>(lo, hi)(engine_); }
    Vec3 in_box(const Box3& b) { return {(*this)(b.lo.x, b.hi.x), (*this)(b.lo.y, b.hi.y), (*this)(b.lo.z, b.hi.z)}; }
    std::uint32_t below(std::uint32_t n) { return static_cast<std::uint32_t>(engine_() % n); }

  private:
    std::mt19937 engine_;
};

/// Turns about a skew axis, stretches unevenly, shears and, where asked, mirrors.
Affine3 skew_transform(bool mirrored, const Vec3& to) {
    const double c = std::cos(0.7), s = std::sin(0.7);
    const Mat3 turn{{Vec3{c, -s, 0}, Vec3{s, c, 0}, Vec3{0, 0, 1}}};
    const Mat3 tilt{{Vec3{1, 0, 0}, Vec3{0, c, -s}, Vec3{0, s, c}}};
    const Mat3 shear{{Vec3{mirrored ? -1.5 : 1.5, 0.4, 0}, Vec3{0, 0.8, 0.3}, Vec3{0, 0, 1.2}}};
    return {turn * tilt * shear, to};
}

/// A point on a triangle in the world, and its barycentric coordinates.
Vec3 point_on(const Scene& scene, SceneTriangle on, double b1, double b2) {
    const Instance& instance = scene.instances[on.instance];
    return instance.to_world.point(triangle_point(instance.data().corners(on.triangle), b1, b2));
}

/// Any point of a triangle; one in three lies within 1e-9 .. 1e-4 of an edge, where rounding matters.
Vec3 any_point_on(const Scene& scene, SceneTriangle on, Random& random) {
    std::array<double, 2> b = square_to_triangle(random(), random());
    if (random.below(3) == 0) b[random.below(2)] = std::pow(10.0, random(-9, -4));
    if (b[0] + b[1] > 1) b = {b[0] / (b[0] + b[1]), b[1] / (b[0] + b[1])};
    return point_on(scene, on, b[0], b[1]);
}

/// World normal of the front of a triangle.
Vec3 front_normal(const Scene& scene, SceneTriangle on) {
    const Instance& instance = scene.instances[on.instance];
    return normalised(area_vector(instance.world_corners(Face::make(on.triangle, Side::Front))));
}

Vec3 any_direction_above(const Vec3& normal, Random& random) {
    const std::array<Vec3, 3> frame = frame_about(normal);
    const Vec3 local = square_to_cosine_hemisphere(random(), random());
    return frame[0] * local.x + frame[1] * local.y + frame[2] * local.z;
}

SceneTriangle any_triangle(const Scene& scene, Random& random) {
    const std::uint32_t instance = random.below(static_cast<std::uint32_t>(scene.instances.size()));
    const auto count = static_cast<std::uint32_t>(scene.instances[instance].data().triangles.size());
    return {instance, random.below(count)};
}

Scene scattered_spheres() {
    Random random(21);
    std::vector<Placed> placed;
    for (int i = 0; i < 12; ++i)
        placed.push_back(
            {make_sphere(1, random(0.1, 0.4)), skew_transform(i % 2 == 1, random.in_box({{-2, -2, -2}, {2, 2, 2}}))});
    return make_scene(placed, least_tables());
}

}  // namespace

TEST_CASE("the nearest hit over instances agrees with brute force in double precision", "[scene_rays]") {
    const Scene scene = scattered_spheres();
    const SceneRays rays(scene);
    Random random(22);
    int hits = 0;
    for (int i = 0; i < 2000; ++i) {
        const Vec3 o = random.in_box({{-3, -3, -3}, {3, 3, 3}}), d = random.in_box({{-2, -2, -2}, {2, 2, 2}}) - o;
        double nearest = std::numeric_limits<double>::infinity();
        bool undecided = false;  // near an edge float may choose either side
        for (const Instance& instance : scene.instances)
            for (std::uint32_t t = 0; t < instance.data().triangles.size(); ++t) {
                const TriangleCorners c = instance.world_corners(Face::make(t, Side::Front));
                const Vec3 e1 = c[1] - c[0], e2 = c[2] - c[0], h = cross(d, e2), s = o - c[0], q = cross(s, e1);
                const double det = dot(e1, h), u = dot(s, h) / det, v = dot(d, q) / det, at = dot(e2, q) / det;
                const double edge = std::min({u, v, 1 - u - v});
                undecided |= at > -1e-4 && std::abs(edge) < 1e-4;
                if (edge >= 0 && at > 0) nearest = std::min(nearest, at);
            }
        if (undecided) continue;
        const SceneHit hit = rays.first_hit(o, d);
        REQUIRE((hit.instance != kNoInstance) == std::isfinite(nearest));
        if (hit.instance == kNoInstance) continue;
        ++hits;
        const double tolerance = 1e-5 / length(d);  // some ten float roundings of coordinates up to 6
        CHECK(hit.t == Approx(nearest).margin(tolerance));
        const SceneTriangle on{hit.instance, hit.triangle};
        CHECK(length(point_on(scene, on, hit.b1, hit.b2) - (o + d * hit.t)) < 2e-5);
        CHECK((hit.side == Side::Front) == (dot(front_normal(scene, on), d) < 0));
    }
    CHECK(hits > 300);
}

TEST_CASE("a closed room does not leak, wherever a ray starts", "[scene_rays]") {
    const Vec3 at = GENERATE(Vec3{0, 0, 0}, Vec3{300, -20, 40});
    const bool mirrored = GENERATE(false, true);
    const Mesh room = turned_inside_out(make_box(5, 3, 4, 3));
    const Scene scene = make_scene({{room, skew_transform(mirrored, at)}}, least_tables());
    const SceneRays rays(scene);
    Random random(31);
    int escaped = 0, wrong_side = 0, in_own_plane = 0;
    for (int i = 0; i < 50000; ++i) {
        const SceneTriangle on = any_triangle(scene, random);
        const Vec3 normal = front_normal(scene, on);
        const SceneHit hit = rays.first_hit(any_point_on(scene, on, random), any_direction_above(normal, random), on);
        escaped += hit.instance == kNoInstance;
        if (hit.instance == kNoInstance) continue;
        wrong_side += hit.side != Side::Front;
        in_own_plane += dot(front_normal(scene, {hit.instance, hit.triangle}), normal) > 1 - 1e-6;
    }
    CHECK(escaped == 0);
    CHECK(wrong_side == 0);
    CHECK(in_own_plane == 0);
}

TEST_CASE("a flat surface of many triangles does not block its own rays", "[scene_rays]") {
    // Tilted, so that no coordinate of its plane is exact in float.
    const Scene scene = make_scene({{make_quad(2, 3, false, 20), skew_transform(false, {3, 4, 5})}}, least_tables());
    const SceneRays rays(scene);
    Random random(32);
    int blocked = 0;
    for (int i = 0; i < 50000; ++i) {
        const SceneTriangle on = any_triangle(scene, random);
        blocked +=
            rays.first_hit(any_point_on(scene, on, random), any_direction_above(front_normal(scene, on), random), on)
                .instance != kNoInstance;
    }
    CHECK(blocked == 0);
}

TEST_CASE("in an empty convex room every two points see each other", "[scene_rays]") {
    const Scene scene =
        make_scene({{turned_inside_out(make_box(5, 3, 4, 3)), skew_transform(true, {7, 8, 9})}}, least_tables());
    const SceneRays rays(scene);
    Random random(33);
    const Candidates all{0};
    int blocked = 0, compared = 0;
    for (int i = 0; i < 50000; ++i) {
        const SceneTriangle a = any_triangle(scene, random), b = any_triangle(scene, random);
        const Vec3 p = any_point_on(scene, a, random), q = any_point_on(scene, b, random), d = normalised(q - p);
        // Within 0.6 degrees of an end's surface, float may see a neighbour in the same plane as in between.
        if (dot(front_normal(scene, a), d) < 0.01 || -dot(front_normal(scene, b), d) < 0.01) continue;
        ++compared;
        blocked += rays.occluded(p, q, a, b, all);
    }
    CHECK(blocked == 0);
    CHECK(compared > 30000);
}

TEST_CASE("segments are blocked from both sides, single and in batches, through tree and list", "[scene_rays]") {
    const Scene scene = scattered_spheres();
    const SceneRays rays(scene);
    Random random(34);
    Candidates all, few;
    for (std::uint32_t i = 0; i < scene.instances.size(); ++i) all.push_back(i);
    const SceneTriangle a = any_triangle(scene, random), b = any_triangle(scene, random);
    std::vector<Vec3> p, q;
    for (int i = 0; i < 150; ++i) {  // more than two packs, not a multiple
        p.push_back(any_point_on(scene, a, random));
        q.push_back(random.in_box({{-3, -3, -3}, {3, 3, 3}}));
    }
    std::vector<std::uint8_t> blocked(p.size(), 7);
    rays.occluded(p, q, a, b, all, blocked);
    int count = 0, different = 0;
    for (std::size_t i = 0; i < p.size(); ++i) {
        const bool single = rays.occluded(p[i], q[i], a, b, all);
        different += single != (blocked[i] == 1);
        CHECK(blocked[i] <= 1);
        Box3 pb, qb;
        pb.add(p[i]), qb.add(q[i]);
        rays.candidates(pb, qb, few);
        CHECK(rays.occluded(p[i], q[i], a, b, few) == single);
        CHECK(rays.occluded(p[i], q[i], a, b) == single);
        count += single;
    }
    CHECK(different == 0);
    CHECK(count > 20);
    CHECK(count < 150);
}

TEST_CASE("the ends' own triangles do not block, others do", "[scene_rays]") {
    // Three unit squares in the planes y = 0, 1, 2.
    const Scene scene = make_scene(
        {{make_quad(1, 1)}, {make_quad(1, 1), translation({0, 1, 0})}, {make_quad(1, 1), translation({0, 2, 0})}},
        least_tables());
    const SceneRays rays(scene);
    const auto triangle_at = [&](double y) {
        const SceneHit hit = rays.first_hit({0.2, y + 0.5, 0.1}, {0, -1, 0});
        return SceneTriangle{hit.instance, hit.triangle};
    };
    const Vec3 p{0.2, 0, 0.1}, middle{0.2, 1, 0.1}, q{0.2, 2, 0.1};
    const Candidates all{0, 1, 2}, ends{0, 2};
    CHECK(triangle_at(1).instance == 1);
    CHECK(rays.occluded(p, q, triangle_at(0), triangle_at(2), all));
    CHECK(rays.occluded(q, p, triangle_at(2), triangle_at(0), all));
    CHECK_FALSE(rays.occluded(p, q, triangle_at(0), triangle_at(2), ends));
    CHECK_FALSE(rays.occluded(p, middle, triangle_at(0), triangle_at(1), all));
    CHECK_FALSE(rays.occluded(p, p, triangle_at(0), triangle_at(0), all));  // no length, nothing between
    CHECK(rays.occluded(p, q, triangle_at(0), triangle_at(2), {0, 2}));
    CHECK_FALSE(rays.occluded(p, q, triangle_at(0), triangle_at(2), {1, kNoInstance}));  // all of it is passed
    CHECK_FALSE(rays.occluded(p, q, triangle_at(0), triangle_at(2), {kNoInstance, 1}));
    CHECK(rays.first_hit(middle, {0, -1, 0}, triangle_at(1)).instance == 0);
}

TEST_CASE("candidates hold all instances that a shaft meets, and leave out those beside it", "[scene_rays]") {
    Random random(41);
    std::vector<Placed> placed;
    for (int i = 0; i < 40; ++i)
        placed.push_back({make_box(random(0.1, 0.5), random(0.1, 0.5), random(0.1, 0.5)),
                          translation(random.in_box({{-4, -4, -4}, {4, 4, 4}}))});
    const Scene scene = make_scene(placed, least_tables());
    const SceneRays rays(scene);
    std::size_t kept = 0, in_common_box = 0;
    Candidates found;
    for (int shaft = 0; shaft < 100; ++shaft) {
        Box3 a, b;
        for (int i = 0; i < 2; ++i) {
            a.add(random.in_box({{-4, -4, -4}, {-1, 4, 4}}));
            b.add(random.in_box({{0, -4, -4}, {4, 4, 4}}));
        }
        const auto shrink = [](Box3& box) { box.hi = box.lo + box.extent() * 0.2; };
        shrink(a), shrink(b);
        rays.candidates(a, b, found);
        CHECK(std::is_sorted(found.begin(), found.end()));
        Candidates cut;
        CHECK(rays.candidates(a, b, cut, found.size()));
        CHECK(cut == found);
        if (!found.empty()) CHECK_FALSE(rays.candidates(a, b, cut, found.size() - 1));
        kept += found.size();
        Box3 both = a;
        both.add(b);
        for (const Instance& instance : scene.instances) in_common_box += both.overlaps(instance.bounds);
        for (int i = 0; i < 200; ++i) {  // what any segment meets is listed
            const Vec3 p = random.in_box(a), q = random.in_box(b);
            for (std::uint32_t k = 0; k < scene.instances.size(); ++k) {
                const Vec3 at = p + (q - p) * random();
                if (scene.instances[k].bounds.contains(at)) CHECK(std::binary_search(found.begin(), found.end(), k));
            }
        }
    }
    // A shaft from corner to corner of its box fills a small part of it.
    CHECK(kept < in_common_box * 6 / 10);
    CHECK(kept > 0);
}

TEST_CASE("rays are as precise a million metres from the origin of the world", "[scene_rays]") {
    const Vec3 far{1e6, -2e6, 3e6};
    const Scene scene = make_scene({{make_quad(1, 1), translation(far)}}, least_tables());
    const SceneRays rays(scene);
    const SceneHit hit = rays.first_hit(far + Vec3{0.1, 2, 0.2}, {0, -4, 0});
    REQUIRE(hit.instance == 0);
    CHECK(hit.t == Approx(0.5).epsilon(1e-6));  // float in the local frame; in the world it could not tell 2 m from 2.1
    CHECK(hit.side == Side::Front);
}
