#include "solver/output/surface_mesh.h"

#include <catch2/catch.hpp>
#include <map>
#include <set>

#include "solver/output/surface_sampler.h"
#include "tests/output/hand_made_scene.h"

using namespace rro;
using namespace rro::test;

namespace {

using Point = std::array<double, 3>;

Point key(const Vec3& p) { return {p.x, p.y, p.z}; }

/// How often each directed edge, by positions, occurs.
std::map<std::pair<Point, Point>, int> directed_edges(const SurfaceMesh& mesh) {
    std::map<std::pair<Point, Point>, int> edges;
    for (const TriangleIndices& t : mesh.triangles)
        for (std::size_t k = 0; k < 3; ++k)
            ++edges[{key(mesh.positions[t[k]]), key(mesh.positions[t[(k + 1) % 3]])}];
    return edges;
}

/// Edges that have no partner running the other way.
int open_edges(const SurfaceMesh& mesh) {
    const auto edges = directed_edges(mesh);
    int open = 0;
    for (const auto& [edge, count] : edges) {
        const auto partner = edges.find({edge.second, edge.first});
        open += std::max(0, count - (partner == edges.end() ? 0 : partner->second));
    }
    return open;
}

double area(const SurfaceMesh& mesh) {
    double sum = 0;
    for (const auto& [a, b, c] : mesh.triangles)
        sum += length(area_vector(mesh.positions[a], mesh.positions[b], mesh.positions[c]));
    return sum;
}

Rgb constant(const Instance&, const Vec3&, std::uint32_t) { return {0.1f, 7.3f, 1e-9f}; }

}  // namespace

TEST_CASE("a subdivided face beside a whole one leaves no T-junction and keeps the area", "[output][surface_mesh]") {
    Scene scene;
    add_instance(scene, "quad", make_quad(2, 3));
    Solution solution = solution_by(scene, constant);
    subdivide(scene.instances[0], solution.instances[0], 0, 2, [](const Vec3&) { return Rgb{1, 1, 1}; });
    const SurfaceMesh mesh = surface_mesh(scene.instances[0], solution.instances[0]);
    // Face 0: 16 elements. Face 1 gets three points on the shared diagonal: four triangles.
    REQUIRE(mesh.first == std::vector<std::uint32_t>{0, 16, 20});
    // The border of the quad: two sides of one face in four parts, two sides of the other whole.
    CHECK(open_edges(mesh) == 2 * 4 + 2);
    CHECK(area(mesh) == Approx(6.0).epsilon(1e-12));
    for (const auto& [edge, count] : directed_edges(mesh)) CHECK(count == 1);
}

TEST_CASE("a closed box stays closed however its faces are subdivided", "[output][surface_mesh]") {
    Scene scene;
    add_instance(scene, "box", make_box(1, 2, 3));
    Solution solution = solution_by(scene, constant);
    for (const auto& [face, levels] : {std::pair{0u, 3}, {3u, 1}, {4u, 4}, {7u, 2}, {11u, 1}})
        subdivide(scene.instances[0], solution.instances[0], face, levels,
                  [](const Vec3&) { return Rgb{0.1f, 7.3f, 1e-9f}; });
    const SurfaceMesh mesh = surface_mesh(scene.instances[0], solution.instances[0]);
    CHECK(open_edges(mesh) == 0);
    CHECK(area(mesh) == Approx(22.0).epsilon(1e-12));
    SECTION("and constant radiosity stays constant, to the bit") {
        for (const Rgb& b : mesh.radiosity) REQUIRE(b == Rgb{0.1f, 7.3f, 1e-9f});
    }
}

TEST_CASE("radiosity that is linear over a plane is given back", "[output][surface_mesh]") {
    Scene scene;
    add_instance(scene, "quad", make_quad(1, 1, false, 8));
    const auto formula = [](const Vec3& p) { return Rgb{static_cast<float>(2 + p.x + 0.5 * p.z), 1, 1}; };
    Solution solution =
        solution_by(scene, [&](const Instance&, const Vec3& centre, std::uint32_t) { return formula(centre); });
    for (std::uint32_t f = 20; f < 40; ++f) subdivide(scene.instances[0], solution.instances[0], f, 1, formula);
    const SurfaceMesh mesh = surface_mesh(scene.instances[0], solution.instances[0]);
    // A mean of neighbours alone misses by half a cell's rise (0.06) at borders and where sizes change. Here only single
    // precision remains.
    double worst = 0;
    for (std::size_t v = 0; v < mesh.positions.size(); ++v)
        worst = std::max(worst, std::abs(double{mesh.radiosity[v].x} - formula(mesh.positions[v]).x));
    CHECK(worst < 1e-6);
}

