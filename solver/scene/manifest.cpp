#include "solver/scene/manifest.h"

#include <algorithm>
#include <cmath>
#include <functional>
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

/// A radiometric quantity of three channels.
Result<Vec3> read_power(const json& value, const std::string& where, const std::string& unit) {
    for (std::size_t c = 0; c < 3; ++c)
        if (!is_usable_power(value[c].get<double>()))
            return bad_input(where + "/" + std::to_string(c),
                             "found " + value[c].dump() + ", expected 0 or 1e-30 to 1e30 " + unit);
    return to_vec3(value);
}

Result<Vec3> read_direction(const json& value, const std::string& where) {
    const Vec3 direction = normalised(to_vec3(value));
    if (!(length2(direction) > 0.5))  // 1, or 0 where there is none
        return bad_input(where, "found " + value.dump() + ", expected a direction");
    return direction;
}

/// Paths in a manifest are relative to its folder.
Result<std::filesystem::path> read_path(const std::string& path, const std::filesystem::path& folder,
                                        const std::string& where) {
    if (path.find('\0') != std::string::npos) return bad_input(where, "a path cannot hold a NUL character");
    return (folder / path).lexically_normal();
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
        const auto exitance = read_power(value["exitance"], where + "/exitance", "W/m^2");
        if (!exitance) return exitance.error();
        material.exitance = *exitance;
    }
    if (value.contains("transmittance")) material.transmittance = to_vec3(value["transmittance"]);
    if (value.contains("group")) material.group = value["group"].get<std::string>();
    if (material.reflectance && material.transmittance)
        for (int c = 0; c < 3; ++c)
            if (const double sum = (*material.reflectance)[c] + (*material.transmittance)[c]; !(sum < 1))
                return bad_input(where + "/transmittance/" + std::to_string(c),
                                 "found " + json((*material.transmittance)[c]).dump() + " beside a reflectance of " +
                                     json((*material.reflectance)[c]).dump() + ", expected a sum below 1");
    return material;
}

