#include "format/inspect.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <numeric>

namespace rro {
namespace {

/// The shortest text that gives the same number back.
template <class T>
std::string shortest(T value) {
    std::array<char, 32> text;
    const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
    return {text.data(), end};
}

std::string triple(const Vec3& v) { return shortest(v.x) + " " + shortest(v.y) + " " + shortest(v.z); }

std::string text_of(const Fact& fact) {
    struct Writer {
        std::string operator()(const std::string& value) const { return value; }
        std::string operator()(bool value) const { return value ? "yes" : "no"; }
        std::string operator()(std::uint64_t value) const { return std::to_string(value); }
        std::string operator()(double value) const { return shortest(value); }
    };
    return std::visit(Writer{}, fact.value);
}

std::string padded(std::string text, std::size_t width) {
    text.resize(std::max(width, text.size()), ' ');
    return text;
}

std::string right_aligned(const std::string& text, std::size_t width) {
    return std::string(width - std::min(width, text.size()), ' ') + text;
}

std::string materials_text(const std::vector<Material>& materials) {
    std::string text = "materials\n";
    for (const Material& m : materials)
        text += "  " + padded(m.name, 20) + "  reflectance " + triple(m.reflectance) + "  exitance " + triple(m.exitance) +
                (m.textured ? "  textured" : "") + "\n";
    return text;
}

std::string sections_text(const std::vector<SectionInfo>& sections) {
    std::string text = "sections               codec        offset        stored           raw\n";
    for (const SectionInfo& s : sections)
        text += "  " + padded(s.name, 20) + " " + padded(s.codec, 5) + right_aligned(std::to_string(s.offset), 14) +
                right_aligned(std::to_string(s.stored_bytes), 14) + right_aligned(std::to_string(s.raw_bytes), 14) + "\n";
    return text;
}

std::string csv_field(const std::string& text) {
    if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
    std::string quoted = "\"";
    for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
    return quoted + "\"";
}

/// A coordinate as stored: a float where nothing was added to it.
std::string coordinate(double origin, float position) {
    return origin == 0 ? shortest(position) : shortest(origin + static_cast<double>(position));
}

}  // namespace

std::vector<FactGroup> archive_facts(const Archive& archive) {
    const ObjectData& o = archive.data();
    const ObjectMeta& m = o.meta;
    const auto count = [](const auto& list) { return std::uint64_t{list.size()}; };
    const auto back_faces = static_cast<std::uint64_t>(
        std::count_if(o.faces.begin(), o.faces.end(), [](Face face) { return face.side() == Side::Back; }));
    return {
        {"source",
         {{"name", m.source_name},
          {"sha256", m.source_sha256},
          {"triangles", std::uint64_t{m.source_triangles}},
          {"dropped", std::uint64_t{m.source_triangles} - count(o.triangles)}}},
        {"settings",
         {{"tool_version", m.tool_version},
          {"options", m.options},
          {"map", std::string(m.grid_map == GridMap::Octahedral ? "octahedral" : "latlong")},
          {"grid", std::uint64_t{m.grid_size}},
          {"image_resolution", std::uint64_t{m.image_resolution}}}},
        {"object",
         {{"bounds_lo", triple(m.bounds.lo)},
          {"bounds_hi", triple(m.bounds.hi)},
          {"origin", triple(o.origin)},
          {"area", m.area},
          {"closed", m.closed},
          {"convex", m.convex}}},
        {"counts",
         {{"vertices", count(o.positions)},
          {"triangles", count(o.triangles)},
          {"faces", count(o.faces)},
          {"two_sided_triangles", back_faces},
          {"materials", count(o.materials)},
          {"patches", count(o.patches)},
          {"clusters", count(o.clusters)},
          {"volumes", count(o.volumes)},
          {"clusters_with_areas", count(o.area_clusters)},
          {"directions", std::uint64_t{o.directions()}}}},
    };
}

std::string inspect_text(const Archive& archive, const std::string& name) {
    std::string text = name + ": format " + std::to_string(archive.version_major()) + "." +
                       std::to_string(archive.version_minor()) + ", " + std::to_string(archive.file_bytes()) +
                       " bytes, sha256 " + archive.content_sha256() + "\n";
    for (const FactGroup& group : archive_facts(archive)) {
        text += group.name + "\n";
        for (const Fact& fact : group.facts) text += "  " + padded(fact.name, 20) + " " + text_of(fact) + "\n";
    }
    return text + materials_text(archive.data().materials) + sections_text(archive.sections());
}

std::string triangles_csv(const Archive& archive) {
    const ObjectData& o = archive.data();
    std::vector<std::string> material(o.triangles.size());
    for (const Patch& patch : o.patches)
        for (const Face face : o.faces.subspan(patch.first_face, patch.face_count))
            material[face.triangle()] = csv_field(o.materials[patch.material].name);

    std::vector<std::uint32_t> order(o.triangles.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(),
              [&](std::uint32_t a, std::uint32_t b) { return o.source_triangle[a] < o.source_triangle[b]; });

    std::string csv = "triangle,material,ax,ay,az,bx,by,bz,cx,cy,cz\n";
    for (const std::uint32_t t : order) {
        csv += std::to_string(o.source_triangle[t]) + "," + material[t];
        for (const std::uint32_t corner : o.triangles[t]) {
            const Vec3f& p = o.positions[corner];
            csv += "," + coordinate(o.origin.x, p.x) + "," + coordinate(o.origin.y, p.y) + "," +
                   coordinate(o.origin.z, p.z);
        }
        csv += "\n";
    }
    return csv;
}

}  // namespace rro
