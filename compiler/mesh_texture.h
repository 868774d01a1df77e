// Textures as mean reflectances: radiosity is a mean over a triangle, so that is all of a texture it can see.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "format/geometry.h"
#include "format/result.h"

namespace rro {

using Uv = std::array<double, 2>;

/// A decoded image: 8 bits, sRGB, row 0 on top.
struct Texture {
    std::uint32_t width = 0, height = 0;
    std::vector<std::uint8_t> rgb;  // [height][width][3]
    Vec3 mean;                      // of the whole image, linear
};

/// What lies beyond the image's edges.
enum class TextureWrap { Repeat, Mirror, Clamp };

/// How a material uses a texture. The image spans the unit square, (0, 0) is its top left corner.
struct TextureUse {
    std::uint32_t texture = 0;  // into SourceMesh::textures
    TextureWrap wrap_u = TextureWrap::Repeat, wrap_v = TextureWrap::Repeat;
    std::array<double, 3> to_u{1, 0, 0}, to_v{0, 1, 0};  // image u = to_u . (file's u, file's v, 1); v likewise
};

/// Linear value of an 8-bit sRGB one, in [0, 1].
double srgb_to_linear(std::uint8_t value);

/// Decodes an image; transparency is dropped.
///
/// errors   those of decode_image
Result<Texture> decode_texture(std::string_view bytes, std::uint64_t most_pixels);

/// Linear mean of the texture over the triangle with these coordinates; over the whole image where one is not finite, or so
/// far off that it names no pixel.
///
/// most_samples   pixels that are looked at, at least 16: 1024 is as fine as it gets
Vec3 mean_over_triangle(const Texture& texture, const TextureUse& use, const std::array<Uv, 3>& corners,
                        std::uint64_t most_samples);

}  // namespace rro
