// The solve pipeline, in order: plan the effects, solve by the method asked for, account for time.
//
// Paper = M. Ouhyoung, Y.-Y. Chuang, R.-H. Liang, "Reusable Radiosity Object", 1997.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "format/result.h"
#include "solver/effects/effect.h"
#include "solver/progress.h"
#include "solver/scene/scene.h"
#include "solver/solution.h"
#include "solver/transport/reusable_solver.h"
#include "solver/transport/transport.h"

namespace rro {

/// How a scene is solved: the reusable method (solver/transport), and two to compare with (solver/study).
enum class Method { Reusable, Hierarchical, Reference };

/// How the reusable method carries light: by direction, or alike in all directions as the paper does.
enum class Transport { Directional, Plain };

/// What a solve is asked for. The defaults are those of `rro-solve run`.
struct SolveOptions {
    Method method = Method::Reusable;
    std::optional<double> accuracy;  // relative error, in (0, 1]; beats the manifest's, which beats 0.02
    VisibilityMethod visibility = VisibilityMethod::Auto;
    std::uint32_t samples = 0;  // per face, for the reference; 0: as many as the accuracy needs
    std::uint64_t seed = 1;
    EffectOverrides overrides = {};
    std::optional<Transport> transport = {};  // for the reusable method only; directional where not given
    std::uint64_t memory = std::uint64_t{8} << 30;  // bytes that the hierarchical method may use for links and elements
    double far_factor = TransportOptions{}.far_factor;  // the five-times rule, of the reusable method
};

/// The values of --method, --transport and --visibility.
/// errors   Usage: no such name (lists those there are)
Result<Method> parse_method(std::string_view name);
/// The same.
Result<Transport> parse_transport(std::string_view name);
/// The same.
Result<VisibilityMethod> parse_visibility(std::string_view name);

/// Plans the effects and solves. What `overrides` take out of the radiometry has left the scene before (leave_out).
///
/// scene     open with the sections that the method needs: kGeometry; for the reusable one kTables and
///           sections_of(options.visibility) besides (open_scene has refused archives that lack them)
/// progress  may be empty
/// returns   radiosity and irradiance of every face in W/m^2, instances as in the scene; effects, warnings, and the seconds of
///           plan and solve (those of load and output are the caller's; total is plan and solve). `converged` is false where
///           the accuracy was not reached (not of the reference where samples are asked for, nor of the hierarchical method: they
///           are done when all is done); the solution is there all the same
/// errors    those of plan_effects. Usage: options or effects that the method does not know. Failed: the hierarchical method
///           needs more memory than options.memory
/// source    the reusable method: Paper; the others: their headers in solver/study
Result<Solution> solve_scene(const Scene& scene, const SolveOptions& options, const Progress& progress = {});

/// The same for a scene that changes: what an edit leaves as it is stays solved (the reusable method, directional). Not
/// thread-safe.
class SceneSolver {
  public:
    /// As solve_scene, from what the last call left. Keeps the scene until the next one.
    Result<Solution> solve(std::shared_ptr<const Scene> scene, const SolveOptions& options, const Progress& progress = {});

    /// What the last solve did to the links.
    const LinkChange& change() const { return change_; }
    /// Did it keep nothing of the solve before?
    bool from_scratch() const { return from_scratch_; }

  private:
    ReusableSolver reusable_;
    LinkChange change_;
    std::uint64_t links_ = 0;
    bool from_scratch_ = true;
};

/// The accuracy to solve for: the one asked for, or the manifest's, or 0.02.
double accuracy_of(const Scene& scene, std::optional<double> asked);

/// Did the solve do what it was asked? The accuracy was met, or the samples asked for were taken.
bool work_done(const Solution& solution, const SolveOptions& options);

/// Bytes that an open scene holds and a solve of it will need, roughly: to refuse what cannot fit before any work.
std::uint64_t estimated_memory(const Scene& scene);

}  // namespace rro
