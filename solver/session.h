// For programs of your own: a scene that is edited, solved and read, without the command line. samples/programs/edit_scene.cpp shows it.
//
//   auto session = SceneSession::open("room.json", {.accuracy = 0.1});    // a Result: test it
//   session->solve();
//   session->move("chair", {rotation, {2, 0, 1}});                         // so are all that follow
//   session->solve();                                                      // costs what the move touches
//   session->radiosity("chair", 0);
//
// Lengths are metres, radiosity and exitance W/m^2, colours linear (r, g, b).
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "solver/solve_scene.h"

namespace rro {

/// A scene and its light. Edits take effect at the next solve(), which costs what they touch. Not thread-safe.
class SceneSession {
  public:
    /// Reads a manifest and opens its archives, each once. Nothing is solved yet.
    ///
    /// options  of every solve(); the accuracy beats the manifest's, which beats 0.02. Edits are cheap with the reusable method
    ///          and directional transport only (the defaults)
    /// errors   BadInput: as read_manifest and open_scene; they name the manifest and the place in it
    static Result<SceneSession> open(const std::filesystem::path& manifest, SolveOptions options = {});

    // Edits. What they refuse changes nothing.

    /// Adds an instance; it comes last.
    ///
    /// archive   a file, relative to the working folder; opened by solve(), once for all its instances
    /// to_world  metres of the archive's frame -> metres of the world; any invertible affine map
    /// errors    BadInput: an instance of this name is there, an empty name or one with `/`, a transform that manifests refuse
    ///           (scene/transform.h)
    Status place(std::string name, const std::filesystem::path& archive, const Affine3& to_world);
    /// Puts an instance elsewhere: replaces its whole transform.
    /// errors   BadInput: no instance of this name, a transform that manifests refuse (scene/transform.h)
    Status move(std::string_view name, const Affine3& to_world);
    /// Takes an instance out.
    /// errors   BadInput: no instance of this name
    Status remove(std::string_view name);
    /// Sets one field of a material of one instance; its other fields stay.
    ///
    /// material  a name of the archive (looked up by solve()), or "*" for all that have none of their own
    /// reflectance  each channel in [0, 1);  exitance  W/m^2, not negative
    /// errors    BadInput: no instance of this name, a value out of range
    Status set_reflectance(std::string_view name, std::string material, const Vec3& reflectance);
    /// The same.
    Status set_exitance(std::string_view name, std::string material, const Vec3& exitance);

    /// Dims all surfaces and lamps of a light group to `scale` times what the manifest says.
    /// errors   BadInput: a negative or infinite scale. Groups that the scene lacks are dark anyway.
    Status dim(std::string light_group, double scale);

    /// Solves the scene as it stands, from what the last solve left.
    ///
    /// returns  the solution, as solution() below
    /// errors   as open_scene and solve_scene. Afterwards the scene can be edited further; the solution before stays
    Result<const Solution*> solve(const Progress& progress = {});

    /// As of the last solve(); before the first one the manifest's.
    const Scene& scene() const { return *scene_; }
    /// As of the last solve(); not to be called before the first one.
    const Solution& solution() const { return *solution_; }
    /// What the last solve() did to the links.
    const LinkChange& change() const { return solver_.change(); }

    /// Mean radiosity of the front of a source triangle (numbered as in the mesh's file, from 0) as of the last solve(), W/m^2.
    /// errors   BadInput: nothing is solved yet, no such instance, no such triangle in its mesh or one that the compiler dropped
    Result<Vec3> radiosity(std::string_view name, std::uint32_t triangle) const;

  private:
    SceneSession(Manifest manifest, SolveOptions options, Scene scene);
    Result<InstanceEntry*> entry(std::string_view name);
    Status set_material(std::string_view name, std::string material, const MaterialOverride& fields);

    Manifest manifest_;
    SolveOptions options_;
    std::map<std::string, double> light_scales_;  // by group
    SectionSet wanted_;
    std::vector<std::shared_ptr<const Object>> opened_;  // every archive met so far
    std::shared_ptr<const Scene> scene_;
    std::unique_ptr<const Solution> solution_;
    SceneSolver solver_;
};

}  // namespace rro
