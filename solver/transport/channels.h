// Channels of light taken together.
#pragma once

#include <array>
#include <cstddef>

#include "format/geometry.h"

namespace rro {

/// A channel of a colour, for fields of C channels: grey scenes have one, and carry equal components.
template <int C>
float component(const Rgb& rgb, std::size_t channel) {
    static_assert(C == 1 || C == 3);
    return channel == 0 ? rgb.x : channel == 1 ? rgb.y : rgb.z;
}

/// The mean of C channels. Where all are alike it is their very value, so that a grey scene has the same bits in one
/// channel and in three; a sum divided by three would not.
template <class T, std::size_t C>
T mean_of(const std::array<T, C>& channels) {
    T beyond = 0;  // the first
    for (std::size_t c = 1; c < C; ++c) beyond += channels[c] - channels[0];
    return channels[0] + beyond / T(C);
}

/// The same of f(channel), C channels.
template <std::size_t C, class F>
auto mean_over(const F& f) {
    std::array<decltype(f(std::size_t{})), C> channels;
    for (std::size_t c = 0; c < C; ++c) channels[c] = f(c);
    return mean_of(channels);
}

}  // namespace rro
