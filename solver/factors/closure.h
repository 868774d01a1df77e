// How well factors close and agree with one another, and the correction that makes them.
#pragma once

#include <cstdint>
#include <vector>

#include "format/result.h"
#include "solver/factors/view_factors.h"

namespace rro {

struct ClosureReport {
    std::vector<double> row_sum;         // [G]
    double largest_defect = 0;           // of |row sum - 1|
    std::uint32_t worst_row = 0;
    double mean_defect = 0;              // area-weighted mean of |row sum - 1|
    double largest_asymmetry = 0;        // of |A_i F_ij - A_j F_ji| / the smaller group's area
    double largest_relative_asymmetry = 0;  // the same relative to the larger of both, where a factor is above 0.01
    std::uint32_t asymmetric_from = 0, asymmetric_to = 0;
};

/// Says how far rows are from 1 (an open scene leaves 1 what escapes) and pairs from reciprocity. Changes nothing.
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
