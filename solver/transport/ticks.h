// Time of single steps, for reports: too short for clocks that cost as much themselves.
#pragma once

#include <x86intrin.h>

#include <cstdint>

namespace rro {

/// The processor's time stamp. Only shares of such times mean anything, and no result may depend on them.
inline std::uint64_t ticks() { return __rdtsc(); }

}  // namespace rro
