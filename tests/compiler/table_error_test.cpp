// Error bars of the tables, against exact areas over the whole sphere.
#include "compiler/table_error.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <numbers>

#include "compiler/compile_object.h"
#include "tests/support/meshes.h"

using namespace rro;

namespace {

CompiledObject compiled(const Mesh& mesh, std::uint32_t grid, GridMap map = GridMap::Octahedral) {
    CompileOptions options;
    options.grid_size = grid;
    options.grid_map = map;
    options.image_resolution = 128;
    Result<CompiledObject> object = compile_object(mesh, options);
    REQUIRE(object);
    return std::move(*object);
}

/// Relative root mean square error of the root's whole-object table over 20,000 directions.
double error_over_sphere(const CompiledObject& object, const std::function<double(const Vec3&)>& exact) {
    const DirectionGrid grid(object.data.meta.grid_map, object.data.meta.grid_size);
    const auto table = object.data.whole_area.first(grid.size());
    double difference = 0, sum = 0;
    constexpr int kDirections = 20000;
    for (int i = 0; i < kDirections; ++i) {
        const double y = 1 - (2 * i + 1.0) / kDirections, turn = 2 * std::numbers::pi * i / std::numbers::phi;
        const double r = std::sqrt(1 - y * y);
        const Vec3 w{r * std::cos(turn), y, r * std::sin(turn)};
        const double off = grid.interpolate(table, w) * static_cast<double>(object.whole_area_scale[0]) / 255 - exact(w);
        difference += off * off;
        sum += exact(w) * exact(w);
    }
    return std::sqrt(difference / sum);
}

}  // namespace

TEST_CASE("the error bar of a box is its table's error over the sphere", "[compiler][table_error]") {
    const GridMap map = GENERATE(GridMap::Octahedral, GridMap::LatLong);
    const std::uint32_t grid = GENERATE(4u, 8u, 12u);
    const CompiledObject object = compiled(test::make_box(2, 3, 5, 4), grid, map);
    const double exact = error_over_sphere(object, [](const Vec3& w) {
        return 15 * std::abs(w.x) + 10 * std::abs(w.y) + 6 * std::abs(w.z);
    });
    INFO("grid " << grid << ", error over the sphere " << exact << ", error bar " << object.whole_area_error[0]);
    // 24 directions instead of 20,000: 1 / sqrt(48) = 14 % of deviation where errors are normal; here they lie along
    // the kinks of |cos|, so few directions carry most. Rounding of tables and rays adds 0.001.
    CHECK(static_cast<double>(object.whole_area_error[0]) <= 1.6 * exact + 0.001);
    CHECK(static_cast<double>(object.whole_area_error[0]) >= 0.5 * exact - 0.001);
}

TEST_CASE("a finer grid errs less, and the archive says so", "[compiler][table_error]") {
    Mesh mesh = test::merged(test::make_box(1, 1, 1, 6), test::make_box(1, 1, 1, 6, {0.4, 1.2, 0.3}));
    const CompiledObject coarse = compiled(mesh, 6), fine = compiled(mesh, 24);
    REQUIRE(coarse.data.error_directions == fine.data.error_directions);
    // Bilinear interpolation of areas with kinks converges between first and second order: 4 to 16 times for 4 times the
    // nodes; visibility has jumps and converges more slowly.
    CHECK(fine.whole_area_error[0] < 0.3f * coarse.whole_area_error[0]);
    CHECK(fine.intrinsic_area_error[0] < 0.3f * coarse.intrinsic_area_error[0]);
    CHECK(fine.visibility_error[0] < 0.7f * coarse.visibility_error[0]);
}

TEST_CASE("where nothing is hidden patch visibility has no error but rounding", "[compiler][table_error]") {
    const CompiledObject object = compiled(test::make_sphere(3), 12);
    // A ray in single precision may pass a silhouette that the scan conversion counts: few samples of many.
    CHECK(object.visibility_error[0] < 0.02f);
    CHECK(object.whole_area_error.size() == object.area_clusters.size());
    CHECK(object.visibility_error.size() == object.area_clusters.size());
}

TEST_CASE("the noise of the measuring images is no error of the tables", "[compiler][table_error]") {
    // A grating before a plate: every cluster of the plate is half hidden, so counts of samples scatter the most.
    Mesh mesh;
    mesh.materials.emplace_back();
    for (int i = 0; i < 10; ++i)
        test::add_parallelogram(mesh, {0.1 * i, 0.5, 0}, {0, 0, 1}, {0.05, 0, 0}, 1, true);
    test::add_parallelogram(mesh, {0, 0, 0}, {0, 0, 1}, {1, 0, 0}, 8, true);
    const auto at_resolution = [&](std::uint32_t resolution) {
        CompileOptions options;
        options.image_resolution = resolution;
        Result<CompiledObject> object = compile_object(mesh, options);
        REQUIRE(object);
        return object->visibility_error[0];
    };
    // The tables themselves get worse with fewer samples too, but nowhere near 1 / sqrt of their number, which is 4.
    CHECK(at_resolution(64) < 2 * at_resolution(256));
}
