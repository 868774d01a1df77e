// From sample counts per direction to the share that is seen, with sense where samples are few.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "format/direction_grid.h"

namespace rro {

/// Sample counts of n things over D directions; index = thing * D + direction.
struct SampleCounts {
    std::vector<std::uint32_t> seen;     // first along the line of sight, from the right side
    std::vector<std::uint32_t> covered;  // would be seen if nothing hid anything; about >= seen

    SampleCounts() = default;
    explicit SampleCounts(std::size_t entries) : seen(entries), covered(entries) {}
};

/// Share seen, in [0, 1], of every thing from every direction: (seen + k prior) / (covered + k). The prior is the share
/// pooled over the directions about it (Gaussian weights of 9 degrees), and where the thing has no samples near, the
/// whole's. So a share of many samples stands, one of few is smoothed, and just beyond its horizon a thing continues
/// with the values of the nearest directions that see it.
///
/// whole    counts of all things together, [D]
/// returns  [n * D]
std::vector<float> visible_shares(const SampleCounts& counts, const SampleCounts& whole, const DirectionGrid& grid);

}  // namespace rro
