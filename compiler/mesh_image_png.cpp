// PNG by libpng. It reports errors by longjmp: what it may jump out of (start, read_header, read_rows) has no objects
// with destructors.
#include <png.h>

#include <algorithm>
#include <array>
#include <csetjmp>
#include <cstring>
#include <string>

#include "compiler/mesh_image.h"

namespace rro {
namespace {

/// No PNG packs pixels denser: one bit each, and deflate's 1032 bytes for one.
constexpr std::uint64_t kMostPixelsPerByte = 8 * 1032;

struct PngSource {
    const char* data;
    std::size_t left;
    std::array<char, 100> fault;  // what libpng says is wrong
};

void give_bytes(png_structp png, png_bytep out, std::size_t count) {
    auto* source = static_cast<PngSource*>(png_get_io_ptr(png));
    if (count > source->left) png_error(png, "the file is cut off");
    std::memcpy(out, source->data, count);
    source->data += count;
    source->left -= count;
}

[[noreturn]] void keep_fault(png_structp png, png_const_charp text) {
    auto* source = static_cast<PngSource*>(png_get_error_ptr(png));
    std::strncpy(source->fault.data(), text, source->fault.size() - 1);
    png_longjmp(png, 1);
}

void ignore_warning(png_structp, png_const_charp) {}

class PngReader {
  public:
    explicit PngReader(std::string_view bytes)
        : source_{bytes.data(), bytes.size(), {}},
          png_(png_create_read_struct(PNG_LIBPNG_VER_STRING, &source_, keep_fault, ignore_warning)),
          info_(png_ ? png_create_info_struct(png_) : nullptr) {
        if (info_) png_set_read_fn(png_, &source_, give_bytes);
    }
    ~PngReader() { png_destroy_read_struct(&png_, &info_, nullptr); }
    PngReader(const PngReader&) = delete;
    PngReader& operator=(const PngReader&) = delete;

    /// False where it failed; fault() says why.
    bool read_header() {
        if (!info_ || setjmp(png_jmpbuf(png_))) return false;
        png_read_info(png_, info_);
        png_set_expand(png_);
        png_set_scale_16(png_);
        png_set_gray_to_rgb(png_);
        png_set_strip_alpha(png_);
        passes_ = png_set_interlace_handling(png_);
        png_read_update_info(png_, info_);
        return true;
    }

    /// Fills rows of row_bytes() each.
    bool read_rows(std::uint8_t* rows) {
        if (setjmp(png_jmpbuf(png_))) return false;
        for (int pass = 0; pass < passes_; ++pass)
            for (std::size_t row = 0; row < height(); ++row) png_read_row(png_, rows + row * row_bytes(), nullptr);
        png_read_end(png_, nullptr);
        return true;
    }

    std::uint32_t width() const { return png_get_image_width(png_, info_); }
    std::uint32_t height() const { return png_get_image_height(png_, info_); }
    std::size_t row_bytes() const { return png_get_rowbytes(png_, info_); }
    std::string fault() const { return source_.fault.data(); }

  private:
    PngSource source_;
    png_structp png_;
    png_infop info_;
    int passes_ = 1;
};

}  // namespace

Result<Image> decode_png(std::string_view bytes, std::uint64_t most_pixels) {
    PngReader reader(bytes);
    const auto broken = [&] { return bad_input("", "it is a broken PNG (" + reader.fault() + ")"); };
    if (!reader.read_header()) return broken();
    auto image = blank_image(reader.width(), reader.height(),
                             std::min<std::uint64_t>(most_pixels, kMostPixelsPerByte * bytes.size()));
    if (!image) return image;
    if (reader.row_bytes() != std::size_t{3} * image->width) return bad_input("", "it is a PNG of an unknown kind");
    if (!reader.read_rows(image->rgb.data())) return broken();
    return image;
}

}  // namespace rro
