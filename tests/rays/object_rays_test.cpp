#include "format/rays/object_rays.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>

#include "format/parallel.h"

using namespace rro;

namespace {

struct Soup {
    std::vector<Vec3f> positions;
    std::vector<TriangleIndices> triangles;

    void add(Vec3f a, Vec3f b, Vec3f c) {
        const auto first = static_cast<std::uint32_t>(positions.size());
        positions.insert(positions.end(), {a, b, c});
        triangles.push_back({first, first + 1, first + 2});
    }
    ObjectRays rays() const { return {positions, triangles}; }
};

/// Large triangles in random positions of the unit cube: most rays meet several.
Soup random_soup(int count, std::uint32_t seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> u(0.0f, 1.0f);
    Soup soup;
    const auto point = [&] { return Vec3f{u(random), u(random), u(random)}; };
    for (int i = 0; i < count; ++i) {
        const Vec3f a = point(), b = point(), c = point();
        soup.add(a, b, c);
    }
    return soup;
}

/// k unit squares (two triangles each) in the planes z = 1 .. k, met by every ray along +z above the unit square.
Soup stack_of_squares(int k) {
    Soup soup;
    for (int i = 1; i <= k; ++i) {
        const auto z = static_cast<float>(i);
        soup.add({0, 0, z}, {1, 0, z}, {1, 1, z});
        soup.add({0, 0, z}, {1, 1, z}, {0, 1, z});
    }
    return soup;
}

std::vector<ObjectRay> random_rays(int count, std::uint32_t seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> u(-0.5f, 1.5f);
    std::vector<ObjectRay> rays;
    for (int i = 0; i < count; ++i) {
        const Vec3f p{u(random), u(random), u(random)}, q{u(random), u(random), u(random)};
        rays.push_back({p, {q.x - p.x, q.y - p.y, q.z - p.z}, 0, 1});
    }
    return rays;
}

struct BruteHit {
    double t = 0, edge = 0;  // edge: smallest barycentric coordinate, negative outside
};

/// Intersection with a triangle's plane in double precision [Moller 97].
BruteHit brute_force(const Soup& soup, std::size_t triangle, const ObjectRay& ray) {
    const TriangleIndices& t = soup.triangles[triangle];
    const Vec3 a = to_double(soup.positions[t[0]]), e1 = to_double(soup.positions[t[1]]) - a,
               e2 = to_double(soup.positions[t[2]]) - a;
    const Vec3 d = to_double(ray.direction), s = to_double(ray.origin) - a;
    const Vec3 h = cross(d, e2);
    const double det = dot(e1, h);
    const Vec3 q = cross(s, e1);
    const double u = dot(s, h) / det, v = dot(d, q) / det;
    return {dot(e2, q) / det, std::min({u, v, 1 - u - v})};
}

}  // namespace

TEST_CASE("the nearest hit and all hits agree with brute force over random triangles", "[rays]") {
    const Soup soup = random_soup(60, 1);
    const ObjectRays rays = soup.rays();
    // Hits within float rounding of an edge or of the segment's ends may fall either way: rays that have one are left
    // out. 1e-5 is some eighty float roundings at the size of the cube.
    constexpr double kUndecided = 1e-5;
    int compared = 0;
    for (const ObjectRay& ray : random_rays(2000, 2)) {
        std::vector<std::pair<double, std::uint32_t>> expected;
        bool undecided = false;
        for (std::uint32_t i = 0; i < soup.triangles.size(); ++i) {
            const BruteHit hit = brute_force(soup, i, ray);
            if (hit.edge < -kUndecided || hit.t < -kUndecided || hit.t > 1 + kUndecided) continue;
            undecided |= hit.edge < kUndecided || hit.t < kUndecided || hit.t > 1 - kUndecided;
            expected.push_back({hit.t, i});
        }
        if (undecided) continue;
        ++compared;
        std::sort(expected.begin(), expected.end());
        const ObjectHit nearest = rays.first_hit(ray);
        CHECK(rays.occluded(ray) == !expected.empty());
        if (expected.empty()) {
            CHECK(nearest.triangle == kNoTriangle);
        } else if (expected.size() == 1 || expected[1].first - expected[0].first > kUndecided) {
            CHECK(nearest.triangle == expected[0].second);
            // Float intersection of a triangle seen at a grazing angle loses some digits.
            CHECK(nearest.t == Approx(expected[0].first).margin(1e-4));
        }
    }
    CHECK(compared > 1800);
}

