#include "format/atomic_file.h"

#include <atomic>
#include <cerrno>
#include <string>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace rro {
namespace {

namespace fs = std::filesystem;

Error cannot_write(const fs::path& path, int reason) {
    return failed(path.string(), "cannot be written: " + std::generic_category().message(reason));
}

/// Writes all bytes; 0, or the system's reason.
int write_all(int file, std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
        const ssize_t written = ::write(file, bytes.data(), bytes.size());
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) return errno;
        bytes = bytes.subspan(static_cast<std::size_t>(written));
    }
    return 0;
}

/// Calls make(name) for new names beside `target` until one is not taken; what it gave, -1 and errno if it cannot.
template <class Make>
int named_beside(const fs::path& target, fs::path& name, const Make& make) {
    static std::atomic<unsigned> counter{0};
    for (;;) {
        const std::string suffix = std::to_string(::getpid()) + "-" + std::to_string(counter++);
        name = target.parent_path() / ("." + target.filename().string() + "." + suffix + ".part");
        const int made = make(name);
        if (made >= 0 || errno != EEXIST) return made;
    }
}

/// Opens a new file in the folder of `target`, with the permissions any new file gets; -1 and errno if it cannot. It has
/// no name until it is whole, so that a program that is ended leaves nothing; where the file system cannot do that it has.
int open_beside(const fs::path& target, fs::path& name) {
    const fs::path folder = target.parent_path();
    const int file = ::open(folder.empty() ? "." : folder.c_str(), O_WRONLY | O_TMPFILE | O_CLOEXEC, 0666);
    if (file >= 0) return file;
    return named_beside(target, name, [](const fs::path& n) {
        return ::open(n.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    });
}

/// Gives an unnamed file a name beside `target`; 0, or -1 and errno.
int give_name(int file, const fs::path& target, fs::path& name) {
    const std::string handle = "/proc/self/fd/" + std::to_string(file);
    return named_beside(target, name, [&](const fs::path& n) {
        return ::linkat(AT_FDCWD, handle.c_str(), AT_FDCWD, n.c_str(), AT_SYMLINK_FOLLOW);
    });
}

/// The rename itself must survive a power cut. A folder that cannot be opened or synced (some network file systems)
/// has still got the new file, so this is no failure.
void sync_folder(const fs::path& folder) {
    const int handle = ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (handle < 0) return;
    ::fsync(handle);
    ::close(handle);
}

}  // namespace

AtomicFile::AtomicFile(fs::path path, fs::path target, fs::path temporary, int file, bool device)
    : path_(std::move(path)), target_(std::move(target)), temporary_(std::move(temporary)), file_(file), device_(device) {}

AtomicFile::AtomicFile(AtomicFile&& other) noexcept
    : path_(std::move(other.path_)), target_(std::move(other.target_)), temporary_(std::move(other.temporary_)),
      file_(std::exchange(other.file_, -1)), device_(other.device_) {}

AtomicFile::~AtomicFile() {
    if (file_ < 0) return;
    ::close(file_);
    if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

Result<AtomicFile> AtomicFile::open(const fs::path& path) {
    std::error_code ignored;
    const fs::file_status status = fs::status(path, ignored);
    if (fs::is_directory(status)) return cannot_write(path, EISDIR);
    if (fs::exists(status) && !fs::is_regular_file(status)) {  // `--out /dev/stdout` is written to, never replaced
        const int device = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
        if (device < 0) return cannot_write(path, errno);
        return AtomicFile(path, path, {}, device, true);
    }
    // A link keeps pointing to its file, which gets the new content and keeps its permissions.
    const fs::path target = fs::is_symlink(path, ignored) && fs::exists(status) ? fs::canonical(path, ignored) : path;
    fs::path temporary;
    const int file = open_beside(target, temporary);
    if (file < 0) return cannot_write(path, errno);
    AtomicFile opened(path, target, temporary, file, false);
    struct stat old {};
    if (::stat(target.c_str(), &old) == 0 && ::fchmod(file, old.st_mode & 07777) != 0) return cannot_write(path, errno);
    return opened;
}

Status AtomicFile::write(std::string_view text) {
    const int reason = write_all(file_, std::as_bytes(std::span(text.data(), text.size())));
    if (reason) return cannot_write(path_, reason);
    return Done{};
}

Status AtomicFile::commit() {
    int reason = !device_ && ::fsync(file_) != 0 ? errno : 0;
    if (!reason && !device_ && temporary_.empty() && give_name(file_, target_, temporary_) != 0) reason = errno;
    if (::close(std::exchange(file_, -1)) != 0 && !reason) reason = errno;
    if (device_) {
        if (reason) return cannot_write(path_, reason);
        return Done{};
    }
    if (!reason && ::rename(temporary_.c_str(), target_.c_str()) != 0) reason = errno;
    if (reason) {
        if (!temporary_.empty()) ::unlink(temporary_.c_str());
        return cannot_write(path_, reason);
    }
    sync_folder(target_.parent_path());
    return Done{};
}

Status write_file_atomically(const fs::path& path, std::string_view text) {
    auto file = AtomicFile::open(path);
    if (!file) return file.error();
    if (auto written = file->write(text); !written) return written.error();
    return file->commit();
}

Status write_file_atomically(const fs::path& path, std::span<const std::byte> bytes) {
    return write_file_atomically(path, std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

}  // namespace rro
