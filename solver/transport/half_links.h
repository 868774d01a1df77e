// Links as receivers read them: for every node a row of what brings it light, ready to be multiplied.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "solver/scene/built_in.h"
#include "solver/transport/link.h"

namespace rro {

/// The two halves of every link, each in its receiver's row, for C channels. Rows that links leave stay as unused numbers
/// until clear().
template <int C>
class HalfLinks {
  public:
    /// Between surfaces, or from a flat node to a surface: E += gain * B.
    struct Scalar {
        std::uint32_t source;
        float gain;
    };
    struct Directed {
        std::uint32_t source;
        float gain;
        Vec3f u;                 // unit, world, towards the source
        Vec3f slope;             // Flat receivers: change of irradiance over position, per light received, 1/m
        float inverse_distance;
        EndMode source_mode, receiver_mode;
    };
    /// Where the half links of one receiver lie.
    struct Row {
        std::uint32_t first = 0, last = 0;
    };
    using Tint = std::array<float, C>;

    explicit HalfLinks(const Nodes& nodes);

    /// New nodes have empty rows.
    void grow();
    /// Empties all rows.
    void clear();
    /// Empties the row of one node.
    void drop(std::uint32_t node);
    /// Fills the rows of the nodes wanted, [nodes], which are empty.
    void add(const std::vector<Link>& links, const std::vector<std::uint8_t>& wanted);

    /// Are there more numbers that no row uses than an edit may leave?
    bool mostly_unused() const;

    Row scalar_row(std::uint32_t node) const { return scalar_row_[node]; }
    Row directed_row(std::uint32_t node) const { return directed_row_[node]; }
    const Scalar& scalar(std::uint32_t k) const { return scalar_[k]; }
    const Directed& directed(std::uint32_t k) const { return directed_[k]; }

    /// Does a medium take more from some channels than from others? Then links carry tints.
    bool tinted() const { return built_in("medium") && C > 1 && absorption_; }
    const Tint& scalar_tint(std::uint32_t k) const { return scalar_tint_[k]; }
    const Tint& directed_tint(std::uint32_t k) const { return directed_tint_[k]; }

    std::uint64_t bytes() const { return scalar_.size() * sizeof(Scalar) + directed_.size() * sizeof(Directed); }

  private:
    /// Half of a link: where it belongs in the receiver's row.
    struct Half {
        const Link* link;
        std::uint32_t at;
        bool at_a, scalar;
    };
    void count(const std::vector<Link>& links, const std::vector<std::uint8_t>& wanted);
    void set(const Half& half);

    const Nodes& nodes_;
    std::vector<Row> scalar_row_, directed_row_;  // [nodes]
    std::size_t used_ = 0;                        // that rows refer to; the vectors below hold others, too
    std::vector<Scalar> scalar_;
    std::vector<Directed> directed_;
    std::optional<Vec3> absorption_;  // 1/m: per channel beyond the channel of least; none where all are alike
    std::vector<Tint> scalar_tint_, directed_tint_;  // [links] what it leaves; empty without
};

/// Does a link bring any light, and does it end at a node that is wanted?
inline bool concerns(const Link& link, const std::vector<std::uint8_t>& wanted) {
    return (link.base_a != 0 || link.base_b != 0) && (wanted[link.a] || wanted[link.b]);
}

}  // namespace rro
