#include "format/parallel.h"

#include <algorithm>
#include <cassert>
#include <memory>
#include <mutex>
#include <thread>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>
#include <oneapi/tbb/task_group.h>

namespace rro {
namespace {

using tbb::global_control;

/// Lives as long as the program: TBB drops the bound with its global_control, and Embree builds on TBB too.
std::unique_ptr<global_control>& thread_bound() {
    static std::unique_ptr<global_control> bound;
    return bound;
}

/// Begins the next jobs whenever one is done and there is room. No thread ever sleeps for room.
class JobQueue {
  public:
    JobQueue(std::span<const std::uint64_t> weights, std::uint64_t budget,
             const std::function<void(std::size_t)>& body)
        : weights_(weights), budget_(budget), body_(body) {}

    void run() {
        begin_jobs();
        tasks_.wait();
    }

  private:
    void begin_jobs() {
        const std::lock_guard lock(mutex_);
        while (next_ < weights_.size() && running_ < thread_count() &&
               (running_ == 0 || weights_[next_] <= budget_ - std::min(budget_, weight_))) {
            ++running_;
            weight_ += weights_[next_];
            tasks_.run([this, job = next_++] { run_job(job); });
        }
    }

    void run_job(std::size_t job) {
        tbb::this_task_arena::isolate([&] { body_(job); });
        {
            const std::lock_guard lock(mutex_);
            --running_;
            weight_ -= weights_[job];
        }
        begin_jobs();
    }

    std::span<const std::uint64_t> weights_;
    std::uint64_t budget_;
    const std::function<void(std::size_t)>& body_;
    std::mutex mutex_;
    std::size_t next_ = 0, running_ = 0;
    std::uint64_t weight_ = 0;  // of those running
    tbb::task_group tasks_;
};

}  // namespace

void set_thread_count(unsigned threads) {
    if (threads == 0) threads = std::max(1u, std::thread::hardware_concurrency());
    thread_bound().reset();  // of two bounds alive TBB takes the smaller
    thread_bound() = std::make_unique<global_control>(global_control::max_allowed_parallelism, threads);
}

unsigned thread_count() {
    return static_cast<unsigned>(global_control::active_value(global_control::max_allowed_parallelism));
}

void parallel_chunks(std::size_t count, std::size_t grain, const std::function<void(std::size_t, std::size_t)>& body) {
    assert(grain > 0);
    const std::size_t chunks = count / grain + (count % grain != 0);
    const auto run = [&](std::size_t chunk) {
        const std::size_t begin = chunk * grain;
        body(begin, begin + std::min(grain, count - begin));
    };
    if (chunks == 1) return run(0);
    // One task per chunk: the partitioner decides who does a chunk, never where it begins.
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, chunks),
        [&](const tbb::blocked_range<std::size_t>& range) {
            for (std::size_t chunk = range.begin(); chunk != range.end(); ++chunk) run(chunk);
        },
        tbb::simple_partitioner());
}

void parallel_jobs(std::span<const std::uint64_t> weights, std::uint64_t budget,
                   const std::function<void(std::size_t)>& body) {
    JobQueue(weights, budget, body).run();
}

}  // namespace rro
