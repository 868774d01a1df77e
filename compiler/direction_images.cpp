#include "compiler/direction_images.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "compiler/scan_conversion.h"
#include "format/sample_points.h"

namespace rro {

bool DirectionImage::empty() const {
    constexpr double kThinnest = 1e-6;  // projected width over height, or the reverse; single precision ends there
    return std::min(pixel_width, pixel_height) <= kThinnest * std::max(pixel_width, pixel_height);
}

DirectionImage fit_image(std::span<const Vec3f> positions, const Vec3& direction, std::uint32_t resolution) {
    assert(!positions.empty() && resolution > 0);
    DirectionImage image;
    const std::array<Vec3, 3> frame = frame_about(direction);
    image.right = frame[0], image.up = frame[1], image.toward = frame[2];
    Box3 projection;
    for (const Vec3f& p : positions) {
        const Vec3 at = to_double(p);
        projection.add({dot(at, image.right), dot(at, image.up), dot(at, image.toward)});
    }
    image.corner = image.right * projection.lo.x + image.up * projection.lo.y;
    image.pixel_width = projection.extent().x / resolution;
    image.pixel_height = projection.extent().y / resolution;
    image.depth = projection.extent().z;
    image.resolution = resolution;
    return image;
}

std::vector<std::uint32_t> faces_by_side(const ObjectData& object) {
    std::vector<std::uint32_t> table(2 * object.triangles.size(), kBlackSide);
    for (std::uint32_t f = 0; f < object.faces.size(); ++f) table[object.faces[f].packed] = f;
    return table;
}

}  // namespace rro
