#include "solver/transport/node_map.h"

#include <map>
#include <utility>

namespace rro {
namespace {

// Children have larger numbers than their parents, so the last group is known first.
void map_groups(const Nodes& from, const Nodes& to, std::vector<std::uint32_t>& map) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> of_children;
    for (std::uint32_t g = 0; g < to.group_count(); ++g) of_children[{to[g].first_child, to[g].second_child}] = g;
    for (std::uint32_t g = from.group_count(); g-- > 0;) {
        const auto found = of_children.find({map[from[g].first_child], map[from[g].second_child]});
        if (found != of_children.end()) map[g] = found->second;
    }
}

}  // namespace

std::vector<std::uint32_t> carry_nodes(const Nodes& from, const UsedElements& used, const SceneChange& change, Nodes& to) {
    std::vector<std::uint32_t> map(from.size(), kNoNode);
    std::vector<std::uint32_t> stays(from.scene().instances.size(), kNoNode);
    for (std::uint32_t i = 0; i < change.before.size(); ++i) {
        const std::uint32_t old = change.before[i];
        if (old == SceneChange::kPlaced) continue;
        const InstanceNodes &a = from.instance(old), &b = to.instance(i);
        const std::size_t count = from.scene().instances[old].data().faces.size() + a.first_face - a.first_cluster;
        for (std::uint32_t k = 0; k < count; ++k) map[a.first_cluster + k] = b.first_cluster + k;
        if (!change.moved[i]) stays[old] = i;
    }
    map_groups(from, to, map);

    // An element in use needs those that it lies in.
    UsedElements divided(from.size(), 0), needed = used;
    for (auto n = static_cast<std::uint32_t>(from.size()); n-- > 0;)
        if (needed[n] && from[n].planar() && from[n].depth > 0) divided[from[n].parent] = needed[from[n].parent] = 1;
    for (std::uint32_t n = 0; n < from.size(); ++n) {
        if (!divided[n] || stays[from[n].instance] == kNoNode) continue;
        to.subdivide(map[n]);
        for (std::uint32_t k = 0; k < from[n].child_count; ++k) map[from[n].first_child + k] = to[map[n]].first_child + k;
    }
    return map;
}

}  // namespace rro
