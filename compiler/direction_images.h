// Orthographic images of the object along a direction: where their samples lie.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "compiler/scan_conversion.h"
#include "format/object_data.h"

namespace rro {

/// An image of resolution^2 samples (scan_conversion.h) over the rectangle that the object's projection fills.
struct DirectionImage {
    Vec3 right, up, toward;                    // orthonormal; toward = the direction, from the object to its viewer
    Vec3 corner;                               // lower left, relative to the object's origin
    double pixel_width = 0, pixel_height = 0;  // m; 0 where a flat object is seen edge-on
    double depth = 0;                          // m, of the object along the direction
    std::uint32_t resolution = 0;

    /// Seen edge-on: samples would lie in the surface itself, where rounding decides.
    bool empty() const;
    ImageFrame frame() const { return {right, up, corner, pixel_width, pixel_height}; }
};

/// positions   of the object, relative to its origin; at least one
/// direction   unit, from the object to its viewer
DirectionImage fit_image(std::span<const Vec3f> positions, const Vec3& direction, std::uint32_t resolution);

/// The face that shows each side of each triangle. [2 T]: index = Face::packed; kBlackSide where that side is black.
inline constexpr std::uint32_t kBlackSide = 0xffffffffu;
std::vector<std::uint32_t> faces_by_side(const ObjectData& object);

}  // namespace rro
