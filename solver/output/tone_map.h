// From exposed radiance to what a screen shows.
#pragma once

#include <cstdint>

#include "format/geometry.h"

namespace rro {

/// Linear display value in [0, 1) of exposed radiance, per channel: x below the shoulder's start t, and from there
/// t + (1 - t)(1 - exp(-(x - t) / (1 - t))), which continues value and slope and never reaches 1. What is dimmer than t
/// keeps its colour and contrast; highlights roll off and grow pale as film does.
///
/// source   our own: the identity joined to an exponential shoulder
Vec3 tone_curve(const Vec3& exposed);

/// sRGB code value (IEC 61966-2-1) of a linear display value, rounded; clamped to [0, 1] first.
std::uint8_t srgb_code(double linear);

}  // namespace rro
