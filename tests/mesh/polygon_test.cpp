#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "compiler/mesh_polygon.h"

using namespace rro;

namespace {

using Triples = std::vector<std::array<std::uint32_t, 3>>;

PolygonTriangles triangulated(const std::vector<Vec3>& polygon) {
    std::uint64_t steps = 1'000'000;
    auto cut = triangulate_polygon(polygon, steps);
    REQUIRE(cut);
    return *std::move(cut);
}

/// Sum of signed areas about +z, and of absolute ones: equal where no triangle is turned over or overlaps.
struct Areas {
    double signed_sum = 0, absolute = 0;
};

Areas areas(const std::vector<Vec3>& polygon) {
    const PolygonTriangles cut = triangulated(polygon);
    REQUIRE(cut.triangles.size() == polygon.size() - 2);
    Areas sum;
    for (const auto& [a, b, c] : cut.triangles) {
        const Vec3 area = area_vector(polygon[a], polygon[b], polygon[c]);
        sum.signed_sum += area.z;
        sum.absolute += length(area);
    }
    return sum;
}

}  // namespace

TEST_CASE("a convex planar polygon is a fan from its first corner", "[mesh][polygon]") {
    std::vector<Vec3> octagon;
    for (int i = 0; i < 8; ++i) octagon.push_back({std::cos(i * 0.785398), 3, std::sin(i * 0.785398)});
    const PolygonTriangles cut = triangulated(octagon);
    CHECK_FALSE(cut.ear_clipped);
    CHECK(cut.triangles == Triples{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}, {0, 5, 6}, {0, 6, 7}});
}

TEST_CASE("concave polygons are covered exactly once, whichever corner is first", "[mesh][polygon]") {
    // An arrow of area 3, and a comb whose fan would leave it.
    const std::vector<std::vector<Vec3>> shapes{{{0, 0, 0}, {2, 0, 0}, {1, 1, 0}, {2, 3, 0}},
                                                {{0, 0, 0},
                                                 {5, 0, 0},
                                                 {5, 3, 0},
                                                 {4, 3, 0},
                                                 {4, 1, 0},
                                                 {3, 1, 0},
                                                 {3, 3, 0},
                                                 {2, 3, 0},
                                                 {2, 1, 0},
                                                 {1, 1, 0},
                                                 {1, 3, 0},
                                                 {0, 3, 0}}};
    for (const auto& shape : shapes)
        for (std::size_t start = 0; start < shape.size(); ++start) {
            std::vector<Vec3> polygon(shape.begin() + static_cast<std::ptrdiff_t>(start), shape.end());
            polygon.insert(polygon.end(), shape.begin(), shape.begin() + static_cast<std::ptrdiff_t>(start));
            double expected = 0;  // shoelace
            for (std::size_t i = 0; i < shape.size(); ++i)
                expected += cross(shape[i], shape[(i + 1) % shape.size()]).z / 2;
            const Areas sum = areas(polygon);
            CHECK(sum.signed_sum == Approx(expected));
            CHECK(sum.absolute == Approx(expected));
        }
}

TEST_CASE("a polygon with straight corners loses none of them where that can be avoided", "[mesh][polygon]") {
    // Else neighbours that use the corner would find no edge there, and a closed mesh would seem open.
    const std::vector<Vec3> square{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}};
    const PolygonTriangles cut = triangulated(square);
    REQUIRE(cut.triangles.size() == 3);
    for (const auto& [a, b, c] : cut.triangles) CHECK(area_vector(square[a], square[b], square[c]).z > 0.1);
}

TEST_CASE("holes bridged by a repeated edge are kept free", "[mesh][polygon]") {
    // A 4 x 4 square with a 2 x 2 hole; the bridge runs (0,0) - (1,1) and back.
    const Areas sum = areas(
        {{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}, {0, 0, 0}, {1, 1, 0}, {1, 3, 0}, {3, 3, 0}, {3, 1, 0}, {1, 1, 0}});
    CHECK(sum.signed_sum == Approx(12));
    CHECK(sum.absolute == Approx(12));
}

TEST_CASE("broken polygons still give k - 2 triangles", "[mesh][polygon]") {
    const double nan = std::nan("");
    CHECK(areas({{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}}).absolute > 0);                      // crosses itself
    CHECK(areas({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {4, 0, 0}}).absolute == 0);          // a line
    CHECK(areas({{1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}}).absolute == 0);                     // a point
    CHECK(areas({{0, 0, 0}, {0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}).absolute == Approx(1));  // a corner twice
    CHECK(areas({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 0}}).absolute ==
          Approx(1));  // closed by repetition
    CHECK(triangulated(std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {nan, 1, 0}, {0, 1, 0}}).triangles.size() == 2);
    CHECK(areas({{0, 0, 0}, {1e30, 0, 0}, {1e30, 1e30, 0}, {0, 1e30, 0}}).absolute == Approx(1e60));
}

TEST_CASE("a saddle is cut into two triangles that share its diagonal", "[mesh][polygon]") {
    const PolygonTriangles cut = triangulated(std::vector<Vec3>{{0, 0, 0}, {1, 0, 0.3}, {1, 1, 0}, {0, 1, 0.3}});
    CHECK(cut.ear_clipped);
    CHECK(cut.triangles.size() == 2);
}
