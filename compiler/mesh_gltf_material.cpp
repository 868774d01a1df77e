#include "compiler/mesh_gltf_material.h"

#include <tiny_gltf.h>

#include <cmath>
#include <numbers>

#include "compiler/mesh_gltf_accessor.h"
#include "compiler/mesh_text.h"

namespace rro {
namespace {

constexpr int kMostUvSets = 1024;  // of a primitive, whatever it is: TEXCOORD_n

/// A number of an extension, or element `at` of an array of numbers; `otherwise` where it is absent or something else.
double extension_number(const tinygltf::Value& extension, const std::string& key, double otherwise,
                        std::size_t at = 0) {
    if (!extension.IsObject() || !extension.Has(key)) return otherwise;
    const tinygltf::Value& value = extension.Get(key);
    if (value.IsNumber()) return value.GetNumberAsDouble();
    if (!value.IsArray() || at >= value.ArrayLen()) return otherwise;
    const tinygltf::Value& element = value.Get(static_cast<int>(at));
    return element.IsNumber() ? element.GetNumberAsDouble() : otherwise;
}

}  // namespace

Result<std::uint32_t> GltfMaterials::use(int number, const std::string& where) {
    const auto known = index_.find(number);
    if (known != index_.end()) return known->second;
    SourceMaterial out;
    int uv_set = 0;
    if (number < 0) {
        out.name = default_material;
    } else if (static_cast<std::size_t>(number) >= model_.materials.size()) {
        return bad_input(
            where, "material " + std::to_string(number) + ", but there are " + std::to_string(model_.materials.size()));
    } else {
        const tinygltf::Material& source = model_.materials[static_cast<std::size_t>(number)];
        out.name = source.name.empty() ? "material" + std::to_string(number) : source.name;
        const std::string place_of = place("/materials/" + std::to_string(number));
        if (auto described = describe(source, out, uv_set, place_of); !described) return described.error();
    }
    const auto index = static_cast<std::uint32_t>(mesh_.materials.size());
    mesh_.materials.push_back(std::move(out));
    uv_set_.push_back(uv_set);
    index_.emplace(number, index);
    return index;
}

Status GltfMaterials::describe(const tinygltf::Material& source, SourceMaterial& out, int& uv_set,
                               const std::string& where) {
    const auto& factor = source.pbrMetallicRoughness.baseColorFactor;
    const auto& emissive = source.emissiveFactor;
    if (factor.size() != 4 || (!emissive.empty() && emissive.size() != 3))
        return bad_input(where, "a colour factor of the wrong length");
    out.reflectance = Vec3{factor[0], factor[1], factor[2]};
    if (emissive.size() == 3) out.exitance = Vec3{emissive[0], emissive[1], emissive[2]} * std::numbers::pi;
    if (const auto strength = source.extensions.find("KHR_materials_emissive_strength");
        strength != source.extensions.end())
        out.exitance *= extension_number(strength->second, "emissiveStrength", 1);
    for (int c = 0; c < 3; ++c)
        if (!((*out.reflectance)[c] >= 0) || !(out.exitance[c] >= 0) || !is_finite(out.exitance))
            return bad_input(where, "found a negative or infinite colour factor, expected at least 0");
    if (source.alphaMode == "MASK" || source.alphaMode == "BLEND")
        mesh_.warnings.push_back("material " + in_quotes(out.name) + ": transparency is ignored: it is opaque");
    if (source.emissiveTexture.index >= 0)
        mesh_.warnings.push_back("material " + in_quotes(out.name) +
                                 ": the emissive texture is ignored: the emissive factor alone counts");
    return add_texture(source.pbrMetallicRoughness.baseColorTexture, out, uv_set);
}

Status GltfMaterials::add_texture(const tinygltf::TextureInfo& info, SourceMaterial& out, int& uv_set) {
    if (info.index < 0) return Done{};
    if (static_cast<std::size_t>(info.index) >= model_.textures.size())
        return bad_input(place("/textures"), "texture " + std::to_string(info.index) + ", but there are " +
                                                 std::to_string(model_.textures.size()));
    const tinygltf::Texture& texture = model_.textures[static_cast<std::size_t>(info.index)];
    const auto image = decoded(texture.source);
    if (!image) {
        leave_out_texture(mesh_, "material " + in_quotes(out.name) + ": the texture", image.error(),
                          "the colour factor");
        return Done{};
    }
    TextureUse use;
    use.texture = *image;
    if (texture.sampler >= 0 && static_cast<std::size_t>(texture.sampler) < model_.samplers.size()) {
        const auto wrap = [](int mode) {
            return mode == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE     ? TextureWrap::Clamp
                   : mode == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT ? TextureWrap::Mirror
                                                                   : TextureWrap::Repeat;
        };
        const tinygltf::Sampler& sampler = model_.samplers[static_cast<std::size_t>(texture.sampler)];
        use.wrap_u = wrap(sampler.wrapS);
        use.wrap_v = wrap(sampler.wrapT);
    }
    uv_set = info.texCoord;
    if (const auto extension = info.extensions.find("KHR_texture_transform"); extension != info.extensions.end()) {
        const tinygltf::Value& value = extension->second;
        const double angle = extension_number(value, "rotation", 0), c = std::cos(angle), s = std::sin(angle);
        const double su = extension_number(value, "scale", 1, 0), sv = extension_number(value, "scale", 1, 1);
        use.to_u = {c * su, s * sv, extension_number(value, "offset", 0, 0)};
        use.to_v = {-s * su, c * sv, extension_number(value, "offset", 0, 1)};
        const double set = extension_number(value, "texCoord", uv_set);
        uv_set = set >= 0 && set <= kMostUvSets ? static_cast<int>(set) : -1;  // which no primitive has
    }
    out.texture = use;
    return Done{};
}

Result<std::uint32_t> GltfMaterials::decoded(int number) {
    const auto known = texture_index_.find(number);
    if (known != texture_index_.end()) return known->second;
    auto texture = image(number);
    if (!texture) return texture_index_.emplace(number, texture.error()).first->second;
    const auto index = static_cast<std::uint32_t>(mesh_.textures.size());
    mesh_.textures.push_back(*std::move(texture));
    return texture_index_.emplace(number, index).first->second;
}

Result<Texture> GltfMaterials::image(int number) const {
    if (number < 0 || static_cast<std::size_t>(number) >= model_.images.size())
        return bad_input(path_.string(), "it names no image");
    const tinygltf::Image& source = model_.images[static_cast<std::size_t>(number)];
    GltfBytes bytes{source.image.data(), source.image.size()};
    if (source.bufferView >= 0) {
        const auto view = gltf_view_bytes(model_, source.bufferView, path_.string());
        if (!view) return view.error();
        bytes = *view;
    } else if (bytes.size == 0) {
        return bad_input(path_.string(), "the file " + in_quotes(source.uri) + " cannot be read");
    }
    return decode_texture({reinterpret_cast<const char*>(bytes.data), bytes.size}, pixels_left(mesh_, limits_));
}

}  // namespace rro
