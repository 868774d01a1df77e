// Self links and the closure of every patch, against exact form factors.
#include "compiler/self_transport.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "compiler/archive_facts.h"
#include "compiler/compile_object.h"
#include "format/parallel.h"
#include "format/self_links.h"
#include "tests/support/meshes.h"

using namespace rro;

namespace {

CompiledObject compiled(const Mesh& mesh) {
    CompileOptions options;
    options.image_resolution = 128;
    Result<CompiledObject> object = compile_object(mesh, options);
    REQUIRE(object);
    return std::move(*object);
}

/// The wall of the unit cube about the origin that a patch lies in: 0 to 5.
std::size_t wall_of(const Patch& patch) {
    const Vec3 n = to_double(patch.normal);
    for (int axis = 0; axis < 3; ++axis)
        if (std::abs(n[axis]) > 0.5) return static_cast<std::size_t>(2 * axis + (n[axis] > 0 ? 1 : 0));
    return 0;
}

/// A box without its top, both sides of its walls: a cup.
Mesh make_cup(int divisions) {
    Mesh cup = test::empty_mesh(false);
    test::add_parallelogram(cup, {0, 0, 0}, {0, 0, 1}, {1, 0, 0}, divisions, true);
    test::add_parallelogram(cup, {0, 0, 0}, {1, 0, 0}, {0, 2, 0}, divisions, true);
    test::add_parallelogram(cup, {0, 0, 1}, {1, 0, 0}, {0, 2, 0}, divisions, true);
    test::add_parallelogram(cup, {0, 0, 0}, {0, 0, 1}, {0, 2, 0}, divisions, true);
    test::add_parallelogram(cup, {1, 0, 0}, {0, 0, 1}, {0, 2, 0}, divisions, true);
    return cup;
}

}  // namespace

TEST_CASE("convex objects have no self links and say so", "[compiler][self_transport]") {
    const CompiledObject box = compiled(test::make_box(1, 2, 3, 4)), sphere = compiled(test::make_sphere(3));
    CHECK(box.data.meta.convex);
    CHECK(box.self_steps.empty());
    CHECK(sphere.data.meta.convex);
    CHECK(sphere.self_steps.empty());
}

TEST_CASE("walls of a cube seen from inside exchange their form factors", "[compiler][self_transport]") {
    const CompiledObject cube = compiled(test::turned_inside_out(test::make_box(1, 1, 1, 12)));
    double exchange[6][6] = {};
    for (const SelfPair& pair : self_pairs(cube.data)) {
        if (pair.step != PairStep::Link) continue;
        // A link may join clusters that reach over an edge; patches share it by area.
        const Cluster &a = cube.clusters[pair.a], &b = cube.clusters[pair.b];
        for (std::uint32_t p = a.first_patch; p < a.first_patch + a.patch_count; ++p)
            for (std::uint32_t q = b.first_patch; q < b.first_patch + b.patch_count; ++q) {
                const double share = static_cast<double>(cube.patches[p].area) / static_cast<double>(a.area) *
                                     static_cast<double>(cube.patches[q].area) / static_cast<double>(b.area);
                const double g = share * static_cast<double>(pair.seen);
                exchange[wall_of(cube.patches[p])][wall_of(cube.patches[q])] += g;
                exchange[wall_of(cube.patches[q])][wall_of(cube.patches[p])] += g;
            }
    }
    constexpr double kOpposite = 0.199824895698387, kAdjacent = 0.200043776075403;
    for (std::size_t w = 0; w < 6; ++w)
        for (std::size_t v = 0; v < 6; ++v) {
            INFO("walls " << w << " and " << v);
            // Some 40,000 lines per pair of walls, and few of them near the common edge: 1 % is three deviations.
            if (v != w) CHECK(exchange[w][v] == Approx(v == (w ^ 1u) ? kOpposite : kAdjacent).epsilon(0.015));
        }
    // Links are as wrong as 0.01 of a patch's radiosity; some thirty reach a patch.
    CHECK(std::abs(closure_defect(cube.data).mean) < 0.005);
    CHECK(closure_defect(cube.data).rms < 0.08);
}

TEST_CASE("a cup keeps part of the light of its inside", "[compiler][self_transport]") {
    const CompiledObject cup = compiled(make_cup(12));
    REQUIRE_FALSE(cup.self_steps.empty());
    double inside = 0, outside = 0;
    for (std::size_t p = 0; p < cup.patches.size(); ++p) {
        const Vec3 to_axis = Vec3{0.5, 1, 0.5} - to_double(cup.patches[p].centre);
        const double received = static_cast<double>(cup.self_received[p]) * static_cast<double>(cup.patches[p].area);
        (dot(to_axis, to_double(cup.patches[p].normal)) > 0 ? inside : outside) += received;
    }
    // The inside of 9 m^2 sends through the mouth of 1 m^2 what the mouth sends to the inside: all of it.
    CHECK(inside == Approx(9 - 1).epsilon(0.01));
    CHECK(outside < 0.01);  // m^2 of 8: links of clusters that hold both sides of a wall
    const ClosureDefect defect = closure_defect(cup.data);
    INFO("mean " << defect.mean << ", rms " << defect.rms);
    // Tables of 12 x 12 directions err by about 0.05 for a patch in a deep cup; the mean is far better.
    CHECK(std::abs(defect.mean) < 0.01);
    CHECK(defect.rms < 0.1);
}

