// What refinement is told of the light as it is.
#pragma once

#include "solver/transport/gather.h"

namespace rro {

/// Sets all of a guide but errors and shares.
template <int C>
void fill_guide(const Nodes& nodes, const LightField<C>& field, Guide& guide);

}  // namespace rro
