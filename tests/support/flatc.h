// flatc, the compiler of stock FlatBuffers, as a witness that has never seen our code.
#pragma once

#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/support/temporary_folder.h"

namespace rro::test {

inline bool flatc_installed() { return std::system("flatc --version > /dev/null 2>&1") == 0; }

inline std::string root_of(std::string section) {
    section[0] = static_cast<char>(std::toupper(section[0]));
    return "rro." + section;
}

inline void run_flatc(const TemporaryFolder& folder, const std::string& arguments) {
    const std::string command = "cd '" + folder.path().string() + "' && flatc " + arguments;
    INFO(command);
    REQUIRE(std::system(command.c_str()) == 0);
}

inline void write_bytes(const std::filesystem::path& path, const std::vector<std::byte>& bytes) {
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

inline std::vector<std::byte> read_bytes(const std::filesystem::path& path) {
    const std::string text = file_text(path);
    const auto bytes = std::as_bytes(std::span(text));
    return {bytes.begin(), bytes.end()};
}

/// A section's payload as JSON.
inline nlohmann::json flatc_to_json(const std::vector<std::byte>& payload, const std::string& section,
                                    const std::string& schema = RRO_SOURCE_DIR "/schemas/rro.fbs") {
    const TemporaryFolder folder;
    write_bytes(folder / "section.bin", payload);
    run_flatc(folder, "--json --strict-json --raw-binary --root-type " + root_of(section) + " '" + schema +
                          "' -- section.bin");
    return nlohmann::json::parse(file_text(folder / "section.json"));
}

/// A payload that stock FlatBuffers writes from JSON.
inline std::vector<std::byte> flatc_to_binary(const nlohmann::json& json, const std::string& section,
                                              const std::string& schema = RRO_SOURCE_DIR "/schemas/rro.fbs") {
    const TemporaryFolder folder;
    std::ofstream(folder / "section.json") << json;
    run_flatc(folder, "--binary --root-type " + root_of(section) + " '" + schema + "' section.json");
    return read_bytes(folder / "section.bin");
}

}  // namespace rro::test
