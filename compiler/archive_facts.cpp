#include "compiler/archive_facts.h"

#include <array>
#include <charconv>
#include <cmath>

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

ClosureDefect closure_defect(const ObjectData& data) {
    ClosureDefect result;
    double area = 0;
    for (std::size_t p = 0; p < data.self_escape.size(); ++p) {
        const double a = static_cast<double>(data.patches[p].area);
        const double off = static_cast<double>(data.self_escape[p]) + static_cast<double>(data.self_received[p]) +
                           static_cast<double>(data.self_black[p]) - 1;
        result.mean += a * off;
        result.rms += a * off * off;
        result.largest = std::max(result.largest, std::abs(off));
        area += a;
    }
    if (area > 0) result.mean /= area, result.rms = std::sqrt(result.rms / area);
    return result;
}

std::string shortest(double x) {
    std::array<char, 32> text;
    const auto end = std::to_chars(text.data(), text.data() + text.size(), x).ptr;
    return {text.data(), end};
}

}  // namespace rro
