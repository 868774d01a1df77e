#include "mesh_files.h"
#include "tests/support/meshes.h"

using namespace rro;
using namespace rro::test;

namespace {

struct Decision {
    Mesh mesh;
    ImportReport report;
};

Decision decided(Mesh mesh, TwoSided mode = TwoSided::Auto, bool fix_winding = false) {
    Decision out{std::move(mesh), {}};
    decide_sides(out.mesh, mode, fix_winding, out.report);
    REQUIRE(out.mesh.two_sided.size() == out.mesh.triangles.size());
    return out;
}

Mesh without(Mesh mesh, std::size_t first, std::size_t count) {
    mesh.triangles.erase(mesh.triangles.begin() + static_cast<std::ptrdiff_t>(first),
                         mesh.triangles.begin() + static_cast<std::ptrdiff_t>(first + count));
    return mesh;
}

double volume(const Mesh& mesh) {
    double sum = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const auto [a, b, c] = corners(mesh, t);
        sum += dot(a, cross(b, c)) / 6;
    }
    return sum;
}

}  // namespace

TEST_CASE("a closed box is one-sided, though its sides share no indices", "[mesh][sides]") {
    const Decision box = decided(make_box(1, 2, 3, 2));
    CHECK(box.report.components == 1);
    CHECK(box.report.closed_components == 1);
    CHECK(box.report.one_sided_triangles == 48);
    CHECK(box.report.two_sided_triangles == 0);
    CHECK(box.mesh.closed);
}

TEST_CASE("a room seen from inside is one-sided as wound", "[mesh][sides]") {
    const Mesh room = turned_inside_out(make_box(4, 3, 5));
    const Decision sides = decided(room);
    CHECK(sides.report.one_sided_triangles == 12);
    CHECK(sides.mesh.triangles == room.triangles);
    CHECK(sides.mesh.closed);
}

TEST_CASE("an open box is two-sided", "[mesh][sides]") {
    const Decision sides = decided(without(make_box(1, 1, 1), 0, 1));
    CHECK(sides.report.two_sided_triangles == 11);
    CHECK(sides.report.closed_components == 0);
    CHECK_FALSE(sides.mesh.closed);
}

TEST_CASE("each component is decided on its own", "[mesh][sides]") {
    Mesh pair = make_two_boxes(1, 0.5);
    pair.triangles.pop_back();
    const Decision sides = decided(pair);
    CHECK(sides.report.components == 2);
    CHECK(sides.report.closed_components == 1);
    CHECK(sides.report.one_sided_triangles == 12);
    CHECK(sides.mesh.two_sided.front() == 0);
    CHECK(sides.mesh.two_sided.back() == 1);
    CHECK_FALSE(sides.mesh.closed);
}

TEST_CASE("one turned triangle makes its component two-sided", "[mesh][sides]") {
    Mesh box = make_box(1, 1, 1);
    std::swap(box.triangles[5][0], box.triangles[5][1]);
    const auto triangles = box.triangles;
    const Decision sides = decided(box);
    CHECK(sides.report.two_sided_triangles == 12);
    CHECK(sides.mesh.triangles == triangles);  // winding is never changed unasked
    CHECK(sides.report.winding_fixed == 0);
}

TEST_CASE("surfaces that touch in a point, or a corner, stay apart", "[mesh][sides]") {
    const Decision sides = decided(merged(make_box(1, 1, 1), make_box(1, 1, 1, 1, {1, 1, 1})));
    CHECK(sides.report.components == 2);
    CHECK(sides.report.one_sided_triangles == 24);
    CHECK(sides.mesh.closed);
}

TEST_CASE("a triangle that is there twice counts once", "[mesh][sides]") {
    // The same way round, whichever corner comes first: a closed box stays closed.
    Mesh box = make_box(1, 1, 1);
    const auto [a, b, c] = box.triangles[3];
    add_triangle(box, b, c, a);
    const Decision closed = decided(box);
    CHECK(closed.report.duplicate_triangles == 1);
    CHECK(closed.mesh.source_triangle.size() == 12);
    CHECK(closed.report.one_sided_triangles == 12);
    // The other way round: of two-sided triangles one does, and the first stays; one-sided ones are the two sides of a sheet.
    Mesh sheet = make_quad(1, 1);
    for (const std::size_t t : {0u, 1u}) add_triangle(sheet, sheet.triangles[t][1], sheet.triangles[t][0], sheet.triangles[t][2]);
    const Decision both = decided(sheet), back_to_back = decided(sheet, TwoSided::No);
    CHECK(both.report.duplicate_triangles == 2);
    CHECK(both.mesh.source_triangle == std::vector<std::uint32_t>{0, 1});
    CHECK(both.report.two_sided_triangles == 2);
    CHECK(back_to_back.report.duplicate_triangles == 0);
    CHECK(back_to_back.report.one_sided_triangles == 4);
}

TEST_CASE("non-manifold faces make their component two-sided, never an error", "[mesh][sides]") {
    // Two boxes that share an edge: four triangles meet there.
    CHECK(decided(merged(make_box(1, 1, 1), make_box(1, 1, 1, 1, {1, 1, 0}))).report.two_sided_triangles == 24);
    // An inner wall.
    Mesh wall = make_box(1, 1, 1);
    wall.triangles.push_back({wall.triangles[0][0], wall.triangles[0][1], wall.triangles[8][2]});
    CHECK(decided(wall).report.closed_components == 0);
}

