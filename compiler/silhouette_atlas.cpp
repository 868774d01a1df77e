#include "compiler/silhouette_atlas.h"

#include <cassert>
#include <cmath>
#include <limits>

#include "compiler/scan_conversion.h"
#include "format/direction_grid.h"
#include "format/parallel.h"
#include "format/sample_points.h"

namespace rro {
namespace {

constexpr std::uint32_t kDirections = 16;  // along each side of the grid; even, so that opposites are among them
constexpr std::uint32_t kPixels = 32;      // along each side of an image
constexpr std::uint32_t kSamples = 4;      // along each side of a pixel

/// Sets centre and radius so that no vertex lies outside, rounding included.
void enclose(std::span<const Vec3f> positions, SilhouetteAtlas& atlas) {
    Box3 box;
    for (const Vec3f& p : positions) box.add(to_double(p));
    atlas.centre = to_float(box.centre());
    double radius2 = 0;
    for (const Vec3f& p : positions) radius2 = std::max(radius2, length2(to_double(p) - to_double(atlas.centre)));
    atlas.radius = std::nextafter(static_cast<float>(std::sqrt(radius2)), std::numeric_limits<float>::max());
}

std::uint8_t coverage_byte(std::uint32_t samples) {
    return static_cast<std::uint8_t>(std::lround(255.0 * samples / (kSamples * kSamples)));
}

}  // namespace

SilhouetteAtlas measure_silhouettes(const ObjectData& object) {
    assert(!object.positions.empty());
    SilhouetteAtlas atlas;
    enclose(object.positions, atlas);
    atlas.grid_size = kDirections;
    atlas.image_size = kPixels;
    const DirectionGrid grid(GridMap::Octahedral, kDirections);
    const auto radius = static_cast<double>(atlas.radius);
    const double sample = 2 * radius / (kPixels * kSamples);
    atlas.coverage.resize(std::size_t{grid.lines()} * kPixels * kPixels);
    parallel_for(grid.lines(), 1, [&](std::size_t line) {
        const auto [right, up, toward] = frame_about(grid.direction(static_cast<std::uint32_t>(line)));
        const ImageFrame frame{right, up, to_double(atlas.centre) - (right + up) * radius, sample, sample};
        const CoverageMask mask =
            silhouette(object.positions, object.triangles, frame, kPixels * kSamples, kPixels * kSamples);
        std::uint8_t* pixel = atlas.coverage.data() + line * kPixels * kPixels;
        for (std::uint32_t row = 0; row < kPixels; ++row)
            for (std::uint32_t column = 0; column < kPixels; ++column) {
                std::uint32_t samples = 0;
                for (std::uint32_t r = row * kSamples; r < (row + 1) * kSamples; ++r)
                    samples += mask.count(r, column * kSamples, (column + 1) * kSamples);
                *pixel++ = coverage_byte(samples);
            }
    });
    return atlas;
}

}  // namespace rro
