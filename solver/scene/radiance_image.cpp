#include "solver/scene/radiance_image.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "solver/scene/file_bytes.h"

namespace rro {
namespace {

constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 30;

}  // namespace

SkyRows::SkyRows(int width, int height) : width_(width), height_(height) {
    assert(width > 0 && height > 0);
    image_.width = std::min(width, kSkyWidth);
    image_.height = std::min(height, kSkyHeight);
    sums_.resize(static_cast<std::size_t>(image_.width));
    weights_.resize(sums_.size());
}

Status SkyRows::add(std::span<const Rgb> row) {
    assert(row_ < height_ && row.size() == static_cast<std::size_t>(width_));
    const auto edge = [&](int r) { return std::cos(std::numbers::pi * r / height_); };
    const double solid_angle = edge(row_) - edge(row_ + 1);
    for (std::size_t x = 0; x < row.size(); ++x) {
        Vec3 value = to_double(row[x]);
        if (!is_finite(value))
            return bad_input("", "the pixel in column " + std::to_string(x) + ", row " + std::to_string(row_) +
                                     " is no finite number");
        for (int c = 0; c < 3; ++c) value[c] = std::max(0.0, value[c]);
        const std::size_t mean = x * sums_.size() / row.size();
        sums_[mean] += value * solid_angle;
        weights_[mean] += solid_angle;
    }
    const auto target = [&](int r) { return static_cast<std::int64_t>(r) * image_.height / height_; };
    ++row_;
    if (row_ < height_ && target(row_) == target(row_ - 1)) return Done{};
    for (std::size_t i = 0; i < sums_.size(); ++i) {
        image_.pixels.push_back(to_float(sums_[i] / weights_[i]));
        sums_[i] = {};
        weights_[i] = 0;
    }
    return Done{};
}

RadianceImage SkyRows::take() {
    assert(row_ == height_);
    return std::move(image_);
}

Result<RadianceImage> decode_sky_image(std::string_view bytes, const std::string& name) {
    if (bytes.starts_with("#?")) return decode_hdr(bytes, name);
    if (bytes.starts_with("\x76\x2f\x31\x01")) return decode_exr(bytes, name);
    return bad_input(name, "is neither a Radiance picture (.hdr) nor OpenEXR (.exr)");
}

Result<RadianceImage> read_sky_image(const std::filesystem::path& path) {
    const auto bytes = read_bytes(path, kMostBytes);
    if (!bytes) return bytes.error();
    return decode_sky_image(*bytes, path.string());
}

}  // namespace rro
