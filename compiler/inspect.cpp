#include "compiler/inspect.h"

#include <algorithm>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <numbers>
#include <vector>

#include "compiler/archive_facts.h"
#include "format/source_order.h"
#include "format/tool/csv_field.h"
#include "format/tool/printed.h"

namespace rro {
namespace {

nlohmann::ordered_json triple(const Vec3& v) {
    return {v.x, v.y, v.z};
}

nlohmann::ordered_json counts_of(const ObjectData& d) {
    return {{"vertices", d.positions.size()},
            {"triangles", d.triangles.size()},
            {"source_triangles", d.meta.source_triangles},
            {"faces", d.faces.size()},
            {"patches", d.patches.size()},
            {"clusters", d.clusters.size()},
            {"cluster_depth", tree_depth(d.clusters)},
            {"volumes", d.volumes.size()},
            {"materials", d.materials.size()},
            {"area_clusters", d.area_clusters.size()},
            {"hit_volumes", d.hit_volumes.size()},
            {"directions", d.directions()}};
}

/// The stored error of one kind of table: of the whole object, and over the clusters that have tables.
struct ErrorBars {
    const char* name;
    double object, median, largest;  // relative
};

std::vector<ErrorBars> error_bars(const ObjectData& d) {
    std::vector<ErrorBars> bars;
    const auto add = [&](const char* name, std::span<const float> errors) {
        if (errors.empty()) return;
        std::vector<double> sorted(errors.begin(), errors.end());
        std::sort(sorted.begin(), sorted.end());
        bars.push_back({name, static_cast<double>(errors[0]), sorted[sorted.size() / 2], sorted.back()});
    };
    add("whole area", d.whole_area_error);
    add("intrinsic area", d.intrinsic_area_error);
    add("patch visibility", d.visibility_error);
    return bars;
}

nlohmann::ordered_json errors_of(const ObjectData& d) {
    nlohmann::ordered_json errors{{"directions", d.error_directions}};
    for (const ErrorBars& bar : error_bars(d)) {
        std::string key = bar.name;
        std::replace(key.begin(), key.end(), ' ', '_');
        errors[key] = {{"object", bar.object}, {"median", bar.median}, {"largest", bar.largest}};
    }
    return errors;
}

/// Mean over the directions of the probability that a line which meets the whole object's box hits the object.
double mean_hit(const Archive& archive, std::span<const std::uint8_t> table) {
    const DirectionGrid& grid = archive.grid();
    const std::vector<double> angles = grid.solid_angles();
    double mean = 0;
    for (std::uint32_t node = 0; node < grid.size(); ++node) mean += table[grid.line(node)] / 255.0 * angles[node];
    return mean / (4 * std::numbers::pi);
}

nlohmann::ordered_json hits_of(const Archive& archive) {
    const ObjectData& d = archive.data();
    if (d.hit_volumes.empty()) return nullptr;
    return {{"volumes", d.hit_volumes.size()},
            {"lines", d.lines()},
            {"intrinsic", !d.intrinsic_hit.empty()},
            {"object", mean_hit(archive, d.whole_hit)}};
}

nlohmann::ordered_json atlas_of(const ObjectData& d) {
    if (d.atlas_coverage.empty()) return nullptr;
    return {{"grid_size", d.atlas_grid_size},
            {"image_size", d.atlas_image_size},
            {"centre", triple(to_double(d.atlas_centre))},
            {"radius", d.atlas_radius}};
}

nlohmann::ordered_json self_links_of(const ObjectData& d) {
    if (d.self_steps.empty()) return nullptr;
    const ClosureDefect defect = closure_defect(d);
    return {{"pairs", d.self_steps.size()},
            {"links", d.self_exchange.size()},
            {"closure", {{"mean", defect.mean}, {"rms", defect.rms}, {"largest", defect.largest}}}};
}

nlohmann::ordered_json inspection(const Archive& archive, const std::string& name) {
    const ObjectData& d = archive.data();
    const ObjectMeta& m = d.meta;
    nlohmann::ordered_json out{
        {"file", name},
        {"bytes", archive.file_bytes()},
        {"version", format_version(archive)},
        {"content", archive.content_sha256()},
        {"tool_version", m.tool_version},
        {"source", {{"name", m.source_name}, {"sha256", m.source_sha256}}},
        {"options", m.options},
        {"grid", {{"map", map_name(m.grid_map)}, {"size", m.grid_size}}},
        {"image_resolution", m.image_resolution},
        {"bounds", {{"lo", triple(m.bounds.lo)}, {"hi", triple(m.bounds.hi)}}},
        {"origin", triple(d.origin)},
        {"area", m.area},
        {"closed", m.closed},
        {"convex", m.convex},
        {"counts", counts_of(d)},
        {"table_errors", errors_of(d)},
        {"hit", hits_of(archive)},
        {"atlas", atlas_of(d)},
        {"selflinks", self_links_of(d)}};
    out["materials"] = nlohmann::ordered_json::array();
    for (const Material& material : d.materials)
        out["materials"].push_back({{"name", material.name},
                                    {"reflectance", triple(material.reflectance)},
                                    {"exitance", triple(material.exitance)},
                                    {"textured", material.textured}});
    out["sections"] = nlohmann::ordered_json::array();
    for (const SectionInfo& s : archive.sections())
        out["sections"].push_back({{"name", s.name},
                                   {"codec", s.codec},
                                   {"offset", s.offset},
                                   {"stored_bytes", s.stored_bytes},
                                   {"raw_bytes", s.raw_bytes},
                                   {"crc32", s.crc32}});
    return out;
}

template <class... Values>
std::string line(const char* format, Values... values) {
    return printed(format, values...) + "\n";
}

}  // namespace

std::string inspection_text(const Archive& archive, const std::string& name) {
    const ObjectData& d = archive.data();
    const ObjectMeta& m = d.meta;
    std::string out =
        name + ": format " + format_version(archive) + ", " + std::to_string(archive.file_bytes()) + " bytes\n";
    out += "content    " + archive.content_sha256() + "\n";
    out += "source     " + m.source_name + " " + m.source_sha256 + "\n";
    out += "made by    rro-compile " + m.tool_version + "\n";
    out += "options    " + m.options + "\n";
    out += line("object     %s, %s; area %.6g m^2; bounds (%.6g, %.6g, %.6g) to (%.6g, %.6g, %.6g) m",
                m.closed ? "closed" : "open", m.convex ? "convex" : "not convex", m.area, m.bounds.lo.x, m.bounds.lo.y,
                m.bounds.lo.z, m.bounds.hi.x, m.bounds.hi.y, m.bounds.hi.z);
    out += line("mesh       %zu triangles of %u in the source, %zu vertices, %zu faces", d.triangles.size(),
                m.source_triangles, d.positions.size(), d.faces.size());
    out += line("trees      %zu patches, %zu clusters (%zu deep), %zu volumes", d.patches.size(), d.clusters.size(),
                tree_depth(d.clusters), d.volumes.size());
    out += line("tables     %u x %u %s directions, images of %u^2; areas of %zu clusters", m.grid_size, m.grid_size,
                map_name(m.grid_map).c_str(), m.image_resolution, d.area_clusters.size());
    for (const ErrorBars& bar : error_bars(d))
        out += line("off grid   %-16s %.3g %% off for the object, %.3g %% for the median cluster, %.3g %% for the worst",
                    bar.name, 100 * bar.object, 100 * bar.median, 100 * bar.largest);
    if (!d.hit_volumes.empty())
        out += line("hit        probabilities of %zu volumes%s along %u lines; %.3g for the object's box", d.hit_volumes.size(),
                    d.intrinsic_hit.empty() ? "" : ", intrinsic ones too", d.lines(), mean_hit(archive, d.whole_hit));
    if (!d.atlas_coverage.empty())
        out += line("atlas      %u silhouettes of %u x %u pixels, of a sphere of %.6g m about (%.6g, %.6g, %.6g)",
                    d.atlas_grid_size * d.atlas_grid_size / 2, d.atlas_image_size, d.atlas_image_size,
                    static_cast<double>(d.atlas_radius), static_cast<double>(d.atlas_centre.x),
                    static_cast<double>(d.atlas_centre.y), static_cast<double>(d.atlas_centre.z));
    if (!d.self_steps.empty()) {
        const ClosureDefect defect = closure_defect(d);
        out += line("self links %zu among %zu pairs; light of patches adds up to 1 %+.2g, root mean square %.2g, worst patch %.2g",
                    d.self_exchange.size(), d.self_steps.size(), defect.mean, defect.rms, defect.largest);
    }
    for (const Material& material : d.materials)
        out += "material   " + material.name +
               line(": reflectance %.4g %.4g %.4g%s, exitance %.6g %.6g %.6g W/m^2", material.reflectance.x,
                    material.reflectance.y, material.reflectance.z, material.textured ? " (textured)" : "",
                    material.exitance.x, material.exitance.y, material.exitance.z);
    for (const SectionInfo& s : archive.sections())
        out += line("section    %-12s %-5s %12llu bytes, %12llu raw, crc32 %08x", s.name.c_str(), s.codec.c_str(),
                    static_cast<unsigned long long>(s.stored_bytes), static_cast<unsigned long long>(s.raw_bytes),
                    static_cast<unsigned>(s.crc32));
    return out;
}

std::string inspection_json(const Archive& archive, const std::string& name) {
    return inspection(archive, name).dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

std::string triangles_csv(const ObjectData& data) {
    const std::vector<std::uint32_t> material = triangle_materials(data);
    std::string out = "triangle,material,ax,ay,az,bx,by,bz,cx,cy,cz\n";
    for (const std::uint32_t t : by_source_number(data)) {
        out += std::to_string(data.source_triangle[t]) + "," + csv_field(data.materials[material[t]].name);
        for (const Vec3& p : data.corners(t))
            for (int axis = 0; axis < 3; ++axis) out += "," + shortest(p[axis]);
        out += "\n";
    }
    return out;
}

}  // namespace rro
