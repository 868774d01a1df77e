// The n x n grids of directions that tables are stored over: which cell a direction falls in, the direction of a node,
// and the taps of bivariate interpolation with seams and poles handled.
//
// Nodes are cell centres. A direction is unit, in the object's own frame.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "format/geometry.h"

namespace rro {

/// How the unit square is folded over the sphere.
enum class GridMap : std::uint8_t {
    Octahedral = 0,  // equal treatment of all axes; the default, up to twice as accurate for the same numbers
    LatLong = 1,     // the paper's: column = longitude 0..2pi, row = latitude -pi/2..pi/2 [HAIN 89]
};

/// Four nodes and their weights; weights are >= 0 and sum to 1. Nodes may repeat (poles, seams).
struct DirectionTaps {
    std::array<std::uint32_t, 4> node;
    std::array<float, 4> weight;
};

/// An n x n grid of directions. Immutable after construction; safe to share between threads.
class DirectionGrid {
  public:
    /// n >= 2.
    DirectionGrid(GridMap map, std::uint32_t n);

    GridMap map() const { return map_; }
    std::uint32_t n() const { return n_; }
    std::uint32_t size() const { return n_ * n_; }  // D

    /// Unit direction of a node, node = row * n + column.
    const Vec3& direction(std::uint32_t node) const { return directions_[node]; }

    /// Lines of sight: what is the same along w and along -w needs one value for both. Where n is even, each node has an
    /// opposite one, and the first D / 2 nodes (rows below n / 2) hold one of each two; where n is odd, some nodes have
    /// none, and every node is a line of its own.
    std::uint32_t lines() const { return n_ % 2 == 0 ? size() / 2 : size(); }
    /// The line that a node lies on, below lines(): the node itself, or the one opposite.
    std::uint32_t line(std::uint32_t node) const;

    /// Solid angle that each node stands for (integral of its interpolation weight over the sphere), sr; they sum to
    /// 4 pi. Computed anew by quadrature over 256 D points. [D]
    std::vector<double> solid_angles() const;

    /// Taps of bivariate interpolation; `w` need not be unit but must not be 0.
    DirectionTaps taps(const Vec3& w) const;

    /// Interpolated value of a table of D entries.
    template <class T>
    double interpolate(std::span<const T> table, const Vec3& w) const {
        const DirectionTaps t = taps(w);
        double sum = 0;
        for (std::size_t i = 0; i < 4; ++i) sum += static_cast<double>(t.weight[i]) * static_cast<double>(table[t.node[i]]);
        return sum;
    }

  private:
    GridMap map_;
    std::uint32_t n_;
    std::vector<Vec3> directions_;  // [D]
};

}  // namespace rro
