// How the bytes of a section are packed (zlib) and guarded (CRC-32).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "format/result.h"

namespace rro {

/// CRC-32 as in zlib and PNG; long inputs on several threads.
std::uint32_t crc32_of(std::span<const std::byte> bytes);

/// A zlib stream (RFC 1950). At most 2 GiB - 1 bytes in (asserted).
std::vector<std::byte> compress_zlib(std::span<const std::byte> raw);

/// The content of a zlib stream that declares to hold `raw_bytes`. Never writes past that, and allocates nothing where
/// the stream is too short to hold as much.
///
/// where    for messages: file and section
/// errors   BadInput: the stream is damaged, or holds less or more than declared
Result<std::vector<std::byte>> decompress_zlib(std::span<const std::byte> stored, std::uint64_t raw_bytes,
                                               const std::string& where);

}  // namespace rro
