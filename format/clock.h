// Wall time, for reports.
#pragma once

#include <chrono>

namespace rro {

using Clock = std::chrono::steady_clock;

/// Milliseconds of wall time.
inline double milliseconds_since(Clock::time_point start) {
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}
/// Seconds of wall time.
inline double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

}  // namespace rro