TEST_CASE("barycentric coordinates belong to corners 1 and 2", "[rays]") {
    Soup soup;
    soup.add({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    const ObjectHit hit = soup.rays().first_hit({{0.5f, 0.25f, 2}, {0, 0, -4}, 0, 1});
    REQUIRE(hit.triangle == 0);
    CHECK(hit.t == 0.5f);  // parameters count in lengths of the direction
    CHECK(hit.u == 0.5f);
    CHECK(hit.v == 0.25f);
}

TEST_CASE("batches give what single rays give", "[rays]") {
    const ObjectRays rays = random_soup(40, 3).rays();
    const std::vector<ObjectRay> list = random_rays(1003, 4);  // not a multiple of a packet
    IgnoredTriangles ignored;
    ignored.a = 5, ignored.range0_begin = 10, ignored.range0_end = 20;

    std::vector<std::uint8_t> blocked(list.size(), 0);
    rays.occluded(list, blocked, ignored);
    std::vector<ObjectHit> hits(list.size());
    rays.first_hits(list, hits);
    // Packets and single rays use different intersectors; they may part on a ray that grazes an edge: 1 in 1000.
    std::size_t different = 0;
    for (std::size_t i = 0; i < list.size(); ++i) {
        different += blocked[i] != rays.occluded(list[i], ignored);
        different += hits[i].triangle != rays.first_hit(list[i]).triangle;
    }
    CHECK(different <= 1);
    CHECK(std::count(blocked.begin(), blocked.end(), 1) > 100);
    CHECK(std::count(blocked.begin(), blocked.end(), 0) > 100);
}

TEST_CASE("a batch keeps rays that were blocked before", "[rays]") {
    const ObjectRays rays = stack_of_squares(1).rays();
    const ObjectRay through{{0.25f, 0.5f, 0}, {0, 0, 1}, 0, 2}, beside{{5, 5, 0}, {0, 0, 1}, 0, 2};
    const std::vector<ObjectRay> list{through, beside, beside, through};
    std::vector<std::uint8_t> blocked{0, 1, 0, 1};
    rays.occluded(list, blocked);
    CHECK(blocked == std::vector<std::uint8_t>{1, 1, 0, 1});
}

TEST_CASE("ignored triangles are passed through, by number and by range", "[rays]") {
    const ObjectRays rays = stack_of_squares(8).rays();  // square i: triangles 2i, 2i + 1; this ray meets the odd ones
    const ObjectRay ray{{0.25f, 0.5f, 0}, {0, 0, 1}, 0, 100};
    CHECK(rays.first_hit(ray).triangle == 1);
    IgnoredTriangles ignored;
    ignored.a = 1;
    CHECK(rays.first_hit(ray, ignored).triangle == 3);
    ignored.b = 3;
    CHECK(rays.first_hit(ray, ignored).triangle == 5);
    ignored.range0_begin = 4, ignored.range0_end = 8;
    CHECK(rays.first_hit(ray, ignored).triangle == 9);
    ignored.range1_begin = 9, ignored.range1_end = 16;
    CHECK(rays.first_hit(ray, ignored).triangle == kNoTriangle);
    CHECK_FALSE(rays.occluded(ray, ignored));
    ignored.range1_end = 15;  // half open: 15 is the last one
    CHECK(rays.first_hit(ray, ignored).triangle == 15);
    CHECK(rays.occluded(ray, ignored));
}

TEST_CASE("a closed surface does not leak through its edges and corners", "[rays]") {
    // A tetrahedron of which every ray from inside, aimed at points of its edges and at its corners, must meet a face.
    Soup soup;
    const Vec3f a{0, 0, 0}, b{1, 0, 0}, c{0, 1, 0}, d{0, 0, 1};
    soup.positions = {a, b, c, d};
    soup.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
    const ObjectRays rays = soup.rays();
    std::mt19937 random(7);
    std::uniform_real_distribution<float> u(0.0f, 1.0f);
    int leaks = 0;
    for (int i = 0; i < 20000; ++i) {
        const Vec3f p{0.1f + 0.15f * u(random), 0.1f + 0.15f * u(random), 0.1f + 0.15f * u(random)};
        const Vec3f end0 = soup.positions[random() % 4], end1 = soup.positions[random() % 4];
        const float s = u(random);
        const Vec3f target{end0.x + s * (end1.x - end0.x), end0.y + s * (end1.y - end0.y),
                           end0.z + s * (end1.z - end0.z)};
        leaks += !rays.occluded({p, {target.x - p.x, target.y - p.y, target.z - p.z}, 0, 10});
    }
    CHECK(leaks == 0);
}

TEST_CASE("which of two coinciding triangles is hit does not depend on threads or on other builds", "[rays]") {
    // Every triangle of a large soup three times: the order in which the tree is built alone decides.
    const Soup once = random_soup(3000, 11);
    Soup soup;
    for (int copy = 0; copy < 3; ++copy)
        for (const TriangleIndices& t : once.triangles)
            soup.add(once.positions[t[0]], once.positions[t[1]], once.positions[t[2]]);
    const std::vector<ObjectRay> list = random_rays(2000, 12);
    const auto built_with = [&](unsigned threads) {
        set_thread_count(threads);
        std::vector<std::vector<std::uint32_t>> hits(4);
        parallel_for(hits.size(), 1, [&](std::size_t i) {
            const ObjectRays rays = soup.rays();
            for (const ObjectRay& ray : list) hits[i].push_back(rays.first_hit(ray).triangle);
        });
        set_thread_count(0);
        return hits;
    };
    const auto alone = built_with(1), together = built_with(4);
    for (const auto& hits : together) CHECK(hits == alone[0]);
}

TEST_CASE("an object without triangles is met by no ray", "[rays]") {
    const ObjectRays rays{{}, {}};
    CHECK(rays.first_hit({{0, 0, 0}, {0, 0, 1}, 0, 1}).triangle == kNoTriangle);
    CHECK_FALSE(rays.occluded({{0, 0, 0}, {0, 0, 1}, 0, 1}));
}

TEST_CASE("memory is counted while objects live", "[rays]") {
    const Soup soup = random_soup(5000, 13);
    const std::uint64_t before = ObjectRays::memory_bytes();
    std::uint64_t during = 0;
    {
        const ObjectRays rays = soup.rays();
        during = ObjectRays::memory_bytes();
    }
    // At least the copies of positions and indices.
    CHECK(during - before >= soup.positions.size() * 12 + soup.triangles.size() * 12);
    CHECK(ObjectRays::memory_bytes() < during);
}
