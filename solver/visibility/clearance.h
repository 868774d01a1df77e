// Proofs that nothing of an object is in a shaft's way: they cost no ray and are exact.
#pragma once

#include "solver/scene/scene.h"
#include "solver/visibility/shaft.h"

namespace rro {

/// Does no line of the shaft meet the instance? False where that is not found out soon. By the boxes of the object's
/// clusters, which hold all its triangles; what lies behind an end that shines to one side is not in the way.
bool certainly_clear(const Shaft& shaft, const Instance& instance);

}  // namespace rro
