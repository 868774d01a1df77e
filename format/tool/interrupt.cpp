#include "format/tool/interrupt.h"

#include <unistd.h>

#include <atomic>
#include <csignal>

namespace rro {
namespace {

constexpr int kInterrupted = 130;  // 128 + SIGINT, as shells have it

// A signal handler can reach nothing but globals.
std::atomic<int> deferring{0};
std::atomic<bool> interrupted{false};
static_assert(std::atomic<int>::is_always_lock_free && std::atomic<bool>::is_always_lock_free);

/// Of this thread; one that holds the end back already must not wait for it.
thread_local int depth = 0;

// Both sides write before they look, so that no file is begun between a handler's look and its end of the program.
void handle(int) {
    interrupted = true;
    if (deferring == 0) _exit(kInterrupted);
}

void stop_deferring() {
    if (--deferring == 0 && interrupted) _exit(kInterrupted);
}

}  // namespace

void end_on_interrupt() {
    struct sigaction action {};
    action.sa_handler = handle;
    action.sa_flags = SA_RESTART;
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
}

DeferInterrupts::DeferInterrupts() {
    ++deferring;
    if (++depth > 1 || !interrupted) return;
    // Too late to begin: whoever of the other threads is last to finish its file ends the program.
    stop_deferring();
    for (;;) pause();
}

DeferInterrupts::~DeferInterrupts() {
    --depth;
    stop_deferring();
}

}  // namespace rro
