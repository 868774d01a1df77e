#include "compiler/compile_object.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <numbers>
#include <span>

#include "compiler/convexity.h"
#include "format/parallel.h"
#include "tests/support/meshes.h"

using namespace rro;

namespace {

/// Small images are enough for what most laws say.
CompileOptions quick(GridMap map = GridMap::Octahedral) {
    CompileOptions options;
    options.grid_map = map;
    options.image_resolution = 96;
    return options;
}

CompiledObject compiled(const Mesh& mesh, const CompileOptions& options = quick()) {
    Result<CompiledObject> object = compile_object(mesh, options);
    REQUIRE(object);
    return std::move(*object);
}

double area_value(const CompiledObject& object, std::size_t k, std::uint32_t direction, bool intrinsic = false) {
    const auto& table = intrinsic ? object.intrinsic_area : object.whole_area;
    const auto& scale = intrinsic ? object.intrinsic_area_scale : object.whole_area_scale;
    return table[k * object.data.directions() + direction] * static_cast<double>(scale[k]) / 255;
}

DirectionGrid grid_of(const CompiledObject& object) {
    return DirectionGrid(object.data.meta.grid_map, object.data.meta.grid_size);
}

double mean_root_area(const CompiledObject& object) {
    const DirectionGrid grid = grid_of(object);
    const std::vector<double> angles = grid.solid_angles();
    double mean = 0;
    for (std::uint32_t d = 0; d < grid.size(); ++d)
        mean += area_value(object, 0, d) * angles[d] / (4 * std::numbers::pi);
    return mean;
}

Mesh leafy(int leaves) {
    Mesh mesh = test::make_sphere(2, 0.3);
    mesh.closed = false;
    for (int i = 0; i < leaves; ++i) {
        const double a = 2.4 * i, h = 2.0 * i / leaves - 1;
        test::add_parallelogram(mesh, Vec3{std::cos(a), h, std::sin(a)} * 0.8, Vec3{0.1, 0.05, 0},
                                Vec3{0, 0.1, 0.1 * h}, 1, true);
    }
    return mesh;
}

template <class T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

bool same(const CompiledObject& a, const CompiledObject& b) {
    return same_bytes(a.positions, b.positions) && same_bytes(a.triangles, b.triangles) &&
           same_bytes(a.source_triangle, b.source_triangle) && same_bytes(a.faces, b.faces) &&
           same_bytes(a.patches, b.patches) && same_bytes(a.clusters, b.clusters) && same_bytes(a.volumes, b.volumes) &&
           same_bytes(a.volume_triangles, b.volume_triangles) && same_bytes(a.area_clusters, b.area_clusters) &&
           same_bytes(a.whole_area, b.whole_area) && same_bytes(a.intrinsic_area, b.intrinsic_area) &&
           same_bytes(a.visibility, b.visibility) && same_bytes(a.whole_area_scale, b.whole_area_scale) &&
           same_bytes(a.intrinsic_area_scale, b.intrinsic_area_scale);
}

// A table value is rounded to 1/127 of the table's largest value, and that to a byte.
constexpr double kHalfStep = 0.5 / 127 + 0.5 / 255 + 1e-6;
// The fit to directions between the nodes takes a node off its own value, the more the nearer it is to a crease: for
// boxes and plates on 12 x 12 directions by up to 5 % of the largest. What that gains between them is tested below.
constexpr double kFit = 0.05;

/// Root mean square over the sphere of what the root's interpolated area, or any table's, is off by.
double error_over_sphere(const DirectionGrid& grid, const std::vector<double>& table, double (*exact)(const Vec3&)) {
    constexpr int kDirections = 5000;
    double sum = 0;
    for (int i = 0; i < kDirections; ++i) {
        const double y = 1 - (2 * i + 1.0) / kDirections, turn = 2 * std::numbers::pi * i / std::numbers::phi;
        const double r = std::sqrt(1 - y * y);
        const Vec3 w{r * std::cos(turn), y, r * std::sin(turn)};
        const double off = grid.interpolate(std::span<const double>(table), w) - exact(w);
        sum += off * off;
    }
    return std::sqrt(sum / kDirections);
}

}  // namespace