TEST_CASE("yes and no hold for all triangles; closedness is a fact all the same", "[mesh][sides]") {
    const Decision yes = decided(make_box(1, 1, 1), TwoSided::Yes), no = decided(make_quad(1, 1), TwoSided::No);
    CHECK(yes.report.two_sided_triangles == 12);
    CHECK(yes.mesh.closed);
    CHECK(no.report.one_sided_triangles == 2);
    CHECK_FALSE(no.mesh.closed);
}

TEST_CASE("fixing the winding turns closed components outward and counts", "[mesh][sides]") {
    Mesh pair = make_two_boxes(1, 0.5);
    for (std::size_t t = 12; t < 24; ++t) std::swap(pair.triangles[t][1], pair.triangles[t][2]);
    std::swap(pair.triangles[2][1], pair.triangles[2][2]);
    const Decision fixed = decided(pair, TwoSided::Auto, true);
    CHECK(fixed.report.winding_fixed == 13);
    CHECK(fixed.report.one_sided_triangles == 24);
    CHECK(volume(fixed.mesh) == Approx(2));
    CHECK(decided(fixed.mesh, TwoSided::Auto, true).report.winding_fixed == 0);
}

TEST_CASE("fixing the winding of an open surface follows the most of it", "[mesh][sides]") {
    Mesh sheet = make_quad(2, 2, false, 3);
    for (const std::size_t t : {0u, 4u, 11u}) std::swap(sheet.triangles[t][1], sheet.triangles[t][2]);
    const Decision fixed = decided(sheet, TwoSided::Auto, true);
    CHECK(fixed.report.winding_fixed == 3);
    CHECK(total_area_vector(fixed.mesh).y == Approx(4));
    CHECK(fixed.report.two_sided_triangles == 18);
}

TEST_CASE("a Moebius strip cannot be fixed and is left alone", "[mesh][sides]") {
    Mesh strip = empty_mesh(false);
    constexpr std::uint32_t n = 12;
    for (std::uint32_t i = 0; i < n; ++i) {
        const double angle = 2 * 3.14159265358979 * i / n;
        const Vec3 out{std::cos(angle), 0, std::sin(angle)};
        const Vec3 across = out * std::cos(angle / 2) + Vec3{0, std::sin(angle / 2), 0};
        strip.positions.push_back(out * 3 - across);
        strip.positions.push_back(out * 3 + across);
    }
    for (std::uint32_t i = 0; i < n; ++i) {
        std::uint32_t c = 2 * i + 2, d = 2 * i + 3;
        if (i + 1 == n) c = 1, d = 0;
        add_triangle(strip, 2 * i, 2 * i + 1, c);
        add_triangle(strip, c, 2 * i + 1, d);
    }
    const Decision fixed = decided(strip, TwoSided::Auto, true);
    CHECK(fixed.mesh.triangles == strip.triangles);
    CHECK(fixed.report.winding_fixed == 0);
    CHECK(fixed.report.components == 1);
    CHECK(fixed.report.two_sided_triangles == 24);
}

TEST_CASE("a dropped triangle without area leaves no hole", "[mesh][sides]") {
    // A tetrahedron whose edge 1-2 has a fifth vertex halfway that only one of its neighbours uses; the sliver 1 5 2
    // closes the gap and is dropped.
    const MeshFolder folder;
    ImportedMesh solid = imported(folder.write(
        "a.obj",
        "v 0 0 0\nv 2 0 0\nv 0 2 0\nv 0 0 2\nv 1 0 0\nf 1 3 2\nf 1 4 3\nf 2 3 4\nf 1 5 4\nf 5 2 4\nf 1 2 5\n"));
    CHECK(solid.report.dropped_degenerate == 1);
    decide_sides(solid.mesh, TwoSided::Auto, false, solid.report);
    CHECK(solid.report.components == 1);
    CHECK(solid.report.one_sided_triangles == 5);
    CHECK(solid.mesh.closed);
}

TEST_CASE("thousands of triangles around one vertex, in no order, are decided like a few", "[mesh][sides]") {
    // Two cones base to base; 7919 is prime, so that a stride of it meets every triangle.
    const auto spindle = [](std::uint32_t around) {
        Mesh mesh;
        mesh.materials.push_back({"default", {}, {}, false});
        mesh.positions = {{0, 0, 1}, {0, 0, -1}};
        for (std::uint32_t i = 0; i < around; ++i) {
            const double angle = 2 * 3.14159265358979 * i / around;
            mesh.positions.push_back({std::cos(angle), std::sin(angle), 0});
        }
        for (std::uint32_t i = 0; i < 2 * around; ++i) {
            const std::uint32_t n = i * 7919 % (2 * around), k = n / 2, a = k + 2, b = (k + 1) % around + 2;
            mesh.triangles.push_back(n % 2 ? TriangleIndices{0, a, b} : TriangleIndices{1, b, a});
            mesh.source_triangle.push_back(i);
            mesh.material.push_back(0);
        }
        mesh.source_triangles = 2 * around;
        return mesh;
    };
    for (const std::uint32_t around : {12u, 30'000u}) {
        INFO(around);
        CHECK(decided(spindle(around)).mesh.closed);
        Mesh turned = spindle(around);
        std::swap(turned.triangles[5][0], turned.triangles[5][1]);
        CHECK_FALSE(decided(turned).mesh.closed);
        const Decision fixed = decided(turned, TwoSided::Auto, true);
        CHECK(fixed.mesh.closed);
        CHECK(fixed.report.winding_fixed == 1);
        Mesh open = spindle(around);
        open.triangles.pop_back();
        CHECK(decided(open).report.closed_components == 0);
        Mesh finned = spindle(around);
        const auto [a, b, c] = finned.triangles[0];
        finned.triangles.push_back({a, b, 7});
        CHECK(decided(finned).report.closed_components == 0);
    }
}
