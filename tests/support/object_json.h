// The sections of an object as JSON in the shape that flatc gives them by schemas/rro.fbs, and a comparison of such JSON.
// Written from the schema, not from the serializer under test.
#pragma once

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "format/object_data.h"

namespace rro::test {

using Json = nlohmann::json;

template <class V>
Json xyz(const V& v) {
    return {{"x", v.x}, {"y", v.y}, {"z", v.z}};
}

template <class T, class Convert>
Json list_of(const T& values, const Convert& convert) {
    Json list = Json::array();
    for (const auto& value : values) list.push_back(convert(value));
    return list;
}

template <class T>
Json numbers(const T& values) {
    return list_of(values, [](const auto& value) { return Json(value); });
}

inline Json meta_json(const ObjectMeta& m) {
    return {{"tool_version", m.tool_version},
            {"source_name", m.source_name},
            {"source_sha256", m.source_sha256},
            {"options", m.options},
            {"grid_map", m.grid_map == GridMap::LatLong ? Json("LatLong") : Json()},
            {"grid_size", m.grid_size == 12 ? Json() : Json(m.grid_size)},
            {"image_resolution", m.image_resolution},
            {"source_triangles", m.source_triangles},
            {"bounds_lo", xyz(m.bounds.lo)},
            {"bounds_hi", xyz(m.bounds.hi)},
            {"area", m.area},
            {"closed", m.closed},
            {"convex", m.convex}};
}

/// {"meta": {...}, "mesh": {...}, ...}: every section of layout::kSections.
inline Json object_json(const ObjectData& o) {
    Json json;
    json["meta"] = meta_json(o.meta);
    json["mesh"] = {{"origin", o.origin == Vec3{} ? Json() : xyz(o.origin)},
                    {"positions", list_of(o.positions, xyz<Vec3f>)},
                    {"triangles", list_of(o.triangles,
                                          [](const TriangleIndices& t) {
                                              return Json{{"a", t[0]}, {"b", t[1]}, {"c", t[2]}};
                                          })},
                    {"faces", list_of(o.faces, [](Face f) { return f.packed; })}};
    json["materials"] = {{"materials", list_of(o.materials, [](const Material& m) {
                              return Json{{"name", m.name},
                                          {"reflectance", xyz(m.reflectance)},
                                          {"exitance", xyz(m.exitance)},
                                          {"textured", m.textured}};
                          })}};
    json["patches"] = {{"patches", list_of(o.patches, [](const Patch& p) {
                            return Json{{"first_face", p.first_face}, {"face_count", p.face_count},
                                        {"material", p.material},     {"area", p.area},
                                        {"reflectance", xyz(p.reflectance)}, {"centre", xyz(p.centre)},
                                        {"normal", xyz(p.normal)},    {"cone_cosine", p.cone_cosine}};
                        })}};
    json["clusters"] = {{"clusters", list_of(o.clusters, [](const Cluster& c) {
                             return Json{{"first_patch", c.first_patch}, {"patch_count", c.patch_count},
                                         {"right_child", c.right_child}, {"area", c.area},
                                         {"radius", c.radius},           {"lo", xyz(c.lo)},
                                         {"hi", xyz(c.hi)},              {"normal", xyz(c.normal)},
                                         {"cone_cosine", c.cone_cosine}};
                         })}};
    json["area"] = {{"clusters", numbers(o.area_clusters)},
                    {"whole", numbers(o.whole_area)},
                    {"whole_scale", numbers(o.whole_area_scale)},
                    {"intrinsic", numbers(o.intrinsic_area)},
                    {"intrinsic_scale", numbers(o.intrinsic_area_scale)}};
    json["visibility"] = {{"visibility", numbers(o.visibility)}};
    json["errors"] = {{"directions", o.error_directions},
                      {"whole", numbers(o.whole_area_error)},
                      {"intrinsic", numbers(o.intrinsic_area_error)},
                      {"visibility", numbers(o.visibility_error)}};
    json["hbv"] = {{"volumes", list_of(o.volumes,
                                       [](const Volume& v) {
                                           return Json{{"lo", xyz(v.lo)},
                                                       {"hi", xyz(v.hi)},
                                                       {"first", v.first},
                                                       {"count", v.count},
                                                       {"right_child", v.right_child}};
                                       })},
                   {"triangles", numbers(o.volume_triangles)}};
    json["hit"] = {{"volumes", numbers(o.hit_volumes)},
                   {"whole", numbers(o.whole_hit)},
                   {"intrinsic", numbers(o.intrinsic_hit)}};
    json["atlas"] = {{"centre", xyz(o.atlas_centre)},
                     {"radius", o.atlas_radius},
                     {"grid_size", o.atlas_grid_size},
                     {"image_size", o.atlas_image_size},
                     {"coverage", numbers(o.atlas_coverage)}};
    json["selflinks"] = {{"steps", numbers(o.self_steps)},       {"exchange", numbers(o.self_exchange)},
                         {"visibility", numbers(o.self_visibility)}, {"escape", numbers(o.self_escape)},
                         {"received", numbers(o.self_received)}, {"black", numbers(o.self_black)}};
    json["source"] = {{"triangles", numbers(o.source_triangle)}};
    return json;
}

/// What a table leaves out: 0, false, "", an empty vector, or null for a default other than 0.
inline bool is_left_out(const Json& value) {
    return value.is_null() || value == 0 || value == false || value == "" || (value.is_array() && value.empty());
}

/// Where two JSON values differ, as a path; empty where they do not. Whole numbers and text must be equal; flatc prints
/// floats with 6 digits and doubles with 12, so numbers with a fraction may differ by a part in 10^5 or 10^-6.
inline std::string difference(const Json& a, const Json& b, const std::string& path = "") {
    if (a.is_object() && b.is_object()) {
        std::set<std::string> keys;
        for (const auto& item : a.items()) keys.insert(item.key());
        for (const auto& item : b.items()) keys.insert(item.key());
        for (const std::string& key : keys) {
            const Json left = a.value(key, Json()), right = b.value(key, Json());
            if (is_left_out(left) && is_left_out(right)) continue;
            if (auto found = difference(left, right, path + "/" + key); !found.empty()) return found;
        }
        return "";
    }
    if (a.is_array() && b.is_array() && a.size() == b.size()) {
        for (std::size_t i = 0; i < a.size(); ++i)
            if (auto found = difference(a[i], b[i], path + "/" + std::to_string(i)); !found.empty()) return found;
        return "";
    }
    if ((a.is_number_float() || b.is_number_float()) && a.is_number() && b.is_number()) {
        const double x = a.get<double>(), y = b.get<double>();
        if (std::abs(x - y) <= std::max(1e-6, 1e-5 * std::abs(x))) return "";
    }
    return a == b ? "" : path + ": " + a.dump().substr(0, 200) + " and " + b.dump().substr(0, 200);
}

}  // namespace rro::test