TEST_CASE("a box shows its exact projected area", "[compiler][effective_area]") {
    const GridMap map = GENERATE(GridMap::Octahedral, GridMap::LatLong);
    const CompiledObject object = compiled(test::make_box(2, 3, 5, 4), quick(map));
    const DirectionGrid grid = grid_of(object);
    CHECK(object.data.meta.convex);
    CHECK(object.data.meta.area == Approx(62));
    for (std::uint32_t d = 0; d < grid.size(); ++d) {
        const Vec3 w = grid.direction(d);
        const double exact = 15 * std::abs(w.x) + 10 * std::abs(w.y) + 6 * std::abs(w.z);
        CHECK(std::abs(area_value(object, 0, d) - exact) <= (kFit + kHalfStep) * object.whole_area_scale[0]);
    }
}

TEST_CASE("a table of fitted areas errs less than exact areas at its nodes", "[compiler][effective_area]") {
    const GridMap map = GENERATE(GridMap::Octahedral, GridMap::LatLong);
    const CompiledObject object = compiled(test::make_box(2, 3, 5, 4), quick(map));
    const DirectionGrid grid = grid_of(object);
    const auto exact = [](const Vec3& w) { return 15 * std::abs(w.x) + 10 * std::abs(w.y) + 6 * std::abs(w.z); };
    std::vector<double> stored, at_nodes;
    for (std::uint32_t d = 0; d < grid.size(); ++d) {
        stored.push_back(area_value(object, 0, d));
        at_nodes.push_back(exact(grid.direction(d)));
    }
    const double fitted = error_over_sphere(grid, stored, exact), plain = error_over_sphere(grid, at_nodes, exact);
    INFO("fitted " << fitted << ", exact at the nodes " << plain);
    CHECK(fitted < 0.9 * plain);
}

TEST_CASE("a convex object's mean effective area is a quarter of its surface", "[compiler][effective_area]") {
    // Cauchy's formula. The error of the sphere is rounding to 8 bits; that of the box the grid's quadrature of |cos|.
    const CompiledObject sphere = compiled(test::make_sphere(4));
    CHECK(mean_root_area(sphere) == Approx(sphere.data.meta.area / 4).epsilon(0.002));
    const CompiledObject box = compiled(test::make_box(2, 3, 5));
    CHECK(mean_root_area(box) == Approx(62.0 / 4).epsilon(0.01));
}

TEST_CASE("nothing of a closed room is seen from outside", "[compiler][effective_area]") {
    const CompiledObject room = compiled(test::turned_inside_out(test::make_box(1, 2, 3, 2)));
    REQUIRE(room.data.meta.closed);
    CHECK(std::all_of(room.visibility.begin(), room.visibility.end(), [](std::uint8_t v) { return v == 0; }));
    CHECK(std::all_of(room.whole_area.begin(), room.whole_area.end(), [](std::uint8_t v) { return v == 0; }));
}

TEST_CASE("nothing is hidden on a convex object", "[compiler][effective_area]") {
    const CompiledObject object = compiled(test::make_sphere(4, 1, {0.3, -0.2, 0.1}), CompileOptions{});
    REQUIRE(object.data.meta.convex);
    CHECK(object.intrinsic_area == object.whole_area);
    CHECK(object.intrinsic_area_scale == object.whole_area_scale);
    const DirectionGrid grid = grid_of(object);
    std::size_t below = 0, visible = 0;
    for (std::size_t p = 0; p < object.patches.size(); ++p)
        for (std::uint32_t d = 0; d < grid.size(); ++d)
            if (dot(to_double(object.patches[p].normal), grid.direction(d)) > 0.3) {
                ++visible;
                below += object.visibility[p * grid.size() + d] < 255 ? 1 : 0;
            }
    // A ray that single precision puts on the neighbour's side of an edge takes one sample of a patch's dozens.
    CHECK(below <= visible / 50);
    // Facing away, the table goes on with what the nearest directions show.
    CHECK(*std::min_element(object.visibility.begin(), object.visibility.end()) >= 200);
}

