#include "compiler/mesh_image.h"

#include <limits>
#include <string>

namespace rro {
namespace {

/// TGA has no signature: no colour map, then "colours" or "colours, run-length coded".
bool looks_like_tga(std::string_view bytes) {
    return bytes.size() > 2 && bytes[1] == 0 && (bytes[2] == 2 || bytes[2] == 10);
}

}  // namespace

Result<Image> blank_image(std::uint64_t width, std::uint64_t height, std::uint64_t most_pixels) {
    constexpr std::uint64_t kLongest = std::numeric_limits<std::uint32_t>::max();
    if (width == 0 || height == 0) return bad_input("", "it has no pixels");
    if (width > kLongest || height > kLongest || width * height > most_pixels)
        return bad_input("", "it has " + std::to_string(width) + " x " + std::to_string(height) +
                                 " pixels, expected at most " + std::to_string(most_pixels));
    Image image{static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height), {}};
    image.rgb.resize(3 * width * height);
    return image;
}

Result<Image> decode_image(std::string_view bytes, std::uint64_t most_pixels) {
    if (bytes.starts_with("\x89PNG")) return decode_png(bytes, most_pixels);
    if (bytes.starts_with("\xff\xd8")) return decode_jpeg(bytes, most_pixels);
    if (looks_like_tga(bytes)) return decode_tga(bytes, most_pixels);
    return bad_input("", std::string("it is no ") + image_formats);
}

}  // namespace rro
