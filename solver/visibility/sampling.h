// How many lines of a shaft are asked, and what their answers are worth (paper, section 3).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "solver/visibility/shaft.h"

namespace rro {

/// Standard deviation of means over Owen-scrambled points against independent ones, at tens of points (measured for penumbrae).
inline constexpr double kSobolGain = 0.6;

/// When rays suffice. m rays, v the share that passes.
enum class StopRule {
    Fixed,    // at `most`
    Paper,    // sqrt(v (1 - v) / m) is below the deviation: at once where the first rays agree
    Laplace,  // the same with v = (k + 1) / (m + 2) for k of m that pass: never certain of what it has not seen
    Edge,     // for links that may be divided instead: Laplace's, but few rays where they agree and no edge would do harm,
              // and none beyond what shows an edge that divides the link
};

/// Which lines: Owen-scrambled Sobol points, or independent ones as in the paper.
enum class LinePoints { Sobol, Independent };

/// How good an answer has to be.
struct Demand {
    StopRule rule = StopRule::Laplace;
    double deviation = 0.05;              // of the mean transmittance
    std::uint32_t first = 16, most = 144;  // rays; rounds are the squares between, and for Edge first times powers of 2
    double edge = 0;                      // Edge: how much a shadow's edge through the link harms; above 1 it divides
    LinePoints points = LinePoints::Sobol;
};

/// The demand of a link: `noise` times the variance of its mean may be 1 at most.
Demand link_demand(double noise, double edge);

/// What is known of the mean transmittance of a shaft.
struct Transmittance {
    double mean = 1;
    double variance = 0;  // of the mean, for the limited number of rays
    double bias = 0;      // what the method's approximation may be wrong by, root mean square
    double spread = 0;    // variance of one ray: a shadow's edge
    std::uint32_t rays = 0;
    bool edge = false;    // some pass and some do not
    bool proven = false;  // an object near the shaft was found not to reach into it

    double error() const;  // of the mean, root mean square
};

/// Rays so far.
struct Tally {
    std::uint32_t drawn = 0;  // points of the sequence
    std::uint32_t rays = 0;   // those of them whose ends face one another
    double passed = 0;        // rays
    double weight = 0, open = 0;
    double undecided = 0;     // sum over rays of x (1 - x), x the chance to pass: 0 for exact ones

    bool unanimous() const { return passed == 0 || passed == rays; }
};

/// Point `index` of the unit hypercube.
std::array<float, 4> line_point(LinePoints points, std::uint32_t index, std::uint64_t seed);

/// Asks the next lines of the sequence, up to number `end`.
///
/// passes   chance that a segment passes, in [0, 1]
template <class Passes>
void extend(Tally& tally, const Shaft& shaft, LinePoints points, std::uint32_t end, const Passes& passes) {
    for (; tally.drawn < end; ++tally.drawn) {
        const Segment s = shaft.segment(line_point(points, tally.drawn, shaft.seed));
        if (!(s.weight > 0)) continue;
        const double x = passes(s);
        tally.weight += s.weight;
        tally.open += s.weight * x;
        tally.passed += x;
        tally.undecided += x * (1 - x);
        ++tally.rays;
    }
}

/// The number of lines after the next round; `drawn` where there is none.
std::uint32_t next_round(const Demand& demand, std::uint32_t drawn);
/// Is the rule content?
bool suffices(const Demand& demand, const Tally& tally);
/// What the rays so far are worth.
Transmittance outcome(const Demand& demand, const Tally& tally);

/// Rounds until the rule is content.
template <class Passes>
Tally sample(const Shaft& shaft, const Demand& demand, const Passes& passes) {
    Tally tally;
    do extend(tally, shaft, demand.points, next_round(demand, tally.drawn), passes);
    while (next_round(demand, tally.drawn) > tally.drawn && !suffices(demand, tally));
    return tally;
}

/// For shafts that lie side by side, [n] numbers of those beside each.
using Neighbours = std::span<const std::vector<std::uint32_t>>;

/// Which of them need more rays than a rule asked that is content where rays agree: those whose rays all agree although a
/// neighbour's do not, or agree on the opposite, up to the rays after which that is no more news.
///
/// returns  ascending
std::vector<std::uint32_t> doubtful(std::span<const Tally> tallies, Neighbours neighbours);

}  // namespace rro
