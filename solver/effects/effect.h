// The effect plan: which effects a scene calls for, and why, decided before any work.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "format/result.h"
#include "solver/scene/built_in.h"
#include "solver/scene/scene.h"
#include "solver/solution.h"

namespace rro {

/// What the solver's passes ask of the plan.
struct Plan {
    std::vector<EffectPlan> effects;    // in the order of kEffects (solver/scene/built_in.h), off ones included
    std::vector<std::string> warnings;  // overrides that change the result
    int channels = 3;                   // 1 where everything is grey

    /// Is it called for, and part of this build?
    bool on(std::string_view name) const { return is_built(name) && called_for(name); }
    EffectPlan& operator[](std::string_view name);

  private:
    bool called_for(std::string_view name) const;
};

/// Effects switched by hand: --with, --without.
struct EffectOverrides {
    std::vector<std::string> with, without;
};

/// errors   Usage: an effect that does not exist (lists those that do), or one both with and without
///          BadInput, naming the manifest: as all_built
Result<Plan> plan_effects(const Scene& scene, const EffectOverrides& overrides);

/// errors   BadInput: an effect is on that is not among `built`, those of a build
Status all_built(const Plan& plan, std::span<const std::string_view> built, const std::string& manifest);

/// Takes out of the scene what is switched off by hand: emitters (no surface emits), textures (materials have their
/// mean), colour (every channel is the mean of the three), sky, sun, lights, transmission, medium, light groups (one for
/// all). The other effects are left to the solver's passes.
void leave_out(const EffectOverrides& overrides, Scene& scene);

}  // namespace rro
