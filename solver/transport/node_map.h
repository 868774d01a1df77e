// Where the nodes of a scene are after an edit.
#pragma once

#include <cstdint>
#include <vector>

#include "solver/transport/nodes.h"
#include "solver/transport/scene_change.h"

namespace rro {

/// The elements in use, and those that they lie in.
using UsedElements = std::vector<std::uint8_t>;  // [nodes]

/// Numbers of old nodes among the new ones, kNoNode: gone. Faces of instances that stay where they are get their elements
/// again, as far as they are in use. Groups are the same where they have the same children.
std::vector<std::uint32_t> carry_nodes(const Nodes& from, const UsedElements& used, const SceneChange& change, Nodes& to);

}  // namespace rro
