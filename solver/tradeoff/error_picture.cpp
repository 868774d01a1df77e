#include "solver/tradeoff/error_picture.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "format/atomic_file.h"
#include "format/parallel.h"
#include "solver/output/camera.h"
#include "solver/output/image_file.h"
#include "solver/output/seen_face.h"
#include "solver/visibility/scene_rays.h"

namespace rro {
namespace {

constexpr int kWidth = 640, kHeight = 360;
constexpr int kSide = 2;  // samples of a pixel: so many squared
constexpr Vec3 kNothing{128, 128, 128};

// sRGB codes at equal steps of the scale: night blue, violet, brick, amber, pale yellow.
constexpr std::array<Vec3, 5> kRamp{Vec3{12, 10, 46}, {92, 28, 118}, {190, 58, 84}, {245, 142, 50}, {255, 244, 178}};

Vec3 ramp(double error) {
    const double range = std::log(kMostShownError / kLeastShownError);
    const double share = error > 0 ? std::clamp(std::log(error / kLeastShownError) / range, 0.0, 1.0) : 0.0;
    const double place = share * (kRamp.size() - 1);
    const auto below = std::min(static_cast<std::size_t>(place), kRamp.size() - 2);
    const double t = place - static_cast<double>(below);
    return kRamp[below] * (1 - t) + kRamp[below + 1] * t;
}

std::uint8_t code(double value) {
    return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
}

}  // namespace

std::array<std::uint8_t, 3> error_colour(double error) {
    const Vec3 c = ramp(error);
    return {code(c.x), code(c.y), code(c.z)};
}

Status write_error_picture(const Scene& scene, const Solution& solution, const std::vector<std::vector<float>>& errors,
                           const std::filesystem::path& path) {
    const SceneRays rays(scene);
    constexpr double aspect = double(kWidth) / kHeight;
    const auto& wanted = scene.manifest.camera;
    const Camera camera = make_camera(wanted ? *wanted : choose_camera(scene, solution, rays, aspect), aspect);
    std::vector<std::uint8_t> pixels(std::size_t{3} * kWidth * kHeight);
    parallel_for(kHeight, 1, [&](std::size_t row) {
        for (int column = 0; column < kWidth; ++column) {
            Vec3 sum;
            for (int s = 0; s < kSide * kSide; ++s) {
                const double x = (column + (s % kSide + 0.5) / kSide) / kWidth;
                const double y = (static_cast<double>(row) + (s / kSide + 0.5) / kSide) / kHeight;
                const SeenFace seen = seen_face(scene, rays, camera.position, camera.direction(x, y));
                sum += seen.face == kNoFace ? kNothing : ramp(double(errors[seen.instance][seen.face]));
            }
            for (int c = 0; c < 3; ++c)
                pixels[(row * kWidth + static_cast<std::size_t>(column)) * 3 + static_cast<std::size_t>(c)] =
                    code(sum[c] / (kSide * kSide));
        }
    });
    const auto png = encode_png(pixels, kWidth, kHeight);
    if (!png) return failed(path.string(), png.error().message);
    return write_file_atomically(path, *png);
}

}  // namespace rro
