// SHA-256 (libcrypto), as lower-case hex.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace rro {

/// 64 digits, as `sha256sum` prints them.
std::string sha256_hex(std::span<const std::byte> bytes);

}  // namespace rro
