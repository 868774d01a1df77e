#include "solver/output/image_file.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfOutputFile.h>
#include <png.h>

#include <array>
#include <cassert>
#include <cstddef>
#include <exception>
#include <vector>

namespace rro {
namespace {

/// Lets OpenEXR write into memory, so that the file itself is written atomically like all others.
class MemoryStream : public Imf::OStream {
  public:
    MemoryStream() : Imf::OStream("memory") {}
    void write(const char c[], int n) override {
        const auto count = static_cast<std::size_t>(n);
        if (position_ + count > bytes_.size()) bytes_.resize(position_ + count);
        bytes_.replace(position_, count, c, count);
        position_ += count;
    }
    std::uint64_t tellp() override { return position_; }
    void seekp(std::uint64_t position) override { position_ = position; }
    std::string take() { return std::move(bytes_); }

  private:
    std::string bytes_;
    std::size_t position_ = 0;
};

}  // namespace

Result<std::string> encode_png(std::span<const std::uint8_t> rgb, int width, int height) {
    assert(rgb.size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3);
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    image.width = static_cast<png_uint_32>(width);
    image.height = static_cast<png_uint_32>(height);
    image.format = PNG_FORMAT_RGB;
    png_alloc_size_t size = 0;
    std::string bytes;
    bool good = png_image_write_to_memory(&image, nullptr, &size, 0, rgb.data(), 0, nullptr) != 0;
    if (good) {
        bytes.resize(size);
        good = png_image_write_to_memory(&image, bytes.data(), &size, 0, rgb.data(), 0, nullptr) != 0;
        bytes.resize(size);
    }
    if (!good) return failed("", std::string("cannot encode PNG: ") + image.message);
    return bytes;
}

Result<std::string> encode_exr(std::span<const Rgb> pixels, int width, int height) {
    assert(pixels.size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    try {
        Imf::Header header(width, height);
        header.compression() = Imf::ZIP_COMPRESSION;
        Imf::FrameBuffer frame;
        const std::array channels{"R", "G", "B"};
        std::vector<Rgb> copy(pixels.begin(), pixels.end());  // OpenEXR's slices take pointers to non-const
        for (std::size_t c = 0; c < channels.size(); ++c) {
            header.channels().insert(channels[c], Imf::Channel(Imf::FLOAT));
            char* base = reinterpret_cast<char*>(copy.data()) + c * sizeof(float);
            frame.insert(channels[c],
                         Imf::Slice(Imf::FLOAT, base, sizeof(Rgb), sizeof(Rgb) * static_cast<std::size_t>(width)));
        }
        MemoryStream stream;
        {
            Imf::OutputFile file(stream, header);
            file.setFrameBuffer(frame);
            file.writePixels(height);
        }  // the destructor completes the line offsets
        return stream.take();
    } catch (const std::exception& problem) {
        return failed("", std::string("cannot encode OpenEXR: ") + problem.what());
    }
}

}  // namespace rro
