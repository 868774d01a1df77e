// Radiance pictures: a text header, then rows of pixels with a common exponent (Radiance's file formats, "Picture File
// Format (.hdr)", Ward 1997).
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <optional>

#include "solver/scene/radiance_image.h"

namespace rro {
namespace {

constexpr int kLeastRunWidth = 8, kMostRunWidth = 0x7fff;  // of rows whose channels are stored one after the other

using Rgbe = std::array<std::uint8_t, 4>;

/// The pixels' bytes, taken one by one.
class Bytes {
  public:
    explicit Bytes(std::string_view bytes) : left_(bytes) {}

    std::size_t left() const { return left_.size(); }
    std::optional<std::uint8_t> next() {
        if (left_.empty()) return std::nullopt;
        const auto byte = static_cast<std::uint8_t>(left_.front());
        left_.remove_prefix(1);
        return byte;
    }
    bool pixel(Rgbe& pixel) {
        if (left_.size() < pixel.size()) return false;
        for (std::uint8_t& byte : pixel) byte = *next();
        return true;
    }

  private:
    std::string_view left_;
};

/// One channel of a row: runs (128 + length, value) and literals (length, values).
bool read_channel(Bytes& bytes, std::vector<Rgbe>& row, std::size_t channel) {
    for (std::size_t x = 0; x < row.size();) {
        const auto code = bytes.next();
        if (!code || *code == 0) return false;
        const bool run = *code > 128;
        const std::size_t count = run ? *code - 128u : *code;
        if (count > row.size() - x) return false;
        std::optional<std::uint8_t> value;
        for (std::size_t i = 0; i < count; ++i) {
            if (i == 0 || !run) value = bytes.next();
            if (!value) return false;
            row[x++][channel] = *value;
        }
    }
    return true;
}

/// A row of whole pixels; (1, 1, 1, n) repeats the last one n times, several in a row count as digits of base 256.
bool read_plain_row(Bytes& bytes, std::vector<Rgbe>& row, const Rgbe& first) {
    std::size_t x = 0;
    int shift = 0;
    for (Rgbe pixel = first;; ) {
        if (pixel[0] == 1 && pixel[1] == 1 && pixel[2] == 1) {
            if (x == 0 || shift > 16) return false;
            const std::size_t count = std::size_t{pixel[3]} << shift;
            if (count > row.size() - x) return false;
            for (std::size_t i = 0; i < count; ++i, ++x) row[x] = row[x - 1];
            shift += 8;
        } else {
            row[x++] = pixel;
            shift = 0;
        }
        if (x == row.size()) return true;
        if (!bytes.pixel(pixel)) return false;
    }
}

bool read_row(Bytes& bytes, std::vector<Rgbe>& row) {
    Rgbe first;
    if (!bytes.pixel(first)) return false;
    const std::size_t width = row.size();
    const bool by_channel = first[0] == 2 && first[1] == 2 && first[2] < 128 && width >= kLeastRunWidth &&
                            width <= kMostRunWidth;
    if (!by_channel) return read_plain_row(bytes, row, first);
    if (width != std::size_t{first[2]} * 256 + first[3]) return false;
    for (std::size_t channel = 0; channel < 4; ++channel)
        if (!read_channel(bytes, row, channel)) return false;
    return true;
}

Rgb decoded(const Rgbe& pixel, double scale) {
    if (pixel[3] == 0) return {};
    const double unit = std::ldexp(scale, pixel[3] - (128 + 8));
    return to_float(Vec3{pixel[0] + 0.5, pixel[1] + 0.5, pixel[2] + 0.5} * unit);
}

struct Header {
    int width = 0, height = 0;
    double exposure = 1;  // that the pixels have been multiplied by
};

bool read_size(std::string_view line, Header& header) {
    const auto take = [&](std::string_view prefix, int& value) {
        if (!line.starts_with(prefix)) return false;
        line.remove_prefix(prefix.size());
        const auto [end, code] = std::from_chars(line.data(), line.data() + line.size(), value);
        if (code != std::errc{} || value < 1 || value > kMostSkySide) return false;
        line.remove_prefix(static_cast<std::size_t>(end - line.data()));
        return true;
    };
    return take("-Y ", header.height) && take(" +X ", header.width) && line.empty() &&
           std::int64_t{header.width} * header.height <= kMostSkyPixels;
}

Result<Header> read_header(std::string_view& bytes, const std::string& name) {
    Header header;
    std::string_view line;
    const auto next_line = [&] {
        const std::size_t end = bytes.find('\n');
        if (end == std::string_view::npos) return false;
        line = bytes.substr(0, end);
        if (line.ends_with('\r')) line.remove_suffix(1);
        bytes.remove_prefix(end + 1);
        return true;
    };
    do {
        if (!next_line()) return bad_input(name, "the header does not end, expected an empty line");
        if (line.starts_with("FORMAT=") && line != "FORMAT=32-bit_rle_rgbe")
            return bad_input(name, "has \"" + std::string(line.substr(0, 60)) + "\", expected FORMAT=32-bit_rle_rgbe");
        if (line.starts_with("EXPOSURE=")) {
            std::string_view number = line.substr(9);
            number.remove_prefix(std::min(number.find_first_not_of(' '), number.size()));
            double factor = 0;
            const auto read = std::from_chars(number.data(), number.data() + number.size(), factor);
            if (read.ec != std::errc{} || !(factor > 1e-30 && factor < 1e30))
                return bad_input(name, "has \"" + std::string(line.substr(0, 60)) + "\", expected a number above 0");
            header.exposure *= factor;
        }
    } while (!line.empty());
    if (!next_line() || !read_size(line, header))
        return bad_input(name, "has the size \"" + std::string(line.substr(0, 60)) +
                                   "\", expected \"-Y height +X width\" with sides of 1 to " + std::to_string(kMostSkySide) + " pixels, " + std::to_string(kMostSkyPixels) + " in all");
    return header;
}

}  // namespace

Result<RadianceImage> decode_hdr(std::string_view bytes, const std::string& name) {
    const auto header = read_header(bytes, name);
    if (!header) return header.error();
    Bytes pixels(bytes);
    SkyRows rows(header->width, header->height);
    std::vector<Rgbe> row(static_cast<std::size_t>(header->width));
    std::vector<Rgb> radiance(row.size());
    for (int y = 0; y < header->height; ++y) {
        if (!read_row(pixels, row))
            return bad_input(name, "row " + std::to_string(y) + " of " + std::to_string(header->height) +
                                       " is broken or cut short");
        for (std::size_t x = 0; x < row.size(); ++x) radiance[x] = decoded(row[x], 1 / header->exposure);
        if (auto added = rows.add(radiance); !added) return bad_input(name, added.error().message);
    }
    return rows.take();
}

}  // namespace rro
