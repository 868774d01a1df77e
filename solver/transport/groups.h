// Groups: a binary tree above the instances of a scene, so that whole neighbourhoods exchange light through one link and
// the work grows with the number of instances, not with that of their pairs.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "solver/scene/scene.h"

namespace rro {

/// Two groups or instances taken together.
struct Group {
    std::array<std::uint32_t, 2> child;  // below groups.size(): a group; else groups.size() + instance
    std::uint32_t first = 0, count = 0;  // its members lie in a row

    bool operator==(const Group&) const = default;
};

/// All groups of a scene.
struct GroupTree {
    std::vector<Group> groups;           // preorder, the root first; empty where instances are few
    std::vector<std::uint32_t> members;  // instances in the order of the leaves; empty without groups

    bool is_group(std::uint32_t child) const { return child < groups.size(); }
    std::uint32_t instance(std::uint32_t child) const { return child - static_cast<std::uint32_t>(groups.size()); }
    bool operator==(const GroupTree&) const = default;
};

/// Halves the instances by their centres along the widest axis, down to single instances. Instances about as large as
/// all of a group first part from the others: a room, or a table under what stands on it, would stretch the boxes of
/// all groups that it is in. Lamps are kept apart from all else: one visibility serves all members of a group, and the
/// light of a lamp among furniture would get that of the furniture. The tree depends on boxes and names, not on the order of the manifest.
GroupTree group_instances(const Scene& scene);

}  // namespace rro
