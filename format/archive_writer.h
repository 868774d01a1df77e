// Sections -> bytes. The same input gives the same bytes.
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "format/object_data.h"
#include "format/result.h"

namespace rro {

/// The whole archive as bytes (FORMAT.md).
///
/// errors   BadInput where a section would exceed 2 GiB - 1
Result<std::vector<std::byte>> encode_archive(const ObjectData& object);

/// Writes the archive to a temporary file beside `path`, syncs, renames: the old file or the new one, never a broken one.
///
/// errors   those of encode_archive; Failed where the file cannot be written (names it)
Status write_archive(const ObjectData& object, const std::filesystem::path& path);

}  // namespace rro
