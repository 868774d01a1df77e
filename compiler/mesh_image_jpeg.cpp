// JPEG by libjpeg-turbo. It reports errors by longjmp: what it may jump out of (read_header, read_rows) has no objects
// with destructors.

// clang-format off
#include <cstdio>  // first: jpeglib.h needs FILE
#include <jpeglib.h>
// clang-format on

#include <array>
#include <csetjmp>
#include <string>

#include "compiler/mesh_image.h"

namespace rro {
namespace {

/// Passes over the image of a progressive file: ten are usual, and each costs as much as an image.
constexpr int kMostScans = 100;

struct JpegState {
    jpeg_error_mgr calls;  // first: libjpeg knows this address
    std::jmp_buf escape;
    std::array<char, JMSG_LENGTH_MAX> fault;
};

[[noreturn]] void keep_fault(j_common_ptr jpeg) {
    auto* state = reinterpret_cast<JpegState*>(jpeg->err);
    jpeg->err->format_message(jpeg, state->fault.data());
    std::longjmp(state->escape, 1);
}

/// Below 0: data that are broken or missing, which libjpeg would make up.
void refuse_made_up_data(j_common_ptr jpeg, int level) {
    if (level < 0) keep_fault(jpeg);
}

void limit_scans(j_common_ptr jpeg) {
    if (jpeg->is_decompressor && reinterpret_cast<j_decompress_ptr>(jpeg)->input_scan_number > kMostScans)
        std::longjmp(reinterpret_cast<JpegState*>(jpeg->err)->escape, 1);
}

class JpegReader {
  public:
    explicit JpegReader(std::string_view bytes) : bytes_(bytes) {
        jpeg_.err = jpeg_std_error(&state_.calls);
        state_.calls.error_exit = keep_fault;
        state_.calls.emit_message = refuse_made_up_data;
        progress_.progress_monitor = limit_scans;
    }
    ~JpegReader() { jpeg_destroy_decompress(&jpeg_); }  // also where it was never created: it is all zeros then
    JpegReader(const JpegReader&) = delete;
    JpegReader& operator=(const JpegReader&) = delete;

    /// False where it failed; fault() says why.
    bool read_header() {
        if (setjmp(state_.escape)) return false;
        jpeg_create_decompress(&jpeg_);
        jpeg_.progress = &progress_;
        jpeg_mem_src(&jpeg_, reinterpret_cast<const unsigned char*>(bytes_.data()), bytes_.size());
        jpeg_read_header(&jpeg_, TRUE);
        return true;
    }

    /// Fills rows of 3 * width() bytes each.
    bool read_rows(std::uint8_t* rows) {
        if (setjmp(state_.escape)) return false;
        jpeg_.out_color_space = JCS_RGB;
        jpeg_start_decompress(&jpeg_);
        while (jpeg_.output_scanline < jpeg_.output_height) {
            JSAMPROW row = rows + std::size_t{3} * jpeg_.output_width * jpeg_.output_scanline;
            jpeg_read_scanlines(&jpeg_, &row, 1);
        }
        jpeg_finish_decompress(&jpeg_);
        return true;
    }

    std::uint32_t width() const { return jpeg_.image_width; }
    std::uint32_t height() const { return jpeg_.image_height; }
    bool is_cmyk() const { return jpeg_.num_components > 3; }
    std::string fault() const {
        return state_.fault[0] ? state_.fault.data() : "more than " + std::to_string(kMostScans) + " scans";
    }

  private:
    std::string_view bytes_;
    JpegState state_{};
    jpeg_progress_mgr progress_{};
    jpeg_decompress_struct jpeg_{};
};

}  // namespace

Result<Image> decode_jpeg(std::string_view bytes, std::uint64_t most_pixels) {
    JpegReader reader(bytes);
    const auto broken = [&] { return bad_input("", "it is a broken JPEG (" + reader.fault() + ")"); };
    if (!reader.read_header()) return broken();
    if (reader.is_cmyk()) return bad_input("", "it is a CMYK JPEG, expected grey or RGB");
    auto image = blank_image(reader.width(), reader.height(), most_pixels);
    if (image && !reader.read_rows(image->rgb.data())) return broken();
    return image;
}

}  // namespace rro
