// Form factors at the ends of what double precision can tell apart, against quadruple precision.
#include <catch2/catch.hpp>

#include <numbers>
#include <random>

#include "format/form_factor.h"
#include "tests/stability/record.h"
#include "tests/stability/wide.h"
#include "tests/support/polygons.h"

namespace rro::test {
namespace {

using std::numbers::pi;

struct Rectangle {
    Vec3 corner, u, v;  // front along u x v
    double area() const { return length(cross(u, v)); }
};

Polygon as_polygon(const Rectangle& r) {
    Polygon p = make_polygon({r.corner, r.corner + r.u, r.corner + r.u + r.v, r.corner + r.v}, 0);
    add_rules(p);
    return p;
}

double by_polygons(const Rectangle& a, const Rectangle& b) { return planar_exchange(as_polygon(a), as_polygon(b)); }

double by_triangles(const Rectangle& a, const Rectangle& b) {
    const auto halves = [](const Rectangle& r) {
        const Vec3 far = r.corner + r.u + r.v;
        return std::array{TriangleCorners{r.corner, r.corner + r.u, far}, TriangleCorners{r.corner, far, r.corner + r.v}};
    };
    double sum = 0;
    for (const TriangleCorners& s : halves(a))
        for (const TriangleCorners& t : halves(b)) sum += exchange_area(s, t);
    return sum;
}

/// On the plane z = 0, front up.
Rectangle floor_of(double x, double y, const Vec3& corner = {}) { return {corner, {x, 0, 0}, {0, y, 0}}; }
/// Over the floor at this height, front down.
Rectangle ceiling_of(double x, double y, double height) { return {{0, 0, height}, {0, y, 0}, {x, 0, 0}}; }
/// On the plane y = 0 over the floor's edge, front towards +y.
Rectangle wall_of(double x, double z, const Vec3& corner = {}) { return {corner, {0, 0, z}, {x, 0, 0}}; }

class Random {
  public:
    double unit() { return double(bits_() >> 11) * 0x1p-53; }
    double between(double low, double high) { return low + (high - low) * unit(); }
    double magnitude(double low, double high) { return std::pow(10.0, between(low, high)); }
    Vec3 point() { return {between(-1, 1), between(-1, 1), between(-1, 1)}; }
    Vec3 direction() {
        for (;;)
            if (const Vec3 p = point(); length2(p) <= 1 && length2(p) > 0.01) return normalised(p);
    }
    TriangleCorners triangle() { return {point(), point(), point()}; }

