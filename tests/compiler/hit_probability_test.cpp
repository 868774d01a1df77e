#include "compiler/hit_probability.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "compiler/compile_object.h"
#include "format/parallel.h"
#include "tests/support/meshes.h"

using namespace rro;

namespace {

CompileOptions options_for(const std::string& tables, GridMap map = GridMap::Octahedral, std::uint32_t grid = 12) {
    CompileOptions options;
    options.grid_map = map;
    options.grid_size = grid;
    options.image_resolution = 128;
    options.tables = *parse_tables(tables);
    return options;
}

CompiledObject compiled(const Mesh& mesh, const CompileOptions& options = options_for("hit")) {
    Result<CompiledObject> object = compile_object(mesh, options);
    REQUIRE(object);
    return std::move(*object);
}

/// Everything for every volume, and no more than the hit probabilities.
CompiledObject compiled_all(const Mesh& mesh) {
    CompileOptions options = options_for("hit");
    options.tables.every_node = true;
    return compiled(mesh, options);
}

double probability(const CompiledObject& object, std::size_t q, std::uint32_t line, bool intrinsic = false) {
    const auto& table = intrinsic ? object.intrinsic_hit : object.whole_hit;
    return table[q * object.data.lines() + line] / 255.0;
}

DirectionGrid grid_of(const CompiledObject& object) {
    return {object.data.meta.grid_map, object.data.meta.grid_size};
}

double projected_area(const Volume& v, const Vec3& w) {
    const Vec3 e = to_double(v.hi) - to_double(v.lo);
    return e.y * e.z * std::abs(w.x) + e.z * e.x * std::abs(w.y) + e.x * e.y * std::abs(w.z);
}

constexpr double kStep = 0.5 / 31 + 0.5 / 255;  // stored in steps of 1/31, as bytes

}  // namespace

TEST_CASE("every line that meets a box's own volume hits it", "[compiler][hit]") {
    const GridMap map = GENERATE(GridMap::Octahedral, GridMap::LatLong);
    for (const std::uint32_t n : {2u, 5u, 12u, 13u}) {  // odd grids look along the axes
        const CompiledObject object = compiled(test::make_box(2, 3, 5, 4), options_for("hit", map, n));
        REQUIRE(object.data.lines() == (n % 2 == 0 ? n * n / 2 : n * n));
        REQUIRE(object.whole_hit.size() == object.hit_volumes.size() * object.data.lines());
        CHECK(object.intrinsic_hit.empty());
        for (const std::uint8_t p : object.whole_hit) REQUIRE(p == 255);  // so do volumes in a box: it is convex
    }
}

TEST_CASE("a sphere fills pi r^2 of its box's projection", "[compiler][hit]") {
    const CompiledObject object = compiled(test::make_sphere(4, 1, {1, 2, -1}));
    const DirectionGrid grid = grid_of(object);
    for (std::uint32_t line = 0; line < grid.lines(); ++line) {
        const double exact = std::numbers::pi / projected_area(object.volumes[0], grid.direction(line));
        CHECK(std::abs(probability(object, 0, line) - exact) < kStep + 0.003);  // the mesh lacks 0.2 % of the disk
    }
}

TEST_CASE("two plates apart fill their share of the box about them", "[compiler][hit]") {
    // In the plane y = 0: 1 x 1 m each, 2 m between them. The whole is flat, so the share is the same from everywhere,
    // edge-on (odd grids) included.
    const Mesh mesh = test::merged(test::translated(test::make_quad(1, 1, true), {-1.5, 0, 0}),
                                   test::translated(test::make_quad(1, 1, true), {1.5, 0, 0}));
    for (const std::uint32_t n : {12u, 13u}) {
        const CompiledObject object = compiled(mesh, options_for("hit", GridMap::Octahedral, n));
        for (std::uint32_t line = 0; line < object.data.lines(); ++line)
            CHECK(std::abs(probability(object, 0, line) - 0.5) < kStep + 0.01);
    }
}

