// Closed shells whose fronts look inwards: rooms. Whatever hides in them, nothing of their fronts is seen from outside the
// object; images of an object do not know it, as rays that meet an edge between two walls may hit either.
#pragma once

#include <vector>

#include "compiler/effective_area.h"
#include "format/object_data.h"

namespace rro {

/// Per patch whether all of its faces belong to closed one-sided components (by shared places of corners) of negative
/// volume. All false unless the whole object is closed (ObjectData::meta).
std::vector<bool> inward_patches(const ObjectData& object);

/// Sets the tables' visibility of such patches to 0, and the whole-object areas of clusters of nothing else.
void hide_inward_patches(const ObjectData& object, EffectiveAreas& areas);

}  // namespace rro
