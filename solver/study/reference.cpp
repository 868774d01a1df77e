#include "solver/study/reference.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <chrono>
#include <cmath>
#include <functional>
#include <mutex>

#include "format/parallel.h"
#include "format/sample_points.h"
#include "solver/visibility/scene_rays.h"

namespace rro {
namespace {

// Samples of a face come in batches of so many: stratified within, independent of one another, so that the spread of
// batch means gives the variance without bias. Few samples make smaller batches.
constexpr std::uint32_t kLargestBatch = 8;
constexpr std::uint32_t kFirstRoundBatches = 4;  // enough for a first guess of the error
constexpr std::uint32_t kMaxSamples = 1u << 24;  // per face; an accuracy that needs more is given up
constexpr int kSureBounces = 3;                  // before Russian roulette may end a path
constexpr std::size_t kFacesPerTask = 16;

/// A stream of random numbers in [0, 1) (SplitMix64), determined by its key.
class Stream {
  public:
    explicit Stream(std::uint64_t key) : state_(key) {}
    double next() {
        state_ += 0x9e3779b97f4a7c15ull;
        return static_cast<double>(mix64(state_) >> 11) * 0x1p-53;
    }

  private:
    std::uint64_t state_;
};

std::uint64_t hash_name(const std::string& name) {  // FNV-1a
    std::uint64_t hash = 0xcbf29ce484222325ull;
    for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ull;
    return hash;
}

/// A point on a face, where a path starts, bounces or samples an emitter.
struct Vertex {
    Vec3 position, normal;
    SceneTriangle on;
};

/// What one face has gathered. Sums are over batch means of irradiance, W/m^2, and of their squares.
struct FaceSums {
    Vec3 sum, squares;
    std::uint32_t batches = 0;
    std::uint32_t escaped = 0, absorbed_by_backs = 0;  // first segments that left the scene, or met a black back
};

struct FaceId {
    std::uint32_t instance = 0, face = 0;
};

/// The emitting faces, to be chosen by area times exitance (summed over channels).
struct Emitters {
    std::vector<FaceId> faces;
    std::vector<double> cumulative;  // W, ascending; the last is the total
    double total() const { return cumulative.empty() ? 0 : cumulative.back(); }
};

double channel_sum(const Vec3& v) {
    return v.x + v.y + v.z;
}
Vec3 squared(const Vec3& v) {
    return hadamard(v, v);
}

/// Traces paths; holds nothing that changes.
class Tracer {
  public:
    explicit Tracer(const Scene& scene) : scene_(scene), rays_(scene) {
        double power = 0;
        for (std::uint32_t i = 0; i < scene.instances.size(); ++i)
            for (std::uint32_t f = 0; f < scene.instances[i].data().faces.size(); ++f) {
                const double weight = area({i, f}) * channel_sum(exitance({i, f}));
                if (!(weight > 0)) continue;
                emitters_.faces.push_back({i, f});
                emitters_.cumulative.push_back(power += weight);
            }
    }

    bool dark() const { return emitters_.faces.empty(); }
    Vec3 reflectance(FaceId id) const { return of_patch(scene_.instances[id.instance].reflectance, id); }
    Vec3 exitance(FaceId id) const { return of_patch(scene_.instances[id.instance].exitance, id); }
    double area(FaceId id) const { return length(area_vector(corners(id))); }
    TriangleCorners corners(FaceId id) const {
        const Instance& instance = scene_.instances[id.instance];
        return instance.world_corners(instance.data().faces[id.face]);
    }

    Vertex vertex(FaceId id, const TriangleCorners& c, double u, double v) const {
        const auto [b1, b2] = square_to_triangle(u, v);
        const std::uint32_t triangle = scene_.instances[id.instance].data().faces[id.face].triangle();
        return {triangle_point(c, b1, b2), normalised(area_vector(c)), {id.instance, triangle}};
    }

    Vec3 irradiance(Vertex at, std::array<double, 2> direction, Stream& random, FaceSums& sums,
                    std::uint64_t& rays) const;

  private:
    Vec3 of_patch(const std::vector<Rgb>& values, FaceId id) const {
        return to_double(values[scene_.instances[id.instance].object->patch_of_face[id.face]]);
    }
    Vec3 direct(const Vertex& at, Stream& random, std::uint64_t& rays) const;

    /// Probability per area of choosing a point on an emitter of this exitance, 1/m^2.
    double choice_density(const Vec3& emitted) const { return channel_sum(emitted) / emitters_.total(); }

