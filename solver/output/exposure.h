// How bright a picture should be.
#pragma once

#include <span>

#include "format/geometry.h"
#include "solver/scene/scene.h"
#include "solver/solution.h"

namespace rro {

/// The value that an automatic exposure brings the log-average to: a photographer's grey card.
inline constexpr double kMiddleGrey = 0.18;

/// Rec. 709 luminance of linear RGB.
constexpr double luminance(const Vec3& c) { return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z; }

/// A luminance and how much of the picture or of the surfaces has it.
struct WeightedLuminance {
    double luminance = 0, weight = 1;
};

/// The factor that brings the weighted geometric mean of the luminances to kMiddleGrey; 1 where all are black. What
/// is black, or a millionth as bright as the brightest, does not count, nor does the brightest hundredth by weight: lamps
/// seen directly must not darken what they light.
///
/// samples   reordered
double automatic_exposure(std::span<WeightedLuminance> samples);

/// The same for the radiosity of all faces of a scene, weighted by area: a factor for W/m^2.
double surface_exposure(const Scene& scene, const Solution& solution);

}  // namespace rro
