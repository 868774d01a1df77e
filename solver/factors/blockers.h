// What may stand between two polygons: a tree over the bodies that can block at all, and the hull of a pair.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "solver/factors/surfaces.h"

namespace rro {

/// A half-space normal . x <= offset.
struct HullSide {
    Vec3 normal;  // unit
    double offset = 0;
};

/// The space between two polygons, each in front of the other: what does not reach into it cannot block.
struct PairHull {
    std::vector<HullSide> sides;  // the two planes of the polygons first
    Box3 box;
};

/// The hull of both, open towards neither: planes of both polygons, and planes through an edge of one and a corner of
/// the other with both on one side. Where the polygons are large (tens of corners), planes of some edges only.
void make_pair_hull(std::span<const Vec3> a, const HullSide& behind_a, std::span<const Vec3> b, const HullSide& behind_b,
                    PairHull& hull);

/// What reaches into a hull.
struct Between {
    std::vector<std::uint32_t> bodies;  // into Surfaces::bodies
    std::vector<std::uint32_t> solids;  // into Surfaces::solids

    bool empty() const { return bodies.empty() && solids.empty(); }
};

/// The tree. Safe to share between threads.
class Blockers {
  public:
    /// Keeps a reference to the surfaces. Those with all of the scene on one side of their plane can block nothing and are
    /// left out: a convex room has no blockers.
    explicit Blockers(const Surfaces& surfaces);

    bool empty() const { return nodes_.empty(); }
    std::size_t size() const { return order_.size(); }

    /// Bodies and solids that reach into a hull, ascending. Those of its ends lie in their planes and do not.
    /// whole    solids count as one; else their bodies are listed
    /// returns  whether there are no more than `most` of both; else the lists are cut short
    bool reach_into(const PairHull& hull, std::size_t most, bool whole, Between& found) const;

    /// Whether any body that `counts` accepts meets the box around both boxes.
    bool any_between(const Box3& a, const Box3& b, const std::function<bool(std::uint32_t)>& counts) const;

  private:
    struct Node {
        Box3 box;
        std::uint32_t first = 0, count = 0;  // leaf: into order_
        std::uint32_t right = 0;             // inner: left is the next node
    };
    void build(std::uint32_t first, std::uint32_t count);

    const std::vector<Body>& bodies_;
    std::vector<Box3> boxes_;           // [bodies]
    std::vector<Node> nodes_;           // preorder
    std::vector<std::uint32_t> order_;  // bodies in the order of the leaves
};

}  // namespace rro
