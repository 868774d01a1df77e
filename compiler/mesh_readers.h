// What the readers of the single formats give to import_mesh: polygons, materials and textures as the file has them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/mesh_import.h"
#include "compiler/mesh_texture.h"
#include "format/geometry.h"
#include "format/result.h"

namespace rro {

/// The name of what has no material.
inline constexpr const char* default_material = "default";

/// A material as the file describes it; nothing is clamped yet.
struct SourceMaterial {
    std::string name;
    std::optional<Vec3> reflectance;  // linear; a factor where there is a texture; none where the file says nothing
    Vec3 exitance;                    // W/m^2
    std::optional<TextureUse> texture;
};

/// Polygons in the order of the file, in the file's own units and axes. F faces, C corners.
struct SourceMesh {
    std::vector<Vec3> positions;
    std::vector<std::uint32_t> corners;        // [C] into positions (import_mesh checks), face after face
    std::vector<std::uint32_t> face_end;       // [F] one past the face's last corner; a face may have any number
    std::vector<std::uint32_t> face_material;  // [F] into materials
    std::vector<std::uint32_t> face_line;      // [F] line of the file, for messages; or empty
    std::vector<Uv> uvs;                       // [C] or empty; NaN where a corner has none
    std::vector<Vec3> colours;                 // [C] or empty; linear, multiply the reflectance
    std::vector<SourceMaterial> materials;
    std::vector<Texture> textures;
    std::uint32_t textures_not_read = 0;
    std::vector<std::string> warnings;
};

/// Closes the face whose corners have been pushed last.
inline void end_face(SourceMesh& mesh, std::uint32_t material) {
    mesh.face_end.push_back(static_cast<std::uint32_t>(mesh.corners.size()));
    mesh.face_material.push_back(material);
}

/// Whether a mesh holds more than it may. Readers ask after every vertex and face, and before they take many at once.
inline bool is_too_large(const SourceMesh& mesh, const ImportLimits& limits, std::uint64_t more = 0) {
    return mesh.positions.size() + more > limits.corners || mesh.corners.size() + more > limits.corners;
}
inline Error too_large(const std::string& where, const ImportLimits& limits) {
    return bad_input(where, "more than " + std::to_string(limits.corners) + " vertices, or corners of all faces",
                     "split the mesh into several objects");
}

/// Counts a texture that cannot be used, and warns: which, why, and what counts `instead`.
inline void leave_out_texture(SourceMesh& mesh, const std::string& which, const Error& why,
                              const std::string& instead) {
    ++mesh.textures_not_read;
    mesh.warnings.push_back(which + " is not read (" + why.message + "): " + instead + " alone counts");
}

/// Pixels that the next texture of a mesh may have.
std::uint64_t pixels_left(const SourceMesh& mesh, const ImportLimits& limits);

/// Every file read so far, in order of first use, and those looked for in vain.
class SourceFiles {
  public:
    explicit SourceFiles(const ImportLimits& limits) : limits_(limits) {}

    /// The whole file; noted, and its bytes added to the hashed ones, the first time it is read.
    ///
    /// errors   BadInput: missing, no regular file, not readable, beyond the limits
    Result<std::string> read(const std::filesystem::path& path);

    /// Whether there is such a file to read; noted as absent if not, as another import may find it.
    bool has(const std::filesystem::path& path);

    const ImportLimits& limits() const { return limits_; }

    const std::vector<std::filesystem::path>& paths() const { return paths_; }
    const std::set<std::filesystem::path>& absent() const { return absent_; }
    const std::string& bytes() const { return bytes_; }

  private:
    ImportLimits limits_;
    std::vector<std::filesystem::path> paths_;
    std::set<std::filesystem::path> absent_;
    std::string bytes_;
    std::uint64_t reads_ = 0, bytes_read_ = 0;
};

/// The polygons of a mesh file, by the reader that its ending calls for.
///
/// errors   BadInput: an unknown ending, an empty file, and those of the readers
Result<SourceMesh> read_source(const std::filesystem::path& path, SourceFiles& files);

/// One reader per format. `bytes` is the content of `path`, without a byte order mark; other files come through
/// `files`.
///
/// errors   BadInput naming the file and line, byte or element: what was found, what was expected
Result<SourceMesh> read_obj(const std::filesystem::path& path, std::string_view bytes, SourceFiles& files);
Result<SourceMesh> read_gltf(const std::filesystem::path& path, std::string_view bytes, SourceFiles& files);
Result<SourceMesh> read_ply(const std::filesystem::path& path, std::string_view bytes, const ImportLimits& limits);
Result<SourceMesh> read_stl(const std::filesystem::path& path, std::string_view bytes, const ImportLimits& limits);
Result<SourceMesh> read_off(const std::filesystem::path& path, std::string_view bytes, const ImportLimits& limits);

/// A material of an MTL file.
struct MtlMaterial {
    std::optional<Vec3> kd;  // none where the file has no Kd
    Vec3 ke;                 // radiance
    std::string map_kd;      // file name, or empty
    TextureUse use;          // how map_Kd lies on the surface; `texture` is not filled
    bool transparent = false, emissive_map = false;
};

/// The materials of an MTL file by name; the first of two equal names counts.
///
/// errors   BadInput naming file and line: unreadable or negative numbers
Result<std::vector<std::pair<std::string, MtlMaterial>>> read_mtl(const std::filesystem::path& path,
                                                                  std::string_view text);

}  // namespace rro
