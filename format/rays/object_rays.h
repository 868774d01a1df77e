// One object as Embree sees it: its triangles in the archive's local frame, float32. The only place that sees Embree.
//
// Scenes are built with RTC_SCENE_FLAG_ROBUST, one Embree scene per archive, shared by its instances. Rays come in the
// local frame relative to ObjectData::origin. Self hits are avoided by triangle number, not by an epsilon alone.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "format/geometry.h"

namespace rro {

/// In place of a triangle's number: none.
inline constexpr std::uint32_t kNoTriangle = 0xffffffffu;

/// A ray segment, origin + t direction, t in (t_min, t_max). The direction need not be unit.
struct ObjectRay {
    Vec3f origin;
    Vec3f direction;
    float t_min = 0;
    float t_max = 0;
};

/// The nearest hit; triangle is kNoTriangle where there is none. u, v are barycentric (corners 1 and 2).
struct ObjectHit {
    std::uint32_t triangle = kNoTriangle;
    float t = 0, u = 0, v = 0;
};

/// Triangles that a ray passes through: two by number (the ends of a near-field ray) and up to two half-open ranges
/// of triangle numbers (the end clusters of a far link).
struct IgnoredTriangles {
    std::uint32_t a = kNoTriangle, b = kNoTriangle;
    std::uint32_t range0_begin = 0, range0_end = 0;
    std::uint32_t range1_begin = 0, range1_end = 0;

    bool covers(std::uint32_t triangle) const {
        return triangle == a || triangle == b || (triangle >= range0_begin && triangle < range0_end) ||
               (triangle >= range1_begin && triangle < range1_end);
    }
};

/// Safe to share between threads after construction.
class ObjectRays {
  public:
    /// positions relative to the object's origin. Builds on the calling thread alone, so that the tree is the same for
    /// any number of threads; build several objects at a time.
    ///
    /// errors   throws std::bad_alloc where Embree runs out of memory
    ObjectRays(std::span<const Vec3f> positions, std::span<const TriangleIndices> triangles);
    ~ObjectRays();
    ObjectRays(ObjectRays&&) noexcept;
    ObjectRays& operator=(ObjectRays&&) noexcept;

    /// The nearest hit. Here and below origins and directions must be finite: Embree does not check.
    ObjectHit first_hit(const ObjectRay& ray, const IgnoredTriangles& ignored = {}) const;
    /// Does the ray hit anything?
    bool occluded(const ObjectRay& ray, const IgnoredTriangles& ignored = {}) const;

    /// blocked[i] |= ray i is occluded; rays already blocked on entry are not traced. Packets of 16 inside; best where
    /// neighbours in the list are coherent. blocked.size() == rays.size().
    void occluded(std::span<const ObjectRay> rays, std::span<std::uint8_t> blocked,
                  const IgnoredTriangles& ignored = {}) const;

    /// Nearest hits of coherent rays (neighbours in the list close together). hits.size() == rays.size().
    void first_hits(std::span<const ObjectRay> rays, std::span<ObjectHit> hits) const;

    /// Bytes that Embree holds for all objects of the process.
    static std::uint64_t memory_bytes();

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace rro
