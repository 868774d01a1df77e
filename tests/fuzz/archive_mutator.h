// Mutations of archives that get past the checksums.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace rro::fuzz {

/// libFuzzer's own mutation of `size` bytes in a buffer of `most`; returns the new size.
using Mutate = std::size_t (*)(std::uint8_t* data, std::size_t size, std::size_t most);

/// An archive changed somewhere: in any byte, or inside the content of one section (which is inflated and deflated
/// again where it must be). Mostly with sizes and checksums put right again as far as the directory can still be
/// found, so that what lies behind them is reached. Empty where the result would exceed `most` bytes.
///
/// The same bytes and seed give the same mutation.
std::vector<std::byte> mutate_archive(std::span<const std::byte> archive, std::size_t most, unsigned seed,
                                      Mutate mutate);

/// Archive `a` with the content of one of its sections, or a further one, taken from archive `b`. Empty where one of
/// them has no directory, or the result would exceed `most` bytes.
std::vector<std::byte> cross_archives(std::span<const std::byte> a, std::span<const std::byte> b, std::size_t most,
                                      unsigned seed);

}  // namespace rro::fuzz
