// Small mesh files in a folder of their own, removed at the end of the test.
#pragma once

#include <unistd.h>

#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include "compiler/mesh_import.h"

namespace rro::test {

class MeshFolder {
  public:
    MeshFolder() {
        static std::atomic<int> count = 0;
        path_ = std::filesystem::temp_directory_path() /
                ("rro_mesh_" + std::to_string(getpid()) + "_" + std::to_string(count++));
        std::filesystem::create_directories(path_);
    }
    ~MeshFolder() { std::filesystem::remove_all(path_); }
    MeshFolder(const MeshFolder&) = delete;
    MeshFolder& operator=(const MeshFolder&) = delete;

    std::filesystem::path write(const std::string& name, std::string_view content) const {
        const std::filesystem::path file = path_ / name;
        std::filesystem::create_directories(file.parent_path());
        std::ofstream(file, std::ios::binary) << content;
        return file;
    }
    const std::filesystem::path& path() const { return path_; }

  private:
    std::filesystem::path path_;
};

/// Imports a file that must be good.
inline ImportedMesh imported(const std::filesystem::path& file, const ImportOptions& options = {}) {
    auto result = import_mesh(file, options);
    if (!result) FAIL(result.error().where << ": " << result.error().message);
    return *std::move(result);
}

/// The error of a file that must be refused.
inline Error refused(const std::filesystem::path& file) {
    const auto result = import_mesh(file, {});
    REQUIRE(!result);
    CHECK(result.error().kind == ErrorKind::BadInput);
    CHECK(result.error().message.size() > 5);
    return result.error();
}

inline TriangleCorners corners(const Mesh& mesh, std::size_t triangle) {
    const TriangleIndices& t = mesh.triangles[triangle];
    return {mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]};
}

inline Vec3 total_area_vector(const Mesh& mesh) {
    Vec3 sum;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) sum += area_vector(corners(mesh, t));
    return sum;
}

inline double total_area(const Mesh& mesh) {
    double sum = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) sum += length(area_vector(corners(mesh, t)));
    return sum;
}

inline bool warns(const ImportReport& report, const std::string& text) {
    for (const std::string& warning : report.warnings)
        if (warning.find(text) != warning.npos) return true;
    return false;
}

/// The bytes of a value as they lie in memory (little-endian).
template <class Value>
std::string raw(const Value& value) {
    std::string bytes(sizeof value, '\0');
    std::memcpy(bytes.data(), &value, sizeof value);
    return bytes;
}

/// A 2 x 2 PNG: red, green / blue, white (8-bit RGB), as any encoder writes it.
inline std::string small_png() {
    static constexpr unsigned char bytes[] = {
        0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48, 0x44,
        0x52, 0x00, 0x00, 0x00, 0x02, 0x00, 0x00, 0x00, 0x02, 0x08, 0x02, 0x00, 0x00, 0x00, 0xfd,
        0xd4, 0x9a, 0x73, 0x00, 0x00, 0x00, 0x12, 0x49, 0x44, 0x41, 0x54, 0x78, 0x9c, 0x63, 0xf8,
        0xcf, 0xc0, 0xc0, 0x00, 0xc2, 0x0c, 0xff, 0x81, 0x00, 0x00, 0x1f, 0xee, 0x05, 0xfb, 0x0b,
        0xd9, 0x68, 0x8b, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82,
    };
    return {reinterpret_cast<const char*>(bytes), sizeof bytes};
}

}  // namespace rro::test
