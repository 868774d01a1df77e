#include "solver/study/reference.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <functional>
#include <mutex>

#include "format/clock.h"
#include "format/parallel.h"
#include "format/sample_points.h"
#include "solver/study/path_tracer.h"

namespace rro {
namespace {

// Samples of a face come in batches of so many: stratified within, independent of one another, so that the spread of
// batch means gives the variance without bias. Few samples make smaller batches.
constexpr std::uint32_t kLargestBatch = 8;
constexpr std::uint32_t kFirstRoundBatches = 4;  // enough for a first guess of the error
constexpr std::uint32_t kMaxSamples = 1u << 24;  // per face; an accuracy that needs more is given up
constexpr std::size_t kFacesPerTask = 16;

std::uint64_t hash_name(const std::string& name) {  // FNV-1a
    std::uint64_t hash = 0xcbf29ce484222325ull;
    for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ull;
    return hash;
}

/// What one face has gathered. Sums are over batch means of irradiance, W/m^2, and of their squares.
struct FaceSums {
    Vec3 sum, squares;
    std::uint32_t batches = 0;
    FirstSegments first;
};

Vec3 squared(const Vec3& v) {
    return hadamard(v, v);
}

/// Unbiased estimates that a face's sums give.
struct FaceEstimate {
    Vec3 irradiance, variance;  // W/m^2, and the variance of that mean
};

FaceEstimate estimate(const FaceSums& s) {
    const double n = s.batches;
    const Vec3 mean = s.sum / n;
    const Vec3 spread = s.squares / n - squared(mean);
    const auto variance = [&](double channel) { return std::max(0.0, channel) / (n - 1); };
    return {mean, {variance(spread.x), variance(spread.y), variance(spread.z)}};
}

/// All faces of the scene with what they have gathered.
struct Gathering {
    std::vector<FaceId> faces;
    std::vector<std::uint64_t> keys;  // [instances] of the random streams
    std::vector<std::size_t> first;   // [instances] place of its first face among faces
    std::vector<FaceSums> sums;       // as faces
    std::uint32_t batch_size = kLargestBatch;
    std::uint64_t rays = 0;

