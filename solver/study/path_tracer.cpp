#include "solver/study/path_tracer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace rro {
namespace {

using std::numbers::pi;

constexpr int kSureBounces = 3;  // before Russian roulette may end a path
constexpr double kEndless = std::numeric_limits<double>::infinity();

double channel_sum(const Vec3& v) {
    return v.x + v.y + v.z;
}

}  // namespace

PathTracer::PathTracer(const Scene& scene)
    : scene_(scene), rays_(scene), sky_is_sampled_(scene.sky && scene.sky->is_peaked()) {
    double power = 0;
    for (std::uint32_t i = 0; i < scene.instances.size(); ++i)
        for (std::uint32_t f = 0; f < scene.instances[i].data().faces.size(); ++f) {
            const double weight = area({i, f}) * channel_sum(exitance({i, f}));
            if (!(weight > 0)) continue;
            emitters_.faces.push_back({i, f});
            emitters_.cumulative.push_back(power += weight);
        }
}

std::uint32_t PathTracer::other_side(FaceId id) const {
    const Object& object = *instance(id).object;
    const Face face = object.data().faces[id.face];
    return (face.side() == Side::Front ? object.back_face : object.front_face)[face.triangle()];
}

PathVertex PathTracer::vertex(FaceId id, const TriangleCorners& c, double u, double v) const {
    const auto [b1, b2] = square_to_triangle(u, v);
    const std::uint32_t triangle = instance(id).data().faces[id.face].triangle();
    return {triangle_point(c, b1, b2), normalised(area_vector(c)), {id.instance, triangle}};
}

double PathTracer::choice_density(const Vec3& emitted) const {
    return channel_sum(emitted) / emitters_.total();
}

/// Emitters' light at a point by one shadow ray, weighted against finding the emitter by chance (balance heuristic
/// [Veach & Guibas 1995]): M k / (p + k), with k = cos cos / (pi d^2) and p the density of the choice. It never exceeds
/// M, however close the emitter.
Vec3 PathTracer::from_emitters(const PathVertex& at, RandomStream& random, std::uint64_t& rays) const {
    if (emitters_.faces.empty()) return {};
    const double chosen = random.next() * emitters_.total(), u = random.next(), v = random.next();
    const auto above = std::upper_bound(emitters_.cumulative.begin(), emitters_.cumulative.end() - 1, chosen);
    const FaceId id = emitters_.faces[static_cast<std::size_t>(above - emitters_.cumulative.begin())];
    const PathVertex emitter = vertex(id, corners(id), u, v);
    const Vec3 d = emitter.position - at.position;
    const double cosines = dot(at.normal, d) * -dot(emitter.normal, d);  // times d^2
    if (!(dot(at.normal, d) > 0 && cosines > 0)) return {};
    ++rays;
    if (rays_.occluded(at.position, emitter.position, at.on, emitter.on)) return {};
    const double kernel = cosines / (pi * length2(d) * length2(d));
    const Vec3 emitted = exitance(id);
    return hadamard(emitted / (1 + choice_density(emitted) / kernel), weakening(length(d)));
}

/// Does light from infinitely far arrive at a point?
bool PathTracer::leaves(const PathVertex& at, const Vec3& from) const {
    return rays_.first_hit(at.position, from, at.on).instance == kNoInstance;
}

/// A sky with bright spots is sampled by brightness too, weighted against finding them by chance (balance heuristic); of
/// any other sky, directions by cosine alone are as good.
Vec3 PathTracer::from_sky(const PathVertex& at, RandomStream& random, std::uint64_t& rays) const {
    if (!sky_is_sampled_) return {};
    const double u = random.next(), v = random.next();
    const Sky::Sample sample = scene_.sky->sample(u, v);
    const double cosine = dot(at.normal, sample.from);
    if (!(cosine > 0 && sample.density > 0)) return {};
    ++rays;
    if (!leaves(at, sample.from)) return {};
    return sample.radiance * (cosine / (sample.density + cosine / pi));
}

Vec3 PathTracer::from_sun(const PathVertex& at, RandomStream& random, std::uint64_t& rays) const {
    if (!scene_.sun) return {};
    const double u = random.next(), v = random.next();
    const Sun::Sample sample = scene_.sun->sample(u, v);
    const double cosine = dot(at.normal, sample.from);
    if (!(cosine > 0)) return {};
    ++rays;
    return leaves(at, sample.from) ? sample.irradiance * cosine : Vec3{};
}

