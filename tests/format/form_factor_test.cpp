#include "format/form_factor.h"

#include <catch2/catch.hpp>
#include <numbers>
#include <random>
#include <vector>

#include "format/sample_points.h"

using namespace rro;

namespace {

using std::numbers::pi;
using Quad = std::array<Vec3, 4>;
using Wide = long double;

/// The parallelogram at `corner`; its front is along u x v.
Quad parallelogram(const Vec3& corner, const Vec3& u, const Vec3& v) {
    return {corner, corner + u, corner + u + v, corner + v};
}

std::array<TriangleCorners, 2> triangles_of(const Quad& q) {
    return {{{q[0], q[1], q[2]}, {q[0], q[2], q[3]}}};
}

Quad scaled(Quad q, double s) {
    for (Vec3& c : q) c *= s;
    return q;
}

double area_of(const Quad& q) {
    return length(cross(q[1] - q[0], q[3] - q[0]));
}

/// Form factor of two parallelograms from the sum over pairs of their triangles.
double form_factor(const Quad& a, const Quad& b) {
    double sum = 0;
    for (const TriangleCorners& s : triangles_of(a))
        for (const TriangleCorners& t : triangles_of(b)) sum += exchange_area(s, t);
    return sum / area_of(a);
}

Quad floor_square() {
    return parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
}
Quad facing_square(double dx, double dy) {
    return parallelogram({dx, dy, 1}, {0, 1, 0}, {1, 0, 0});
}

/// The square over the floor's edge y = 0, open by `angle`.
Quad inclined_square(double angle) {
    return parallelogram({0, 0, 0}, {0, std::cos(angle), std::sin(angle)}, {1, 0, 0});
}

/// The six inward walls of the unit cube.
std::vector<Quad> room() {
    return {parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), parallelogram({0, 0, 1}, {0, 1, 0}, {1, 0, 0}),
            parallelogram({0, 0, 0}, {0, 1, 0}, {0, 0, 1}), parallelogram({1, 0, 0}, {0, 0, 1}, {0, 1, 0}),
            parallelogram({0, 0, 0}, {0, 0, 1}, {1, 0, 0}), parallelogram({0, 1, 0}, {1, 0, 0}, {0, 0, 1})};
}

class Random {
  public:
    explicit Random(std::uint64_t seed) : engine_(seed) {}
    double signed_unit() { return 2 * unit() - 1; }
    double unit() { return std::uniform_real_distribution<double>(0, 1)(engine_); }
    Vec3 point() { return {signed_unit(), signed_unit(), signed_unit()}; }
    Vec3 direction() {
        std::normal_distribution<double> normal;
        return normalised({normal(engine_), normal(engine_), normal(engine_)});
    }
    TriangleCorners triangle(double size) { return {point() * size, point() * size, point() * size}; }

  private:
    std::mt19937_64 engine_;
};

