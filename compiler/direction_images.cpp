#include "compiler/direction_images.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "compiler/scan_conversion.h"
#include "format/sample_points.h"

namespace rro {
namespace {

/// Positive where the corners run counter-clockwise in the image: its viewer sees the front.
double turn_of(const std::array<ImagePoint, 3>& t) {
    return (t[1].x - t[0].x) * (t[2].y - t[0].y) - (t[1].y - t[0].y) * (t[2].x - t[0].x);
}

std::uint32_t covered_samples(const std::array<ImagePoint, 3>& t, std::uint32_t resolution) {
    std::uint32_t count = 0;
    for_each_span(t, resolution, resolution,
                  [&](std::uint32_t, std::uint32_t begin, std::uint32_t end) { count += end - begin; });
    return count;
}

}  // namespace

bool DirectionImage::empty() const {
    constexpr double kThinnest = 1e-6;  // projected width over height, or the reverse; single precision ends there
    return std::min(pixel_width, pixel_height) <= kThinnest * std::max(pixel_width, pixel_height);
}

Vec3 DirectionImage::sample(std::uint32_t column, std::uint32_t row) const {
    return corner + right * ((column + sample_shift(row)) * pixel_width) + up * ((row + kSampleHeight) * pixel_height);
}

ObjectRay DirectionImage::ray(std::uint32_t column, std::uint32_t row) const {
    return {to_float(sample(column, row)), to_float(-toward), 0, static_cast<float>(depth)};
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
    // The plane keeps some distance: a ray that starts on the surface may miss it in float.
    const double margin = 0.01 * max_component(projection.extent());
    image.corner =
        image.right * projection.lo.x + image.up * projection.lo.y + image.toward * (projection.hi.z + margin);
    image.pixel_width = projection.extent().x / resolution;
    image.pixel_height = projection.extent().y / resolution;
    image.depth = projection.extent().z + 2 * margin;
    image.resolution = resolution;
    return image;
}

std::vector<std::uint32_t> faces_by_side(const ObjectData& object) {
    std::vector<std::uint32_t> table(2 * object.triangles.size(), kNoFace);
    for (std::uint32_t f = 0; f < object.faces.size(); ++f) table[object.faces[f].packed] = f;
    return table;
}

void count_seen(const ObjectData& object, std::span<const std::uint32_t> face_by_side, const ObjectRays& rays,
                const DirectionImage& image, std::span<std::uint32_t> seen) {
    constexpr std::uint32_t kTile = 4;  // 4 x 4 neighbouring samples make one packet of 16 rays
    if (image.empty()) return;
    std::vector<ObjectRay> band;
    std::vector<ObjectHit> hits;
    for (std::uint32_t top = 0; top < image.resolution; top += kTile) {
        band.clear();
        for (std::uint32_t left = 0; left < image.resolution; left += kTile)
            for (std::uint32_t row = top; row < std::min(top + kTile, image.resolution); ++row)
                for (std::uint32_t column = left; column < std::min(left + kTile, image.resolution); ++column)
                    band.push_back(image.ray(column, row));
        hits.resize(band.size());
        rays.first_hits(band, hits);
        for (const ObjectHit& hit : hits) {
            if (hit.triangle == kNoTriangle) continue;
            const bool front = dot(area_vector(object.corners(hit.triangle)), image.toward) > 0;
            const std::uint32_t face = face_by_side[Face::make(hit.triangle, front ? Side::Front : Side::Back).packed];
            if (face != kNoFace) ++seen[face];
        }
    }
}

void count_covered(const ObjectData& object, std::span<const std::uint32_t> face_by_side, const DirectionImage& image,
                   std::span<std::uint32_t> toward, std::span<std::uint32_t> opposite) {
    if (image.empty()) return;
    std::vector<ImagePoint> projected;
    projected.reserve(object.positions.size());
    for (const Vec3f& p : object.positions) projected.push_back(image.frame().place(to_double(p)));
    for (std::uint32_t t = 0; t < object.triangles.size(); ++t) {
        const auto& [a, b, c] = object.triangles[t];
        const std::array corners{projected[a], projected[b], projected[c]};
        const double turn = turn_of(corners);
        if (turn == 0) continue;
        const std::uint32_t front = face_by_side[Face::make(t, Side::Front).packed];
        const std::uint32_t back = face_by_side[Face::make(t, Side::Back).packed];
        const std::uint32_t facing = turn > 0 ? front : back;
        const std::uint32_t averted = opposite.empty() ? kNoFace : turn > 0 ? back : front;
        if (facing == kNoFace && averted == kNoFace) continue;
        const std::uint32_t samples = covered_samples(corners, image.resolution);
        if (facing != kNoFace) toward[facing] += samples;
        if (averted != kNoFace) opposite[averted] += samples;
    }
}

}  // namespace rro