TEST_CASE("the creases of a box stay sharp, its sides are shaded as one", "[output][surface_mesh]") {
    Scene scene;
    add_instance(scene, "box", make_box(1, 1, 1, 2));
    const ObjectData& data = scene.instances[0].data();
    const auto by_side = [&](const Instance&, const Vec3&, std::uint32_t face) {
        return Rgb{static_cast<float>(face / 8), 1, 1};  // 8 triangles to a side
    };
    const Solution solution = solution_by(scene, by_side);
    const SurfaceMesh mesh = surface_mesh(scene.instances[0], solution.instances[0]);
    REQUIRE(mesh.triangles.size() == 48);
    CHECK(mesh.positions.size() == 6 * 9);
    for (std::uint32_t f = 0; f < 48; ++f)
        for (const std::uint32_t v : mesh.triangles[f]) {
            CHECK(mesh.radiosity[v].x == static_cast<float>(f / 8));
            const Vec3 normal = normalised(area_vector(data.corners(data.faces[f])));
            CHECK(dot(to_double(mesh.normals[v]), normal) == Approx(1.0).epsilon(1e-6));
        }
}

TEST_CASE("a finely faceted sphere is shaded without seams", "[output][surface_mesh]") {
    Scene scene;
    add_instance(scene, "sphere", make_sphere(2));
    const Solution solution = solution_by(scene, [](const Instance&, const Vec3& centre, std::uint32_t) {
        return Rgb{static_cast<float>(1 + centre.y), 1, 1};
    });
    const SurfaceMesh mesh = surface_mesh(scene.instances[0], solution.instances[0]);
    CHECK(mesh.positions.size() == 162);  // 10 * 4^2 + 2: every point is one vertex
}

TEST_CASE("front and back of a sheet, and two materials, never mix", "[output][surface_mesh]") {
    Scene scene;
    Mesh sheet = make_quad(1, 1, true, 2);
    sheet.materials.push_back({"other", {0.5, 0.5, 0.5}, {}, false});
    for (std::size_t t = 4; t < 8; ++t) sheet.material[t] = 1;
    add_instance(scene, "sheet", sheet);
    const ObjectData& data = scene.instances[0].data();
    const auto value = [&](std::uint32_t face) {
        const float side = data.faces[face].side() == Side::Front ? 5.0f : 1.0f;
        return side + static_cast<float>(data.patches[face].material);
    };
    const Solution solution = solution_by(
        scene, [&](const Instance&, const Vec3&, std::uint32_t face) { return Rgb{value(face), 0, 0}; });
    const SurfaceMesh mesh = surface_mesh(scene.instances[0], solution.instances[0]);
    for (std::uint32_t f = 0; f < data.faces.size(); ++f)
        for (const std::uint32_t v : mesh.triangles[f]) CHECK(mesh.radiosity[v].x == value(f));
}

TEST_CASE("the sampler finds the triangle about any point of a face", "[output][surface_mesh]") {
    Scene scene;
    add_instance(scene, "quad", make_quad(1, 1));
    Solution solution = solution_by(scene, constant);
    const auto formula = [](const Vec3& p) { return Rgb{static_cast<float>(3 + p.x), static_cast<float>(3 - p.z), 1}; };
    for (const std::uint32_t face : {0u, 1u}) subdivide(scene.instances[0], solution.instances[0], face, 5, formula);
    const SurfaceMesh mesh = surface_mesh(scene.instances[0], solution.instances[0]);
    const SurfaceSampler sampler(mesh);
    const TriangleCorners corners = scene.instances[0].data().corners(scene.instances[0].data().faces[0]);
    for (int i = 0; i <= 20; ++i)
        for (int j = 0; i + j <= 20; ++j) {
            const double b1 = i / 20.0, b2 = j / 20.0;
            const Vec3 p = corners[0] + (corners[1] - corners[0]) * b1 + (corners[2] - corners[0]) * b2;
            const Vec3 b = sampler.radiosity(0, b1, b2);
            // Elements are 1/32 wide: half of one is the most that a value at the border may miss; a wrong triangle
            // misses by more.
            CHECK(b.x == Approx(3 + p.x).margin(0.016));
            CHECK(b.y == Approx(3 - p.z).margin(0.016));
        }
    // Points beside the face, as rounded hits give them, take the nearest triangle.
    CHECK(sampler.radiosity(0, -1e-7, 0.5).x == Approx(sampler.radiosity(0, 0, 0.5).x).epsilon(1e-5));
}
