// SHA-256 (libcrypto), as lower-case hex.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace rro {

std::string sha256_hex(std::span<const std::byte> bytes);

}  // namespace rro
