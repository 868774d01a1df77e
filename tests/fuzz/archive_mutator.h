// Mutations of archives that get past the checksums.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "tests/fuzz/mutate.h"

namespace rro::fuzz {

/// An archive changed somewhere: in any byte, or inside the content of one section (which is inflated and deflated
/// again where it must be). Mostly with sizes and checksums put right again as far as the directory can still be
/// found, so that what lies behind them is reached. It may exceed `most` bytes a little.
///
/// The same bytes and seed give the same mutation.
std::vector<std::byte> mutate_archive(std::span<const std::byte> archive, std::size_t most, unsigned seed,
                                      Mutate mutate);

/// Archive `a` with the content of one of its sections, or a further one, taken from archive `b`. Empty where one of
/// them has no directory.
std::vector<std::byte> cross_archives(std::span<const std::byte> a, std::span<const std::byte> b, unsigned seed);

}  // namespace rro::fuzz
