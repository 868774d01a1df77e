// Which effects a scene calls for, and why: one rule per effect.
#pragma once

#include <array>
#include <vector>

#include "solver/scene/scene.h"
#include "solver/solution.h"

namespace rro {

/// The names of the effects, in the contract's order.
inline constexpr std::array kEffects{"emitters", "interreflection", "occlusion",    "self",     "colour", "sky",
                                     "sun",      "lights",          "transmission", "textures", "groups", "medium"};

/// One line per effect, in that order, with a reason that names an instance, a material or a light where there is one.
std::vector<EffectPlan> called_for(const Scene& scene);

}  // namespace rro