TEST_CASE("without the convex shortcut intrinsic and whole areas of a sphere agree", "[compiler][effective_area]") {
    // A speck far inside makes the object concave and shows nothing.
    Mesh mesh = test::merged(test::make_sphere(3), test::make_box(0.01, 0.01, 0.01));
    const CompiledObject object = compiled(mesh);
    REQUIRE(!object.data.meta.convex);
    // The root is seen whole from everywhere, by either way of counting.
    for (std::uint32_t d = 0; d < object.data.directions(); ++d)
        CHECK(area_value(object, 0, d, true) == Approx(area_value(object, 0, d)).epsilon(0.01));
}

TEST_CASE("a cluster alone shows at least what it shows within its object", "[compiler][effective_area]") {
    const CompiledObject object = compiled(test::make_two_boxes(1, 0.2, 6));
    REQUIRE(!object.data.meta.convex);
    const DirectionGrid grid = grid_of(object);
    double largest_excess = 0, hidden = 0;
    for (std::size_t k = 0; k < object.area_clusters.size(); ++k)
        for (std::uint32_t d = 0; d < grid.size(); ++d) {
            const double whole = area_value(object, k, d), own = area_value(object, k, d, true);
            const double area = object.clusters[object.area_clusters[k]].area;
            largest_excess = std::max(largest_excess, (whole - own) / area);
            hidden = std::max(hidden, (own - whole) / area);
        }
    // Two images of different resolution: the share of a cluster of a few samples differs by a sample or two.
    CHECK(largest_excess < 0.1);
    CHECK(hidden > 0.5);  // the facing sides hide each other
}

TEST_CASE("a box far from another shows its projection by itself", "[compiler][effective_area]") {
    // So far that the two halves of the tree are the boxes.
    const CompiledObject object = compiled(test::make_two_boxes(1, 8, 6));
    const DirectionGrid grid = grid_of(object);
    int boxes = 0;
    for (std::size_t k = 0; k < object.area_clusters.size(); ++k) {
        const Cluster& cluster = object.clusters[object.area_clusters[k]];
        if (std::abs(cluster.area - 6) > 1e-4) continue;
        ++boxes;
        for (std::uint32_t d = 0; d < grid.size(); ++d) {
            const Vec3 w = grid.direction(d);
            CHECK(std::abs(area_value(object, k, d, true) - (std::abs(w.x) + std::abs(w.y) + std::abs(w.z))) <=
                  (kFit + kHalfStep) * object.intrinsic_area_scale[k]);
        }
    }
    CHECK(boxes == 2);
}

TEST_CASE("one box hides the other along their axis", "[compiler][effective_area]") {
    CompileOptions options;
    options.grid_size = 13;  // odd: a node looks along y
    options.image_resolution = 64;
    const CompiledObject object =
        compiled(test::merged(test::make_box(1, 1, 1), test::make_box(1, 1, 1, 1, {0, 5, 0})), options);
    const DirectionGrid grid = grid_of(object);
    std::uint32_t along = 0;
    for (std::uint32_t d = 0; d < grid.size(); ++d)
        if (grid.direction(d).y > grid.direction(along).y) along = d;
    REQUIRE(grid.direction(along).y > 1 - 1e-12);
    CHECK(area_value(object, 0, along) == Approx(1).epsilon(0.1));  // not 2; the area's steepest valley, and the fit rounds it
}

TEST_CASE("a room shows nothing to the outside", "[compiler][effective_area]") {
    const CompiledObject object = compiled(test::turned_inside_out(test::make_box(2, 2, 2, 3)));
    CHECK(!object.data.meta.convex);
    // A ray along the rim may slip between the walls, one of thousands.
    for (std::size_t k = 0; k < object.area_clusters.size(); ++k)
        CHECK(object.whole_area_scale[k] <= 1e-4 * object.data.meta.area);
    for (const std::uint8_t v : object.visibility) CHECK(v <= 2);
    // A wall by itself is seen from inside: its intrinsic area is its projection.
    const DirectionGrid grid = grid_of(object);
    for (std::size_t k = 0; k < object.area_clusters.size(); ++k) {
        const Cluster& cluster = object.clusters[object.area_clusters[k]];
        if (cluster.patch_count != 1) continue;
        for (std::uint32_t d = 0; d < grid.size(); ++d) {
            const double exact = cluster.area * std::max(0.0, dot(to_double(cluster.normal), grid.direction(d)));
            CHECK(std::abs(area_value(object, k, d, true) - exact) <= 0.02 * cluster.area);
        }
    }
}

