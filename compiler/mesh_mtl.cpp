// MTL. Numbers are read strictly; tinyobjloader splits texture options from file names.
#include <algorithm>
#include <cmath>

#define TINYOBJLOADER_USE_DOUBLE
#include <tiny_obj_loader.h>

#include "compiler/mesh_readers.h"
#include "compiler/mesh_text.h"

namespace rro {
namespace {

/// "Kd r g b" or "Kd r", which stands for grey.
Result<Vec3> colour(const std::string& where, const std::vector<std::string_view>& words) {
    const std::string key(words[0]);
    if (words.size() != 2 && words.size() != 4)
        return bad_input(where, key + " with " + std::to_string(words.size() - 1) + " values, expected three numbers");
    Vec3 rgb;
    for (int c = 0; c < 3; ++c) {
        const std::string_view word = words[words.size() == 2 ? 1 : static_cast<std::size_t>(c) + 1];
        const auto value = parse_real(word);
        if (!value || !(*value >= 0) || !std::isfinite(*value))
            return bad_input(where, "found " + in_quotes(word) + ", expected a number of at least 0 after " + key);
        rgb[c] = *value;
    }
    return rgb;
}

/// File name and placement of "map_Kd [options] name". MTL's v runs up from the bottom of the image.
void read_texture(std::string_view options, MtlMaterial& material) {
    tinyobj::texture_option_t option{};
    option.clamp = false;
    std::fill_n(option.scale, 3, 1.0);
    std::fill_n(option.origin_offset, 3, 0.0);
    std::string name;
    tinyobj::ParseTextureNameAndOption(&name, &option, std::string(options).c_str());
    material.map_kd = trimmed(name);
    material.use.to_u = {option.scale[0], 0, option.origin_offset[0]};
    material.use.to_v = {0, -option.scale[1], 1 - option.origin_offset[1]};
    material.use.wrap_u = material.use.wrap_v = option.clamp ? TextureWrap::Clamp : TextureWrap::Repeat;
}

Status read_statement(const std::string& where, std::string_view line, const std::vector<std::string_view>& words,
                      MtlMaterial& material) {
    const std::string_view key = words[0];
    if (key == "Kd" || key == "Ke") {
        if (words.size() > 1 && (words[1] == "spectral" || words[1] == "xyz"))
            return bad_input(where, std::string(key) + " " + std::string(words[1]) + " is not supported",
                             "give the colour as three numbers");
        const auto rgb = colour(where, words);
        if (!rgb) return rgb.error();
        if (key == "Kd") material.kd = *rgb;
        if (key == "Ke") material.ke = *rgb;
    } else if ((key == "d" || key == "Tr") && words.size() > 1) {
        const auto value = parse_real(words.back());
        if (!value)
            return bad_input(where,
                             "found " + in_quotes(words.back()) + ", expected a number after " + std::string(key));
        material.transparent = key == "d" ? *value < 1 : *value > 0;
    } else if (key == "map_Kd" && words.size() > 1) {
        read_texture(trimmed(line.substr(line.find(key) + key.size())), material);
    } else if (key == "map_d") {
        material.transparent = true;
    } else if (key == "map_Ke") {
        material.emissive_map = true;
    }
    return Done{};
}

}  // namespace

Result<std::vector<std::pair<std::string, MtlMaterial>>> read_mtl(const std::filesystem::path& path,
                                                                  std::string_view text) {
    std::vector<std::pair<std::string, MtlMaterial>> materials;
    LineReader lines(without_mark(text));
    std::string_view line;
    std::vector<std::string_view> words;
    while (lines.next(line)) {
        split_words(line, words);
        if (words.empty() || words[0].starts_with('#')) continue;
        if (words[0] == "newmtl") {
            materials.emplace_back(trimmed(line.substr(line.find("newmtl") + 6)), MtlMaterial{});
            continue;
        }
        if (materials.empty()) continue;
        if (auto read = read_statement(at_line(path, lines.line_number()), line, words, materials.back().second); !read)
            return read.error();
    }
    return materials;
}

}  // namespace rro
