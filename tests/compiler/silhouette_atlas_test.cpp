#include "compiler/silhouette_atlas.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "compiler/compile_object.h"
#include "compiler/scan_conversion.h"
#include "format/parallel.h"
#include "format/sample_points.h"
#include "tests/support/meshes.h"

using namespace rro;

namespace {

/// The mesh as the compiler lays it out, with nothing but its silhouettes.
CompiledObject compiled(const Mesh& mesh) {
    CompileOptions options;
    options.tables = *parse_tables("atlas");
    Result<CompiledObject> object = compile_object(mesh, options);
    REQUIRE(object);
    return std::move(*object);
}

struct Image {
    const ObjectData& data;
    std::uint32_t line;

    double coverage(std::uint32_t column, std::uint32_t row) const {
        const std::uint32_t m = data.atlas_image_size;
        return data.atlas_coverage[(std::size_t{line} * m + row) * m + column] / 255.0;
    }
    /// Area of the silhouette, m^2.
    double area() const {
        const std::uint32_t m = data.atlas_image_size;
        const double pixel = 2 * static_cast<double>(data.atlas_radius) / m;
        double sum = 0;
        for (std::uint32_t row = 0; row < m; ++row)
            for (std::uint32_t column = 0; column < m; ++column) sum += coverage(column, row);
        return sum * pixel * pixel;
    }
};

DirectionGrid grid_of(const ObjectData& data) { return {GridMap::Octahedral, data.atlas_grid_size}; }

}  // namespace

TEST_CASE("a sphere's silhouettes are disks", "[compiler][atlas]") {
    const Vec3 centre{0.5, -2, 3};
    const CompiledObject object = compiled(test::make_sphere(4, 0.7, centre));
    const ObjectData& data = object.data;
    REQUIRE(data.atlas_coverage.size() == 128 * 1024);
    CHECK(length(data.origin + to_double(data.atlas_centre) - centre) < 1e-5);
    CHECK(data.atlas_radius == Approx(0.7).epsilon(1e-5));
    for (std::uint32_t line = 0; line < 128; ++line) {
        const Image image{data, line};
        // 128 x 128 samples of a disk: its rim's 400 samples err at random, by 10 of 12,900; the mesh lacks 0.2 %.
        CHECK(image.area() == Approx(std::numbers::pi * 0.49).epsilon(0.004));
        for (const std::uint32_t i : {0u, 31u})
            for (const std::uint32_t j : {0u, 31u}) CHECK(image.coverage(i, j) == 0);
        CHECK(image.coverage(15, 16) == 1);
    }
}

TEST_CASE("coverage times the pixels' area is a box's projected area, in its own place", "[compiler][atlas]") {
    const CompiledObject object = compiled(test::make_box(2, 3, 5));
    const ObjectData& data = object.data;
    const DirectionGrid grid = grid_of(data);
    for (std::uint32_t line = 0; line < grid.lines(); ++line) {
        const Vec3 w = grid.direction(line);
        const double exact = 15 * std::abs(w.x) + 10 * std::abs(w.y) + 6 * std::abs(w.z);
        CHECK(Image{data, line}.area() == Approx(exact).epsilon(0.01));  // a sample row more or less at its rim
    }
}

TEST_CASE("a pixel lies where the format says", "[compiler][atlas]") {
    // A speck near one end of a long thin triangle's line of sight: which pixel it darkens is computed from the text.
    Mesh mesh = test::make_box(0.08, 0.08, 0.08, 1, {0.6, 0.2, -0.3});
    mesh = test::merged(mesh, test::make_box(0.001, 0.001, 0.001, 1, {-1, -1, -1}));
    mesh = test::merged(mesh, test::make_box(0.001, 0.001, 0.001, 1, {1, 1, 1}));
    const CompiledObject object = compiled(mesh);
    const ObjectData& data = object.data;
    const DirectionGrid grid = grid_of(data);
    const double r = data.atlas_radius;
    for (std::uint32_t line = 0; line < grid.lines(); ++line) {
        const auto frame = frame_about(grid.direction(line));
        const Vec3 p = Vec3{0.6, 0.2, -0.3} - to_double(data.atlas_centre);
        const auto column = static_cast<std::uint32_t>((dot(p, frame[0]) / r + 1) / 2 * 32);
        const auto row = static_cast<std::uint32_t>((dot(p, frame[1]) / r + 1) / 2 * 32);
        CHECK(Image{data, line}.coverage(column, row) > 0);
    }
}

TEST_CASE("opposite directions see mirror images", "[compiler][atlas]") {
    const DirectionGrid grid(GridMap::Octahedral, 16);
    for (std::uint32_t node = grid.lines(); node < grid.size(); ++node) {
        const auto here = frame_about(grid.direction(node)), stored = frame_about(grid.direction(grid.line(node)));
        CHECK(length(here[0] - stored[0]) < 1e-12);
        CHECK(length(here[1] + stored[1]) < 1e-12);
    }
}

TEST_CASE("both sides of a triangle block", "[compiler][atlas]") {
    const CompiledObject front = compiled(test::make_quad(1, 1, false)), both = compiled(test::make_quad(1, 1, true));
    CHECK(front.atlas_coverage == both.atlas_coverage);
    const DirectionGrid grid = grid_of(front.data);
    for (std::uint32_t line = 0; line < grid.lines(); ++line)
        CHECK(Image{front.data, line}.area() == Approx(std::abs(grid.direction(line).y)).margin(0.015));
}

TEST_CASE("silhouettes are the same for any number of threads", "[compiler][atlas][determinism]") {
    const Mesh mesh = test::make_two_boxes(1, 0.3, 3);
    set_thread_count(1);
    const CompiledObject first = compiled(mesh);
    for (const unsigned threads : {2u, 8u}) {
        set_thread_count(threads);
        CHECK(compiled(mesh).atlas_coverage == first.atlas_coverage);
    }
    set_thread_count(0);
}

TEST_CASE("a silhouette has the samples that its triangles cover one by one, whatever is skipped", "[compiler][scan]") {
    // Triangles of all sizes, many of them hidden, many between samples, some beyond the image.
    const Mesh mesh = test::merged(test::make_sphere(4, 1), test::make_box(0.5, 2.5, 0.2, 9, {0.4, 0, 0.9}));
    std::vector<Vec3f> positions;
    for (const Vec3& p : mesh.positions) positions.push_back(to_float(p));
    const auto [right, up, toward] = frame_about(normalised(Vec3{1, 2, 3}));
    for (const std::uint32_t columns : {1u, 64u, 100u, 129u}) {
        const std::uint32_t rows = 70;
        const ImageFrame frame{right, up, (right + up) * -0.9, 1.8 / columns, 1.8 / rows};
        CoverageMask expected(columns, rows);
        for (const auto& [a, b, c] : mesh.triangles) {
            const auto at = [&](std::uint32_t v) { return frame.place(to_double(positions[v])); };
            for_each_span(std::array{at(a), at(b), at(c)}, columns, rows,
                          [&](std::uint32_t row, std::uint32_t begin, std::uint32_t end) { expected.cover(row, begin, end); });
        }
        const CoverageMask found = silhouette(positions, mesh.triangles, frame, columns, rows);
        std::uint32_t covered = 0;
        for (std::uint32_t row = 0; row < rows; ++row)
            for (std::uint32_t column = 0; column < columns; ++column) {
                REQUIRE(found.count(row, column, column + 1) == expected.count(row, column, column + 1));
                covered += found.count(row, column, column + 1);
            }
        CHECK(covered > rows * columns / 2);
    }
}