TEST_CASE("a wall between two plates hides them from one another", "[compiler][self_transport]") {
    Mesh plates = test::empty_mesh(false);
    test::add_parallelogram(plates, {0, 0, 0}, {0, 0, 1}, {1, 0, 0}, 4);                  // looks up
    test::add_parallelogram(plates, {0, 1, 0}, {1, 0, 0}, {0, 0, 1}, 4);                  // looks down
    SECTION("nothing between") {
        const CompiledObject object = compiled(plates);
        const std::vector<SelfPair> pairs = self_pairs(object.data);
        REQUIRE_FALSE(pairs.empty());
        CHECK(static_cast<double>(pairs[0].seen) == Approx(2 * 0.199824895698387).epsilon(0.01));
        CHECK(pairs[0].seen == pairs[0].unoccluded);
    }
    SECTION("a wall whose back is black") {
        test::add_parallelogram(plates, {-5, 0.5, -5}, {0, 0, 11}, {11, 0, 0}, 4);        // looks up
        const CompiledObject object = compiled(plates);
        double below = 0, black = 0;
        for (std::size_t p = 0; p < object.patches.size(); ++p) {
            const Patch& patch = object.patches[p];
            if (patch.centre.y > 0.25f) continue;
            below += static_cast<double>(object.self_received[p] * patch.area);
            black += static_cast<double>(object.self_black[p] * patch.area);
        }
        CHECK(below < 0.02);  // of 1 m^2: links of clusters that hold parts of wall and upper plate
        CHECK(black > 0.95);  // of 1 m^2; the wall reaches 5 m beyond the plate
    }
}

TEST_CASE("crevices keep their light", "[compiler][self_transport]") {
    // A bookcase of boxes: of the two triangles of its back each book sees what is near, a small part, and next to nothing
    // else. Lines spread by area miss that part and meet the next book instead.
    Mesh shelf = test::make_box(1.2, 1.9, 0.01, 1, {0, 0.97, -0.16});
    for (const double x : {-0.6, 0.6}) shelf = test::merged(shelf, test::make_box(0.03, 1.9, 0.3, 1, {x, 0.97, 0}));
    for (int row = 0; row < 4; ++row) {
        shelf = test::merged(shelf, test::make_box(1.16, 0.03, 0.28, 1, {0, 0.1 + 0.4 * row, 0}));
        for (int k = 0; k < 11; ++k)
            shelf = test::merged(shelf, test::make_box(0.04 + 0.01 * (k % 4), 0.2 + 0.02 * (k % 3), 0.18, 1,
                                                       {-0.5 + 0.095 * k, 0.245 + 0.4 * row + 0.01 * (k % 3), 0.02}));
    }
    const CompiledObject object = compiled(shelf);
    const ClosureDefect defect = closure_defect(object.data);
    INFO("mean " << defect.mean << ", rms " << defect.rms);
    CHECK(std::abs(defect.mean) < 0.02);  // several thousand pairs of some sixty lines each; -0.08 with lines spread by area
    CHECK(defect.rms < 0.04);
}

TEST_CASE("no patch receives clearly more than all the light there is", "[compiler][self_transport]") {
    // Scraps a thousandth as wide as the box that they lie in, near its walls: few lines meet what is nearest.
    Mesh mesh = make_cup(4);
    for (int i = 0; i < 200; ++i)
        test::add_parallelogram(mesh, {0.004 * i + 0.1, 0.001 + 0.0001 * (i % 7), 0.1 + 0.0039 * ((i * 37) % 200)}, {0.001, 0.0002, 0},
                                {0, 0.0003, 0.001}, 1, true);
    const CompiledObject object = compiled(mesh);
    REQUIRE_FALSE(object.self_received.empty());
    CHECK(*std::max_element(object.self_received.begin(), object.self_received.end()) <= 1.51f);  // 1.5 and the bytes of visibility
    for (std::size_t p = 0; p < object.patches.size(); ++p) CHECK(object.self_received[p] >= 0);
}

TEST_CASE("self links do not depend on the number of threads", "[compiler][self_transport]") {
    const Mesh mesh = make_cup(6);
    set_thread_count(1);
    const CompiledObject one = compiled(mesh);
    set_thread_count(4);
    const CompiledObject four = compiled(mesh);
    set_thread_count(0);
    CHECK(one.self_steps == four.self_steps);
    CHECK(one.self_exchange == four.self_exchange);
    CHECK(one.self_visibility == four.self_visibility);
    CHECK(one.self_escape == four.self_escape);
    CHECK(one.self_black == four.self_black);
}
