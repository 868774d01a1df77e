// Placing, moving and deleting in the text of a manifest: every byte outside the changed value stays.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "format/result.h"

namespace rro {

/// The text of a manifest that parse_manifest accepts, and the file it stands in. Edits give the new text, which need not
/// be valid in itself: it is to be parsed before it is used.
struct ManifestText {
    std::filesystem::path path;  // archive paths are relative to its folder
    std::string text;
};

/// Values are JSON text; what is empty is left out.
struct NewInstance {
    std::string name;
    std::string archive, transform, materials;
};

/// The parts of a transform as the command line gives them; what is absent stays.
struct TransformChange {
    std::vector<double> translate;  // empty, or 3
    std::vector<double> rotate;     // empty, or axis and degrees
    std::vector<double> scale;      // empty, 1 or 3
    std::vector<double> matrix;     // empty, or 16, and then nothing else

    bool empty() const { return translate.empty() && rotate.empty() && scale.empty() && matrix.empty(); }
};

/// The place of an instance among the instances.
/// errors   BadInput: no such instance (lists them and gives the nearest name)
Result<std::size_t> find_instance(const ManifestText& manifest, std::string_view name);

/// Appends an instance.
/// errors   BadInput: the name is taken
Result<std::string> with_instance(const ManifestText& manifest, const NewInstance& instance);
/// errors   BadInput: as find_instance
Result<std::string> without_instance(const ManifestText& manifest, std::string_view name);
/// Sets the whole transform (JSON text).
Result<std::string> with_transform(const ManifestText& manifest, std::string_view name, std::string_view transform);
/// Sets parts of a transform; a matrix replaces all parts.
/// errors   BadInput: as find_instance; parts for an instance that is placed by matrix
Result<std::string> with_transform_parts(const ManifestText& manifest, std::string_view name,
                                         const TransformChange& change);
/// Sets one field (JSON text) of one of an instance's materials.
Result<std::string> with_material_field(const ManifestText& manifest, std::string_view name, std::string_view material,
                                        std::string_view field, std::string_view value);

/// A new transform as JSON; empty where nothing is given.
std::string transform_json(const TransformChange& change);

/// The text as it reads in another folder: relative paths of archives, pictures and photometric files lead to the same
/// files as before.
std::string moved_to_folder(const ManifestText& manifest, const std::filesystem::path& folder);

/// Rewrites a manifest: reads it, edits, checks the result by the rules of parse_manifest, replaces the file atomically.
///
/// edit     gives the new text; asked once, nothing is written if it fails
/// errors   BadInput: the manifest cannot be used before or after the edit; Failed: cannot be written
Status edit_manifest_file(const std::filesystem::path& path,
                          const std::function<Result<std::string>(const ManifestText&)>& edit);

/// The three edits of the command line. `archive` is relative to the working folder; it is opened and verified before the
/// manifest is written, where its path is relative to the manifest.
Status place_in_file(const std::filesystem::path& manifest, const std::string& name,
                     const std::filesystem::path& archive, const TransformChange& transform);
Status move_in_file(const std::filesystem::path& manifest, const std::string& name, const TransformChange& transform);
Status delete_in_file(const std::filesystem::path& manifest, const std::string& name);

}  // namespace rro