    std::uint32_t batches() const { return sums.empty() ? 0 : sums.front().batches; }
};

Gathering nothing_gathered(const Scene& scene, const ReferenceOptions& options) {
    Gathering g;
    for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
        g.first.push_back(g.faces.size());
        g.keys.push_back(mix64(hash_name(scene.instances[i].name) ^ mix64(options.seed)));
        for (std::uint32_t f = 0; f < scene.instances[i].data().faces.size(); ++f) g.faces.push_back({i, f});
    }
    g.sums.resize(g.faces.size());
    if (options.samples > 0)
        g.batch_size = std::min(kLargestBatch, std::bit_floor(std::max(1u, options.samples / kFirstRoundBatches)));
    return g;
}

void sample_face(const PathTracer& tracer, FaceId id, std::uint64_t instance_key, std::uint32_t batch_size,
                 std::uint32_t batches, FaceSums& sums, std::uint64_t& rays) {
    const TriangleCorners corners = tracer.corners(id);
    const std::uint64_t face_key = mix64(instance_key + id.face);
    for (const std::uint32_t end = sums.batches + batches; sums.batches < end; ++sums.batches) {
        const std::uint64_t batch_key = mix64(face_key ^ sums.batches);
        Vec3 mean;
        for (std::uint32_t i = 0; i < batch_size; ++i) {
            const std::array<float, 4> u = sobol4(i, batch_key);
            RandomStream random(mix64(batch_key ^ i));
            mean += tracer.irradiance(tracer.vertex(id, corners, u[0], u[1]), {u[2], u[3]}, random, sums.first, rays);
        }
        mean *= 1.0 / batch_size;
        sums.sum += mean;
        sums.squares += squared(mean);
    }
}

/// Adds batches to every face; `report` gets the share done.
void sample_all(const PathTracer& tracer, std::uint32_t batches, Gathering& g, const std::function<void(double)>& report) {
    std::atomic<std::uint64_t> rays{0};
    std::atomic<std::size_t> done{0};
    std::mutex reporting;
    parallel_chunks(g.faces.size(), kFacesPerTask, [&](std::size_t begin, std::size_t end) {
        std::uint64_t chunk_rays = 0;
        for (std::size_t k = begin; k < end; ++k)
            sample_face(tracer, g.faces[k], g.keys[g.faces[k].instance], g.batch_size, batches, g.sums[k], chunk_rays);
        rays += chunk_rays;
        done += end - begin;
        if (const std::unique_lock lock(reporting, std::try_to_lock); lock)
            report(static_cast<double>(done.load()) / static_cast<double>(g.faces.size()));
    });
    g.rays += rays;
}

/// Reflected radiosity R = B - M of a face: rho E, and tau E of its other side.
struct Reflected {
    Vec3 mean, variance;  // W/m^2, and of that mean; both sides' samples are independent
};

Reflected reflected(const PathTracer& tracer, const Gathering& g, std::size_t k) {
    const FaceEstimate here = estimate(g.sums[k]);
    const Vec3 rho = tracer.reflectance(g.faces[k]), tau = tracer.transmittance(g.faces[k]);
    Reflected r{hadamard(rho, here.irradiance), hadamard(squared(rho), here.variance)};
    if (tau != Vec3{}) {
        const FaceEstimate behind = estimate(g.sums[g.first[g.faces[k].instance] + tracer.other_side(g.faces[k])]);
        r.mean += hadamard(tau, behind.irradiance);
        r.variance += hadamard(squared(tau), behind.variance);
    }
    return r;
}

/// Relative standard error of R over all faces and channels, weighted by area. The noise in R^2 is subtracted.
double relative_error(const PathTracer& tracer, const Gathering& g) {
    double noise = 0, signal = 0;
    for (std::size_t k = 0; k < g.faces.size(); ++k) {
        const Reflected r = reflected(tracer, g, k);
        const double area = tracer.area(g.faces[k]);
        noise += area * (r.variance.x + r.variance.y + r.variance.z);
        signal += area * length2(r.mean);
    }
    if (noise == 0) return 0;
    return signal > noise ? std::sqrt(noise / (signal - noise)) : 1.0;
}

/// Doubles the samples until the error asked is reached, or takes the number asked.
void gather(const PathTracer& tracer, const ReferenceOptions& options, const Progress& progress, Gathering& g,
            Solution& s) {
    double from = 0, to = 1;
    const auto report = [&](double share) {
        if (progress) progress("reference", from + (to - from) * share);
    };
    std::uint32_t batches = kFirstRoundBatches;
    if (options.samples > 0) batches = std::max(2u, (options.samples + g.batch_size - 1) / g.batch_size);
    if (options.samples == 0) to = 0;  // how far the first round leads is not known yet
    for (;;) {
        sample_all(tracer, batches, g, report);
        ++s.iterations;
        s.estimated_error = relative_error(tracer, g);
        s.converged = options.samples > 0 || s.estimated_error <= options.accuracy;
        batches = g.batches();  // as many again
        if (s.converged || batches * 2 * g.batch_size > kMaxSamples) return;
        const double needed = std::pow(s.estimated_error / options.accuracy, 2);
        from = std::min(1.0, 1 / needed), to = std::min(1.0, 2 / needed);
    }
}

/// Per face B = M + R; power that comes, stays and leaves.
void fill_solution(const Scene& scene, const PathTracer& tracer, const Gathering& g, Solution& s) {
    s.instances.resize(scene.instances.size());
    for (std::size_t k = 0; k < g.faces.size(); ++k) {
        const FaceId id = g.faces[k];
        const Vec3 irradiance = estimate(g.sums[k]).irradiance, emitted = tracer.exitance(id);
        const Reflected r = reflected(tracer, g, k);
        const Vec3 radiosity = emitted + r.mean;
        InstanceSolution& out = s.instances[id.instance];
        out.radiosity.push_back(to_float(radiosity));
        out.irradiance.push_back(to_float(irradiance));
        out.standard_error.push_back(to_float({std::sqrt(r.variance.x), std::sqrt(r.variance.y), std::sqrt(r.variance.z)}));
        const double area = tracer.area(id);
        const double per_sample = area / (static_cast<double>(g.sums[k].batches) * g.batch_size);
        const FirstSegments& first = g.sums[k].first;
        s.energy.emitted += emitted * area + first.entering * per_sample;
        s.energy.absorbed +=
            hadamard(Vec3{1, 1, 1} - tracer.reflectance(id) - tracer.transmittance(id), irradiance) * area;
        s.energy.absorbed += hadamard(radiosity, first.absorbed) * per_sample;
        s.energy.escaped += hadamard(radiosity, first.escaped) * per_sample;
    }
}

}  // namespace

Result<Solution> solve_reference(const Scene& scene, const ReferenceOptions& options, const Progress& progress) {
    if (options.samples == 0 && !(options.accuracy > 0))
        return Error{ErrorKind::Usage, "", "accuracy must be above 0, found " + std::to_string(options.accuracy), ""};
    if (options.samples > kMaxSamples)
        return Error{ErrorKind::Usage, "", "at most " + std::to_string(kMaxSamples) + " samples per triangle", ""};
    const auto start = Clock::now();
    const PathTracer tracer(scene);
    Gathering g = nothing_gathered(scene, options);
    Solution solution;
    solution.accuracy = options.accuracy;
    gather(tracer, options, progress, g, solution);
    fill_solution(scene, tracer, g, solution);
    solution.rays = g.rays;
    solution.elements = g.faces.size();
    solution.seconds.iterate = seconds_since(start);
    return solution;
}

}  // namespace rro
