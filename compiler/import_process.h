// Import in a process of its own: a library that crashes, hangs or eats memory over a hostile file takes no more than
// that process down.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "compiler/mesh_import.h"
#include "format/result.h"

namespace rro {

/// What the process may take. Honest meshes stay far below: a million triangles take 0.25 GB and a few seconds, the 11
/// million that ImportLimits allow ten times as much. These limits are for what escapes those.
struct ContainmentLimits {
    std::uint64_t memory_bytes = std::uint64_t{1} << 32;  // beyond what the caller has; not under sanitizers
    std::uint32_t cpu_seconds = 300;
    std::uint32_t wall_seconds = 3600;  // for one that waits for ever and takes no time of the processor
};

/// import_mesh and decide_sides in a child process. May be called from several threads at once.
///
/// errors   those of import_mesh; BadInput naming the file: the child crashed, or went beyond a limit;
///          Failed: no process can be started
Result<ImportedMesh> import_mesh_contained(const std::filesystem::path& path, const ImportOptions& options,
                                           TwoSided two_sided, bool fix_winding, const ContainmentLimits& limits = {});

/// What `work` returns, called in a child process with those limits. The child has this thread alone: work may not wait
/// for others. It ignores Ctrl-C, and dies with this process.
///
/// where    for errors
/// errors   as above; Internal: work threw another exception than bad_alloc
Result<std::string> run_contained(const std::string& where, const std::function<std::string()>& work,
                                  const ContainmentLimits& limits);

}  // namespace rro
