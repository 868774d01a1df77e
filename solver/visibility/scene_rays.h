// Rays through a whole scene: an instance tree in double precision over the objects' own ray structures. A ray is made
// in double, taken into an archive's local frame, and only then rounded to float.
//
// End points that lie on a triangle (given with it) are first drawn inside by some float roundings of the object's
// largest coordinate, 1e-6 of it: so edges where walls meet neither leak nor block.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "format/rays/object_rays.h"
#include "solver/scene/scene.h"

namespace rro {

/// In place of an instance's number: none.
inline constexpr std::uint32_t kNoInstance = 0xffffffffu;

/// A triangle of the scene.
struct SceneTriangle {
    std::uint32_t instance = kNoInstance;
    std::uint32_t triangle = kNoTriangle;
};

/// What a ray meets first.
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
    /// returns  whether there are no more than `most`; else the list is cut short
    bool candidates(const Box3& a, const Box3& b, Candidates& out, std::size_t most = kNoInstance) const;

    /// Is the open segment from p to q blocked by a triangle other than the two ends' own, of the instances listed?
    bool occluded(const Vec3& p, const Vec3& q, const SceneTriangle& p_on, const SceneTriangle& q_on,
                  std::span<const std::uint32_t> candidates) const;

    /// The same against all instances, found on the way, but those that `passed` names: for single segments without a
    /// shaft, or with too many candidates in it.
    bool occluded(const Vec3& p, const Vec3& q, const SceneTriangle& p_on, const SceneTriangle& q_on,
                  const std::array<std::uint32_t, 2>& passed = {kNoInstance, kNoInstance}) const;

    /// The same for many segments with common ends and candidates, several at a time: blocked[i] = 1 or 0.
    void occluded(std::span<const Vec3> p, std::span<const Vec3> q, const SceneTriangle& p_on,
                  const SceneTriangle& q_on, std::span<const std::uint32_t> candidates,
                  std::span<std::uint8_t> blocked) const;

  private:
    struct Node {
        Box3 box;
        std::uint32_t first = 0, count = 0;  // leaf: into order_
        std::uint32_t right = 0;             // inner: left is the next node
    };
    /// An instance as a ray meets it.
    struct Place {
        Affine3 to_local;        // from the world to the archive's frame, relative to ObjectData::origin
        Affine3 to_world;        // and back
        double coordinates = 0;  // largest absolute local coordinate of the object
        const ObjectRays* rays = nullptr;
        std::span<const Vec3f> positions;
        std::span<const TriangleIndices> triangles;
    };
    struct LocalHit;
    struct Shrink;

    Shrink shrink(const SceneTriangle& on) const;
    void build(std::uint32_t first, std::uint32_t count);
    static LocalHit hit_in(const Place& place, const Vec3& origin, const Vec3& direction, double t_max,
                           std::uint32_t ignored);
    bool occluded_by(std::uint32_t instance, const Vec3& p, const Vec3& q, const SceneTriangle& p_on,
                     const SceneTriangle& q_on) const;

    const Scene& scene_;
    std::vector<Place> places_;         // [instances]
    std::vector<Node> nodes_;           // preorder
    std::vector<std::uint32_t> order_;  // instances in the order of the leaves
};

}  // namespace rro