struct WideVec {
    Wide x, y, z;
};
WideVec wide(const Vec3& a) {
    return {a.x, a.y, a.z};
}
WideVec operator-(const WideVec& a, const WideVec& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
WideVec operator+(const WideVec& a, const WideVec& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
WideVec operator*(const WideVec& a, Wide s) {
    return {a.x * s, a.y * s, a.z * s};
}
Wide wide_dot(const WideVec& a, const WideVec& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
WideVec wide_cross(const WideVec& a, const WideVec& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// Lambert's formula as the books print it, in 64 bits of mantissa.
double reference(const Vec3& p, const Vec3& n, const TriangleCorners& t) {
    const std::array<WideVec, 3> v{wide(t[0]) - wide(p), wide(t[1]) - wide(p), wide(t[2]) - wide(p)};
    if (wide_dot(wide_cross(v[1] - v[0], v[2] - v[0]), v[0]) >= 0) return 0;
    std::vector<WideVec> above;
    for (std::size_t i = 0; i < 3; ++i) {
        const WideVec &a = v[i], &b = v[(i + 1) % 3];
        const Wide ha = wide_dot(wide(n), a), hb = wide_dot(wide(n), b);
        if (ha > 0) above.push_back(a);
        if ((ha > 0) != (hb > 0)) above.push_back(a + (b - a) * (ha / (ha - hb)));
    }
    Wide sum = 0;
    for (std::size_t i = 0; i < above.size(); ++i) {
        const WideVec &a = above[i], &b = above[(i + 1) % above.size()];
        const WideVec c = wide_cross(b, a);
        const Wide s = std::sqrt(wide_dot(c, c));
        if (s > 0) sum += wide_dot(wide(n), c) / s * std::atan2(s, wide_dot(a, b));
    }
    return static_cast<double>(sum / (2 * std::numbers::pi_v<Wide>));
}

/// Lambert's double integral by a fine midpoint rule, in 64 bits: for tiny polygons, where the contour cancels.
double area_reference(const Vec3& p, const Vec3& n, const TriangleCorners& t) {
    constexpr int kCells = 40;
    const WideVec v = wide(t[0]) - wide(p), e1 = wide(t[1]) - wide(t[0]), e2 = wide(t[2]) - wide(t[0]);
    const WideVec normal = wide_cross(e1, e2);
    Wide sum = 0;
    for (int i = 0; i < kCells; ++i)
        for (int j = 0; i + j < kCells; ++j)
            for (const Wide third : {Wide(1) / 3, Wide(2) / 3}) {
                if (third > 0.5L && i + j + 1 == kCells) continue;
                const WideVec w = v + e1 * ((i + third) / kCells) + e2 * ((j + third) / kCells);
                const Wide r2 = wide_dot(w, w);
                sum += std::max(Wide(0), wide_dot(wide(n), w)) * -wide_dot(normal, v) / (r2 * r2);
            }
    return static_cast<double>(sum / (2 * kCells * kCells * std::numbers::pi_v<Wide>));
}

}  // namespace

TEST_CASE("facing, adjacent, inclined and shifted squares have their closed-form factors", "[format][form_factor]") {
    // Howell C-11, C-14, C-16; derived twice. Asked for 1e-6; corners that touch converge slowest.
    struct Case {
        const char* name;
        Quad other;
        double exact;
    };
    for (const Case& c : {Case{"facing", facing_square(0, 0), 0.199824895698387},
                          Case{"common edge, 90 degrees", inclined_square(pi / 2), 0.200043776075403},
                          Case{"common edge, 45 degrees", inclined_square(pi / 4), 0.483347695478878},
                          Case{"common edge, 60 degrees", inclined_square(pi / 3), 0.370905321150051},
                          Case{"common edge, 120 degrees", inclined_square(2 * pi / 3), 0.0866150011182761},
                          Case{"shifted by (1, 0)", facing_square(1, 0), 0.0860504891523273},
                          Case{"shifted by (1, 1)", facing_square(1, 1), 0.0433274095741047}}) {
        INFO(c.name);
        CHECK(std::abs(form_factor(floor_square(), c.other) / c.exact - 1) < 1e-6);
        CHECK(std::abs(form_factor(c.other, floor_square()) / c.exact - 1) < 1e-6);
    }
}

TEST_CASE("a point on the axis of a square, and a point beside it", "[format][form_factor]") {
    const Quad above = facing_square(0, 0);
    CHECK(point_to_polygon({0.5, 0.5, 0}, {0, 0, 1}, above) == Approx(0.239456470460774).epsilon(1e-14));
    const auto [s, t] = triangles_of(above);
    CHECK(point_to_triangle({0.5, 0.5, 0}, {0, 0, 1}, s) + point_to_triangle({0.5, 0.5, 0}, {0, 0, 1}, t) ==
          Approx(0.239456470460774).epsilon(1e-14));
    CHECK(point_to_polygon({0.5, 0.5, 0}, {0, 0, -1}, above) == 0);  // below the horizon
    CHECK(point_to_polygon({0.5, 0.5, 2}, {0, 0, -1}, above) == 0);  // from behind
    CHECK(point_to_polygon({0.5, 0.5, 1}, {0, 0, 1}, above) == 0);   // on the plane, inside
    CHECK(point_to_polygon({2.5, 0.5, 1}, {-1, 0, 0}, above) == 0);  // on the plane, outside
    CHECK(point_to_polygon({0.5, 0.5, 0}, {0, 0, 1}, {}) == 0);      // no polygon at all
    CHECK(point_to_polygon({0, 0, 0}, {0, 0, 1}, std::array{Vec3{1, 0, 1}, Vec3{2, 0, 1}, Vec3{3, 0, 1}}) == 0);
}

TEST_CASE("the triangle kernel agrees with the book's formula in long double", "[format][form_factor]") {
    // Both clip, so clipped, near, middle and far views are all met. Each Gamma, at most about as long as `size`, is
    // rounded to some 1e-16 of itself, which a grazing view is left with; the area form of far views errs by 1e-12.
    Random random(1);
    for (const double size : {100.0, 10.0, 1.0, 0.3, 0.1, 0.03, 0.01}) {
        const double margin = 3e-15 * std::min(1.0, size);
        for (int i = 0; i < 5000; ++i) {
            const TriangleCorners t = random.triangle(size);
            const Vec3 p = random.direction(), n = random.direction();
            const double f = point_to_triangle(p, n, t);
            REQUIRE(f == Approx(reference(p, n, t)).epsilon(1e-11).margin(margin));
            REQUIRE(point_to_polygon(p, n, t) == Approx(f).epsilon(1e-11).margin(margin));
        }
    }
}

TEST_CASE("tiny far triangles keep nine digits", "[format][form_factor]") {
    // Solid angles from 1e-6 to 1e-12, where the contour formula in double cancels 6 to 12 digits. The midpoint rule of
    // 1600 cells errs by (size / 40)^2; grazing views within 1 % of a right angle are left out, as in them the
    // triangle's plane is only given to 1e-16 / size by its corners.
    Random random(2);
    for (const double size : {1e-3, 1e-4, 1e-5, 1e-6})
        for (int i = 0; i < 100; ++i) {
            const Vec3 p = random.direction() * (1 + random.unit()), n = random.direction();
            const TriangleCorners t = random.triangle(size);
            const Vec3 to = normalised(p), normal = normalised(area_vector(t));
            if (dot(to, normal) < 0.01 || std::abs(dot(n, to)) < 0.01) continue;
            REQUIRE(point_to_triangle(p, n, t) == Approx(area_reference(p, n, t)).epsilon(2e-3 * size * size + 1e-12));
        }
}

TEST_CASE("a far triangle cut by the horizon keeps its digits", "[format][form_factor]") {
    // The right triangle of legs s with its hypotenuse end on the horizon: only heights decide, and the area form is
    // linear in them. Corner heights -s/2, s/2, s/2 leave 3/4 of the area at mean height 5 s / 18.
    for (const double s : {1e-3, 1e-6, 1e-9}) {
        const TriangleCorners t{Vec3{1, 0, -s / 2}, Vec3{1, s, s / 2}, Vec3{1, 0, s / 2}};
        const TriangleCorners turned{t[0], t[2], t[1]};
        const bool faces = area_vector(t).x < 0;
        const double exact = 0.75 * (s * s / 2) * (5 * s / 18) / pi;
        CHECK(point_to_triangle({0, 0, 0}, {0, 0, 1}, faces ? t : turned) == Approx(exact).epsilon(2 * s * s + 1e-14));
        CHECK(point_to_triangle({0, 0, 0}, {0, 0, 1}, faces ? turned : t) == 0);
    }
}

TEST_CASE("a polygon is the sum of its triangles, also when it is not convex", "[format][form_factor]") {
    // An arrow head: the fan from its first corner overlaps itself, the contour does not care.
    const std::vector<Vec3> arrow{{-1, -1, 1}, {0, 1, 1}, {1, -1, 1}, {0, -0.5, 1}};
    Random random(3);
    for (const double scale : {1.0, 1e-3}) {  // near and far
        for (int i = 0; i < 500; ++i) {
            const Vec3 p = random.point() * 0.9, n = random.direction();
            std::vector<Vec3> small;
            for (const Vec3& c : arrow) small.push_back({c.x * scale, c.y * scale, 1});
            const TriangleCorners l{small[0], small[1], small[3]}, r{small[1], small[2], small[3]};
            const double sum = point_to_triangle(p, n, l) + point_to_triangle(p, n, r);
            REQUIRE(point_to_polygon(p, n, small) == Approx(sum).epsilon(1e-10).margin(1e-15 * scale));
        }
    }
}

TEST_CASE("seen from inside, the walls of a closed room fill the hemisphere", "[format][form_factor]") {
    Random random(4);
    const auto walls = room();
    const auto total = [&](const Vec3& p, const Vec3& n) {
        double sum = 0;
        for (const Quad& w : walls)
            for (const TriangleCorners& t : triangles_of(w)) sum += point_to_triangle(p, n, t);
        return sum;
    };
    const auto total_of_quads = [&](const Vec3& p, const Vec3& n) {
        double sum = 0;
        for (const Quad& w : walls) sum += point_to_polygon(p, n, w);
        return sum;
    };
    SECTION("anywhere") {
        for (int i = 0; i < 2000; ++i) {
            const Vec3 p{random.unit(), random.unit(), random.unit()}, n = random.direction();
            REQUIRE(total(p, n) == Approx(1).margin(1e-12));
            REQUIRE(total_of_quads(p, n) == Approx(1).margin(1e-12));
        }
    }
    SECTION("on a wall, facing inwards") {
        for (int i = 0; i < 2000; ++i) {
            const Vec3 p{random.unit(), random.unit(), 0};
            REQUIRE(total(p, {0, 0, 1}) == Approx(1).margin(1e-12));
            REQUIRE(total_of_quads(p, {0, 0, 1}) == Approx(1).margin(1e-12));
        }
    }
    SECTION("close to an edge and to a corner") {
        // The direction to an edge at distance d is known to 1e-16 / d.
        for (const double d : {1e-2, 1e-4, 1e-6, 1e-9, 1e-12}) {
            const double margin = 1e-14 + 1e-14 / d * 1e-2;
            CHECK(total({d, 0.37, 0}, {0, 0, 1}) == Approx(1).margin(margin));
            CHECK(total({d, 0.37, 2 * d}, normalised({1, 2, 3})) == Approx(1).margin(margin));
            CHECK(total({d, 2 * d, 0}, {0, 0, 1}) == Approx(1).margin(margin));
            CHECK(total_of_quads({d, 2 * d, 3 * d}, normalised({3, 1, 2})) == Approx(1).margin(margin));
        }
    }
}

TEST_CASE("a point on an edge or corner sees what a point just in front of it sees", "[format][form_factor]") {
    const Quad wall = parallelogram({0, 0, 0}, {0, 1, 0}, {0, 0, 1});                     // x = 0, front +x
    CHECK(point_to_polygon({0, 0.5, 0}, {0, 0, 1}, wall) == Approx(0.5).epsilon(1e-14));  // a floor up to the wall
    CHECK(point_to_polygon({0, 0, 0}, {0, 0, 1}, wall) == Approx(0.25).epsilon(1e-14));   // the room's corner
    CHECK(point_to_polygon({0, 1.5, 0}, {0, 0, 1}, wall) == 0);  // on the edge's line, beyond its end

    // The same floor and wall in any position: heights above the horizon that should be 0 are now rounding.
    Random random(5);
    for (int i = 0; i < 200; ++i) {
        const Vec3 y = random.direction(), x = normalised(cross(y, random.direction())), z = cross(x, y);
        const Vec3 origin = random.point();
        const Quad turned = parallelogram(origin, y, z);
        const double s = 0.1 + 0.8 * random.unit();
        REQUIRE(point_to_polygon(origin + y * s, z, turned) == Approx(0.5).epsilon(1e-12));
        REQUIRE(point_to_polygon(origin, z, turned) == Approx(0.25).epsilon(1e-12));
    }

    const double off = 1e-8;  // the view changes by about this much over this distance
    for (int i = 0; i < 200; ++i) {
        const TriangleCorners t = random.triangle(1);
        const Vec3 n = random.direction(), up = normalised(area_vector(t));
        if (length(area_vector(t)) < 0.1) continue;
        const double s = 0.1 + 0.8 * random.unit();
        for (const Vec3& p : {t[0], t[2], t[0] + (t[1] - t[0]) * s, t[2] + (t[0] - t[2]) * s}) {
            const double limit = point_to_triangle(p + up * off, n, t);
            REQUIRE(point_to_triangle(p, n, t) == Approx(limit).margin(1e-6));
            REQUIRE(point_to_polygon(p, n, t) == Approx(limit).margin(1e-6));
        }
    }
}

TEST_CASE("coming closer to a wall's edge, a floor sees more of it without a jump", "[format][form_factor]") {
    const Quad wall = parallelogram({0, -1, 0}, {0, 2, 0}, {0, 0, 1});
    double last = 0;
    for (double d = 1; d > 1e-15; d /= 2) {
        const double f = point_to_polygon({d, 0, 0}, {0, 0, 1}, wall);
        REQUIRE(f >= last);
        REQUIRE(f <= 0.5);
        last = f;
    }
    CHECK(last == Approx(0.5).margin(1e-12));
}

TEST_CASE("hard input gives a share, never NaN", "[format][form_factor]") {
    Random random(6);
    const auto hard = [&random] {  // sizes over 20 decades, with exact zeros, ones and repeated numbers among them
        const double pick = random.unit();
        if (pick < 0.2) return 0.0;
        if (pick < 0.4) return random.signed_unit() < 0 ? -1.0 : 1.0;
        return random.signed_unit() * std::pow(10.0, -10 + 20 * random.unit());
    };
    const auto hard_point = [&] { return Vec3{hard(), hard(), hard()}; };
    for (int i = 0; i < 100000; ++i) {
        TriangleCorners t{hard_point(), hard_point(), hard_point()};
        Vec3 p = hard_point(), n = normalised(hard_point());
        const int kind = i % 8;
        if (kind == 1) p = t[0];
        if (kind == 2) p = triangle_point(t, random.unit(), 0);
        if (kind == 3) p = triangle_point(t, 0.3, 0.3);
        if (kind == 4) p = triangle_point(t, 1 + random.unit(), 0);
        if (kind == 5) n = normalised(area_vector(t));
        if (kind == 6) n = normalised(t[1] - p);
        if (kind == 7) t[2] = t[0] + (t[1] - t[0]) * random.unit();
        const double f = point_to_triangle(p, n, t);
        REQUIRE((f >= 0 && f <= 1));
        const double g = point_to_polygon(p, n, std::array{t[0], t[1], t[2], hard_point()});
        REQUIRE((g >= 0 && g <= 1));
        REQUIRE(is_finite(polygon_vector_irradiance(p, t)));
    }
}

TEST_CASE("form factors do not depend on the unit of length", "[format][form_factor]") {
    Random random(7);
    for (int i = 0; i < 1000; ++i) {
        const TriangleCorners t = random.triangle(i % 2 ? 1.0 : 0.01);
        const Vec3 p = random.direction(), n = random.direction();
        const double f = point_to_triangle(p, n, t);
        for (const double s : {1e-6, 1e-3, 1e3, 1e6}) {
            const double g = point_to_triangle(p * s, n, {t[0] * s, t[1] * s, t[2] * s});
            REQUIRE(g == Approx(f).epsilon(1e-10).margin(1e-15));  // corners are rounded anew at each scale
        }
    }
    for (const double s : {1e-6, 1e6})
        CHECK(form_factor(scaled(floor_square(), s), scaled(inclined_square(pi / 2), s)) ==
              Approx(0.200043776075403).epsilon(1e-6));
}

TEST_CASE("a huge polygon is a half space", "[format][form_factor]") {
    // A ceiling of half width w at height 1 misses pi / w^2 or so of the hemisphere's projection.
    for (const double w : {1e3, 1e6, 1e9}) {
        const Quad ceiling = parallelogram({-w, -w, 1}, {0, 2 * w, 0}, {2 * w, 0, 0});
        CHECK(point_to_polygon({0, 0, 0}, {0, 0, 1}, ceiling) == Approx(1).margin(4 / (w * w) + 1e-14));
        CHECK(point_to_polygon({0, 0, 0}, {1, 0, 0}, ceiling) == Approx(0.5).margin(2 / w + 1e-14));
    }
}

TEST_CASE("exchange areas are reciprocal and stay within both areas", "[format][form_factor]") {
    // The two ways err independently, by about the tolerance of 1e-6 each; what stops the refinement is an estimate, not
    // a bound, hence ten times that. Triangles may pierce each other, or share an edge or a corner.
    Random random(8);
    int seen = 0;
    for (int i = 0; i < 150; ++i) {
        const TriangleCorners a = random.triangle(1);
        TriangleCorners b = random.triangle(1);
        if (i % 3 == 1) b = {a[1], a[0], b[2]};
        if (i % 3 == 2) b[1] = a[2];
        const double ab = exchange_area(a, b), ba = exchange_area(b, a);
        REQUIRE(ab == Approx(ba).epsilon(1e-5).margin(1e-12));
        REQUIRE(ab <= length(area_vector(a)) * (1 + 1e-12));
        REQUIRE(ab <= length(area_vector(b)) * (1 + 1e-5));
        seen += ab > 0;
    }
    CHECK(seen > 50);
}

TEST_CASE("exchange areas in a regular tetrahedron close", "[format][form_factor]") {
    // By symmetry each face sends a third to each other; sums over a closed body are 1.
    const std::array<Vec3, 4> v{Vec3{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
    const TriangleCorners a{v[0], v[2], v[1]}, b{v[0], v[1], v[3]};
    const bool inwards = dot(area_vector(a), a[0]) < 0;
    REQUIRE(inwards == (dot(area_vector(b), b[0]) < 0));
    const auto in = [inwards](const TriangleCorners& t) { return inwards ? t : TriangleCorners{t[0], t[2], t[1]}; };
    CHECK(exchange_area(in(a), in(b)) / length(area_vector(a)) == Approx(1.0 / 3).epsilon(1e-6));
    CHECK(exchange_area(a, a) == 0);
    CHECK(exchange_area(in(a), {in(b)[0], in(b)[2], in(b)[1]}) == 0);  // its back
}

TEST_CASE("the vector irradiance gives every form factor whose polygon is above the horizon", "[format][form_factor]") {
    Random random(9);
    int tried = 0;
    for (const double size : {1.0, 0.1, 0.01, 1e-4, 1e-6})
        for (int i = 0; i < 2000; ++i) {
            const Vec3 p = random.direction() * 2, n = random.direction();
            const Vec3 c = random.point() * size, u = random.point() * size, v = random.point() * size;
            const Quad q = parallelogram(c, u, v);
            bool above = true;
            for (const Vec3& corner : q) above = above && dot(n, corner - p) > 0;
            if (!above) continue;
            ++tried;
            const double f = point_to_polygon(p, n, q);
            REQUIRE(dot(n, polygon_vector_irradiance(p, q)) == Approx(f).epsilon(1e-12).margin(1e-15 * size * size));
        }
    CHECK(tried > 3000);

    const Quad above = facing_square(0, 0);
    CHECK(length(polygon_vector_irradiance({0.5, 0.5, 2}, above)) == 0);  // from behind
    CHECK(length(polygon_vector_irradiance({0.5, 0.5, 1}, above)) == 0);  // on it
    const Vec3 corner = polygon_vector_irradiance({0, 0, 1}, above);      // a quarter of each of three half circles
    CHECK(length(corner - Vec3{0.25, 0.25, 0.25}) < 1e-15);
}

TEST_CASE("coaxial disks have their closed form over all ratios", "[format][form_factor]") {
    CHECK(disk_to_disk(1, 1) == Approx((3 - std::sqrt(5.0)) / 2).epsilon(1e-15));
    CHECK(disk_to_disk(1, 2) == Approx(0.763932022500210).epsilon(1e-15));
    CHECK(disk_to_disk(1, 0) == 0);
    CHECK(disk_to_disk(0, 1) == Approx(0.5).epsilon(1e-15));
    for (int i = -12; i <= 12; ++i)
        for (int j = -12; j <= 12; ++j)
            for (const double factor : {1.0, 1.7, 5.3}) {
                const double r1 = factor * std::pow(10.0, i), r2 = std::pow(10.0, j) / factor;
                const Wide a = r1, b = r2, y = 1 + a * a + b * b;
                // (1 + (a-b)^2)(1 + (a+b)^2) = y^2 - 4 a^2 b^2, which cancels when a and b are large and equal.
                const Wide root = std::sqrt((1 + (a - b) * (a - b)) * (1 + (a + b) * (a + b)));
                INFO("r1 " << r1 << ", r2 " << r2);
                REQUIRE(std::abs(disk_to_disk(r1, r2) / static_cast<double>(2 * b * b / (y + root)) - 1) < 2e-15);
                // Reciprocity: area times factor is the same both ways.
                REQUIRE(disk_to_disk(r1, r2) * r1 * r1 == Approx(disk_to_disk(r2, r1) * r2 * r2).epsilon(2e-15));
            }
}
