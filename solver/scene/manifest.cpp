#include "solver/scene/manifest.h"

#include <algorithm>
#include <map>
#include <numbers>

#include "format/tool/json_document.h"
#include "schemas/scene_schema.h"
#include "solver/scene/transform.h"

namespace rro {
namespace {

using nlohmann::json;

Vec3 to_vec3(const json& value) {
    return {value[0].get<double>(), value[1].get<double>(), value[2].get<double>()};
}

/// Keys of contracts whose effects do not exist yet, wherever they stand.
Status refuse_unsupported(const json& document, const std::string& name) {
    const auto refuse = [&](const std::string& pointer, const std::string& key) -> Status {
        return bad_input(json_place(name, pointer + "/" + key), "\"" + key + "\" is not supported by this version");
    };
    for (const char* key : {"sky", "sun", "lights", "medium"})
        if (document.contains(key)) return refuse("", key);
    const json& instances = document["instances"];
    for (std::size_t i = 0; i < instances.size(); ++i) {
        if (!instances[i].contains("materials")) continue;
        for (const auto& [material, fields] : instances[i]["materials"].items()) {
            if (material == "extras") continue;
            for (const char* key : {"transmittance", "group"})
                if (fields.contains(key))
                    return refuse("/instances/" + std::to_string(i) + "/materials/" + pointer_step(material), key);
        }
    }
    return Done{};
}

Result<Affine3> read_transform(const json& value, const std::string& where) {
    Affine3 to_world;
    if (value.contains("matrix")) {
        const auto m = value["matrix"].get<std::array<double, 16>>();
        if (m[12] != 0 || m[13] != 0 || m[14] != 0 || m[15] != 1)
            return bad_input(where + "/matrix", "the last row is " + json{m[12], m[13], m[14], m[15]}.dump() +
                                                    ", expected [0,0,0,1]: rows first, points are columns");
        to_world = {{{Vec3{m[0], m[1], m[2]}, Vec3{m[4], m[5], m[6]}, Vec3{m[8], m[9], m[10]}}}, {m[3], m[7], m[11]}};
    } else {
        TransformParts parts;
        if (value.contains("translate")) parts.translate = to_vec3(value["translate"]);
        if (value.contains("rotate")) {
            parts.axis = to_vec3(value["rotate"]["axis"]);
            parts.degrees = value["rotate"]["degrees"].get<double>();
            if (parts.axis == Vec3{}) return bad_input(where + "/rotate/axis", "found [0,0,0], expected a direction");
        }
        if (value.contains("scale")) {
            const json& scale = value["scale"];
            const double s = scale.is_number() ? scale.get<double>() : 1;
            parts.scale = scale.is_number() ? Vec3{s, s, s} : to_vec3(scale);
        }
        to_world = compose(parts);
    }
    if (const std::string fault = transform_fault(to_world); !fault.empty()) return bad_input(where, fault);
    return to_world;
}

Result<MaterialOverride> read_material(const json& value, const std::string& where) {
    MaterialOverride material;
    if (value.contains("reflectance")) material.reflectance = to_vec3(value["reflectance"]);
    if (value.contains("exitance")) {
        material.exitance = to_vec3(value["exitance"]);
        for (int c = 0; c < 3; ++c) {
            const double m = (*material.exitance)[c];
            if (!is_usable_exitance(m))
                return bad_input(where + "/exitance/" + std::to_string(c),
                                 "found " + json(m).dump() + ", expected 0 or 1e-30 to 1e30 W/m^2");
        }
    }
    return material;
}

Result<InstanceEntry> read_instance(const json& value, const std::filesystem::path& folder, const std::string& where) {
    InstanceEntry entry;
    entry.name = value["name"].get<std::string>();
    const json& archive = value["archive"];
    const std::string path = archive.is_string() ? archive.get<std::string>() : archive["path"].get<std::string>();
    if (path.find('\0') != std::string::npos)
        return bad_input(where + "/archive", "a path cannot hold a NUL character");
    entry.archive = (folder / path).lexically_normal();
    if (archive.is_object()) entry.content = archive.value("content", "");
    for (char& digit : entry.content)
        if (digit >= 'A' && digit <= 'F') digit = static_cast<char>(digit - 'A' + 'a');
    if (value.contains("transform")) {
        auto to_world = read_transform(value["transform"], where + "/transform");
        if (!to_world) return to_world.error();
        entry.to_world = *to_world;
    }
    if (value.contains("materials"))
        for (const auto& [name, fields] : value["materials"].items()) {
            if (name == "extras") continue;
            auto material = read_material(fields, where + "/materials/" + pointer_step(name));
            if (!material) return material.error();
            entry.materials.emplace_back(name, *material);
        }
    std::stable_partition(entry.materials.begin(), entry.materials.end(), [](const auto& m) { return m.first == "*"; });
    return entry;
}

Result<CameraEntry> read_camera(const json& value, const std::string& where) {
    CameraEntry camera;
    camera.position = to_vec3(value["position"]);
    camera.target = to_vec3(value["target"]);
    if (value.contains("up")) camera.up = to_vec3(value["up"]);
    camera.vertical_fov = value.value("vertical_fov", camera.vertical_fov);
    if (value.contains("exposure")) camera.exposure = value["exposure"].get<double>();
    const Vec3 view = normalised(camera.target - camera.position);
    if (!(length2(view) > 0.5))  // 1, or 0 where the direction is lost
        return bad_input(where + "/target", "found the camera's position, expected a point to look at");
    if (!(length(cross(view, normalised(camera.up))) > 1e-6))  // closer, and rounding decides the picture's tilt
        return bad_input(where + "/up", "found " + value.value("up", json{0, 1, 0}).dump() +
                                            ", expected a direction that is not along the view");
    return camera;
}

}  // namespace

bool is_usable_exitance(double exitance) {
    constexpr double smallest = 1e-30, largest = 1e30;
    return exitance == 0 || (exitance >= smallest && exitance <= largest);
}

Result<Manifest> read_manifest(const std::filesystem::path& path) {
    const std::string name = path.string();
    auto document = read_json(path);
    if (!document) return document.error();
    static const JsonSchema schema(scene_schema);
    if (auto fits = schema.check(*document, name); !fits) return fits.error();
    if (auto supported = refuse_unsupported(*document, name); !supported) return supported.error();

    Manifest manifest;
    manifest.path = path;
    std::map<std::string, std::size_t> names;
    const json& instances = (*document)["instances"];
    for (std::size_t i = 0; i < instances.size(); ++i) {
        const std::string where = name + ": /instances/" + std::to_string(i);
        auto entry = read_instance(instances[i], path.parent_path(), where);
        if (!entry) return entry.error();
        const auto [first, is_new] = names.emplace(entry->name, i);
        if (!is_new)
            return bad_input(where + "/name", "found " + described(entry->name) + ", the name of /instances/" +
                                                  std::to_string(first->second) + " already; expected another");
        manifest.instances.push_back(std::move(*entry));
    }
    if (document->contains("camera")) {
        auto camera = read_camera((*document)["camera"], name + ": /camera");
        if (!camera) return camera.error();
        manifest.camera = *camera;
    }
    if (document->contains("groups"))
        for (const auto& [group, members] : (*document)["groups"].items())
            if (group != "extras") manifest.groups.push_back({group, members.get<std::vector<std::string>>()});
    if (document->contains("accuracy")) manifest.accuracy = (*document)["accuracy"].get<double>();
    return manifest;
}

}  // namespace rro
