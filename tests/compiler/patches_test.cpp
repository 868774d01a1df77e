#include "compiler/patches.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <vector>

#include "tests/support/meshes.h"

using namespace rro;

namespace {

Surface surface_of(const Mesh& mesh) {
    Result<Surface> surface = make_surface(mesh);
    REQUIRE(surface);
    return *surface;
}

double area_of(const Surface& surface, std::span<const std::uint32_t> faces) {
    double area = 0;
    for (const std::uint32_t f : faces) area += length(surface.area_vector[f]);
    return area;
}

}  // namespace

TEST_CASE("patches share out the faces and keep within cone and area", "[compiler][patches]") {
    const Mesh mesh = test::merged(test::make_sphere(4), test::make_box(1, 2, 3, 20, {4, 0, 0}));
    const Surface surface = surface_of(mesh);
    const PatchLimits limits{0.02, 0.9, 0.1};
    const PatchGroups groups = make_patches(surface, limits);

    std::vector<std::uint32_t> all = groups.faces;
    std::sort(all.begin(), all.end());
    REQUIRE(all.size() == surface.faces.size());
    for (std::uint32_t f = 0; f < all.size(); ++f) REQUIRE(all[f] == f);

    for (std::size_t p = 0; p < groups.size(); ++p) {
        const auto patch = groups.patch(p);
        REQUIRE(!patch.empty());
        CHECK((patch.size() == 1 || area_of(surface, patch) <= limits.largest_area));
        Vec3 mean;
        for (const std::uint32_t f : patch) mean += surface.area_vector[f];
        for (const std::uint32_t f : patch)
            CHECK(dot(normalised(mean), normalised(surface.area_vector[f])) >= limits.cone_cosine - 1e-12);
    }
    // Crumbs would cost tables and give nothing: the mean patch fills at least a third of what it may.
    const double total = area_of(surface, groups.faces);
    CHECK(double(groups.size()) <= 3 * total / limits.largest_area);
}

TEST_CASE("a leaf card is one patch per side", "[compiler][patches]") {
    const Surface surface = surface_of(test::make_quad(1, 1, true));
    const PatchGroups groups = make_patches(surface, {10, 0.8, 0.1});
    REQUIRE(groups.size() == 2);
    for (std::size_t p = 0; p < 2; ++p) {
        REQUIRE(groups.patch(p).size() == 2);
        CHECK(surface.faces[groups.patch(p)[0]].side() == surface.faces[groups.patch(p)[1]].side());
    }
}

TEST_CASE("patches continue over an edge where two-sided triangles are wound against each other",
          "[compiler][patches]") {
    Mesh mesh = test::make_quad(1, 1, true);
    std::swap(mesh.triangles[1][1], mesh.triangles[1][2]);
    const Surface surface = surface_of(mesh);
    CHECK(make_patches(surface, {10, 0.8, 0.1}).size() == 2);
}

TEST_CASE("materials and unlike textures part patches", "[compiler][patches]") {
    Mesh mesh = test::make_quad(1, 1);
    const PatchLimits limits{10, 0.8, 0.1};
    CHECK(make_patches(surface_of(mesh), limits).size() == 1);

    mesh.materials[0].textured = true;
    mesh.reflectance = {{0.5f, 0.5f, 0.5f}, {0.5f, 0.55f, 0.5f}};
    CHECK(make_patches(surface_of(mesh), limits).size() == 1);
    mesh.reflectance[1].z = 0.9f;
    CHECK(make_patches(surface_of(mesh), limits).size() == 2);

    mesh.materials[0].textured = false;
    mesh.materials.push_back({"other", {0.5, 0.5, 0.5}, {}, false});
    mesh.material[1] = 1;
    CHECK(make_patches(surface_of(mesh), limits).size() == 2);
}

TEST_CASE("scraps that look opposite ways do not share a patch", "[compiler][patches]") {
    // A sliver of a plate: its two large sides are equal and opposite, so their normals add up to nothing.
    const Mesh mesh = test::merged(test::make_box(10, 10, 10, 1), test::make_box(0.1, 0.1, 1e-4, 1, {8, 0, 0}));
    const Surface surface = surface_of(mesh);
    const PatchGroups groups = make_patches(surface, {1, 0.8, 0.1});
    for (std::size_t p = 0; p < groups.size(); ++p) {
        Vec3 sum;
        for (const std::uint32_t f : groups.patch(p)) sum += surface.area_vector[f];
        CHECK(length(sum) >= 0.8 * area_of(surface, groups.patch(p)) * (1 - 1e-9));
    }
}

TEST_CASE("hundreds of blades on one edge are no trouble", "[compiler][patches]") {
    Mesh mesh = test::empty_mesh(false);
    mesh.positions = {{0, 0, 0}, {0, 1, 0}};
    for (int i = 0; i < 500; ++i) {
        const double angle = 2 * M_PI * i / 500;
        mesh.positions.push_back({std::cos(angle), 0.5, std::sin(angle)});
        test::add_triangle(mesh, 0, 1, static_cast<std::uint32_t>(mesh.positions.size() - 1), true);
    }
    const Surface surface = surface_of(mesh);
    const PatchGroups groups = make_patches(surface, {0.01, 0.8, 0.1});
    CHECK(groups.faces.size() == 1000);
    CHECK(groups.size() == 1000);  // each is larger than a patch may be
}

TEST_CASE("dust near one another shares patches, within cone and place; larger pieces keep theirs",
          "[compiler][patches]") {
    // A box, and 600 loose triangles of a millionth of its area each, in two clouds that look up and sideways.
    Mesh mesh = test::make_box(1, 1, 1, 6);
    for (int i = 0; i < 600; ++i) {
        const bool up = i % 2 == 0;
        const Vec3 at{1.5 + (i % 20) * 0.002 + (up ? 0 : 2), 0.002 * (i / 20), 0.001 * (i % 7)};
        const Vec3 edge{0.003, 0, 0}, other = up ? Vec3{0, 0, -0.003} : Vec3{0, 0.003, 0};
        test::add_parallelogram(mesh, at, edge, other, 1, false);
    }
    const Surface surface = surface_of(mesh);
    const PatchLimits limits{0.003, 0.8, 0.1};
    const PatchGroups groups = make_patches(surface, limits);
    std::size_t box_patches = 0, dust_patches = 0;
    for (std::size_t p = 0; p < groups.size(); ++p) {
        Box3 box;
        for (const std::uint32_t f : groups.patch(p))
            for (const Vec3& corner : surface.corners(surface.faces[f].triangle())) box.add(corner);
        (box.lo.x < 1.2 ? box_patches : dust_patches) += 1;
        CHECK(max_component(box.extent()) < 4 * std::sqrt(limits.largest_area));
    }
    CHECK(box_patches == groups.size() - dust_patches);
    CHECK(dust_patches >= 2);   // two ways to look
    CHECK(dust_patches <= 24);  // 0.0054 m^2 of dust in heaps of up to 0.00075 m^2, instead of 600
}