TEST_CASE("other parts of the object count, before and behind; not for the intrinsic probability", "[compiler][hit]") {
    // Nine small triangles at y = 0 that fill half of their box, and a plate below, at y = -1, that fills it all.
    Mesh mesh = test::empty_mesh(false);
    for (int i = 0; i < 9; ++i) {
        const auto first = static_cast<std::uint32_t>(mesh.positions.size());
        const double x = (i - 4.5) / 9;
        for (const Vec3& p : {Vec3{x, 0, -0.5}, Vec3{x + 1.0 / 9, 0, -0.5}, Vec3{x, 0, 0.5}}) mesh.positions.push_back(p);
        test::add_triangle(mesh, first, first + 1, first + 2, true);
    }
    test::add_parallelogram(mesh, {-2, -1, -2}, {0, 0, 4}, {4, 0, 0}, 3, true);
    CompileOptions options = options_for("hit", GridMap::Octahedral, 13);  // a node looks straight down
    options.tables.every_node = true;
    const CompiledObject object = compiled(mesh, options);
    const DirectionGrid grid = grid_of(object);
    std::uint32_t down = 0;
    for (std::uint32_t d = 0; d < grid.size(); ++d)
        if (grid.direction(d).y < grid.direction(down).y) down = d;
    std::uint32_t opposite = 0;
    for (std::uint32_t d = 0; d < grid.size(); ++d)
        if (grid.direction(d).y > grid.direction(opposite).y) opposite = d;
    bool found = false;
    for (std::size_t q = 0; q < object.hit_volumes.size(); ++q) {
        const Volume& v = object.volumes[object.hit_volumes[q]];
        if (v.lo.y < 0 || v.count != 9) continue;
        found = true;
        for (const std::uint32_t d : {down, opposite}) {
            CHECK(probability(object, q, d) == 1);
            CHECK(std::abs(probability(object, q, d, true) - 0.5) < kStep + 0.03);
        }
    }
    CHECK(found);
}

TEST_CASE("a volume's own probability is at most the object's, and the root's own is the object's", "[compiler][hit]") {
    Mesh mesh = test::merged(test::make_sphere(3), test::make_box(0.3, 3, 0.3, 5, {0.9, 0, 0}));
    const CompiledObject object = compiled_all(mesh);
    REQUIRE(object.hit_volumes.size() == object.volumes.size());
    REQUIRE(object.intrinsic_hit.size() == object.whole_hit.size());
    double less = 0;
    for (std::size_t q = 0; q < object.hit_volumes.size(); ++q)
        for (std::uint32_t line = 0; line < object.data.lines(); ++line) {
            const double whole = probability(object, q, line), own = probability(object, q, line, true);
            REQUIRE(own <= whole);
            less += whole - own;
            if (q == 0) CHECK(own == whole);
        }
    CHECK(less > 100);
}

TEST_CASE("a volume's own probability is that of its triangles alone", "[compiler][hit]") {
    const Mesh mesh = test::merged(test::make_sphere(3), test::make_box(0.3, 3, 0.3, 5, {0.9, 0, 0}));
    const CompiledObject object = compiled_all(mesh);
    const DirectionGrid grid = grid_of(object);
    std::size_t compared = 0;
    for (std::size_t q = 1; q < object.hit_volumes.size() && compared < 5; ++q) {
        const Volume& v = object.volumes[object.hit_volumes[q]];
        if (v.count < 100 || v.count > 600) continue;
        Mesh part = test::empty_mesh(false);
        for (const Vec3f& p : object.positions) part.positions.push_back(to_double(p));
        for (std::uint32_t i = v.first; i < v.first + v.count; ++i) {
            const TriangleIndices& t = object.triangles[object.volume_triangles[i]];
            test::add_triangle(part, t[0], t[1], t[2]);
        }
        const CompiledObject alone = compiled(part);
        ++compared;
        for (std::uint32_t line = 0; line < grid.lines(); ++line)  // images of other resolutions: the rim's samples differ
            CHECK(std::abs(probability(object, q, line, true) - probability(alone, 0, line)) < 2 * kStep + 0.04);
    }
    CHECK(compared == 5);
}

TEST_CASE("the largest volumes are stored, each with all above it", "[compiler][hit]") {
    const CompiledObject object = compiled(test::make_sphere(5), options_for("hit", GridMap::Octahedral, 2));
    REQUIRE(object.volumes.size() > 2000);
    REQUIRE(object.hit_volumes.size() == 1024);
    std::vector<bool> stored(object.volumes.size(), false);
    for (const std::uint32_t v : object.hit_volumes) stored[v] = true;
    const auto surface = [](const Volume& v) { return Box3{to_double(v.lo), to_double(v.hi)}.surface_area(); };
    double smallest = 1e30, largest_left_out = 0;
    for (std::uint32_t v = 0; v < object.volumes.size(); ++v) {
        if (stored[v])
            smallest = std::min(smallest, surface(object.volumes[v]));
        else
            largest_left_out = std::max(largest_left_out, surface(object.volumes[v]));
        const std::uint32_t right = object.volumes[v].right_child;
        if (right != 0 && !stored[v]) CHECK((!stored[v + 1] && !stored[right]));
    }
    CHECK(smallest >= largest_left_out);
}

TEST_CASE("hit probabilities are the same for any number of threads", "[compiler][hit][determinism]") {
    const Mesh mesh = test::make_two_boxes(1, 0.3, 3);
    set_thread_count(1);
    const CompiledObject first = compiled_all(mesh);
    for (const unsigned threads : {2u, 8u}) {
        set_thread_count(threads);
        const CompiledObject again = compiled_all(mesh);
        CHECK(again.whole_hit == first.whole_hit);
        CHECK(again.intrinsic_hit == first.intrinsic_hit);
    }
    set_thread_count(0);
}
