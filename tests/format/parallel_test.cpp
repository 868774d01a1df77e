#include "format/parallel.h"

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
