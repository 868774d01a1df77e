// Small images as files, by the libraries that read them.
#pragma once

// clang-format off
#include <cstdio>  // first: jpeglib.h needs FILE
#include <jpeglib.h>
// clang-format on

#include <png.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

namespace rro::test {

using Pixel = std::array<unsigned char, 3>;  // r, g, b

/// What kind of PNG.
struct PngKind {
    int colours = PNG_COLOR_TYPE_RGB, bits = 8;
    bool interlaced = false;
    std::vector<Pixel> palette{};
};

/// A PNG of rows as its kind has them, each of the same number of bytes; 16-bit numbers have their high byte first.
inline std::string png_file(unsigned width, unsigned height, const PngKind& kind,
                            const std::vector<unsigned char>& bytes) {
    std::string file;
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
    png_infop info = png_create_info_struct(png);
    const auto append = [](png_structp to, png_bytep data, std::size_t count) {
        static_cast<std::string*>(png_get_io_ptr(to))->append(reinterpret_cast<const char*>(data), count);
    };
    png_set_write_fn(png, &file, append, nullptr);
    png_set_IHDR(png, info, width, height, kind.bits, kind.colours,
                 kind.interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    std::vector<png_color> palette;
    for (const auto& [r, g, b] : kind.palette) palette.push_back({r, g, b});
    if (!palette.empty()) png_set_PLTE(png, info, palette.data(), static_cast<int>(palette.size()));
    png_write_info(png, info);
    const int passes = png_set_interlace_handling(png);
    for (int pass = 0; pass < passes; ++pass)
        for (unsigned row = 0; row < height; ++row) png_write_row(png, bytes.data() + bytes.size() / height * row);
    png_write_end(png, info);
    png_destroy_write_struct(&png, &info);
    return file;
}

/// A JPEG of pixels with `channels` bytes each: 1 grey, 3 RGB, 4 CMYK; in these scans where there are some.
inline std::string jpeg_file(unsigned width, unsigned height, int channels, bool progressive,
                             const std::vector<unsigned char>& bytes, const std::vector<jpeg_scan_info>& scans = {}) {
    jpeg_compress_struct jpeg{};
    jpeg_error_mgr calls{};
    jpeg.err = jpeg_std_error(&calls);
    jpeg_create_compress(&jpeg);
    unsigned char* data = nullptr;
    unsigned long size = 0;
    jpeg_mem_dest(&jpeg, &data, &size);
    jpeg.image_width = width;
    jpeg.image_height = height;
    jpeg.input_components = channels;
    jpeg.in_color_space = channels == 1 ? JCS_GRAYSCALE : channels == 3 ? JCS_RGB : JCS_CMYK;
    jpeg_set_defaults(&jpeg);
    jpeg_set_quality(&jpeg, 95, TRUE);
    if (progressive) jpeg_simple_progression(&jpeg);
    if (!scans.empty()) {
        jpeg.scan_info = scans.data();
        jpeg.num_scans = static_cast<int>(scans.size());
    }
    jpeg_start_compress(&jpeg, TRUE);
    std::vector<unsigned char> copy = bytes;  // the library's pointer is not to constant bytes
    while (jpeg.next_scanline < height) {
        JSAMPROW row = copy.data() + bytes.size() / height * jpeg.next_scanline;
        jpeg_write_scanlines(&jpeg, &row, 1);
    }
    jpeg_finish_compress(&jpeg);
    std::string file(reinterpret_cast<const char*>(data), size);
    jpeg_destroy_compress(&jpeg);
    std::free(data);
    return file;
}

/// A TGA of 24 bits; pixels row by row from the top, which is also how they are stored.
inline std::string tga_file(unsigned width, unsigned height, const std::vector<Pixel>& pixels) {
    std::string file(18, '\0');
    file[2] = 2;
    for (std::size_t i = 0; i < 2; ++i) {
        file[12 + i] = static_cast<char>(width >> 8 * i & 0xff);
        file[14 + i] = static_cast<char>(height >> 8 * i & 0xff);
    }
    file[16] = 24;
    file[17] = 0x20;  // from the top
    for (const auto& [r, g, b] : pixels) file += {static_cast<char>(b), static_cast<char>(g), static_cast<char>(r)};
    return file;
}

}  // namespace rro::test
