// Which effects a scene calls for, and why: one rule per effect.
#pragma once

#include <vector>

#include "solver/scene/scene.h"
#include "solver/solution.h"

namespace rro {

/// One line per effect, in the order of kEffects, with a reason that names an instance, a material or a light where there is one.
std::vector<EffectPlan> called_for(const Scene& scene);

}  // namespace rro
