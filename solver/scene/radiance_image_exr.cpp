// OpenEXR pictures, read a row at a time.
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>

#include <cstring>
#include <exception>
#include <stdexcept>

#include "solver/scene/radiance_image.h"

namespace rro {
namespace {

constexpr int kMostTileSide = 2048;  // OpenEXR holds whole tiles
constexpr int kMostChannels = 8;     // and rows of all channels

/// Lets OpenEXR read from memory.
class MemoryStream : public Imf::IStream {
  public:
    MemoryStream(std::string_view bytes, const std::string& name) : Imf::IStream(name.c_str()), bytes_(bytes) {}
    bool read(char c[], int n) override {
        const auto count = static_cast<std::size_t>(n);
        if (n < 0 || position_ > bytes_.size() || count > bytes_.size() - position_)
            throw std::runtime_error("the file is cut short");
        std::memcpy(c, bytes_.data() + position_, count);
        position_ += count;
        return position_ < bytes_.size();
    }
    std::uint64_t tellg() override { return position_; }
    void seekg(std::uint64_t position) override { position_ = position; }

  private:
    std::string_view bytes_;
    std::size_t position_ = 0;
};

/// What cannot be used of a header, or nothing.
std::string fault(const Imf::Header& header) {
    const auto& data = header.dataWindow();
    const auto side = [](int lo, int hi) { return static_cast<std::int64_t>(hi) - lo + 1; };
    const std::int64_t width = side(data.min.x, data.max.x), height = side(data.min.y, data.max.y);
    if (width * height > kMostSkyPixels)
        return "has " + std::to_string(width) + " x " + std::to_string(height) + " pixels, expected at most " +
               std::to_string(kMostSkyPixels);
    if (!(data == header.displayWindow())) return "has a data window that is not its display window";
    const Imf::ChannelList& channels = header.channels();
    const bool rgb = channels.findChannel("R") && channels.findChannel("G") && channels.findChannel("B");
    if (!rgb && (!channels.findChannel("Y") || channels.findChannel("RY")))
        return "has no channels R, G, B, and no Y alone";
    int count = 0;
    for (auto channel = channels.begin(); channel != channels.end(); ++channel) {
        if (++count > kMostChannels) return "has more than " + std::to_string(kMostChannels) + " channels";
        if (channel.channel().xSampling != 1 || channel.channel().ySampling != 1) return "has subsampled channels";
    }
    return {};
}

}  // namespace

Result<RadianceImage> decode_exr(std::string_view bytes, const std::string& name) {
    try {
        Imf::Header::setMaxImageSize(kMostSkySide, kMostSkySide);  // checked before anything is allocated
        Imf::Header::setMaxTileSize(kMostTileSide, kMostTileSide);
        MemoryStream stream(bytes, name);
        Imf::InputFile file(stream, 1);
        if (const std::string problem = fault(file.header()); !problem.empty()) return bad_input(name, problem);
        const auto& window = file.header().dataWindow();
        const int width = window.max.x - window.min.x + 1, height = window.max.y - window.min.y + 1;
        const bool grey = !file.header().channels().findChannel("R");
        SkyRows rows(width, height);
        std::vector<Rgb> row(static_cast<std::size_t>(width));
        const char* const names[3] = {grey ? "Y" : "R", "G", "B"};
        Imf::FrameBuffer frame;  // every row goes to the same memory: no stride along y
        for (std::size_t c = 0; c < (grey ? 1u : 3u); ++c) {
            char* base = reinterpret_cast<char*>(row.data()) + c * sizeof(float) -
                         static_cast<std::ptrdiff_t>(sizeof(Rgb)) * window.min.x;
            frame.insert(names[c], Imf::Slice(Imf::FLOAT, base, sizeof(Rgb), 0));
        }
        file.setFrameBuffer(frame);
        for (int y = window.min.y; y <= window.max.y; ++y) {
            file.readPixels(y);
            if (grey)
                for (Rgb& pixel : row) pixel.y = pixel.z = pixel.x;
            if (auto added = rows.add(row); !added) return bad_input(name, added.error().message);
        }
        return rows.take();
    } catch (const std::exception& problem) {
        return bad_input(name, std::string("is no OpenEXR picture that can be read: ") + problem.what());
    }
}

}  // namespace rro