    const Scene& scene_;
    SceneRays rays_;
    Emitters emitters_;
};

/// Emitters' light at a point by one shadow ray, weighted against finding the emitter by chance (balance heuristic
/// [Veach & Guibas 1995]): M k / (p + k), with k = cos cos / (pi d^2) and p the density of the choice. It never exceeds
/// M, however close the emitter.
Vec3 Tracer::direct(const Vertex& at, Stream& random, std::uint64_t& rays) const {
    if (dark()) return {};
    const double chosen = random.next() * emitters_.total(), u = random.next(), v = random.next();
    const auto above = std::upper_bound(emitters_.cumulative.begin(), emitters_.cumulative.end() - 1, chosen);
    const FaceId id = emitters_.faces[static_cast<std::size_t>(above - emitters_.cumulative.begin())];
    const Vertex emitter = vertex(id, corners(id), u, v);
    const Vec3 d = emitter.position - at.position;
    const double cosines = dot(at.normal, d) * -dot(emitter.normal, d);  // times d^2
    if (!(dot(at.normal, d) > 0 && cosines > 0)) return {};
    ++rays;
    if (rays_.occluded(at.position, emitter.position, at.on, emitter.on)) return {};
    const double kernel = cosines / (M_PI * length2(d) * length2(d));
    const Vec3 emitted = exitance(id);
    return emitted / (1 + choice_density(emitted) / kernel);
}

/// One sample of the irradiance at a point: a path whose first direction comes from `direction` in the unit square.
Vec3 Tracer::irradiance(Vertex at, std::array<double, 2> direction, Stream& random, FaceSums& sums,
                        std::uint64_t& rays) const {
    Vec3 gathered, throughput{1, 1, 1};
    for (int bounce = 0;; ++bounce) {
        gathered += hadamard(throughput, direct(at, random, rays));
        const std::array<Vec3, 3> frame = frame_about(at.normal);
        const Vec3 local = square_to_cosine_hemisphere(direction[0], direction[1]);
        const Vec3 towards = frame[0] * local.x + frame[1] * local.y + frame[2] * local.z;
        ++rays;
        const SceneHit hit = rays_.first_hit(at.position, towards, at.on);
        if (hit.instance == kNoInstance) {
            if (bounce == 0) ++sums.escaped;
            return gathered;
        }
        const Instance& instance = scene_.instances[hit.instance];
        const Object& object = *instance.object;
        const FaceId id{hit.instance, (hit.side == Side::Front ? object.front_face : object.back_face)[hit.triangle]};
        if (id.face == kNoFace) {
            if (bounce == 0) ++sums.absorbed_by_backs;
            return gathered;
        }
        const TriangleCorners c = corners(id);
        at = {instance.to_world.point(triangle_point(instance.data().corners(hit.triangle), hit.b1, hit.b2)),
              normalised(area_vector(c)),
              {hit.instance, hit.triangle}};
        const Vec3 emitted = exitance(id);
        const double cosines = local.z * -dot(at.normal, towards);
        if (channel_sum(emitted) > 0 && cosines > 0) {
            const double kernel = cosines / (M_PI * hit.t * hit.t);
            gathered += hadamard(throughput, emitted) / (1 + choice_density(emitted) / kernel);
        }
        throughput = hadamard(throughput, reflectance(id));
        const double strongest = std::min(1.0, max_component(throughput));
        if (!(strongest > 0)) return gathered;
        if (bounce >= kSureBounces) {
            if (random.next() >= strongest) return gathered;
            throughput *= 1 / strongest;
        }
        direction = {random.next(), random.next()};
    }
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
    std::vector<FaceSums> sums;       // as faces
    std::uint32_t batch_size = kLargestBatch;
    std::uint64_t rays = 0;

    std::uint32_t batches() const { return sums.empty() ? 0 : sums.front().batches; }
};

Gathering nothing_gathered(const Scene& scene, const ReferenceOptions& options) {
    Gathering g;
    for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
        g.keys.push_back(mix64(hash_name(scene.instances[i].name) ^ mix64(options.seed)));
        for (std::uint32_t f = 0; f < scene.instances[i].data().faces.size(); ++f) g.faces.push_back({i, f});
    }
    g.sums.resize(g.faces.size());
    if (options.samples > 0)
        g.batch_size = std::min(kLargestBatch, std::bit_floor(std::max(1u, options.samples / kFirstRoundBatches)));
    return g;
}

void sample_face(const Tracer& tracer, FaceId id, std::uint64_t instance_key, std::uint32_t batch_size,
                 std::uint32_t batches, FaceSums& sums, std::uint64_t& rays) {
    const TriangleCorners corners = tracer.corners(id);
    const std::uint64_t face_key = mix64(instance_key + id.face);
    for (const std::uint32_t end = sums.batches + batches; sums.batches < end; ++sums.batches) {
        const std::uint64_t batch_key = mix64(face_key ^ sums.batches);
        Vec3 mean;
        for (std::uint32_t i = 0; i < batch_size; ++i) {
            const std::array<float, 4> u = sobol4(i, batch_key);
            Stream random(mix64(batch_key ^ i));
            mean += tracer.irradiance(tracer.vertex(id, corners, u[0], u[1]), {u[2], u[3]}, random, sums, rays);
        }
        mean *= 1.0 / batch_size;
        sums.sum += mean;
        sums.squares += squared(mean);
    }
}

/// Adds batches to every face; `report` gets the share done.
void sample_all(const Tracer& tracer, std::uint32_t batches, Gathering& g, const std::function<void(double)>& report) {
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

/// Relative standard error of R = B - M over all faces and channels, weighted by area. The noise in R^2 is subtracted.
double relative_error(const Tracer& tracer, const Gathering& g) {
    double noise = 0, signal = 0;
    for (std::size_t k = 0; k < g.faces.size(); ++k) {
        const FaceEstimate e = estimate(g.sums[k]);
        const double area = tracer.area(g.faces[k]);
        const Vec3 rho = tracer.reflectance(g.faces[k]);
        noise += area * dot(squared(rho), e.variance);
        signal += area * length2(hadamard(rho, e.irradiance));
    }
    if (noise == 0) return 0;
    return signal > noise ? std::sqrt(noise / (signal - noise)) : 1.0;
}

/// Doubles the samples until the error asked is reached, or takes the number asked.
void gather(const Tracer& tracer, const ReferenceOptions& options, const Progress& progress, Gathering& g,
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

/// Per face B = M + rho E; power that stays and leaves. First segments are distributed as the light that a face gives
/// off, so their shares that leave the scene or meet black backs are the shares of its radiosity that do.
void fill_solution(const Scene& scene, const Tracer& tracer, const Gathering& g, Solution& s) {
    s.instances.resize(scene.instances.size());
    for (std::size_t k = 0; k < g.faces.size(); ++k) {
        const FaceId id = g.faces[k];
        const FaceEstimate e = estimate(g.sums[k]);
        const Vec3 rho = tracer.reflectance(id), emitted = tracer.exitance(id);
        const Vec3 radiosity = emitted + hadamard(rho, e.irradiance);
        InstanceSolution& out = s.instances[id.instance];
        out.radiosity.push_back(to_float(radiosity));
        out.irradiance.push_back(to_float(e.irradiance));
        const Vec3 v = hadamard(squared(rho), e.variance);
        out.standard_error.push_back(to_float({std::sqrt(v.x), std::sqrt(v.y), std::sqrt(v.z)}));
        const double area = tracer.area(id);
        const double per_sample = area / (static_cast<double>(g.sums[k].batches) * g.batch_size);
        s.energy.emitted += emitted * area;
        s.energy.absorbed += hadamard(Vec3{1, 1, 1} - rho, e.irradiance) * area;
        s.energy.absorbed += radiosity * (per_sample * g.sums[k].absorbed_by_backs);
        s.energy.escaped += radiosity * (per_sample * g.sums[k].escaped);
    }
}

}  // namespace

Result<Solution> solve_reference(const Scene& scene, const ReferenceOptions& options, const Progress& progress) {
    if (options.samples == 0 && !(options.accuracy > 0))
        return Error{ErrorKind::Usage, "", "accuracy must be above 0, found " + std::to_string(options.accuracy), ""};
    if (options.samples > kMaxSamples)
        return Error{ErrorKind::Usage, "", "at most " + std::to_string(kMaxSamples) + " samples per triangle", ""};
    const auto start = std::chrono::steady_clock::now();
    const Tracer tracer(scene);
    Gathering g = nothing_gathered(scene, options);
    Solution solution;
    solution.accuracy = options.accuracy;
    gather(tracer, options, progress, g, solution);
    fill_solution(scene, tracer, g, solution);
    solution.rays = g.rays;
    solution.elements = g.faces.size();
    solution.seconds.iterate = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return solution;
}

}  // namespace rro
