// Orthographic images of the object along a direction: what is seen first (by Embree), and what would be seen if
// nothing hid anything (by scan conversion), both at the same sample points.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "compiler/scan_conversion.h"
#include "format/object_data.h"
#include "format/rays/object_rays.h"

namespace rro {

/// Sample points of an image: resolution^2 points over the rectangle that the object's projection fills. Sample
/// (column, row) lies at corner + right (column + sample_shift(row)) pixel_width + up (row + 1/2) pixel_height.
struct DirectionImage {
    Vec3 right, up, toward;                    // orthonormal; toward = the direction, from the object to its viewer
    Vec3 corner;                               // in a plane in front of the object, relative to its origin
    double pixel_width = 0, pixel_height = 0;  // m; 0 where a flat object is seen edge-on
    double depth = 0;                          // m, from the plane to behind the object
    std::uint32_t resolution = 0;

    /// Seen edge-on: samples would lie in the surface itself, where rounding decides.
    bool empty() const;
    Vec3 sample(std::uint32_t column, std::uint32_t row) const;
    /// The ray through a sample, from the viewer to the object.
    ObjectRay ray(std::uint32_t column, std::uint32_t row) const;
    ImageFrame frame() const { return {right, up, corner, pixel_width, pixel_height}; }
};

/// positions   of the object, relative to its origin; at least one
/// direction   unit, from the object to its viewer
DirectionImage fit_image(std::span<const Vec3f> positions, const Vec3& direction, std::uint32_t resolution);

/// The face that shows each side of each triangle. [2 T]: index = Face::packed; kNoFace where that side is black.
inline constexpr std::uint32_t kNoFace = 0xffffffffu;
std::vector<std::uint32_t> faces_by_side(const ObjectData& object);

/// Adds to seen[f] the number of samples at which face f is the first thing hit, seen from its own side.
void count_seen(const ObjectData& object, std::span<const std::uint32_t> face_by_side, const ObjectRays& rays,
                const DirectionImage& image, std::span<std::uint32_t> seen);

/// Adds to toward[f] the number of samples that face f covers, for faces turned to the image's viewer, and to
/// opposite[f] for those turned the other way, which a viewer behind the object has on the same lines. `opposite` may
/// be empty.
void count_covered(const ObjectData& object, std::span<const std::uint32_t> face_by_side, const DirectionImage& image,
                   std::span<std::uint32_t> toward, std::span<std::uint32_t> opposite);

}  // namespace rro
