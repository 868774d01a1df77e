#include "solver/output/tone_map.h"

#include <algorithm>
#include <cmath>

namespace rro {
namespace {

/// Above a lit white wall under middle-grey exposure, below a lamp.
constexpr double kShoulder = 0.35;

}  // namespace

Vec3 tone_curve(const Vec3& exposed) {
    Vec3 out;
    for (int c = 0; c < 3; ++c) {
        const double x = std::max(exposed[c], 0.0);
        constexpr double room = 1 - kShoulder;
        out[c] = x <= kShoulder ? x : kShoulder + room * (1 - std::exp(-(x - kShoulder) / room));
    }
    return out;
}

std::uint8_t srgb_code(double linear) {
    const double x = std::clamp(linear, 0.0, 1.0);
    const double encoded = x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
    return static_cast<std::uint8_t>(std::lround(255 * encoded));
}

}  // namespace rro