/// Inverse square, cosine, and a shadow ray for each light.
Vec3 PathTracer::from_lights(const PathVertex& at, std::uint64_t& rays) const {
    Vec3 sum;
    for (const PointLight& light : scene_.lights) {
        const Vec3 d = light.position - at.position;
        const double distance = length(d), cosine = dot(at.normal, d) / distance;
        if (!(cosine > 0)) continue;
        const Vec3 intensity = light.intensity_towards(-d / distance);
        if (intensity == Vec3{}) continue;
        ++rays;
        if (rays_.occluded(at.position, light.position, at.on, {})) continue;
        sum += hadamard(intensity * (cosine / (distance * distance)), weakening(distance));
    }
    return sum;
}

/// What comes straight from sky, sun and lights, as far as it is not found by chance.
Vec3 PathTracer::from_outside(const PathVertex& at, RandomStream& random, std::uint64_t& rays) const {
    const Vec3 far = from_sky(at, random, rays) + from_sun(at, random, rays);
    return hadamard(far, weakening(kEndless)) + from_lights(at, rays);
}

/// The sky's part of the irradiance by a cosine-weighted direction that meets nothing. The medium is left out.
Vec3 PathTracer::missed(const Vec3& from, double cosine) const {
    if (!scene_.sky) return {};
    const Vec3 all = scene_.sky->radiance(from) * pi;
    return sky_is_sampled_ ? all * (cosine / (cosine + pi * scene_.sky->density(from))) : all;
}

/// Reflects or transmits diffusely: the path goes on from the side it met, or from the other one. Weakens `throughput`.
/// returns  whether there is anything left to follow
bool PathTracer::scatter(FaceId id, PathVertex& at, Vec3& throughput, RandomStream& random) const {
    const Vec3 rho = reflectance(id), tau = transmittance(id);
    const double reflected = max_component(rho), transmitted = max_component(tau);
    if (transmitted > 0 && random.next() * (reflected + transmitted) < transmitted) {
        at.normal = -at.normal;
        throughput = hadamard(throughput, tau) * ((reflected + transmitted) / transmitted);
    } else if (reflected > 0) {
        throughput = hadamard(throughput, rho) * ((reflected + transmitted) / reflected);
    } else {
        return false;
    }
    return max_component(throughput) > 0;
}

Vec3 PathTracer::irradiance(PathVertex at, std::array<double, 2> direction, RandomStream& random, FirstSegments& first,
                            std::uint64_t& rays) const {
    Vec3 gathered, throughput{1, 1, 1};
    for (int bounce = 0;; ++bounce) {
        gathered += hadamard(throughput, from_emitters(at, random, rays));
        const Vec3 outside = from_outside(at, random, rays);
        gathered += hadamard(throughput, outside);
        if (bounce == 0) first.entering += outside;
        const std::array<Vec3, 3> frame = frame_about(at.normal);
        const Vec3 local = square_to_cosine_hemisphere(direction[0], direction[1]);
        const Vec3 towards = frame[0] * local.x + frame[1] * local.y + frame[2] * local.z;
        ++rays;
        const SceneHit hit = rays_.first_hit(at.position, towards, at.on);
        if (hit.instance == kNoInstance) {
            const Vec3 left = weakening(kEndless), sky = hadamard(missed(towards, local.z), left);
            if (bounce == 0) {
                first.escaped += left;
                first.absorbed += Vec3{1, 1, 1} - left;
                first.entering += sky;
            }
            return gathered + hadamard(throughput, sky);
        }
        const Instance& met = scene_.instances[hit.instance];
        const Object& object = *met.object;
        const FaceId id{hit.instance, (hit.side == Side::Front ? object.front_face : object.back_face)[hit.triangle]};
        if (id.face == kNoFace) {
            if (bounce == 0) first.absorbed += Vec3{1, 1, 1};
            return gathered;
        }
        const Vec3 left = weakening(hit.t);
        if (bounce == 0) first.absorbed += Vec3{1, 1, 1} - left;
        throughput = hadamard(throughput, left);
        at = {met.to_world.point(triangle_point(met.data().corners(hit.triangle), hit.b1, hit.b2)),
              normalised(area_vector(corners(id))),
              {hit.instance, hit.triangle}};
        const Vec3 emitted = exitance(id);
        const double cosines = local.z * -dot(at.normal, towards);
        if (channel_sum(emitted) > 0 && cosines > 0) {
            const double kernel = cosines / (pi * hit.t * hit.t);
            gathered += hadamard(throughput, emitted) / (1 + choice_density(emitted) / kernel);
        }
        if (!scatter(id, at, throughput, random)) return gathered;
        if (bounce >= kSureBounces) {
            const double strongest = std::min(1.0, max_component(throughput));
            if (random.next() >= strongest) return gathered;
            throughput *= 1 / strongest;
        }
        direction = {random.next(), random.next()};
    }
}

}  // namespace rro
