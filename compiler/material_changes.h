// What a library says about an object's materials, over what its mesh says.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "compiler/mesh.h"
#include "format/result.h"

namespace rro {

/// What is absent stays as the import found it.
struct MaterialChange {
    std::optional<Vec3> reflectance;  // each in [0, 1); replaces a texture
    std::optional<Vec3> exitance;     // W/m^2
};

/// By the name of the material; "*" first, which is all of them, then by name.
using MaterialChanges = std::vector<std::pair<std::string, MaterialChange>>;

/// Applies the changes in their order, field by field.
///
/// place    of the changes, for messages: "library.json: /objects/3/materials"
/// errors   Usage: a name that no material has (names those there are)
Status change_materials(Mesh& mesh, const MaterialChanges& changes, const std::string& place);

/// Text that two lists share only if they are equal: `{"*":{"reflectance":[0.5,0.5,0.5]}}`, for an archive's options.
std::string canonical_text(const MaterialChanges& changes);

}  // namespace rro
