// Image files -> pixels, for mesh_texture.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "format/result.h"

namespace rro {

/// 8 bits per channel as the file has them, row 0 on top.
struct Image {
    std::uint32_t width = 0, height = 0;
    std::vector<std::uint8_t> rgb;  // [height][width][3]
};

/// The formats below, for messages.
inline constexpr const char* image_formats = "PNG, JPEG or TGA";

/// Decodes an image by its content. Transparency and colour profiles are dropped; 16 bits are rounded to 8; grey and
/// palettes become colours.
///
/// most_pixels   larger images are refused before memory is taken for them
/// errors        BadInput without a place: no format that is read, broken or cut off, too large, CMYK
Result<Image> decode_image(std::string_view bytes, std::uint64_t most_pixels);

/// The formats by themselves. `bytes` begin as the format does.
Result<Image> decode_png(std::string_view bytes, std::uint64_t most_pixels);
Result<Image> decode_jpeg(std::string_view bytes, std::uint64_t most_pixels);
/// Uncompressed and run-length coded, 24 and 32 bits.
Result<Image> decode_tga(std::string_view bytes, std::uint64_t most_pixels);

/// An image of that size with black pixels.
///
/// errors   BadInput: no pixels, or more than `most_pixels`
Result<Image> blank_image(std::uint64_t width, std::uint64_t height, std::uint64_t most_pixels);

}  // namespace rro
