#include "format/parallel.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <set>
#include <vector>

#include <catch2/catch.hpp>

using namespace rro;

TEST_CASE("every index is visited once, in chunks that depend on the size alone", "[parallel]") {
    for (const std::size_t count : {0u, 1u, 7u, 64u, 1000u}) {
        std::set<std::pair<std::size_t, std::size_t>> first_chunks;
        for (const unsigned threads : {1u, 2u, 8u}) {
            set_thread_count(threads);
            CHECK(thread_count() == threads);
            std::vector<int> visits(count, 0);
            std::set<std::pair<std::size_t, std::size_t>> chunks;
            std::mutex mutex;
            parallel_chunks(count, 7, [&](std::size_t begin, std::size_t end) {
                for (std::size_t i = begin; i < end; ++i) ++visits[i];
                const std::lock_guard lock(mutex);
                chunks.insert({begin, end});
            });
            CHECK(visits == std::vector<int>(count, 1));
            if (threads == 1) first_chunks = chunks;
            CHECK(chunks == first_chunks);
            for (const auto& [begin, end] : chunks) CHECK((begin % 7 == 0 && (end - begin == 7 || end == count)));
        }
    }
    set_thread_count(0);
}

TEST_CASE("a sum by chunks has the same bits on any number of threads", "[parallel]") {
    const std::size_t count = 100000, grain = 333;
    std::vector<double> sums;
    for (const unsigned threads : {1u, 2u, 8u}) {
        set_thread_count(threads);
        std::vector<double> parts((count + grain - 1) / grain, 0);
        parallel_chunks(count, grain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) parts[begin / grain] += std::sin(double(i));
        });
        double sum = 0;
        for (const double part : parts) sum += part;
        sums.push_back(sum);
    }
    set_thread_count(0);
    CHECK(sums[0] == sums[1]);
    CHECK(sums[0] == sums[2]);
}

TEST_CASE("one thread means one thread", "[parallel]") {
    set_thread_count(1);
    std::atomic<int> inside{0}, most{0};
    parallel_for(200, 1, [&](std::size_t) {
        const int now = ++inside;
        int before = most.load();
        while (now > before && !most.compare_exchange_weak(before, now)) {
        }
        double work = 0;
        for (int i = 0; i < 1000; ++i) work += std::sqrt(double(i));
        CHECK(work > 0);
        --inside;
    });
    CHECK(most == 1);
    set_thread_count(0);
    CHECK(thread_count() >= 1);
}

TEST_CASE("every job runs once, no more at once than threads and budget allow", "[parallel]") {
    const std::vector<std::uint64_t> weights{5, 1, 1, 9, 2, 2, 2, 2, 1, 30, 1, 1};
    constexpr std::uint64_t budget = 6;
    for (const unsigned threads : {1u, 4u}) {
        set_thread_count(threads);
        std::vector<int> runs(weights.size(), 0);
        std::vector<double> sums(weights.size(), 0);
        std::mutex mutex;
        std::size_t running = 0, most_running = 0;
        std::uint64_t weight = 0;
        bool over_budget = false;
        parallel_jobs(weights, budget, [&](std::size_t job) {
            {
                const std::lock_guard lock(mutex);
                weight += weights[job];
                most_running = std::max(most_running, ++running);
                over_budget = over_budget || (running > 1 && weight > budget);
            }
            // A thread that waits here must not begin another job: `running` would count it.
            std::atomic<int> inner{0};
            parallel_for(100, 1, [&](std::size_t) { ++inner; });
            ++runs[job];
            sums[job] = inner;
            const std::lock_guard lock(mutex);
            --running;
            weight -= weights[job];
        });
        CHECK(runs == std::vector<int>(weights.size(), 1));
        CHECK(sums == std::vector<double>(weights.size(), 100));
        CHECK(most_running <= threads);
        CHECK(!over_budget);
    }
    set_thread_count(0);
    parallel_jobs({}, budget, [](std::size_t) { FAIL("there is no job"); });
}