Result<InstanceEntry> read_instance(const json& value, const std::filesystem::path& folder, const std::string& where) {
    InstanceEntry entry;
    entry.name = value["name"].get<std::string>();
    const json& archive = value["archive"];
    const std::string path = archive.is_string() ? archive.get<std::string>() : archive["path"].get<std::string>();
    const auto resolved = read_path(path, folder, where + "/archive");
    if (!resolved) return resolved.error();
    entry.archive = *resolved;
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

Result<SkyEntry> read_sky(const json& value, const std::filesystem::path& folder, const std::string& where) {
    SkyEntry sky;
    const auto kinds = value.count("radiance") + value.count("cie_overcast") + value.count("image");
    if (kinds != 1)
        return bad_input(where, "found " + std::to_string(kinds) +
                                    " of \"radiance\", \"cie_overcast\" and \"image\", expected one");
    if (value.contains("scale") && !value.contains("image")) return bad_input(where + "/scale", "only an image has a scale");
    sky.ground = value.value("ground", false);
    const auto kinds_of_radiance = {std::pair("radiance", &sky.radiance), std::pair("cie_overcast", &sky.cie_overcast)};
    for (const auto& [key, radiance] : kinds_of_radiance) {
        if (!value.contains(key)) continue;
        const auto read = read_power(value[key], where + "/" + key, "W/(m^2 sr)");
        if (!read) return read.error();
        *radiance = *read;
    }
    if (value.contains("image")) {
        const auto image = read_path(value["image"].get<std::string>(), folder, where + "/image");
        if (!image) return image.error();
        sky.image = *image;
        sky.scale = value.value("scale", sky.scale);
        if (!is_usable_power(sky.scale))
            return bad_input(where + "/scale", "found " + value["scale"].dump() + ", expected 0 or 1e-30 to 1e30");
    }
    return sky;
}

Result<SunEntry> read_sun(const json& value, const std::string& where) {
    SunEntry sun;
    const auto direction = read_direction(value["direction"], where + "/direction");
    if (!direction) return direction.error();
    const auto irradiance = read_power(value["irradiance"], where + "/irradiance", "W/m^2");
    if (!irradiance) return irradiance.error();
    sun.direction = *direction;
    sun.irradiance = *irradiance;
    sun.angular_diameter = value.value("angular_diameter", sun.angular_diameter);
    return sun;
}

/// Which keys a type of light needs and allows.
struct LightKeys {
    LightEntry::Type type;
    std::vector<const char*> needed, allowed;
};

Status check_light_keys(const json& value, const LightKeys& keys, const std::string& where) {
    const std::string type = value["type"].get<std::string>();
    for (const char* key : keys.needed)
        if (!value.contains(key))
            return bad_input(where, "the key \"" + std::string(key) + "\" is missing, a light of type \"" + type +
                                        "\" needs it");
    const auto has = [](const std::vector<const char*>& list, const char* key) {
        return std::any_of(list.begin(), list.end(), [&](const char* k) { return std::string_view(k) == key; });
    };
    for (const char* key : {"direction", "intensity", "cone_degrees", "file"})
        if (value.contains(key) && !has(keys.needed, key) && !has(keys.allowed, key))
            return bad_input(where + "/" + key, "a light of type \"" + type + "\" has no \"" + key + "\"");
    return Done{};
}

Result<LightEntry> read_light(const json& value, const std::filesystem::path& folder, const std::string& where) {
    static const std::map<std::string, LightKeys, std::less<>> types{
        {"point", {LightEntry::Type::Point, {"intensity"}, {}}},
        {"spot", {LightEntry::Type::Spot, {"direction", "intensity", "cone_degrees"}, {}}},
        {"ies", {LightEntry::Type::Ies, {"file"}, {"direction", "intensity"}}}};
    const LightKeys& keys = types.at(value["type"].get<std::string>());
    if (auto fits = check_light_keys(value, keys, where); !fits) return fits.error();
    LightEntry light;
    light.name = value["name"].get<std::string>();
    light.type = keys.type;
    light.position = to_vec3(value["position"]);
    constexpr double farthest = 1e100;  // squares of distances stay finite
    for (int axis = 0; axis < 3; ++axis)
        if (!(std::abs(light.position[axis]) <= farthest))
            return bad_input(where + "/position/" + std::to_string(axis),
                             "found " + json(light.position[axis]).dump() + ", expected at most 1e100 m");
    if (value.contains("direction")) {
        const auto direction = read_direction(value["direction"], where + "/direction");
        if (!direction) return direction.error();
        light.direction = *direction;
    }
    if (value.contains("intensity")) {
        const auto intensity = read_power(value["intensity"], where + "/intensity", "W/sr");
        if (!intensity) return intensity.error();
        light.intensity = *intensity;
    }
    light.cone_degrees = value.value("cone_degrees", light.cone_degrees);
    if (value.contains("file")) {
        const auto file = read_path(value["file"].get<std::string>(), folder, where + "/file");
        if (!file) return file.error();
        light.file = *file;
    }
    light.group = value.value("group", "");
    return light;
}

/// Everything but instances that lights a scene or weakens light.
Status read_lights(const json& document, const std::string& name, const std::filesystem::path& folder,
                   Manifest& manifest) {
    if (document.contains("sky")) {
        const auto sky = read_sky(document["sky"], folder, name + ": /sky");
        if (!sky) return sky.error();
        manifest.sky = *sky;
    }
    if (document.contains("sun")) {
        const auto sun = read_sun(document["sun"], name + ": /sun");
        if (!sun) return sun.error();
        manifest.sun = *sun;
    }
    std::map<std::string, std::size_t> names;
    const json lights = document.value("lights", json::array());
    for (std::size_t i = 0; i < lights.size(); ++i) {
        const std::string where = name + ": /lights/" + std::to_string(i);
        auto light = read_light(lights[i], folder, where);
        if (!light) return light.error();
        if (const auto [first, is_new] = names.emplace(light->name, i); !is_new)
            return bad_input(where + "/name", "found " + described(light->name) + ", the name of /lights/" +
                                                  std::to_string(first->second) + " already; expected another");
        manifest.lights.push_back(std::move(*light));
    }
    if (document.contains("medium")) {
        const auto absorption = read_power(document["medium"]["absorption"], name + ": /medium/absorption", "1/m");
        if (!absorption) return absorption.error();
        manifest.absorption = *absorption;
    }
    return Done{};
}

std::vector<GroupEntry> read_groups(const json& document) {
    std::vector<GroupEntry> groups;
    if (!document.contains("groups")) return groups;
    for (const auto& [name, members] : document["groups"].items())
        if (name != "extras") groups.push_back({name, members.get<std::vector<std::string>>()});
    return groups;
}

Result<Manifest> manifest_of(const json& document, const std::filesystem::path& path) {
    const std::string name = path.string();
    static const JsonSchema schema(scene_schema);
    if (auto fits = schema.check(document, name); !fits) return fits.error();

    Manifest manifest;
    manifest.path = path;
    std::map<std::string, std::size_t> names;
    const json& instances = document["instances"];
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
    if (document.contains("camera")) {
        auto camera = read_camera(document["camera"], name + ": /camera");
        if (!camera) return camera.error();
        manifest.camera = *camera;
    }
    if (auto lights = read_lights(document, name, path.parent_path(), manifest); !lights) return lights.error();
    manifest.groups = read_groups(document);
    if (document.contains("accuracy")) manifest.accuracy = document["accuracy"].get<double>();
    return manifest;
}

}  // namespace

bool is_usable_power(double power) {
    constexpr double smallest = 1e-30, largest = 1e30;
    return power == 0 || (power >= smallest && power <= largest);
}

Result<Manifest> read_manifest(const std::filesystem::path& path) {
    auto document = read_json(path);
    if (!document) return document.error();
    return manifest_of(*document, path);
}

Result<Manifest> parse_manifest(std::string_view text, const std::filesystem::path& path) {
    auto document = parse_json(text, path.string());
    if (!document) return document.error();
    return manifest_of(*document, path);
}

}  // namespace rro
