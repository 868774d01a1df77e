#include "compiler/import_process.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <new>
#include <string_view>
#include <vector>

#include "compiler/import_transfer.h"
#include "format/sha256.h"

namespace rro {
namespace {

#if defined(__SANITIZE_ADDRESS__)
constexpr bool kLimitsMemory = false;  // the sanitizer reserves terabytes of addresses
#elif defined(__has_feature)
constexpr bool kLimitsMemory = !__has_feature(address_sanitizer);
#else
constexpr bool kLimitsMemory = true;
#endif

/// Exit codes of the child.
enum Ending { kDone = 0, kOutOfMemory = 1, kThrew = 2, kNotWritten = 3 };

/// What the child writes its answer to: no file, whose size users may limit (ulimit -f).
class Pipe {
  public:
    Pipe() {
        if (pipe2(ends_, O_CLOEXEC) == 0) fcntl(ends_[1], F_SETPIPE_SZ, 1 << 20);  // fewer changes of process
    }
    ~Pipe() {
        close_end(0);
        close_end(1);
    }
    Pipe(const Pipe&) = delete;
    Pipe& operator=(const Pipe&) = delete;

    bool is_open() const { return ends_[0] >= 0; }

    /// In the child: closes all that it has of its parent but this and the standard streams. Among it may be the pipes
    /// of other threads' children, which would seem open to their readers for as long as this process lives.
    void keep_nothing_else() const {
        const auto own = static_cast<unsigned>(ends_[1]);
        close_range(own + 1, ~0u, 0);
        if (own > 3) close_range(3, own - 1, 0);
    }

    bool write_all(std::string_view bytes) const {
        while (!bytes.empty()) {
            const ssize_t written = write(ends_[1], bytes.data(), bytes.size());
            if (written < 0 && errno == EINTR) continue;
            if (written <= 0) return false;
            bytes.remove_prefix(static_cast<std::size_t>(written));
        }
        return true;
    }

    /// In the parent: everything that is written until the child ends.
    std::string read_all() {
        close_end(1);
        std::string bytes;
        std::vector<char> chunk(1 << 20);
        for (;;) {
            const ssize_t got = read(ends_[0], chunk.data(), chunk.size());
            if (got < 0 && errno == EINTR) continue;
            if (got <= 0) return bytes;
            bytes.append(chunk.data(), static_cast<std::size_t>(got));
        }
    }

  private:
    void close_end(std::size_t end) {
        if (ends_[end] >= 0) close(ends_[end]);
        ends_[end] = -1;
    }

    int ends_[2] = {-1, -1};
};

/// Lowers a limit of this process; never raises one.
void limit(int resource, rlim_t most, rlim_t grace = 0) {
    rlimit now{};
    getrlimit(static_cast<__rlimit_resource_t>(resource), &now);
    now.rlim_max = std::min(now.rlim_max, most + grace);
    now.rlim_cur = std::min({now.rlim_cur, now.rlim_max, most});
    setrlimit(static_cast<__rlimit_resource_t>(resource), &now);
}

/// Addresses that this process has taken so far.
rlim_t mapped_bytes() {
    unsigned long pages = 0;
    if (std::FILE* file = std::fopen("/proc/self/statm", "r")) {
        if (std::fscanf(file, "%lu", &pages) != 1) pages = 0;
        std::fclose(file);
    }
    return static_cast<rlim_t>(pages) * static_cast<rlim_t>(sysconf(_SC_PAGESIZE));
}

void confine(const ContainmentLimits& limits, pid_t parent) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent) _exit(kNotWritten);                              // it went before it could be told apart
    for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, SIG_IGN);  // the parent's to decide
    for (const int signal : {SIGALRM, SIGXCPU}) std::signal(signal, SIG_DFL);
    sigset_t none;
    sigemptyset(&none);
    sigprocmask(SIG_SETMASK, &none, nullptr);
    limit(RLIMIT_CORE, 0);
    limit(RLIMIT_CPU, limits.cpu_seconds, 1);  // where the first limit's signal does not end it, the second does
    if (kLimitsMemory) limit(RLIMIT_AS, mapped_bytes() + limits.memory_bytes);
    alarm(limits.wall_seconds);
}

