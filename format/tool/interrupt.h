// Ctrl-C: the program ends with 130 and leaves no half-written file.
#pragma once

namespace rro {

/// From now on SIGINT and SIGTERM end the program with exit code 130: at once, or, while a DeferInterrupts lives, when
/// it goes. Call once, from main.
void end_on_interrupt();

/// Put around the writing of a file, so that its temporary file is gone before the program is. Any number of threads
/// may; once the signal has come, none begins another.
class DeferInterrupts {
  public:
    DeferInterrupts();
    ~DeferInterrupts();
    DeferInterrupts(const DeferInterrupts&) = delete;
    DeferInterrupts& operator=(const DeferInterrupts&) = delete;
};

}  // namespace rro
