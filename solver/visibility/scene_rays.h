// Rays through a whole scene: an instance tree in double precision over the objects' own ray structures. A ray is made
// in double, taken into an archive's local frame, and only then rounded to float.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "format/rays/object_rays.h"
#include "solver/scene/scene.h"

namespace rro {

inline constexpr std::uint32_t kNoInstance = 0xffffffffu;

/// A triangle of the scene.
struct SceneTriangle {
    std::uint32_t instance = kNoInstance;
    std::uint32_t triangle = kNoTriangle;
};

struct SceneHit {
    std::uint32_t instance = kNoInstance;  // kNoInstance: nothing was hit
    std::uint32_t triangle = kNoTriangle;  // of the archive
    Side side = Side::Front;               // the side that the ray came from
    double t = 0;                          // along the ray's direction
    double b1 = 0, b2 = 0;                 // barycentric, of ObjectData::corners(triangle) 1 and 2
};

/// Candidate occluders of a shaft: instances whose bounds it meets, ascending by number.
using Candidates = std::vector<std::uint32_t>;

/// Safe to share between threads after construction. Keeps a reference to the scene.
class SceneRays {
  public:
    explicit SceneRays(const Scene& scene);

    /// Nearest hit along origin + t direction, t > 0; passes through `ignored`. Hits of black backs count as hits.
    SceneHit first_hit(const Vec3& origin, const Vec3& direction, const SceneTriangle& ignored = {}) const;

    /// Instances whose bounds meet the convex hull of two boxes (conservatively).
    void candidates(const Box3& a, const Box3& b, Candidates& out) const;

    /// Is the open segment from p to q blocked by a triangle other than the two ends' own, of the instances listed?
    bool occluded(const Vec3& p, const Vec3& q, const SceneTriangle& p_on, const SceneTriangle& q_on,
                  std::span<const std::uint32_t> candidates) const;

    /// The same for many segments with common ends and candidates, several at a time: blocked[i] = 1 or 0.
    void occluded(std::span<const Vec3> p, std::span<const Vec3> q, const SceneTriangle& p_on, const SceneTriangle& q_on,
                  std::span<const std::uint32_t> candidates, std::span<std::uint8_t> blocked) const;

  private:
    struct Node {
        Box3 box;
        std::uint32_t first = 0, count = 0;  // leaf: into order_
        std::uint32_t right = 0;             // inner: left is the next node
    };
    const Scene& scene_;
    std::vector<Node> nodes_;
    std::vector<std::uint32_t> order_;
};

}  // namespace rro
