// Files that appear whole or not at all: written beside their target, synced, renamed.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string_view>

#include "format/result.h"

namespace rro {

/// Writes `bytes` to a temporary file in the target's folder, syncs it and renames it over `path`.
///
/// errors   Failed: the folder is missing, no permission, disk full (names the file and the system's reason); the
///          temporary file is removed
Status write_file_atomically(const std::filesystem::path& path, std::span<const std::byte> bytes);
/// The same for text.
Status write_file_atomically(const std::filesystem::path& path, std::string_view text);

/// The same, piece by piece, for what need not be in memory at once. A file that is not committed leaves nothing behind.
class AtomicFile {
  public:
    /// errors   Failed: as above
    static Result<AtomicFile> open(const std::filesystem::path& path);
    AtomicFile(AtomicFile&& other) noexcept;
    AtomicFile& operator=(AtomicFile&&) = delete;
    ~AtomicFile();

    /// errors   Failed: disk full, and the like
    Status write(std::string_view text);
    /// Syncs and renames; nothing may be written after it.
    /// errors   Failed: as above
    Status commit();

  private:
    AtomicFile(std::filesystem::path path, std::filesystem::path target, std::filesystem::path temporary, int file,
               bool device);
    std::filesystem::path path_, target_, temporary_;  // no temporary one while the file has no name
    int file_ = -1;
    bool device_ = false;  // written in place
};

}  // namespace rro
