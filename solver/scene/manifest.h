// The scene manifest "rro-scene/1" (schemas/scene.schema.json) as values. Nothing here opens an archive.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "format/geometry.h"
#include "format/result.h"

namespace rro {

/// What a manifest says about one material of one instance; what is absent stays as the archive has it.
struct MaterialOverride {
    std::optional<Vec3> reflectance;  // each in [0, 1)
    std::optional<Vec3> exitance;     // W/m^2, >= 0
};

struct InstanceEntry {
    std::string name;
    std::filesystem::path archive;  // resolved against the manifest's folder
    std::string content;            // lower-case hex prefix of the file's SHA-256, or empty
    Affine3 to_world;               // invertible, condition number at most 1e9
    std::vector<std::pair<std::string, MaterialOverride>> materials;  // "*" first, then by name
};

struct CameraEntry {
    Vec3 position{0, 0, 1}, target{0, 0, 0}, up{0, 1, 0};
    double vertical_fov = 45;          // degrees
    std::optional<double> exposure;    // stops
};

/// A named group of surfaces, for view factors.
struct GroupEntry {
    std::string name;
    std::vector<std::string> members;  // "instance" or "instance/material", as written
};

struct Manifest {
    std::filesystem::path path;
    std::vector<InstanceEntry> instances;  // in file order
    std::optional<CameraEntry> camera;
    std::optional<double> accuracy;
    std::vector<GroupEntry> groups;  // by name
};

/// Whether an exitance and what it adds up to survive in results, which are single precision: 0, or 1e-30 to 1e30 W/m^2.
bool is_usable_exitance(double exitance);

/// Reads and checks a manifest: JSON, schema, names, transforms.
///
/// errors   BadInput, naming file and JSON pointer (or line and column for broken JSON): not there, not JSON, comments,
///          unknown key, wrong type, repeated or empty name, `/` in a name, singular or ill-conditioned transform, a
///          value out of range, a key whose effect this version does not support
Result<Manifest> read_manifest(const std::filesystem::path& path);

}  // namespace rro
