// Work over an index range on several threads, with results that do not depend on how many there are.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

namespace rro {

/// Bounds every parallel loop and Embree's builds from now on; 0 = all cores. Call once, from main.
void set_thread_count(unsigned threads);
/// How many threads that is.
unsigned thread_count();

/// Calls body(begin, end) over disjoint chunks of [0, count). Chunk borders depend on `count` and `grain` alone, so a
/// body that writes only to its own indices, or to one slot per chunk (begin / grain), gives the same result on any
/// number of threads.
void parallel_chunks(std::size_t count, std::size_t grain, const std::function<void(std::size_t, std::size_t)>& body);

/// Calls body(i) for every i in [0, count), in such chunks.
template <class Body>
void parallel_for(std::size_t count, std::size_t grain, const Body& body) {
    parallel_chunks(count, grain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) body(i);
    });
}

/// Calls body(i) for every i below weights.size(), begun in about that order: large jobs that are parallel inside as
/// well. At most one per thread is under way, and no more than weigh `budget` together (one alone may weigh more). A
/// thread that waits inside a job helps with that job only. Bodies must not throw.
void parallel_jobs(std::span<const std::uint64_t> weights, std::uint64_t budget,
                   const std::function<void(std::size_t)>& body);

}  // namespace rro
