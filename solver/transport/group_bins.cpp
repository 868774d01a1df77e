#include "solver/transport/group_bins.h"

#include <algorithm>
#include <numbers>

#include "format/parallel.h"
#include "solver/transport/channels.h"
#include "solver/transport/flat_light.h"

namespace rro {

namespace {

constexpr std::uint32_t kGrid = 12;   // the archives' default
constexpr std::size_t kGrain = 16;    // groups per parallel chunk

}  // namespace

template <int C>
GroupBins<C>::GroupBins(const Nodes& nodes, const EndAreas& areas)
    : nodes_(nodes), areas_(areas), grid_(GridMap::Octahedral, kGrid), used_(nodes.group_count(), 0) {
    std::vector<std::uint32_t> depth(nodes.group_count(), 0);
    for (std::uint32_t g = 0; g < nodes.group_count(); ++g) {
        if (nodes[g].parent != kNoNode) depth[g] = depth[nodes[g].parent] + 1;
        levels_.resize(std::max<std::size_t>(levels_.size(), depth[g] + 1));
        levels_[depth[g]].push_back(g);
    }
}

template <int C>
void GroupBins<C>::reset() {
    std::fill(used_.begin(), used_.end(), std::uint8_t{0});
}

template <int C>
void GroupBins<C>::use(std::uint32_t group) {
    used_[group] = 1;
}

template <int C>
void GroupBins<C>::allocate(DirectionBins<C>& bins) {
    for (std::uint32_t g = 0; g < used_.size(); ++g) {
        if (nodes_[g].parent != kNoNode) used_[g] |= used_[nodes_[g].parent];
        if (!used_[g]) continue;
        for (const std::uint32_t child : {nodes_[g].first_child, nodes_[g].second_child})
            if (!nodes_[child].group() && nodes_[child].kind == NodeKind::Bins) bins.use(child, EndMode::Outside);
    }
    const bool any = std::find(used_.begin(), used_.end(), 1) != used_.end();
    intensity_.assign(any ? used_.size() * C * grid_.size() : 0, 0);
    incoming_.assign(any ? used_.size() * kIncoming * grid_.size() : 0, 0);
}

template <int C>
void GroupBins<C>::clear_incoming() {
    std::fill(incoming_.begin(), incoming_.end(), 0.0f);
}

template <int C>
std::array<float, C> GroupBins<C>::root_intensity(const DirectionBins<C>& bins, const std::vector<float>& radiosity,
                                                  std::uint32_t root, const Vec3& w) const {
    const Node& node = nodes_[root];
    if (node.kind == NodeKind::Bins) return bins.intensity(root, EndMode::Outside, w);
    std::array<float, C> out{};
    const double projected = dot(node.area_vector, w);
    if (!(projected > 0)) return out;
    const double factor = projected * areas_.visible_share(node, w, EndMode::Outside) * std::numbers::inv_pi;
    for (std::size_t c = 0; c < C; ++c) out[c] = static_cast<float>(factor) * radiosity[root * C + c];
    return out;
}

template <int C>
void GroupBins<C>::pull(const DirectionBins<C>& bins, const std::vector<float>& radiosity) {
    if (intensity_.empty()) return;
    const std::size_t d = grid_.size();
    parallel_for(used_.size(), kGrain, [&](std::size_t g) {
        if (!used_[g]) return;
        float* out = &intensity_[g * C * d];
        std::fill(out, out + C * d, 0.0f);
        const Node& node = nodes_[static_cast<std::uint32_t>(g)];
        for (const std::uint32_t child : {node.first_child, node.second_child}) {
            if (nodes_[child].group()) continue;
            for (std::uint32_t k = 0; k < d; ++k) {
                const auto value = root_intensity(bins, radiosity, child, grid_.direction(k));
                for (std::size_t c = 0; c < C; ++c) out[c * d + k] += value[c];
            }
        }
    });
    for (auto g = static_cast<std::uint32_t>(used_.size()); g-- > 1;) {
        const std::uint32_t parent = nodes_[g].parent;
        if (!used_[parent]) continue;
        const float* from = &intensity_[g * C * d];
        float* to = &intensity_[parent * C * d];
        for (std::size_t k = 0; k < C * d; ++k) to[k] += from[k];
    }
}

template <int C>
std::array<float, C> GroupBins<C>::intensity(std::uint32_t group, const Vec3& w) const {
    const DirectionTaps taps = grid_.taps(w);
    const float* table = &intensity_[group * C * grid_.size()];
    std::array<float, C> out{};
    for (std::size_t c = 0; c < C; ++c)
        for (std::size_t t = 0; t < 4; ++t) out[c] += taps.weight[t] * table[c * grid_.size() + taps.node[t]];
    return out;
}

template <int C>
void GroupBins<C>::splat(std::uint32_t group, const Vec3& u, double inverse_distance, const std::array<float, C>& h) {
    const DirectionTaps taps = grid_.taps(u);
    const std::size_t d = grid_.size();
    splat_into(&incoming_[group * kIncoming * d], d, taps, u, inverse_distance, h);
}

template <int C>
void GroupBins<C>::push_to(std::uint32_t group, std::uint32_t child, DirectionBins<C>& bins,
                           std::vector<float>& vectors) {
    const std::size_t d = grid_.size();
    const float* plane = &incoming_[group * kIncoming * d];
    const Node& node = nodes_[child];
    const Vec3 offset = node.centre - nodes_[group].centre;
    for (std::size_t k = 0; k < d; ++k) {
        std::array<float, C> h;
        for (std::size_t c = 0; c < C; ++c) h[c] = plane[c * d + k];
        const float strength = mean_of(h);
        if (!(strength > 0)) continue;
        const Vec3 sum{plane[C * d + k], plane[(C + 1) * d + k], plane[(C + 2) * d + k]};
        const Arrival light = translated(sum, strength, plane[(C + 3) * d + k], offset);
        for (float& x : h) x *= light.gain;
        if (node.group()) {
            splat(child, light.direction, light.inverse_distance, h);
        } else if (node.kind == NodeKind::Bins) {
            bins.splat(child, EndMode::Outside, light.direction, light.inverse_distance, h);
        } else if (const double cosine = dot(node.normal(), light.direction); cosine > 0) {
            const Vec3 along = arrival(node, light.direction);
            const double share = areas_.visible_share(node, light.direction, EndMode::Outside) * cosine /
                                 dot(node.normal(), along);
            float* v = &vectors[node.slot * std::size_t(6 * C)];
            for (std::size_t c = 0; c < C; ++c)
                for (int axis = 0; axis < 3; ++axis)
                    v[3 * c + static_cast<std::size_t>(axis)] += static_cast<float>(share * along[axis]) * h[c];
        }
    }
}

template <int C>
void GroupBins<C>::push(DirectionBins<C>& bins, std::vector<float>& vectors) {
    if (incoming_.empty()) return;
    for (const std::vector<std::uint32_t>& level : levels_)  // children of one level have one parent each
        parallel_for(level.size(), kGrain, [&](std::size_t k) {
            const std::uint32_t g = level[k];
            if (!used_[g]) return;
            push_to(g, nodes_[g].first_child, bins, vectors);
            push_to(g, nodes_[g].second_child, bins, vectors);
        });
}

template <int C>
std::uint64_t GroupBins<C>::bytes() const {
    return (intensity_.size() + incoming_.size()) * sizeof(float);
}

template class GroupBins<1>;
template class GroupBins<3>;

}  // namespace rro
