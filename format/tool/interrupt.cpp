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

void handle(int) {
    if (deferring == 0) _exit(kInterrupted);
    interrupted = true;
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
}

DeferInterrupts::~DeferInterrupts() {
    if (--deferring == 0 && interrupted) _exit(kInterrupted);
}

}  // namespace rro
