// Files that lights are read from. The first byte chooses: photometric files (IES LM-63) or pictures of the sky (Radiance,
// OpenEXR); the rest is the file.
#include <cmath>
#include <string_view>

#include "solver/scene/ies.h"
#include "solver/scene/lights.h"
#include "solver/scene/radiance_image.h"
#include "tests/fuzz/reading.h"

namespace {

using namespace rro;
using fuzz::require;

void check_web(const IesDistribution& web) {
    for (double vertical = 0; vertical <= 180; vertical += 30)
        for (double horizontal = -90; horizontal <= 450; horizontal += 60) {
            const double candela = web.intensity(vertical, horizontal);
            require(candela >= 0 && candela <= web.largest() * (1 + 1e-12), "intensities lie between those of the file");
        }
}

void check_sky(RadianceImage image) {
    require(image.width >= 1 && image.height >= 1 && image.width <= kSkyWidth && image.height <= kSkyHeight,
            "no more is kept than is allowed");
    require(image.pixels.size() == static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height),
            "pictures are whole");
    for (const Rgb& pixel : image.pixels)
        require(is_finite(to_double(pixel)) && pixel.x >= 0 && pixel.y >= 0 && pixel.z >= 0, "radiances are finite");
    const Sky sky = Sky::image(image.width, image.height, std::move(image.pixels), false);
    if (sky.dark()) return;
    const Sky::Sample sample = sky.sample(0.3, 0.7);
    require(std::abs(length(sample.from) - 1) < 1e-9 && sample.density >= 0, "directions can be chosen");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size == 0) return 0;
    const std::string_view file(reinterpret_cast<const char*>(data) + 1, size - 1);
    if (data[0] % 2 == 0) {
        if (const auto web = parse_ies(file, "lamp.ies")) check_web(*web);
    } else if (auto image = decode_sky_image(file, "sky")) {
        check_sky(std::move(*image));
    }
    return 0;
}
