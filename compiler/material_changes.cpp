#include "compiler/material_changes.h"

#include <nlohmann/json.hpp>

#include "format/tool/json_document.h"
#include "format/tool/names.h"

namespace rro {
namespace {

Error unknown_material(const Mesh& mesh, const std::string& name, const std::string& place) {
    std::vector<std::string> names;
    for (const Material& material : mesh.materials) names.push_back(material.name);
    return {ErrorKind::Usage, place + "/" + pointer_step(name),
            "the mesh has no such material, expected one of: " + listed(names), nearest_hint(name, names)};
}

nlohmann::json to_json(const Vec3& v) {
    return {v.x, v.y, v.z};
}

}  // namespace

Status change_materials(Mesh& mesh, const MaterialChanges& changes, const std::string& place) {
    for (const auto& [name, change] : changes) {
        bool found = name == "*";
        for (std::uint32_t m = 0; m < mesh.materials.size(); ++m) {
            if (name != "*" && mesh.materials[m].name != name) continue;
            found = true;
            Material& material = mesh.materials[m];
            if (change.reflectance) material.textured = false;
            material.reflectance = change.reflectance.value_or(material.reflectance);
            material.exitance = change.exitance.value_or(material.exitance);
        }
        if (!found) return unknown_material(mesh, name, place);
    }
    return Done{};
}

std::string canonical_text(const MaterialChanges& changes) {
    nlohmann::json text = nlohmann::json::object();
    for (const auto& [name, change] : changes) {
        nlohmann::json& fields = text[name] = nlohmann::json::object();
        if (change.reflectance) fields["reflectance"] = to_json(*change.reflectance);
        if (change.exitance) fields["exitance"] = to_json(*change.exitance);
    }
    return text.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace rro