  private:
    std::mt19937_64 bits_{3};
};

/// Both kernels of pairs promise 1e-6 (format/form_factor.h, solver/factors/planar_kernel.h).
constexpr double kPromised = 1e-6;

void record_pair(const std::string& what, const std::string& law, const Rectangle& a, const Rectangle& b, double exchange,
                 double bound = kPromised, double triangles = kPromised) {
    Worst polygons, pairs;
    polygons.add_relative(by_polygons(a, b), exchange);
    polygons.add_relative(by_polygons(b, a), exchange);
    pairs.add_relative(by_triangles(a, b), exchange);
    pairs.add_relative(by_triangles(b, a), exchange);
    record("kernels", what + ", polygons", law, bound, polygons.value());
    record("kernels", what + ", triangles", law, triangles, pairs.value());
}

}  // namespace

TEST_CASE("squares that share an edge, at any ratio of their sides", "[stability][kernels]") {
    for (const double ratio : {1.0, 1e-2, 1e-4, 1e-6})
        for (const double other : {1.0, ratio}) {
            const double exchange = static_cast<double>(wide_corner_exchange(1, Wide(ratio), Wide(other)));
            // What happens at a needle's ends falls between the nodes of a rule: triangles keep 1e-3 (form_factor.h).
            record_pair(ratio < 1 ? "needles at right angles on a common edge, sides 1e-2 to 1e-6 of it"
                                  : "squares at right angles on a common edge",
                        "Howell C-14, either way round",
                        floor_of(1, ratio), wall_of(1, other), exchange, kPromised, ratio < 1 ? 1e-3 : kPromised);
        }
}

TEST_CASE("squares that touch at a corner", "[stability][kernels]") {
    // Two pairs side by side on one edge: the whole is two pairs with a common edge and two that touch at a corner.
    const Wide corner = (wide_corner_exchange(2, 1, 1) - 2 * wide_corner_exchange(1, 1, 1)) / 2;
    record_pair("unit squares at right angles that touch at a corner", "Howell C-14 by additivity", floor_of(1, 1),
                wall_of(1, 1, {1, 0, 0}), static_cast<double>(corner));
}

TEST_CASE("squares in one plane", "[stability][kernels]") {
    Worst worst;
    for (const Vec3& corner : {Vec3{1, 0, 0}, Vec3{1, 1, 0}, Vec3{-1, 0.3, 0}, Vec3{3, 5, 0}, Vec3{0.3, 0.3, 0}, Vec3{0, 0, 0}})
        for (const double side : {1.0, 1e-6, 1e6}) {
            const Rectangle a = floor_of(1, 1), b = floor_of(side, side, corner);
            for (const double f : {by_polygons(a, b), by_polygons(b, a), by_triangles(a, b), by_triangles(b, a)})
                worst.add(std::abs(f));
        }
    record("kernels", "coplanar squares, apart, touching, overlapping", "exchange nothing", 0, worst.value());
}

TEST_CASE("squares on an edge, all but coplanar", "[stability][kernels]") {
    // A F = (sin t)^2 C for small t, C = 1/pi of the integral of y y' / r^4 over both: below 1/4 (the strip's limit).
    Worst worst;
    for (const double t : {1e-9, 1e-8, 1e-6, 1e-4}) {
        const Rectangle a = floor_of(1, 1), b{{0, 0, 0}, {0, -std::cos(t), std::sin(t)}, {1, 0, 0}};
        for (const double f : {by_polygons(a, b), by_polygons(b, a), by_triangles(a, b), by_triangles(b, a)}) {
            worst.add(f - t * t / 4);
            worst.add(-f);
        }
    }
    // Where F is below 1e-12, no more is promised than that it is as small.
    record("kernels", "squares on a common edge, 1e-9 to 1e-4 off one plane", "0 <= A F <= t^2 / 4, excess in m^2", 1e-12,
           worst.value());
}

TEST_CASE("facing squares at distances from 1e-6 to 1e9", "[stability][kernels]") {
    for (const double d : {1e-6, 1e-4, 1e-2, 1.0, 1e2, 1e4, 1e6, 1e9}) {
        const double exchange = wide_facing(1, 1, d);
        const Rectangle a = floor_of(1, 1), b = ceiling_of(1, 1, d);
        // A gap of less than 1 % may cost the quadrature over triangles some 1e-3 (form_factor.h).
        if (d < 0.01)
            record_pair("all but coincident unit squares, 1e-6 and 1e-4 apart", "Howell C-11", a, b, exchange, kPromised, 5e-3);
        else
            record_pair("facing unit squares, 0.01 to 1e9 apart", "Howell C-11", a, b, exchange);
    }
}

TEST_CASE("a square and one of a millionth of its size", "[stability][kernels]") {
    // Over so small a square the factor of its centre is the mean up to (size / distance)^2.
    Random random;
    for (int k = 0; k < 20; ++k) {
        const double small = 1e-6, d = random.magnitude(-2, 2);
        const Rectangle a = floor_of(small, small, {random.unit(), random.unit(), 0}), b = ceiling_of(1, 1, d);
        const Vec3 centre = a.corner + 0.5 * (a.u + a.v);
        const std::vector<Vec3> corners{b.corner, b.corner + b.u, b.corner + b.u + b.v, b.corner + b.v};
        record_pair("a square 1e-6 wide under a unit square, 0.01 to 100 apart", "factor of its centre times its area", a, b,
                    a.area() * wide_point_factor(centre, {0, 0, 1}, corners));
    }
}

TEST_CASE("points and triangles of any size and distance", "[stability][kernels]") {
    // Rounding of corners relative to p is 1e-16 of the distance; a factor that faces both by more than g in the cosines
    // loses 1/g of it. Views within a hundredth of grazing are the next case.
    Random random;
    Worst worst, sums, vectors, scaled;
    int seen = 0;
    while (seen < 4000) {
        const double size = random.magnitude(-6, 3);
        TriangleCorners t = random.triangle();
        for (Vec3& c : t) c *= size;
        const Vec3 at = random.direction() * (size > 1 ? size : 1.0), n = random.direction();
        const Vec3 normal = normalised(area_vector(t)), to = normalised(-at);
        if (std::abs(dot(normal, to)) < 0.01 || std::abs(dot(n, to)) < 0.01) continue;
        // A needle's plane is known to 1e-16 of its length over its width.
        if (length(area_vector(t)) < 0.05 * size * size) continue;
        ++seen;
        const double expected = wide_point_factor(at, n, t), f = point_to_triangle(at, n, t);
        worst.add(std::abs(f - expected) / std::max(expected, 1e-6 * std::pow(std::min(size, 1.0), 2)));
        const Vec3 m = 0.5 * (t[0] + t[1]);
        const double halves = point_to_triangle(at, n, {t[0], m, t[2]}) + point_to_triangle(at, n, {m, t[1], t[2]});
        sums.add(std::abs(halves - f) / std::max(f, 1e-6 * std::pow(std::min(size, 1.0), 2)));
        const double lowest = std::min({dot(n, t[0] - at), dot(n, t[1] - at), dot(n, t[2] - at)});
        if (f > 0 && lowest > 0) vectors.add_relative(dot(n, polygon_vector_irradiance(at, t)), f);
        for (const double s : {0x1p-40, 0x1p40})
            scaled.add_relative(point_to_triangle(at * s, n, {t[0] * s, t[1] * s, t[2] * s}), f);
    }
    record("kernels", "a point and a triangle, sizes 1e-6 to 1e3 of the distance", "the contour formula in 113 bits", 1e-9,
           worst.value());
    record("kernels", "a triangle and its halves", "the sum of the parts is the whole", 1e-9, sums.value());
    record("kernels", "factor and vector irradiance", "F = n . V above the horizon", 1e-10, vectors.value());
    record("kernels", "all lengths times 2^40 and 2^-40", "the same factor", 0, scaled.value());
}

TEST_CASE("grazing to the last ulp", "[stability][kernels]") {
    // A point some ulps before, on or behind the plane of a square, or the square as much above its horizon. The plane and
    // the horizon are known to a few 1e-16, so F is right to that, absolutely.
    Random random;
    Worst worst;
    const std::vector<Vec3> square{{1, -0.5, -0.5}, {2, -0.5, -0.5}, {2, -0.5, 0.5}, {1, -0.5, 0.5}};  // front towards -y
    for (int k = 0; k < 2000; ++k) {
        double y = -0.5;
        for (int ulps = static_cast<int>(random.between(-5, 5)), step = 0; step < std::abs(ulps); ++step)
            y = std::nextafter(y, ulps < 0 ? -1.0 : 0.0);
        const Vec3 p{0, y, random.between(-1, 1)}, n = random.direction();
        for (const double f : {point_to_polygon(p, n, square), point_to_triangle(p, n, {square[0], square[1], square[2]}) +
                                                                   point_to_triangle(p, n, {square[0], square[2], square[3]})})
            worst.add(std::abs(f - wide_point_factor(p, n, square)));
        // The same square seen from below, where it rises over the horizon by some ulps.
        const double rise = static_cast<int>(random.between(-5, 5)) * 0x1p-53;
        const Vec3 below{0, -2, 0}, tilted = normalised({0.0, 1.0, 0.0});
        std::vector<Vec3> low{{1, -2 + rise, -0.5}, {1, -2 + rise, 0.5}, {1, -2.5, 0.5}, {1, -2.5, -0.5}};
        worst.add(std::abs(point_to_polygon(below, tilted, low) - wide_point_factor(below, tilted, low)));
    }
    record("kernels", "points within 5 ulps of a polygon's plane, polygons within 5 ulps of the horizon",
           "the contour formula in 113 bits, absolute", 4e-15, worst.value());
}

TEST_CASE("far triangles that the horizon cuts", "[stability][kernels]") {
    // Heights over the horizon are known to 1e-16 of the distance, so that F is right to that times the area.
    Random random;
    Worst worst;
    int cut = 0;
    while (cut < 1000) {
        const double size = random.magnitude(-5, -2);
        TriangleCorners t = random.triangle();
        for (Vec3& c : t) c = c * size + Vec3{1, 0, 0};
        const Vec3 n = normalised({random.between(-1, 1) * size, random.between(-1, 1), random.between(-1, 1)});
        const double low = std::min({dot(n, t[0]), dot(n, t[1]), dot(n, t[2])}), high = std::max({dot(n, t[0]), dot(n, t[1]), dot(n, t[2])});
        if (!(low < 0 && high > 0)) continue;
        ++cut;
        worst.add(std::abs(point_to_triangle({}, n, t) - wide_point_factor({}, n, t)) / (size * size * size));
    }
    record("kernels", "far triangles across the horizon, sizes 1e-5 to 1e-2", "the contour formula in 113 bits, over size^3", 1e-9, worst.value());
}

TEST_CASE("disks of radii from 1e-12 to 1e12 of their distance", "[stability][kernels]") {
    Worst factor, reciprocity, monotony;
    for (int i = -12; i <= 12; ++i)
        for (int j = -12; j <= 12; ++j) {
            const double r1 = std::pow(10.0, i), r2 = 0.7 * std::pow(10.0, j), f = disk_to_disk(r1, r2);
            factor.add_relative(f, wide_disks(r1, r2));
            reciprocity.add_relative(r1 * r1 * f, r2 * r2 * disk_to_disk(r2, r1));
            monotony.add(f - disk_to_disk(r1, 1.001 * r2));
            monotony.add(disk_to_disk(1.001 * r1, r2) - f);
            monotony.add(f - 1);
            monotony.add(-f);
        }
    record("kernels", "coaxial disks, radii 1e-12 to 1e12", "Howell C-41 in 113 bits", 2e-15, factor.value());
    record("kernels", "coaxial disks, radii 1e-12 to 1e12", "A1 F12 = A2 F21", 2e-15, reciprocity.value());
    // The last bit may go either way where a disk covers all there is.
    record("kernels", "coaxial disks, radii 1e-12 to 1e12", "0 <= F <= 1, more with R2, less with R1; excess", 3e-16,
           monotony.value());
}

TEST_CASE("random triangles: reciprocity, bounds, parts", "[stability][kernels]") {
    // The two kernels share nothing but the point's factor: one integrates over triangles, the other along contours.
    Random random;
    Worst kernels, reciprocity, bounds, parts;
    const auto polygon_of = [](const TriangleCorners& t) {
        Polygon p = make_polygon({t[0], t[1], t[2]}, 0);
        add_rules(p);
        return p;
    };
    for (int k = 0; k < 60; ++k) {
        const double size = random.magnitude(-3, 0);
        TriangleCorners a = random.triangle(), b = random.triangle();
        for (Vec3& c : b) c = c * size + Vec3{1.5 + random.unit(), 0, 0};
        const double smaller = std::min(length(area_vector(a)), length(area_vector(b)));
        const Polygon pa = polygon_of(a), pb = polygon_of(b);
        const double f = planar_exchange(pa, pb), triangles = exchange_area(a, b);
        // Cut by the other's horizon, either side may be left with next to nothing.
        const double from = std::max(f, 1e-6 * smaller);
        kernels.add(std::abs(triangles - f) / from);
        reciprocity.add(std::abs(planar_exchange(pb, pa) - f) / from);
        bounds.add(std::max(f, triangles) / smaller - 1);
        bounds.add(-std::min(f, triangles));
        const Vec3 m = 0.5 * (b[0] + b[1]);
        parts.add((exchange_area(a, {b[0], m, b[2]}) - triangles) / from);
        parts.add((planar_exchange(pa, polygon_of({b[0], m, b[2]})) - f) / from);
    }
    record("kernels", "random pairs of triangles, sizes 1e-3 to 1", "both kernels of pairs agree", 2 * kPromised, kernels.value());
    record("kernels", "random pairs of triangles, sizes 1e-3 to 1", "A1 F12 = A2 F21", 2 * kPromised, reciprocity.value());
    record("kernels", "random pairs of triangles, sizes 1e-3 to 1", "0 <= A F <= the smaller area; excess", 0, bounds.value());
    record("kernels", "random pairs of triangles, sizes 1e-3 to 1", "a part receives no more than the whole; excess",
           2 * kPromised, parts.value());
}

}  // namespace rro::test
