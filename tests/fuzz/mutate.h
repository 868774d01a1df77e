// libFuzzer's own mutation, as the mutators here use it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <ranges>

/// Changes `size` bytes in a buffer of `most`; returns the new size.
extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most);

namespace rro::fuzz {

using Mutate = std::size_t (*)(std::uint8_t* data, std::size_t size, std::size_t most);

/// Hands a changed input back to libFuzzer; returns its size, 0 where it does not fit.
template <std::ranges::contiguous_range Bytes>
std::size_t hand_over(const Bytes& changed, std::uint8_t* out, std::size_t most) {
    const auto size = std::size(changed);
    if (size > most) return 0;
    std::copy_n(reinterpret_cast<const std::uint8_t*>(std::data(changed)), size, out);
    return size;
}

}  // namespace rro::fuzz
