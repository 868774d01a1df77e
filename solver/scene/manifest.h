// The scene manifest "rro-scene/1" (schemas/scene.schema.json) as values. Nothing here opens another file.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "format/geometry.h"
#include "format/result.h"

namespace rro {

/// What a manifest says about one material of one instance; what is absent stays as the archive has it.
struct MaterialOverride {
    std::optional<Vec3> reflectance;  // each in [0, 1)
    std::optional<Vec3> exitance;     // W/m^2, >= 0
    std::optional<Vec3> transmittance = {};  // each in [0, 1)
    std::optional<std::string> group = {};   // light group
};

/// One instance, as written.
struct InstanceEntry {
    std::string name;
    std::filesystem::path archive;  // resolved against the manifest's folder
    std::string content;            // lower-case hex prefix of the file's SHA-256, or empty
    Affine3 to_world;               // invertible, condition number at most 1e9
    std::vector<std::pair<std::string, MaterialOverride>> materials;  // "*" first, then by name
};

/// Where pictures are taken from.
struct CameraEntry {
    Vec3 position{0, 0, 1}, target{0, 0, 0}, up{0, 1, 0};  // m, m, any length
    double vertical_fov = 45;          // degrees
    std::optional<double> exposure;    // stops
};

/// One of radiance, cie_overcast and image.
struct SkyEntry {
    std::optional<Vec3> radiance;      // W/(m^2 sr), from everywhere
    std::optional<Vec3> cie_overcast;  // W/(m^2 sr), of the zenith
    std::filesystem::path image;       // resolved against the manifest's folder
    double scale = 1;                  // of the image's radiance
    bool ground = false;               // nothing comes from below the horizon

    bool operator==(const SkyEntry&) const = default;
};

/// Light from infinitely far, from a disc.
struct SunEntry {
    Vec3 direction;                  // the way light travels, unit
    Vec3 irradiance;                 // W/m^2, on a plane that faces the sun
    double angular_diameter = 0.53;  // degrees

    bool operator==(const SunEntry&) const = default;
};

/// A lamp without extent.
struct LightEntry {
    enum class Type { Point, Spot, Ies };
    std::string name;
    Type type = Type::Point;
    Vec3 position;                  // m
    Vec3 direction{0, -1, 0};       // unit; of spot and ies
    std::optional<Vec3> intensity;  // W/sr; of ies where it is brightest, else as the file says
    double cone_degrees = 360;      // the whole opening angle of a spot
    std::filesystem::path file;     // of ies, resolved against the manifest's folder
    std::string group;              // light group, or empty

    bool operator==(const LightEntry&) const = default;
};

/// A set of surfaces for view factors, as written: "instance" or "instance/material".
struct GroupEntry {
    std::string name;
    std::vector<std::string> members;
};

/// A whole manifest; what is absent is not written there.
struct Manifest {
    std::filesystem::path path;
    std::vector<InstanceEntry> instances;  // in file order
    std::optional<CameraEntry> camera;
    std::optional<double> accuracy;        // relative error, in (0, 1]
    std::optional<SkyEntry> sky = {};
    std::optional<SunEntry> sun = {};
    std::vector<LightEntry> lights = {};     // in file order
    std::optional<Vec3> absorption = {};     // of the medium, 1/m
    std::vector<GroupEntry> groups = {};     // by name
};

/// Whether a radiometric quantity (exitance, radiance, irradiance, intensity) and what it adds up to survive in results,
/// which are single precision: 0, or 1e-30 to 1e30.
bool is_usable_power(double power);

/// Reads and checks a manifest: JSON, schema, names, transforms.
///
/// errors   BadInput, naming file and JSON pointer (or line and column for broken JSON): not there, not JSON, comments,
///          unknown key, wrong type, repeated or empty name, `/` in a name, singular or ill-conditioned transform, a
///          value out of range, a direction of no length, a light with a key that its type lacks or without one it needs
Result<Manifest> read_manifest(const std::filesystem::path& path);

/// The same from text at hand; `path` is where it stands or would stand.
Result<Manifest> parse_manifest(std::string_view text, const std::filesystem::path& path);

}  // namespace rro
