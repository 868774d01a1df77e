// Paths of light through a scene, for the reference: unbiased samples of irradiance.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "format/sample_points.h"
#include "solver/scene/scene.h"
#include "solver/visibility/scene_rays.h"

namespace rro {

/// A stream of random numbers in [0, 1) (SplitMix64), determined by its key.
class RandomStream {
  public:
    explicit RandomStream(std::uint64_t key) : state_(key) {}
    double next() {
        state_ += 0x9e3779b97f4a7c15ull;
        return static_cast<double>(mix64(state_) >> 11) * 0x1p-53;
    }

  private:
    std::uint64_t state_;
};

/// A face of an instance, by numbers.
struct FaceId {
    std::uint32_t instance = 0, face = 0;
};

/// A point on a face, where a path starts, bounces or samples an emitter.
struct PathVertex {
    Vec3 position, normal;
    SceneTriangle on;
};

/// Where the first segments of a face's paths led. They are distributed as the light that the face gives off, so the
/// shares, per channel, are those of its radiosity. Sums over samples.
struct FirstSegments {
    Vec3 escaped;   // left the scene
    Vec3 absorbed;  // met a black back, or ended in the medium
    Vec3 entering;  // W/m^2 of irradiance straight from sky, sun and lights
};

/// Safe to share between threads. Keeps a reference to the scene.
class PathTracer {
  public:
    explicit PathTracer(const Scene& scene);

    Vec3 reflectance(FaceId id) const { return to_double(instance(id).reflectance[patch(id)]); }
    Vec3 transmittance(FaceId id) const { return to_double(instance(id).transmittance_of(patch(id))); }
    Vec3 exitance(FaceId id) const { return to_double(instance(id).exitance[patch(id)]); }
    TriangleCorners corners(FaceId id) const { return instance(id).world_corners(instance(id).data().faces[id.face]); }
    double area(FaceId id) const { return length(area_vector(corners(id))); }

    /// The same triangle's other side; kNoFace where it has one only.
    std::uint32_t other_side(FaceId id) const;

    /// The point of a face that belongs to a point of the unit square; `c` are its corners.
    PathVertex vertex(FaceId id, const TriangleCorners& c, double u, double v) const;

    /// One sample of the irradiance at a point, W/m^2: a path whose first direction comes from `direction` in the unit
    /// square. Adds to `first` and to the number of rays.
    Vec3 irradiance(PathVertex at, std::array<double, 2> direction, RandomStream& random, FirstSegments& first,
                    std::uint64_t& rays) const;

  private:
    /// The emitting faces, to be chosen by area times exitance (summed over channels).
    struct Emitters {
        std::vector<FaceId> faces;
        std::vector<double> cumulative;  // W, ascending; the last is the total
        double total() const { return cumulative.empty() ? 0 : cumulative.back(); }
    };

    const Instance& instance(FaceId id) const { return scene_.instances[id.instance]; }
    std::uint32_t patch(FaceId id) const { return instance(id).object->patch_of_face[id.face]; }

    Vec3 from_emitters(const PathVertex& at, RandomStream& random, std::uint64_t& rays) const;
    Vec3 from_outside(const PathVertex& at, RandomStream& random, std::uint64_t& rays) const;
    Vec3 from_sky(const PathVertex& at, RandomStream& random, std::uint64_t& rays) const;
    Vec3 from_sun(const PathVertex& at, RandomStream& random, std::uint64_t& rays) const;
    Vec3 from_lights(const PathVertex& at, std::uint64_t& rays) const;
    Vec3 missed(const Vec3& from, double cosine) const;
    bool leaves(const PathVertex& at, const Vec3& from) const;
    Vec3 weakening(double distance) const { return scene_.medium ? scene_.medium->transmittance(distance) : Vec3{1, 1, 1}; }
    bool scatter(FaceId id, PathVertex& at, Vec3& throughput, RandomStream& random) const;

    /// Probability per area of choosing a point on an emitter of this exitance, 1/m^2.
    double choice_density(const Vec3& emitted) const;

    const Scene& scene_;
    SceneRays rays_;
    Emitters emitters_;
    bool sky_is_sampled_ = false;
};

}  // namespace rro
