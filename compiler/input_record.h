// Which files an archive was made from, noted beside it, so that the next build need not import a mesh to know.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace rro {

/// What an import looked for: files that it read, the mesh first, and files that were not there.
struct InputFiles {
    std::vector<std::filesystem::path> read, absent;
};

/// The files of an import and the hash it would give them now (ImportedMesh::sha256).
struct RecordedInputs {
    std::vector<std::filesystem::path> read;
    std::string sha256;
};

/// The record of an archive: ".NAME.rro.inputs" beside it. Paths in it are relative to the mesh's folder, so that it
/// holds wherever both are moved.
std::filesystem::path input_record_path(const std::filesystem::path& archive);

/// Notes the files beside the archive. The record is a help, never needed: where it cannot be written there is none,
/// and the next build imports the mesh.
void write_input_record(const std::filesystem::path& archive, const InputFiles& inputs);

/// Reads the record and every file it names. None where there is no record, or an import might now find other files:
/// one of them is gone, or one that was absent is there. The record tells no hash: whoever asks compares with that in
/// the archive, so that a record that is older than its archive, or was left by another, deceives nobody.
std::optional<RecordedInputs> read_recorded_inputs(const std::filesystem::path& archive,
                                                   const std::filesystem::path& mesh);

}  // namespace rro
