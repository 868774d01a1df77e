// How well factors close and agree with one another, and the correction that makes them.
#pragma once

#include <cstdint>
#include <vector>

#include "format/result.h"
#include "solver/factors/view_factors.h"

namespace rro {

/// Adds row after row, and pairs that are not exact.
class ClosureMeter {
  public:
    explicit ClosureMeter(const std::vector<double>& area) : area_(area) {}
    void add_row(std::span<const Factor> row);
    /// there, back   A_i F_ij and A_j F_ji, m^2
    void add_pair(std::uint32_t i, std::uint32_t j, double there, double back);
    ClosureReport report() const;

  private:
    const std::vector<double>& area_;  // [G]
    ClosureReport report_;
    double weighted_defect_ = 0, weight_ = 0;
};

/// Closure and reciprocity of a matrix in memory. Changes nothing.
ClosureReport measure_closure(const Factors& factors);

/// What `close_rows` did.
struct Closing {
    std::vector<double> moved;  // [G] largest |change| of a factor in the row
    std::vector<double> sum_moved;  // [G] row sum after minus before
    double largest_move = 0;
    std::uint32_t worst_row = 0;
    int rounds = 0;
};

/// The least change of the exchanges K = A F, as sum (K' - K)^2 / K, that brings every row to 1 and keeps K' symmetric
/// and not negative. Zeros stay zeros. Pairs that come as two estimates are first averaged, by the inverse of their
/// variances. Standard errors stay as they are.
///
/// errors   Failed: no such factors exist, e.g. a row without any; names the row
/// source   Lagrange: K' = K (1 + m_i + m_j), a linear system in m solved by conjugate gradients; exchanges that would
///          become negative are held at 0 and the rest is solved again
Result<Closing> close_rows(Factors& factors);

}  // namespace rro
