#include "compiler/object_bvh.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <vector>

#include "tests/support/meshes.h"

using namespace rro;

namespace {

std::vector<Vec3f> single(const Mesh& mesh) {
    std::vector<Vec3f> positions;
    for (const Vec3& p : mesh.positions) positions.push_back(to_float(p));
    return positions;
}

std::size_t depth_below(const ObjectBvh& bvh, std::uint32_t volume) {
    if (bvh.volumes[volume].right_child == 0) return 1;
    return 1 + std::max(depth_below(bvh, volume + 1), depth_below(bvh, bvh.volumes[volume].right_child));
}

void check_bvh(const ObjectBvh& bvh, std::span<const Vec3f> positions, std::span<const TriangleIndices> triangles) {
    std::vector<std::uint32_t> order = bvh.triangles;
    std::sort(order.begin(), order.end());
    REQUIRE(order.size() == triangles.size());
    for (std::uint32_t t = 0; t < order.size(); ++t) REQUIRE(order[t] == t);
    REQUIRE(bvh.volumes[0].first == 0);
    REQUIRE(bvh.volumes[0].count == triangles.size());
    for (std::uint32_t i = 0; i < bvh.volumes.size(); ++i) {
        const Volume& volume = bvh.volumes[i];
        const Box3 box{to_double(volume.lo), to_double(volume.hi)};
        for (std::uint32_t k = volume.first; k < volume.first + volume.count; ++k)
            for (const std::uint32_t v : triangles[bvh.triangles[k]]) REQUIRE(box.contains(to_double(positions[v])));
        if (volume.right_child == 0) {
            REQUIRE(volume.count <= 8);
            continue;
        }
        const Volume &left = bvh.volumes[i + 1], &right = bvh.volumes[volume.right_child];
        REQUIRE(left.first == volume.first);
        REQUIRE(right.first == left.first + left.count);
        REQUIRE(left.count + right.count == volume.count);
        REQUIRE(left.count > 0);
        REQUIRE(right.count > 0);
    }
}

}  // namespace

TEST_CASE("volumes bound their triangles and share them out", "[compiler][object_bvh]") {
    const Mesh mesh = test::merged(test::make_sphere(3), test::make_box(1, 2, 3, 5, {5, 0, 0}));
    const std::vector<Vec3f> positions = single(mesh);
    check_bvh(build_object_bvh(positions, mesh.triangles), positions, mesh.triangles);
}

TEST_CASE("triangles at one place are still divided", "[compiler][object_bvh]") {
    Mesh mesh = test::make_quad(1, 1);
    const TriangleIndices corners = mesh.triangles[0];
    mesh.triangles.assign(1000, corners);
    const std::vector<Vec3f> positions = single(mesh);
    check_bvh(build_object_bvh(positions, mesh.triangles), positions, mesh.triangles);
}

TEST_CASE("ever smaller triangles do not make a list", "[compiler][object_bvh]") {
    Mesh mesh = test::empty_mesh(false);
    for (int i = 0; i < 120; ++i) {
        const double size = std::exp2(-i);
        const auto first = static_cast<std::uint32_t>(mesh.positions.size());
        for (const Vec3& p : {Vec3{size, 0, 0}, Vec3{1.5 * size, 0, 0}, Vec3{size, 0.5 * size, 0}})
            mesh.positions.push_back(p);
        test::add_triangle(mesh, first, first + 1, first + 2);
    }
    const std::vector<Vec3f> positions = single(mesh);
    const ObjectBvh bvh = build_object_bvh(positions, mesh.triangles);
    check_bvh(bvh, positions, mesh.triangles);
    CHECK(depth_below(bvh, 0) <= 64);
}
