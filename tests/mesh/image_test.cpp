// Images by format. A lossless format gives its pixels exactly.
#include <catch2/catch.hpp>
#include <cstdlib>

#include "compiler/mesh_image.h"
#include "tests/support/image_files.h"

using namespace rro;
using namespace rro::test;

namespace {

constexpr std::uint64_t many = 1 << 20;
using Bytes = std::vector<unsigned char>;

Image decoded(const std::string& file) {
    auto image = decode_image(file, many);
    if (!image) FAIL(image.error().message);
    return *std::move(image);
}

std::string refusal(const std::string& file, std::uint64_t most_pixels = many) {
    const auto image = decode_image(file, most_pixels);
    REQUIRE(!image);
    CHECK(image.error().kind == ErrorKind::BadInput);
    return image.error().message;
}

bool has(const std::string& text, const std::string& part) {
    return text.find(part) != text.npos;
}

/// 5 x 3 pixels, all different.
Bytes ramp(std::size_t channels) {
    Bytes bytes(5 * 3 * channels);
    for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<unsigned char>(11 * i);
    return bytes;
}

/// What a grey image becomes, or one with alpha: `channels` to take from, of `stride`.
Bytes rgb_of(const Bytes& bytes, std::size_t stride, std::size_t step) {
    Bytes rgb;
    for (std::size_t i = 0; i < bytes.size(); i += stride)
        for (std::size_t c = 0; c < 3; ++c) rgb.push_back(bytes[i + step * c]);
    return rgb;
}

}  // namespace

TEST_CASE("PNG: colour, grey, alpha and interlacing give the pixels as they are", "[mesh][image]") {
    for (const bool interlaced : {false, true}) {
        CHECK(decoded(png_file(5, 3, {PNG_COLOR_TYPE_RGB, 8, interlaced}, ramp(3))).rgb == ramp(3));
        CHECK(decoded(png_file(5, 3, {PNG_COLOR_TYPE_RGBA, 8, interlaced}, ramp(4))).rgb == rgb_of(ramp(4), 4, 1));
        CHECK(decoded(png_file(5, 3, {PNG_COLOR_TYPE_GRAY, 8, interlaced}, ramp(1))).rgb == rgb_of(ramp(1), 1, 0));
        CHECK(decoded(png_file(5, 3, {PNG_COLOR_TYPE_GA, 8, interlaced}, ramp(2))).rgb == rgb_of(ramp(2), 2, 0));
    }
    const Image image = decoded(png_file(5, 3, {}, ramp(3)));
    CHECK(image.width == 5);
    CHECK(image.height == 3);
}

TEST_CASE("PNG: 16 bits are rounded to 8, one bit is black or white", "[mesh][image]") {
    // v * 257 is v in 16 bits; 100 below and above it v is still the nearest.
    Bytes wide;
    for (const unsigned char v : ramp(3)) {
        const int value = std::clamp(v * 257 + (v % 2 ? 100 : -100), 0, 65535);
        wide.push_back(static_cast<unsigned char>(value >> 8));
        wide.push_back(static_cast<unsigned char>(value & 0xff));
    }
    CHECK(decoded(png_file(5, 3, {PNG_COLOR_TYPE_RGB, 16}, wide)).rgb == ramp(3));
    CHECK(decoded(png_file(2, 1, {PNG_COLOR_TYPE_GRAY, 1}, {0x40})).rgb == Bytes{0, 0, 0, 255, 255, 255});
}

TEST_CASE("PNG: palettes become colours, at every depth", "[mesh][image]") {
    const std::vector<Pixel> palette{{1, 2, 3}, {40, 50, 60}, {250, 251, 252}};
    const Bytes expected{250, 251, 252, 1, 2, 3, 40, 50, 60};
    CHECK(decoded(png_file(3, 1, {PNG_COLOR_TYPE_PALETTE, 8, false, palette}, {2, 0, 1})).rgb == expected);
    CHECK(decoded(png_file(3, 1, {PNG_COLOR_TYPE_PALETTE, 2, true, palette}, {0b10000100})).rgb == expected);
}

TEST_CASE("JPEG: baseline and progressive, colour and grey", "[mesh][image]") {
    // Smooth pixels at quality 95 with halved colour resolution: within 6 of 255.
    Bytes grey, colour;
    for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 24; ++x) {
            grey.push_back(static_cast<unsigned char>(10 * x + y));
            for (const int value : {100, 8 * x, 200 - 5 * y}) colour.push_back(static_cast<unsigned char>(value));
        }
    const auto worst = [](const Bytes& a, const Bytes& b) {
        REQUIRE(a.size() == b.size());
        int most = 0;
        for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, std::abs(a[i] - b[i]));
        return most;
    };
    for (const bool progressive : {false, true}) {
        CHECK(worst(decoded(jpeg_file(24, 16, 3, progressive, colour)).rgb, colour) <= 6);
        CHECK(worst(decoded(jpeg_file(24, 16, 1, progressive, grey)).rgb, rgb_of(grey, 1, 0)) <= 6);
    }
    CHECK(has(refusal(jpeg_file(24, 16, 4, false, Bytes(24 * 16 * 4))), "CMYK"));
}

