#include "compiler/mesh_texture.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "compiler/mesh_image.h"

namespace rro {
namespace {

/// Texture coordinates that double precision resolves to a thousandth of a pixel; beyond, only the mean is known.
constexpr double kLargestUv = 1e8;

std::array<double, 256> linear_values() {
    std::array<double, 256> table{};
    for (std::size_t i = 0; i < table.size(); ++i) {
        const double s = static_cast<double>(i) / 255;
        table[i] = s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);  // IEC 61966-2-1
    }
    return table;
}

Vec3 texel(const Texture& texture, std::size_t column, std::size_t row) {
    const std::uint8_t* rgb = texture.rgb.data() + 3 * (row * texture.width + column);
    return {srgb_to_linear(rgb[0]), srgb_to_linear(rgb[1]), srgb_to_linear(rgb[2])};
}

Vec3 mean_of_image(const Texture& texture) {
    Vec3 sum;
    for (std::size_t row = 0; row < texture.height; ++row)
        for (std::size_t column = 0; column < texture.width; ++column) sum += texel(texture, column, row);
    return sum / (static_cast<double>(texture.width) * texture.height);
}

std::size_t wrapped(double x, TextureWrap wrap, std::uint32_t count) {
    if (wrap == TextureWrap::Repeat) x -= std::floor(x);
    if (wrap == TextureWrap::Mirror) x = 1 - std::abs(x - 2 * std::floor(x / 2) - 1);
    return static_cast<std::size_t>(std::clamp(std::floor(x * count), 0.0, count - 1.0));
}

}  // namespace

double srgb_to_linear(std::uint8_t value) {
    static const std::array<double, 256> table = linear_values();
    return table[value];
}

Result<Texture> decode_texture(std::string_view bytes, std::uint64_t most_pixels) {
    auto image = decode_image(bytes, most_pixels);
    if (!image) return image.error();
    Texture texture{image->width, image->height, std::move(image->rgb), {}};
    texture.mean = mean_of_image(texture);
    return texture;
}

Vec3 mean_over_triangle(const Texture& texture, const TextureUse& use, const std::array<Uv, 3>& corners,
                        std::uint64_t most_samples) {
    std::array<Vec3, 3> at;  // image u, v
    double longest = 0;      // in pixels
    for (std::size_t i = 0; i < 3; ++i) {
        const auto [u, v] = corners[i];
        at[i] = {use.to_u[0] * u + use.to_u[1] * v + use.to_u[2], use.to_v[0] * u + use.to_v[1] * v + use.to_v[2], 0};
        if (!(std::abs(at[i].x) <= kLargestUv && std::abs(at[i].y) <= kLargestUv)) return texture.mean;
    }
    for (std::size_t i = 0; i < 3; ++i) {
        const Vec3 edge = at[(i + 1) % 3] - at[i];
        longest = std::max({longest, std::abs(edge.x) * texture.width, std::abs(edge.y) * texture.height});
    }
    // Centroids of n^2 congruent parts: at least 16, more where the triangle covers many pixels, at most 1024.
    const double most = std::clamp(std::floor(std::sqrt(static_cast<double>(most_samples))), 4.0, 32.0);
    const int n = static_cast<int>(std::clamp(std::ceil(longest / 2), 4.0, most));
    const Vec3 along = (at[1] - at[0]) / n, across = (at[2] - at[0]) / n;
    Vec3 sum;
    const auto add = [&](double i, double j) {
        const Vec3 p = at[0] + along * i + across * j;
        sum += texel(texture, wrapped(p.x, use.wrap_u, texture.width), wrapped(p.y, use.wrap_v, texture.height));
    };
    for (int j = 0; j < n; ++j)
        for (int i = 0; i + j < n; ++i) {
            add(i + 1.0 / 3, j + 1.0 / 3);
            if (i + j + 1 < n) add(i + 2.0 / 3, j + 2.0 / 3);
        }
    return sum / (static_cast<double>(n) * n);
}

}  // namespace rro
