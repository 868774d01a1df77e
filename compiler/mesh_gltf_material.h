// Materials and textures of a glTF document, taken over as primitives use them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "compiler/mesh_readers.h"

namespace tinygltf {
class Model;
struct Material;
struct TextureInfo;
}  // namespace tinygltf

namespace rro {

class GltfMaterials {
  public:
    /// All four must outlive this; materials, textures and warnings go to `mesh`.
    GltfMaterials(const tinygltf::Model& model, const std::filesystem::path& path, const ImportLimits& limits,
                  SourceMesh& mesh)
        : model_(model), path_(path), limits_(limits), mesh_(mesh) {}

    /// Our number of a glTF material (-1: none) that the primitive at `where` uses.
    ///
    /// errors   BadInput: no such material or texture, a negative or infinite factor
    Result<std::uint32_t> use(int number, const std::string& where);

    /// Which TEXCOORD the texture of a material (our number) lies by.
    int uv_set(std::uint32_t material) const { return uv_set_[material]; }

  private:
    std::string place(const std::string& pointer) const { return path_.string() + ": " + pointer; }
    Status describe(const tinygltf::Material& source, SourceMaterial& out, int& uv_set, const std::string& where);
    Status add_texture(const tinygltf::TextureInfo& info, SourceMaterial& out, int& uv_set);
    Result<std::uint32_t> decoded(int number);
    Result<Texture> image(int number) const;

    const tinygltf::Model& model_;
    const std::filesystem::path& path_;
    const ImportLimits& limits_;
    SourceMesh& mesh_;
    std::map<int, std::uint32_t> index_;                         // glTF material -> ours
    std::vector<int> uv_set_;                                    // [materials of ours]
    std::map<int, Result<std::uint32_t>> texture_index_;  // glTF image -> ours, or why there is none
};

}  // namespace rro
