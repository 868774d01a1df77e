// The effect plan: which effects a scene calls for, and why, decided before any work.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "format/result.h"
#include "solver/scene/scene.h"
#include "solver/solution.h"

namespace rro {

/// What the solver's passes ask of the plan.
struct Plan {
    std::vector<EffectPlan> effects;    // in the contract's order, off ones included
    std::vector<std::string> warnings;  // overrides that change the result
    int channels = 3;                   // 1 where everything is grey

    bool on(std::string_view name) const;
    EffectPlan& operator[](std::string_view name);
};

/// Effects switched by hand: --with, --without.
struct EffectOverrides {
    std::vector<std::string> with, without;
};

/// errors   Usage: an effect that does not exist (lists those that do), or one both with and without
Result<Plan> plan_effects(const Scene& scene, const EffectOverrides& overrides);

/// Takes out of the scene what is switched off by hand: emitters (no surface emits), textures (materials have their
/// mean), colour (every channel is the mean of the three), sky, sun, lights, transmission, medium, light groups (one for
/// all). The other effects are left to the solver's passes.
void leave_out(const EffectOverrides& overrides, Scene& scene);

}  // namespace rro
