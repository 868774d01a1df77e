// Pictures of measured light: Radiance .hdr and OpenEXR, as skies.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "format/geometry.h"
#include "format/result.h"

namespace rro {

/// Linear RGB, rows from the top.
struct RadianceImage {
    int width = 0, height = 0;
    std::vector<Rgb> pixels;
};

/// Takes an image latitude by longitude row by row and keeps at most kSkyWidth x kSkyHeight means, so that a huge picture
/// needs no huge memory. Each pixel belongs to one mean, by its solid angle: the light of the whole is kept.
class SkyRows {
  public:
    SkyRows(int width, int height);

    /// errors   the first pixel that is no finite number; negative ones, left by resampling, count as 0
    Status add(std::span<const Rgb> row);
    RadianceImage take();

  private:
    int width_, height_;
    int row_ = 0;
    RadianceImage image_;
    std::vector<Vec3> sums_;       // of the row of means under way
    std::vector<double> weights_;  // solid angles, as sums_
};
/// The largest sky that is kept, pixels.
inline constexpr int kSkyWidth = 2048, kSkyHeight = 1024;

// Of pictures that are read. The largest skies published have 24576 x 12288 pixels.
inline constexpr int kMostSkySide = 1 << 16;
inline constexpr std::int64_t kMostSkyPixels = std::int64_t{1} << 29;

/// errors   BadInput: neither of the two formats, broken, too large, not RGB or grey, a pixel that is no finite number
Result<RadianceImage> read_sky_image(const std::filesystem::path& path);

/// The same from bytes at hand; `name` stands in messages.
Result<RadianceImage> decode_sky_image(std::string_view bytes, const std::string& name);

// Both formats alone.
Result<RadianceImage> decode_hdr(std::string_view bytes, const std::string& name);
Result<RadianceImage> decode_exr(std::string_view bytes, const std::string& name);

}  // namespace rro
