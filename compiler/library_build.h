// `rro-compile library`: the file that lists an object library (schemas/library.schema.json), and builds of many
// objects.
#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <vector>

#include "compiler/build_command.h"
#include "format/result.h"

namespace rro {

/// The command line of `library`.
struct LibraryRequest {
    std::filesystem::path library;          // the JSON file
    std::filesystem::path out;              // a folder; made if it is not there
    std::filesystem::path depfile, report;  // empty: none
};

/// One plan per object of the library, in its order, each with one target that is built if it has changed.
///
/// errors   BadInput, naming file and JSON pointer: not there, not JSON, comments, unknown key, wrong type, a value out of
///          range, a repeated or empty name, `/` in a name, an archive that would overwrite its mesh; Failed: the
///          folder cannot be made, or that of an output is missing
Result<std::vector<BuildPlan>> plan_library(const LibraryRequest& request);

/// Told what happens while many objects are built; from one thread at a time, either may be empty.
struct BuildListener {
    std::function<void(const BuildOutcome&)> done;  // in the order of the plans
    CompileProgress progress;                       // of one object its phases, of several how many are done
};

/// Builds all targets of all plans, several at a time and each on several threads. How many depends on the threads and
/// on the size of the meshes, so that memory does not grow with the library; the archives do not depend on it.
std::vector<BuildOutcome> build_all(std::span<const BuildPlan> plans, const BuildListener& listener = {});

/// An error of one object as the library's: options that cannot be used are bad input, namely the library's file; a
/// mesh that cannot be used is work that failed, as the other objects are still written.
Error library_error(const Error& error);

}  // namespace rro
