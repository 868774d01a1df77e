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
Status write_file_atomically(const std::filesystem::path& path, std::string_view text);

}  // namespace rro
