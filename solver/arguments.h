// Values of the command line.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>

#include "format/result.h"

namespace rro {

/// "8G", "512M", "64K" or plain bytes; powers of 1024.
/// errors   Usage: anything else, or 0
Result<std::uint64_t> parse_bytes(std::string_view text);

/// "960x540": width and height, each 1 to 16384 pixels.
/// errors   Usage: anything else
Result<std::array<int, 2>> parse_size(std::string_view text);

/// 8 GiB, or the limit on the address space (ulimit -v) where that is less.
std::uint64_t default_memory();

/// Can all these files be written? To be asked before long work. Empty paths are passed over.
///
/// errors   Usage: two of them are one file, or one is `input`; Failed: no such folder, no permission, a folder itself
Status check_outputs(std::span<const std::filesystem::path> outputs, const std::filesystem::path& input);

}  // namespace rro
