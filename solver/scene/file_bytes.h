// Small files read whole.
#pragma once

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>

#include "format/result.h"

namespace rro {

/// errors   BadInput: cannot be opened or read, a folder, more than `most` bytes
inline Result<std::string> read_bytes(const std::filesystem::path& path, std::uint64_t most) {
    std::error_code code;
    if (std::filesystem::is_directory(path, code)) return bad_input(path.string(), "is a folder, expected a file");
    std::ifstream file(path, std::ios::binary);
    if (!file) return bad_input(path.string(), std::string("cannot be read: ") + std::strerror(errno));
    std::string bytes;
    char block[1 << 16];
    while (file.read(block, sizeof block) || file.gcount() > 0) {
        bytes.append(block, static_cast<std::size_t>(file.gcount()));
        if (bytes.size() > most)
            return bad_input(path.string(), "has more than " + std::to_string(most) + " bytes, the most that is read");
    }
    if (file.bad()) return bad_input(path.string(), "cannot be read to its end");
    return bytes;
}

}  // namespace rro
