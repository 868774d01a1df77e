// Pixels as the bytes of image files.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "format/geometry.h"
#include "format/result.h"

namespace rro {

/// 8-bit RGB PNG, marked as sRGB.
///
/// rgb      [height * width * 3] sRGB codes, rows from the top
/// errors   Failed: libpng's reason
Result<std::string> encode_png(std::span<const std::uint8_t> rgb, int width, int height);

/// OpenEXR with float R, G, B, lossless.
///
/// pixels   [height * width] linear, rows from the top
/// errors   Failed: OpenEXR's reason
Result<std::string> encode_exr(std::span<const Rgb> pixels, int width, int height);

}  // namespace rro
