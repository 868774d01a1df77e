// For programs of your own: a scene that is edited, solved and read, without the command line. samples/programs/edit_scene.cpp shows it.
//
//   auto session = SceneSession::open("room.json");
//   session->move("chair", {rotation, {2, 0, 1}});
//   session->solve();
//   session->radiosity("chair", 0);
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
    /// Reads a manifest and opens its archives.
    /// errors   as read_manifest and open_scene
    static Result<SceneSession> open(const std::filesystem::path& manifest, SolveOptions options = {});

    /// errors of edits   BadInput: no instance of this name, or one already, an empty name or one with `/`, a singular transform,
    ///                   a value out of range. An archive and its materials are looked at by solve().
    Status place(std::string name, const std::filesystem::path& archive, const Affine3& to_world);
    Status move(std::string_view name, const Affine3& to_world);
    Status remove(std::string_view name);
    /// material  a name, or "*" for all that have none of their own
    Status set_reflectance(std::string_view name, std::string material, const Vec3& reflectance);
    Status set_exitance(std::string_view name, std::string material, const Vec3& exitance);  // W/m^2

    /// Dims all surfaces and lamps of a light group to `scale` times what the manifest says.
    /// errors   BadInput: a negative or infinite scale. Groups that the scene lacks are dark anyway.
    Status dim(std::string light_group, double scale);

    /// Solves the scene as it stands. After an error it can be edited further; the solution before stays.
    /// errors   as open_scene and solve_scene
    Result<const Solution*> solve(const Progress& progress = {});

    /// As of the last solve().
    const Scene& scene() const { return *scene_; }
    const Solution& solution() const { return *solution_; }
    const LinkChange& change() const { return solver_.change(); }

    /// Mean radiosity of a source triangle's front as of the last solve(), W/m^2.
    /// errors   BadInput: no such instance, or no such triangle in its mesh
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
