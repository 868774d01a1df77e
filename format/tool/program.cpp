#include "format/tool/program.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <new>

#include "format/tool/interrupt.h"

namespace rro {

int report_error(std::string_view program, const Error& error) {
    std::string text{program};
    text += ": error: ";
    if (!error.where.empty()) text += error.where + ": ";
    text += error.message + "\n";
    if (!error.hint.empty()) text += "  hint: " + error.hint + "\n";
    std::fputs(text.c_str(), stderr);
    return static_cast<int>(error.kind);
}

void report_warning(std::string_view program, std::string_view message) {
    const std::string text = std::string{program} + ": warning: " + std::string{message} + "\n";
    std::fputs(text.c_str(), stderr);
}

Error error_from_exception(const std::exception& exception) {
    if (dynamic_cast<const std::bad_alloc*>(&exception))
        return failed("", "out of memory", "raise the address-space limit (ulimit -v) or use a smaller input");
    return {ErrorKind::Internal, "", std::string("internal error: ") + exception.what(), "please report this"};
}

int run_program(std::string_view program, int (*work)(int argc, char** argv), int argc, char** argv) {
    end_on_interrupt();
    try {
        return work(argc, argv);
    } catch (const std::exception& exception) {
        return report_error(program, error_from_exception(exception));
    }
}

TerminalProgress::TerminalProgress(bool quiet) : drawing_(!quiet && isatty(STDERR_FILENO) != 0) {}

TerminalProgress::~TerminalProgress() {
    clear();
}

std::function<void(std::string_view, double)> TerminalProgress::callback() {
    if (!drawing_) return {};
    return [this](std::string_view phase, double done) {
        const int percent = static_cast<int>(100 * std::clamp(done, 0.0, 1.0));
        std::string line = std::string{phase} + " " + std::to_string(percent) + " %";
        if (line == shown_) return;  // terminals are slow; whole percents are enough
        clear();
        std::fputs(line.c_str(), stderr);
        std::fflush(stderr);
        shown_ = std::move(line);
    };
}

void TerminalProgress::clear() {
    if (shown_.empty()) return;
    std::fputs("\r\033[K", stderr);
    std::fflush(stderr);
    shown_.clear();
}

}  // namespace rro
