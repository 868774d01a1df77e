#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "format/atomic_file.h"
#include "format/parallel.h"
#include "format/sample_points.h"
#include "solver/output/camera.h"
#include "solver/output/exposure.h"
#include "solver/output/image_file.h"
#include "solver/output/output.h"
#include "solver/output/seen_face.h"
#include "solver/output/surface_mesh.h"
#include "solver/output/surface_sampler.h"
#include "solver/output/tone_map.h"

namespace rro {
namespace {

/// Pixels take a few samples first, and the rest only where those of their neighbourhood differ by more than this,
/// relatively. Neighbours count because an edge may cross a pixel between its first samples.
constexpr double kFlat = 0.04;
constexpr std::size_t kFirstSamples = 4;

/// Rays at most that measure the brightness of a picture.
constexpr int kExposureRays = 250'000;

constexpr std::uint64_t kPixelPattern = 1;  // seed of the sample points; one pattern for all pixels

/// Radiance along rays. Safe to share between threads.
class Eye {
  public:
    Eye(const Scene& scene, const Solution& solution, const SceneRays& rays)
        : scene_(scene), rays_(rays), meshes_(scene.instances.size()), samplers_(scene.instances.size()) {
        parallel_for(meshes_.size(), 1, [&](std::size_t i) {
            meshes_[i] = surface_mesh(scene.instances[i], solution.instances[i]);
            samplers_[i] = std::make_unique<SurfaceSampler>(meshes_[i]);
        });
    }

    /// W/(m^2 sr); sky and sun where nothing is hit, black on backs of one-sided surfaces.
    Vec3 radiance(const Vec3& origin, const Vec3& towards) const {
        const Vec3 direction = normalised(towards);
        const SeenFace seen = seen_face(scene_, rays_, origin, direction);
        if (seen.instance == kNoInstance)
            return weakened(background(direction), std::numeric_limits<double>::infinity());
        if (seen.face == kNoFace) return {};
        return weakened(samplers_[seen.instance]->radiosity(seen.face, seen.b1, seen.b2) / std::numbers::pi, seen.t);
    }

  private:
    Vec3 background(const Vec3& direction) const {
        const Vec3 sky = scene_.sky ? scene_.sky->radiance(direction) : Vec3{};
        return scene_.sun ? sky + scene_.sun->radiance(direction) : sky;
    }
    Vec3 weakened(const Vec3& radiance, double distance) const {
        return scene_.medium ? hadamard(radiance, scene_.medium->transmittance(distance)) : radiance;
    }

    const Scene& scene_;
    const SceneRays& rays_;
    std::vector<SurfaceMesh> meshes_;
    std::vector<std::unique_ptr<SurfaceSampler>> samplers_;
};

struct Film {
    int width = 0, height = 0;
    std::vector<std::array<float, 4>> pattern;  // places of the samples within a pixel

    std::size_t pixels() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
};

/// Samples of one pixel so far.
struct Pixel {
    Vec3f sum, lo, hi;
};

/// Means over pixels of `shade(radiance)`, rows from the top. Shading before the mean keeps the edges of lamps smooth on
/// screen.
template <class Shade>
class Exposure {
  public:
    Exposure(const Eye& eye, const Camera& camera, const Film& film, const Shade& shade)
        : eye_(eye), camera_(camera), film_(film), shade_(shade), first_(std::min(kFirstSamples, film.pattern.size())) {}

    /// put(index, value) stores a pixel.
    template <class Put>
    void run(const Put& put) {
        std::vector<Pixel> pixels(film_.pixels());
        for_each_pixel([&](std::size_t i, int column, int row) { pixels[i] = first_samples(column, row); });
        for_each_pixel([&](std::size_t i, int column, int row) {
            const Vec3 sum = to_double(pixels[i].sum);
            if (first_ == film_.pattern.size() || is_flat(pixels, column, row))
                put(i, sum / static_cast<double>(first_));
            else
                put(i, (sum + more_samples(column, row)) / static_cast<double>(film_.pattern.size()));
        });
    }

  private:
    template <class Body>
    void for_each_pixel(const Body& body) const {
        const auto width = static_cast<std::size_t>(film_.width);
        parallel_for(static_cast<std::size_t>(film_.height), 1, [&](std::size_t row) {
            for (std::size_t column = 0; column < width; ++column)
                body(row * width + column, static_cast<int>(column), static_cast<int>(row));
        });
    }

