// TGA with colours of 24 or 32 bits.
#include <algorithm>
#include <array>

#include "compiler/mesh_image.h"

namespace rro {
namespace {

constexpr std::size_t kHeaderBytes = 18;

/// Pixels one after the other, unpacked; in the order of the file.
class TgaPixels {
  public:
    TgaPixels(std::string_view bytes, std::size_t pixel_bytes, bool packed)
        : bytes_(bytes), pixel_bytes_(pixel_bytes), packed_(packed) {}

    /// False at the end of the file.
    bool next(std::array<std::uint8_t, 3>& rgb) {
        if (packed_ && left_ == 0) {  // a packet: how many pixels, and whether all are the same
            if (bytes_.empty()) return false;
            const auto head = static_cast<unsigned char>(bytes_[0]);
            bytes_.remove_prefix(1);
            left_ = (head & 0x7fu) + 1;
            repeats_ = (head & 0x80u) != 0;
        }
        if (bytes_.size() < pixel_bytes_) return false;
        for (std::size_t c = 0; c < 3; ++c) rgb[c] = static_cast<std::uint8_t>(bytes_[2 - c]);  // stored blue first
        if (packed_) --left_;
        if (!packed_ || !repeats_ || left_ == 0) bytes_.remove_prefix(pixel_bytes_);
        return true;
    }

  private:
    std::string_view bytes_;
    std::size_t pixel_bytes_;
    bool packed_, repeats_ = false;
    unsigned left_ = 0;
};

}  // namespace

Result<Image> decode_tga(std::string_view bytes, std::uint64_t most_pixels) {
    const auto byte = [&](std::size_t i) { return static_cast<std::size_t>(static_cast<unsigned char>(bytes[i])); };
    const Error cut_off = bad_input("", "it is a TGA that is cut off");
    if (bytes.size() < kHeaderBytes) return cut_off;
    const std::size_t comment_bytes = byte(0), bits = byte(16), flags = byte(17);
    const bool packed = byte(2) == 10, from_top = (flags & 0x20) != 0, from_right = (flags & 0x10) != 0;
    if ((bits != 24 && bits != 32) || from_right)
        return bad_input("", "it is a TGA of another kind than 24 or 32 bits from the left");
    if (bytes.size() < kHeaderBytes + comment_bytes) return cut_off;
    auto image = blank_image(byte(12) | byte(13) << 8, byte(14) | byte(15) << 8, most_pixels);
    if (!image) return image;
    TgaPixels pixels(bytes.substr(kHeaderBytes + comment_bytes), bits / 8, packed);
    std::array<std::uint8_t, 3> rgb{};
    for (std::size_t y = 0; y < image->height; ++y) {
        const std::size_t row = from_top ? y : image->height - 1 - y;
        for (std::size_t x = 0; x < image->width; ++x) {
            if (!pixels.next(rgb)) return cut_off;
            std::copy(rgb.begin(), rgb.end(), &image->rgb[3 * (row * image->width + x)]);
        }
    }
    return image;
}

}  // namespace rro
