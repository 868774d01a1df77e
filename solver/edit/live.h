// rro-solve live: a scene kept in memory that answers edits, one JSON object per line (schemas/live.schema.json).
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <memory>
#include <string>
#include <string_view>

#include "format/result.h"
#include "solver/solve_scene.h"

namespace rro {

/// What `live` is asked for.
struct LiveOptions {
    SolveOptions solve;
    std::uint64_t memory = std::uint64_t{8} << 30;          // most that a scene and its solve may need, bytes
    std::size_t history_bytes = std::size_t{256} << 20;     // manifests and solutions kept to undo and redo
};

/// A solved scene and the edits since it was opened. Archives are loaded once and kept; an edit is solved from the scene
/// before it (SceneSolver). Not thread-safe.
class LiveSession {
  public:
    /// Reads and solves the scene.
    /// errors   as read_manifest, open_scene and solve_scene
    static Result<LiveSession> open(const std::filesystem::path& manifest, const LiveOptions& options);
    LiveSession(LiveSession&&) noexcept;
    ~LiveSession();

    /// The line that says so: {"event":"ready",...}.
    std::string ready() const;

    /// One reply to one request, both without a line break. An error changes nothing and is a reply like others.
    std::string answer(std::string_view request);

    /// Has `quit` been answered?
    bool ended() const;

    /// The scene as it stands, and its solution; none after edits with "solve": false.
    const Scene& scene() const;
    const Solution* solution() const;

  private:
    struct Parts;
    explicit LiveSession(std::unique_ptr<Parts> parts);
    std::unique_ptr<Parts> parts_;
};

/// Answers line by line until quit or the end of input; empty lines are passed over. A line longer than 64 MiB is refused.
void serve(LiveSession& session, std::istream& in, std::ostream& out);

}  // namespace rro
