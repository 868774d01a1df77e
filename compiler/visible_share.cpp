#include "compiler/visible_share.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "format/parallel.h"

namespace rro {
namespace {

// A share of n samples has variance V (1 - V) / n <= 1 / (4 n), neighbouring directions differ by about 0.25: equal
// at 4.
constexpr double kPriorSamples = 4;
// exp(-40 (1 - cos)): a Gaussian of 9 degrees, half the spacing of a 12 x 12 grid.
constexpr double kConcentration = 40;
// Weight of the whole object's share in the prior, in samples: below that of one sample two grid cells away.
constexpr double kWholeWeight = 1e-6;

std::vector<float> neighbour_weights(const DirectionGrid& grid) {
    const std::size_t size = grid.size();
    std::vector<float> weights(size * size);
    for (std::uint32_t a = 0; a < size; ++a)
        for (std::uint32_t b = 0; b < size; ++b) {
            const double cosine = dot(grid.direction(a), grid.direction(b));
            weights[a * size + b] = static_cast<float>(std::exp(kConcentration * (cosine - 1)));
        }
    return weights;
}

std::vector<double> shares_of_whole(const SampleCounts& whole) {
    double seen = 0, covered = 0;
    for (std::size_t d = 0; d < whole.seen.size(); ++d) seen += whole.seen[d], covered += whole.covered[d];
    const double mean = covered > 0 ? seen / covered : 0;
    std::vector<double> shares;
    for (std::size_t d = 0; d < whole.seen.size(); ++d)
        shares.push_back(whole.covered[d] > 0 ? static_cast<double>(whole.seen[d]) / whole.covered[d] : mean);
    return shares;
}

}  // namespace

std::vector<float> visible_shares(const SampleCounts& counts, const SampleCounts& whole, const DirectionGrid& grid) {
    const std::size_t directions = grid.size();
    assert(whole.seen.size() == directions && counts.seen.size() % directions == 0);
    const std::vector<float> weights = neighbour_weights(grid);
    const std::vector<double> whole_share = shares_of_whole(whole);
    std::vector<float> shares(counts.seen.size());
    parallel_for(counts.seen.size() / directions, 64, [&](std::size_t thing) {
        const std::size_t row = thing * directions;
        for (std::size_t d = 0; d < directions; ++d) {
            double seen = kWholeWeight * whole_share[d], covered = kWholeWeight;
            for (std::size_t other = 0; other < directions; ++other) {
                const double weight = weights[d * directions + other];
                seen += weight * counts.seen[row + other];
                covered += weight * counts.covered[row + other];
            }
            const double share =
                (counts.seen[row + d] + kPriorSamples * seen / covered) / (counts.covered[row + d] + kPriorSamples);
            shares[row + d] = static_cast<float>(std::clamp(share, 0.0, 1.0));
        }
    });
    return shares;
}

}  // namespace rro
