// What both programs share at the terminal: how an error looks, which exit code it becomes, and progress.
#pragma once

#include <exception>
#include <functional>
#include <string>
#include <string_view>

#include "format/result.h"

namespace rro {

/// Prints "PROGRAM: error: WHERE: MESSAGE" and, where there is one, "  hint: HINT" to stderr; returns the exit code.
int report_error(std::string_view program, const Error& error);

/// Prints "PROGRAM: warning: MESSAGE" to stderr.
void report_warning(std::string_view program, std::string_view message);

/// An exception that reached main, or one job of many, as an Error: Failed where memory ran out, Internal otherwise.
Error error_from_exception(const std::exception& exception);

/// All that main does: from now on Ctrl-C ends the program (interrupt.h); an exception that gets out of `work` is reported.
///
/// work     called with the arguments
/// returns  the exit code: of `work`, or of the exception
int run_program(std::string_view program, int (*work)(int argc, char** argv), int argc, char** argv);

/// Draws phases and the share done on one line of stderr; only on a terminal, and not when quiet. The line is wiped
/// when the object goes. Not thread-safe: one thread reports at a time.
class TerminalProgress {
  public:
    explicit TerminalProgress(bool quiet);
    ~TerminalProgress();
    TerminalProgress(const TerminalProgress&) = delete;
    TerminalProgress& operator=(const TerminalProgress&) = delete;

    /// To pass to the libraries; refers to this object. Empty where nothing would be drawn.
    std::function<void(std::string_view phase, double done)> callback();

    /// Wipes the line, so that something else can be printed; the next report draws it again.
    void clear();

  private:
    bool drawing_;
    std::string shown_;
};

}  // namespace rro
