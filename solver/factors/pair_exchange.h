// What two groups exchange: exactly where nothing is between, else the pairs of polygons that have something between.
#pragma once

#include <cstdint>
#include <vector>

#include "solver/factors/blockers.h"
#include "solver/factors/planar_kernel.h"
#include "solver/factors/surfaces.h"

namespace rro {

/// Faces of the two groups, by number, that see each other past something.
struct ObstructedPair {
    std::uint32_t a = 0, b = 0;
};

/// Two groups and what is known of their exchange.
struct GroupPair {
    std::uint32_t from = 0, to = 0;  // from <= to
    double exchange = 0;             // m^2: A_from F, of the pairs with nothing between
    bool known = false;              // all of it is in `exchange`, or to be added to it
    std::vector<ObstructedPair> obstructed;
    double seconds = 0;              // that cutting these will take, by the cost model
    bool sampled = false;            // left to rays
    double there = 0, back = 0;      // all together, integrated over `from` and over `to`
    double error_there = 0, error_back = 0;
};

/// What all pairs share. Safe to share between threads.
struct PairWork {
    PairWork(const Surfaces& surfaces_, const Blockers& blockers_, double accuracy_);

    const Surfaces& surfaces;
    const Blockers& blockers;
    double accuracy;
    std::vector<Box3> boxes;  // [G]
};

/// Room for one thread to work in.
struct PairScratch {
    FacingPair facing;
    PairHull hull;
    Between between;
};

/// What groups i <= j exchange with nothing between; m^2.
double exact_exchange(const PairWork& work, std::uint32_t i, std::uint32_t j, PairScratch& scratch);

/// Lists what has something between. A pair with too much between for cutting comes back as `sampled`; one of few
/// polygons with nothing between is not `known`: its exact exchange has not been computed.
GroupPair find_pair(const PairWork& work, std::uint32_t i, std::uint32_t j, PairScratch& scratch);

/// Adds the obstructed pairs, integrated over either end, to what is exact.
void cut_out(const PairWork& work, GroupPair& pair);

}  // namespace rro