/// The child's whole life. No destructors and no exit handlers run: what they would tidy up is the parent's.
[[noreturn]] void work_and_end(const std::function<std::string()>& work, const Pipe& answer) {
    try {
        _exit(answer.write_all(work()) ? kDone : kNotWritten);
    } catch (const std::bad_alloc&) {
        _exit(kOutOfMemory);
    } catch (const std::exception& exception) {
        _exit(answer.write_all(exception.what()) ? kThrew : kNotWritten);
    }
}

Error stopped(const std::string& where, int signal, const ContainmentLimits& limits) {
    constexpr const char* split = "split the mesh into several objects, or write it anew with another program";
    if (signal == SIGXCPU)
        return bad_input(where, "reading it took more than " + std::to_string(limits.cpu_seconds) + " s of CPU time",
                         split);
    if (signal == SIGALRM)
        return bad_input(where, "reading it came to no end in " + std::to_string(limits.wall_seconds) + " s", split);
    const char* name = sigabbrev_np(signal);
    return bad_input(where,
                     "the reader was stopped by signal " + (name ? "SIG" + std::string(name) : std::to_string(signal)),
                     signal == SIGKILL ? "somebody, or a machine out of memory, ended it: try again"
                                       : "the file is broken in a way that a library does not survive; write it anew "
                                         "with another program");
}

Error out_of_memory(const std::string& where, const ContainmentLimits& limits) {
    std::array<char, 32> gib;
    std::snprintf(gib.data(), gib.size(), "%.3g", static_cast<double>(limits.memory_bytes) / (1 << 30));
    return bad_input(
        where,
        "reading it needed more memory than there is, or than the " + std::string(gib.data()) + " GiB it may have",
        "split the mesh into several objects, or raise the address-space limit (ulimit -v) if there is one");
}

}  // namespace

Result<std::string> run_contained(const std::string& where, const std::function<std::string()>& work,
                                  const ContainmentLimits& limits) {
    Pipe answer;
    const pid_t parent = getpid();
    const pid_t child = answer.is_open() ? fork() : -1;
    if (child < 0)
        return failed(where, std::string("no process can be started to read it: ") + std::strerror(errno),
                      "close other programs, or raise the limits (ulimit -u, ulimit -n)");
    if (child == 0) {
        answer.keep_nothing_else();
        confine(limits, parent);
        work_and_end(work, answer);
    }
    std::string content = answer.read_all();
    int status = 0;
    while (waitpid(child, &status, 0) < 0)
        if (errno != EINTR) return failed(where, std::string("the reader is lost: ") + std::strerror(errno));
    if (WIFSIGNALED(status)) return stopped(where, WTERMSIG(status), limits);
    switch (WEXITSTATUS(status)) {
        case kDone:
            return content;
        case kOutOfMemory:
            return out_of_memory(where, limits);
        case kThrew:
            return Error{ErrorKind::Internal, where, "internal error: " + content, "please report this"};
        default:
            return failed(where, "the reader could not hand over what it read", "try again");
    }
}

Result<ImportedMesh> import_mesh_contained(const std::filesystem::path& path, const ImportOptions& options,
                                           TwoSided two_sided, bool fix_winding, const ContainmentLimits& limits) {
    // What the child may find locked, were another thread at it for the first time just now: done once, before.
    [[maybe_unused]] static const std::string hashing_is_set_up = sha256_hex({});
    const auto import = [&] {
        auto imported = import_mesh(path, options);
        if (imported) decide_sides(imported->mesh, two_sided, fix_winding, imported->report);
        return encode_import(imported);
    };
    const auto answer = run_contained(path.string(), import, limits);
    if (!answer) return answer.error();
    auto imported = decode_import(*answer);
    if (!imported) return failed(path.string(), "the reader's answer is incomplete");
    return *std::move(imported);
}

}  // namespace rro