TEST_CASE("a two-sided quad shows A |cos| from both sides", "[compiler][effective_area]") {
    const CompiledObject object = compiled(test::make_quad(2, 3, true));
    REQUIRE(object.triangles.size() == 2);
    REQUIRE(object.faces.size() == 4);
    CHECK(object.data.meta.area == Approx(12));
    const DirectionGrid grid = grid_of(object);
    for (std::uint32_t d = 0; d < grid.size(); ++d)
        CHECK(std::abs(area_value(object, 0, d) - 6 * std::abs(grid.direction(d).y)) <=
              (kFit + kHalfStep) * object.whole_area_scale[0]);
    // One-sided, the back is black.
    const CompiledObject front = compiled(test::make_quad(2, 3, false));
    for (std::uint32_t d = 0; d < grid.size(); ++d)
        CHECK(std::abs(area_value(front, 0, d) - 6 * std::max(0.0, grid.direction(d).y)) <=
              (kFit + kHalfStep) * front.whole_area_scale[0]);
}

TEST_CASE("two one-sided quads in one place, back to back, show what a two-sided one does", "[compiler][effective_area]") {
    Mesh mesh = test::make_quad(2, 3, false, 3);
    mesh = test::merged(mesh, test::turned_inside_out(test::make_quad(2, 3, false, 5)));
    for (Vec3& p : mesh.positions) p = {p.x, 0.3 * p.x - 0.2 * p.z, p.z};  // heights that round
    const CompiledObject object = compiled(mesh);
    const DirectionGrid grid = grid_of(object);
    const Vec3 normal = Vec3{-0.3, 1, 0.2} * 6;  // times the area
    for (std::uint32_t d = 0; d < grid.size(); ++d)
        for (const bool intrinsic : {false, true})
            CHECK(std::abs(area_value(object, 0, d, intrinsic) - std::abs(dot(normal, grid.direction(d)))) <=
                  (kFit + kHalfStep) * object.whole_area_scale[0]);
}

TEST_CASE("a plate halves what is seen of another", "[compiler][effective_area]") {
    // A two-sided plate over one half of a larger one, close: from straight above, half of the lower one is seen.
    Mesh mesh = test::make_quad(2, 2, false, 8);
    mesh = test::merged(mesh, test::translated(test::make_quad(1, 2, true), {0.5, 0.01, 0}));
    CompileOptions options;
    options.grid_size = 13;  // odd: a node looks straight down
    options.image_resolution = 128;
    const CompiledObject object = compiled(mesh, options);
    const DirectionGrid grid = grid_of(object);
    std::uint32_t up = 0;
    for (std::uint32_t d = 0; d < grid.size(); ++d)
        if (grid.direction(d).y > grid.direction(up).y) up = d;
    double seen = 0;
    for (std::size_t p = 0; p < object.patches.size(); ++p) {
        const Patch& patch = object.patches[p];
        if (patch.centre.y > 0.005f) continue;
        const double cosine = std::max(0.0, dot(to_double(patch.normal), grid.direction(up)));
        seen += patch.area * cosine * object.visibility[p * grid.size() + up] / 255;
    }
    CHECK(seen == Approx(2 * grid.direction(up).y).epsilon(0.03));
}