    Vec3 sample(int column, int row, std::size_t s) const {
        const std::array<float, 4>& place = film_.pattern[s];
        return shade_(eye_.radiance(camera_.position, camera_.direction((column + place[0]) / film_.width,
                                                                       (row + place[1]) / film_.height)));
    }
    Pixel first_samples(int column, int row) const {
        Vec3 sum;
        Box3 range;
        for (std::size_t s = 0; s < first_; ++s) {
            const Vec3 seen = sample(column, row, s);
            sum += seen;
            range.add(seen);
        }
        return {to_float(sum), to_float(range.lo), to_float(range.hi)};
    }
    Vec3 more_samples(int column, int row) const {
        Vec3 sum;
        for (std::size_t s = first_; s < film_.pattern.size(); ++s) sum += sample(column, row, s);
        return sum;
    }
    bool is_flat(const std::vector<Pixel>& pixels, int column, int row) const {
        Box3 range;
        for (int y = std::max(row - 1, 0); y <= std::min(row + 1, film_.height - 1); ++y)
            for (int x = std::max(column - 1, 0); x <= std::min(column + 1, film_.width - 1); ++x) {
                const Pixel& p = pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(film_.width) +
                                        static_cast<std::size_t>(x)];
                range.add(to_double(p.lo));
                range.add(to_double(p.hi));
            }
        return max_component(range.extent()) <= kFlat * max_component(range.hi);
    }

    const Eye& eye_;
    const Camera& camera_;
    const Film& film_;
    const Shade& shade_;
    const std::size_t first_;
};

/// Exposure from the middles of every n-th pixel, n as small as kExposureRays allows; in stops.
double measured_stops(const Eye& eye, const Camera& camera, const Film& film) {
    const double pixels = static_cast<double>(film.width) * film.height;
    const int stride = std::max(1, static_cast<int>(std::ceil(std::sqrt(pixels / kExposureRays))));
    const int columns = (film.width + stride - 1) / stride, rows = (film.height + stride - 1) / stride;
    std::vector<WeightedLuminance> samples(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
    parallel_for(samples.size(), 1024, [&](std::size_t i) {
        const int column = static_cast<int>(i % static_cast<std::size_t>(columns)) * stride;
        const int row = static_cast<int>(i / static_cast<std::size_t>(columns)) * stride;
        samples[i].luminance = luminance(eye.radiance(
            camera.position, camera.direction((column + 0.5) / film.width, (row + 0.5) / film.height)));
    });
    return std::log2(automatic_exposure(samples));
}

Result<std::string> linear_picture(const Eye& eye, const Camera& camera, const Film& film) {
    std::vector<Rgb> pixels(film.pixels());
    const auto shade = [](const Vec3& radiance) { return radiance; };
    Exposure(eye, camera, film, shade).run([&](std::size_t i, const Vec3& value) { pixels[i] = to_float(value); });
    return encode_exr(pixels, film.width, film.height);
}

Result<std::string> display_picture(const Eye& eye, const Camera& camera, const Film& film, double stops) {
    std::vector<std::uint8_t> codes(3 * film.pixels());
    const auto shade = [factor = std::exp2(stops)](const Vec3& radiance) { return tone_curve(radiance * factor); };
    Exposure(eye, camera, film, shade).run([&](std::size_t i, const Vec3& value) {
        for (int c = 0; c < 3; ++c) codes[3 * i + static_cast<std::size_t>(c)] = srgb_code(value[c]);
    });
    return encode_png(codes, film.width, film.height);
}

std::string lower_case_ending(const std::filesystem::path& path) {
    std::string ending = path.extension().string();
    for (char& c : ending)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return ending;
}

}  // namespace

Result<double> write_picture(const Scene& scene, const Solution& solution, const SceneRays& rays,
                             const PictureOptions& options, const std::filesystem::path& path) {
    const std::string ending = lower_case_ending(path);
    if (ending != ".png" && ending != ".exr")
        return Error{ErrorKind::Usage, path.string(), "a picture's name must end in .png or .exr", {}};
    if (options.width < 1 || options.height < 1 || options.samples_per_pixel < 1)
        return Error{ErrorKind::Usage, path.string(), "a picture needs at least one pixel and one sample", {}};

    Film film{options.width, options.height, {}};
    for (int s = 0; s < options.samples_per_pixel; ++s)
        film.pattern.push_back(sobol4(static_cast<std::uint32_t>(s), kPixelPattern));
    const double aspect = static_cast<double>(film.width) / film.height;
    const auto& wanted = scene.manifest.camera;
    const Camera camera = make_camera(wanted ? *wanted : choose_camera(scene, solution, rays, aspect), aspect);
    const Eye eye(scene, solution, rays);

    double stops = wanted && wanted->exposure ? *wanted->exposure : 0.0;
    if (ending == ".png" && !(wanted && wanted->exposure)) stops = measured_stops(eye, camera, film);
    const Result<std::string> bytes =
        ending == ".exr" ? linear_picture(eye, camera, film) : display_picture(eye, camera, film, stops);
    if (!bytes) return Error{bytes.error().kind, path.string(), bytes.error().message, {}};
    if (const Status written = write_file_atomically(path, *bytes); !written) return written.error();
    return ending == ".exr" ? 0.0 : stops;
}

}  // namespace rro
