// `rro-compile build`: meshes in, archives out.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "compiler/compile_object.h"
#include "compiler/material_changes.h"
#include "compiler/mesh_import.h"
#include "format/result.h"

namespace rro {

/// The command line of `build`, in its own words.
struct BuildRequest {
    std::vector<std::filesystem::path> meshes;
    std::filesystem::path out;
    std::uint32_t grid = 12;
    std::string map = "octahedral";  // or latlong
    std::string two_sided = "auto";  // yes, no
    bool fix_winding = false;
    std::string unit = "m";   // cm, mm, in
    std::string up = "y";     // z
    std::string reflectance;  // "r,g,b", or empty
    std::string cluster_weights;  // "proximity,orientation,reflectivity,aspect,size", or empty for the defaults
    std::string tables = "default";
    std::filesystem::path depfile, report;  // empty: none
    bool if_changed = false;
    MaterialChanges materials;    // of a library's object
    std::string materials_place;  // where they stand, for messages
};

/// One mesh and where its archive goes.
struct BuildTarget {
    std::filesystem::path mesh, archive;
};

/// A request whose values have been checked.
struct BuildPlan {
    std::vector<BuildTarget> targets;
    ImportOptions import;
    TwoSided two_sided = TwoSided::Auto;
    bool fix_winding = false, if_changed = false;
    CompileOptions compile;
    MaterialChanges materials;
    std::string materials_place;
    std::string options;  // canonical text of all that decides an archive's bytes, table version included
};

/// Checks a request and makes the folder of its archives.
///
/// errors   Usage: a value out of range or unknown, several meshes for one FILE, two equal stems, an archive that would
///          overwrite a mesh; Failed: DIR cannot be made, or the folder of an output is missing
Result<BuildPlan> plan_build(const BuildRequest& request);

/// What became of one mesh.
struct BuildOutcome {
    BuildTarget target;
    std::optional<Error> error;                 // set: nothing was written, and only the fields above it hold
    bool unchanged = false;                     // --if-changed found the archive made from the same source and options
    std::vector<std::filesystem::path> inputs;  // every file read, the mesh first
    ObjectMeta meta;
    // Where it is not unchanged:
    ImportReport import;
    std::vector<std::string> warnings;  // the import's, and what was dropped
    std::size_t triangles = 0, faces = 0, patches = 0, clusters = 0, volumes = 0;
    // In any case:
    std::uint64_t bytes = 0;
    double seconds = 0;
};

/// Imports, compiles and writes one archive; errors are in the outcome, and nothing is thrown. With if_changed, an
/// archive that is current stays: where the record beside it names the files it was made from, they are hashed, else
/// imported.
BuildOutcome build_target(const BuildTarget& target, const BuildPlan& plan, const CompileProgress& progress = {});

/// "desk.rro: 12 triangles, ..., 0.35 s": one line without its end.
std::string summary_line(const BuildOutcome& outcome);

/// A Makefile rule per archive that is there: "archive: inputs". Each ends with `also`, where that is not empty.
std::string depfile_text(const std::vector<BuildOutcome>& outcomes, const std::filesystem::path& also = {});

/// The report of all meshes, as JSON text.
std::string build_report(const std::vector<BuildOutcome>& outcomes);

}  // namespace rro
