// Whether a box lies outside of a shaft between two boxes, without rays.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "format/geometry.h"

namespace rro {

/// A half space n . x <= offset.
struct HalfSpace {
    Vec3 n;
    double offset = 0;

    bool misses(const Box3& box) const {
        return n.x * (n.x > 0 ? box.lo.x : box.hi.x) + n.y * (n.y > 0 ? box.lo.y : box.hi.y) +
                   n.z * (n.z > 0 ? box.lo.z : box.hi.z) >
               offset;
    }
};

/// The convex hull of two boxes. Its sides are planes of the boxes, or planes through parallel edges of both
/// [Haines & Wallace 1991]: in the projection along an axis, such a plane connects the same corner of both boxes, and
/// its normal points out of that corner.
class BoxHull {
  public:
    BoxHull(const Box3& a, const Box3& b) : bounds_(a) {
        bounds_.add(b);
        for (int axis = 0; axis < 3; ++axis) {
            const int i = (axis + 1) % 3, j = (axis + 2) % 3;
            for (const double si : {-1.0, 1.0})
                for (const double sj : {-1.0, 1.0}) {
                    const double ai = si > 0 ? a.hi[i] : a.lo[i], aj = sj > 0 ? a.hi[j] : a.lo[j];
                    const double ei = (si > 0 ? b.hi[i] : b.lo[i]) - ai, ej = (sj > 0 ? b.hi[j] : b.lo[j]) - aj;
                    // (ej, -ei) or its opposite; the axes' own planes are those of bounds_.
                    const double turn = ej * si > 0 ? 1 : -1;
                    if (ei == 0 || ej == 0 || -ei * turn * sj < 0) continue;
                    HalfSpace& side = sides_[static_cast<std::size_t>(count_++)];
                    side.n[i] = ej * turn, side.n[j] = -ei * turn;
                    side.offset = side.n[i] * ai + side.n[j] * aj;
                }
        }
    }

    /// Conservative: false where undecided.
    bool misses(const Box3& box) const {
        return !bounds_.overlaps(box) || std::any_of(sides_.begin(), sides_.begin() + count_,
                                                     [&](const HalfSpace& side) { return side.misses(box); });
    }

  private:
    Box3 bounds_;
    std::array<HalfSpace, 12> sides_;
    std::ptrdiff_t count_ = 0;
};

}  // namespace rro