TEST_CASE("clusters and patches are contiguous and bound what they hold", "[compiler][layout]") {
    const CompiledObject object = compiled(leafy(200));
    const ObjectData& data = object.data;
    REQUIRE(data.clusters.size() == 2 * data.patches.size() - 1);
    std::uint32_t next_face = 0;
    for (const Patch& patch : data.patches) {
        REQUIRE(patch.first_face == next_face);
        next_face += patch.face_count;
        double area = 0;
        for (std::uint32_t f = patch.first_face; f < next_face; ++f) {
            const Vec3 a = area_vector(data.corners(data.faces[f]));
            area += length(a);
            CHECK(dot(normalised(a), to_double(patch.normal)) >= static_cast<double>(patch.cone_cosine) - 1e-6);
        }
        CHECK(static_cast<double>(patch.area) == Approx(area));
        CHECK(patch.cone_cosine >= 0.8f - 1e-6f);
    }
    REQUIRE(next_face == data.faces.size());
    double faces_area = 0;
    for (const Cluster& cluster : data.clusters) {
        const Patch& last = data.patches[cluster.first_patch + cluster.patch_count - 1];
        for (std::uint32_t f = data.patches[cluster.first_patch].first_face; f < last.first_face + last.face_count; ++f)
            for (const Vec3& p : data.corners(data.faces[f])) {
                CHECK(length(p - cluster.centre()) <= static_cast<double>(cluster.radius));
                CHECK(Box3{to_double(cluster.lo), to_double(cluster.hi)}.contains(p));
            }
        if (cluster.right_child == 0) faces_area += static_cast<double>(cluster.area);
    }
    CHECK(faces_area == Approx(data.meta.area));
    // Triangles count in the order of their first face, vertices in the order of first use.
    std::uint32_t next_triangle = 0, next_vertex = 0;
    for (const Face f : data.faces)
        if (f.triangle() >= next_triangle) REQUIRE(f.triangle() == next_triangle++);
    for (const TriangleIndices& t : data.triangles)
        for (const std::uint32_t v : t)
            if (v >= next_vertex) REQUIRE(v == next_vertex++);
    CHECK(next_triangle == data.triangles.size());
    CHECK(next_vertex == data.positions.size());
}

TEST_CASE("the same object for any number of threads, and twice", "[compiler][determinism]") {
    const GridMap map = GENERATE(GridMap::Octahedral, GridMap::LatLong);
    const CompileOptions options = quick(map);
    const Mesh mesh = leafy(100);
    set_thread_count(1);
    const CompiledObject first = compiled(mesh, options);
    for (const unsigned threads : {1u, 2u, 8u}) {
        set_thread_count(threads);
        CHECK(same(first, compiled(mesh, options)));
    }
    set_thread_count(0);
}

TEST_CASE("only a convex body passes for one", "[compiler][convexity]") {
    const auto convex = [](const Mesh& mesh) {
        const Result<Surface> surface = make_surface(mesh);
        REQUIRE(surface);
        return is_convex(*surface);
    };
    CHECK(convex(test::make_sphere(3)));
    CHECK(convex(test::make_box(1, 0.001, 4, 7, {10, 20, 30})));
    CHECK(!convex(test::make_quad(1, 1)));
    CHECK(!convex(test::make_two_boxes(1, 0.5)));
    CHECK(!convex(test::turned_inside_out(test::make_box(1, 1, 1))));
    Mesh dented = test::make_sphere(3);
    dented.positions[100] *= 0.9;
    CHECK(!convex(dented));
    Mesh two_sided = test::make_box(1, 1, 1);
    std::fill(two_sided.two_sided.begin(), two_sided.two_sided.end(), std::uint8_t{1});
    CHECK(!convex(two_sided));
}

TEST_CASE("an object far from zero keeps its shape through the origin", "[compiler][surface]") {
    CompileOptions options;
    options.image_resolution = 64;
    const Vec3 far{5e6, -3e6, 1e6};
    const CompiledObject object = compiled(test::make_box(1, 2, 3, 1, far), options);
    CHECK(length(object.data.origin - far) < 1e-6);
    CHECK(object.data.meta.area == Approx(22).epsilon(1e-9));
    CHECK(length(object.data.meta.bounds.centre() - far) < 1e-6);
    CHECK(compiled(test::make_box(1, 2, 3, 1, {10, 0, 0}), options).data.origin == Vec3{});
}

TEST_CASE("what single precision cannot hold is refused or counted", "[compiler][surface]") {
    CHECK(!compile_object(test::make_box(1e20, 1e20, 1e20), {}));
    CHECK(!compile_object(test::make_box(1e-20, 1e-20, 1e-20), {}));
    Mesh sliver = test::make_quad(1, 1);
    sliver.positions.push_back({1e-20, 0, 0});
    sliver.positions.push_back({0, 0, 0});
    sliver.positions.push_back({0, 1e-30, 1e-30});
    test::add_triangle(sliver, 4, 5, 6);
    const CompiledObject object = compiled(sliver);
    CHECK(object.triangles.size() == 2);
    CHECK(object.dropped_by_rounding == 1);
}
