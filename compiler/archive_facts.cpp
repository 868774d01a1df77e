#include "compiler/archive_facts.h"

#include <array>
#include <charconv>

namespace rro {

std::string format_version(const Archive& archive) {
    return std::to_string(archive.version_major()) + "." + std::to_string(archive.version_minor());
}

std::string map_name(GridMap map) {
    return map == GridMap::Octahedral ? "octahedral" : "latlong";
}

std::vector<std::uint32_t> triangle_materials(const ObjectData& data) {
    std::vector<std::uint32_t> material(data.triangles.size());
    for (const Patch& p : data.patches)
        for (std::uint32_t f = p.first_face; f < p.first_face + p.face_count; ++f)
            material[data.faces[f].triangle()] = p.material;
    return material;
}

std::string shortest(double x) {
    std::array<char, 32> text;
    const auto end = std::to_chars(text.data(), text.data() + text.size(), x).ptr;
    return {text.data(), end};
}

}  // namespace rro
