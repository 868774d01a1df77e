// An imported mesh as bytes, from the process that reads it to the one that compiles it (import_process). Both run the
// same program on the same machine: numbers as they lie in memory, no version.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "compiler/mesh_import.h"
#include "format/result.h"

namespace rro {

/// A mesh, or why there is none, as bytes.
std::string encode_import(const Result<ImportedMesh>& imported);

/// None where the bytes are not all that encode_import has written.
std::optional<Result<ImportedMesh>> decode_import(std::string_view bytes);

}  // namespace rro