TEST_CASE("TGA: from the top or the bottom, 24 or 32 bits, packed or not", "[mesh][image]") {
    const std::vector<Pixel> pixels{{1, 2, 3}, {4, 5, 6}, {7, 8, 9}, {10, 11, 12}};
    const std::string file = tga_file(2, 2, pixels);
    CHECK(decoded(file).rgb == Bytes{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12});
    std::string bottom_up = file;
    bottom_up[17] = 0;
    CHECK(decoded(bottom_up).rgb == Bytes{7, 8, 9, 10, 11, 12, 1, 2, 3, 4, 5, 6});
    // A comment; a packet of one pixel three times, which goes on in the next row; then one of a single pixel.
    std::string packed = file.substr(0, 18) + "note" + "\x82\3\2\1\x7f" + std::string("\0\6\5\4\x7f", 5);
    packed[0] = 4;
    packed[2] = 10;
    packed[16] = 32;
    CHECK(decoded(packed).rgb == Bytes{1, 2, 3, 1, 2, 3, 1, 2, 3, 4, 5, 6});
    std::string palette = file;
    palette[16] = 8;
    CHECK(has(refusal(palette), "24 or 32 bits"));
}

TEST_CASE("an image that is cut off anywhere is refused", "[mesh][image]") {
    std::string packed = tga_file(5, 3, {}) +
                         "\x8e"
                         "abc";
    packed[2] = 10;
    for (const std::string& file : {png_file(5, 3, {}, ramp(3)), png_file(5, 3, {PNG_COLOR_TYPE_RGB, 8, true}, ramp(3)),
                                    jpeg_file(5, 3, 3, false, ramp(3)), jpeg_file(5, 3, 3, true, ramp(3)),
                                    tga_file(5, 3, std::vector<Pixel>(15)), packed}) {
        CHECK(decode_image(file, many));
        std::size_t taken = 0;
        for (std::size_t size = 0; size < file.size(); ++size)
            taken += decode_image(std::string_view(file).substr(0, size), many) ? 1 : 0;
        CHECK(taken == 0);
    }
}

TEST_CASE("a changed byte gives another image or a refusal, never more", "[mesh][image]") {
    for (std::string file :
         {png_file(5, 3, {}, ramp(3)), jpeg_file(5, 3, 3, true, ramp(3)), tga_file(5, 3, std::vector<Pixel>(15))})
        for (char& byte : file)
            for (const int change : {0x01, 0x80, 0xff}) {
                byte = static_cast<char>(byte ^ change);
                const auto image = decode_image(file, many);
                CHECK((!image || image->rgb.size() == 3 * std::size_t{image->width} * image->height));
                byte = static_cast<char>(byte ^ change);
            }
}

TEST_CASE("what is no image, or too large, is refused with its reason", "[mesh][image]") {
    CHECK(has(refusal(""), image_formats));
    CHECK(has(refusal("BM and more"), image_formats));
    CHECK(has(refusal("GIF89a"), image_formats));
    CHECK(has(refusal("\x89PNG\r\n\x1a\n"), "cut off"));
    CHECK(has(refusal("\xff\xd8 no"), "JPEG"));
    for (const std::string& file :
         {png_file(5, 3, {}, ramp(3)), jpeg_file(5, 3, 3, false, ramp(3)), tga_file(5, 3, std::vector<Pixel>(15))}) {
        CHECK(decode_image(file, 15));
        CHECK(has(refusal(file, 14), "5 x 3 pixels, expected at most 14"));
    }
}

TEST_CASE("a JPEG of more scans than any program writes is refused: each costs as much as an image", "[mesh][image]") {
    // Each coefficient of the grey blocks by itself; then once more, for its last bit.
    std::vector<jpeg_scan_info> scans{{1, {0}, 0, 0, 0, 0}};
    for (int k = 1; k < 64; ++k) scans.push_back({1, {0}, k, k, 0, 1});
    CHECK(decoded(jpeg_file(5, 3, 1, true, ramp(1), scans)).width == 5);
    for (int k = 1; k < 64; ++k) scans.push_back({1, {0}, k, k, 1, 0});
    CHECK(has(refusal(jpeg_file(5, 3, 1, true, ramp(1), scans)), "more than 100 scans"));
}
