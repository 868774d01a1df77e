// What mesh_fuzz takes: a byte that chooses the format, then the file.
#pragma once

#include <algorithm>
#include <array>
#include <string>
#include <string_view>

namespace rro::fuzz {

/// By the number that the first byte gives (taken modulo their count; '0' gives the first).
inline constexpr std::array<std::string_view, 8> kMeshFormats{
    "obj", "ply", "off", "stl", "gltf", "glb",
    "mtl",    // the material file of an OBJ
    "parts",  // JSON up to a NUL, then the binary chunk: made into a GLB with lengths that are right
};

inline std::size_t format_of(char first) {
    constexpr int count = static_cast<int>(kMeshFormats.size());
    return static_cast<std::size_t>(((first - '0') % count + count) % count);
}

/// The first byte for a format.
inline char first_byte(std::size_t format) { return static_cast<char>('0' + static_cast<int>(format)); }

/// A GLB of "parts".
inline std::string glb_of(std::string_view parts) {
    const auto end = std::min(parts.find('\0'), parts.size());
    std::string json(parts.substr(0, end)), binary(parts.substr(std::min(end + 1, parts.size())));
    json.resize((json.size() + 3) / 4 * 4, ' ');
    binary.resize((binary.size() + 3) / 4 * 4, '\0');
    const auto number = [](std::size_t value) {
        std::string bytes;
        for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>(value >> shift & 0xff);
        return bytes;
    };
    return "glTF" + number(2) + number(12 + 8 + json.size() + 8 + binary.size()) + number(json.size()) + "JSON" + json +
           number(binary.size()) + std::string("BIN\0", 4) + binary;
}

}  // namespace rro::fuzz
