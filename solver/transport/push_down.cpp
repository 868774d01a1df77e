#include "solver/transport/push_down.h"

#include <algorithm>

namespace rro {

namespace {

constexpr float kClose = 0.5f;     // own links below that are no sign of something close; a row beyond 1 is noise
constexpr float kMostRow = 1.15f;  // of a face: rows that are a little above 1 are as many as those a little below
constexpr float kMostElementRow = 1.05f;

/// How much of what a surface inherits something must hide, because its own links bring so much.
double hidden_share(float own, float inherited) {
    return own > kClose && inherited > 0 && own + inherited > kMostRow ? double(std::min(inherited, own + inherited - 1)) : 0.0;
}

}  // namespace

template <int C>
void PushDown<C>::grow() {
    vectors_.resize(std::size_t(nodes_.flat_count()) * 6 * C, 0);
    inherited_.resize(nodes_.size() * C, 0);
}

template <int C>
void PushDown<C>::push(std::uint32_t instance, Push what, const Passage<C>& light, std::vector<float>& irradiance) {
    const InstanceNodes& in = nodes_.instance(instance);
    push_clusters(in, light, irradiance);
    push_faces(instance, what, light, irradiance);
    push_elements(in, what, light, irradiance);
}

template <int C>
void PushDown<C>::push_clusters(const InstanceNodes& in, const Passage<C>& light, std::vector<float>& irradiance) {
    constexpr std::size_t kFlat = 6 * C;
    for (std::uint32_t id = in.first_cluster; id < in.first_face; ++id) {
        const Node& n = nodes_[id];
        std::copy_n(light.received(id), C, &irradiance[id * C]);
        if (n.kind == NodeKind::Flat) std::copy_n(light.vectors(n), kFlat, &vectors_[n.slot * kFlat]);
        if (n.parent == kNoNode) continue;
        for (std::size_t c = 0; c < C; ++c) irradiance[id * C + c] += irradiance[n.parent * C + c];
        if (n.kind != NodeKind::Flat || nodes_[n.parent].kind != NodeKind::Flat) continue;
        add_slope(irradiance, id);
        for (std::size_t c = 0; c < kFlat; ++c) vectors_[n.slot * kFlat + c] += vectors_[nodes_[n.parent].slot * kFlat + c];
    }
}

// A flat node's vector meets each face's own cosine, its gradient the place of the face.
template <int C>
void PushDown<C>::push_faces(std::uint32_t instance, Push what, const Passage<C>& light, std::vector<float>& irradiance) {
    const std::uint32_t first = nodes_.instance(instance).first_face;
    const std::size_t faces = nodes_.scene().instances[instance].data().faces.size();
    for (std::uint32_t id = first; id < first + faces; ++id) {
        const Node& n = nodes_[id];
        const float* v = &vectors_[nodes_[n.parent].slot * std::size_t(6 * C)];
        const Vec3 normal = n.normal();
        float* from = &inherited_[id * C];
        std::copy_n(light.received(id), C, &irradiance[id * C]);
        std::copy_n(light.from_bins(id), C, from);
        for (std::size_t c = 0; c < C; ++c) {
            const double e = normal.x * double(v[3 * c]) + normal.y * double(v[3 * c + 1]) + normal.z * double(v[3 * c + 2]);
            from[c] += static_cast<float>(std::max(0.0, e)) + irradiance[n.parent * C + c];
        }
        add_slope(inherited_, id);
        for (std::size_t c = 0; c < C; ++c) from[c] = std::max(0.0f, from[c]);
    }
    if (what == Push::BoundRows) share_out_faces(instance, irradiance);
    for (std::uint32_t id = first; id < first + faces; ++id) add_inherited(irradiance, id, &inherited_[id * C]);
}

// Nodes above a face know what they receive in all, not which of their faces are hidden from it: what is taken from those goes to
// others below the same node, the lowest one that has room.
template <int C>
void PushDown<C>::share_out_faces(std::uint32_t instance, const std::vector<float>& irradiance) {
    const InstanceNodes& in = nodes_.instance(instance);
    const auto end = in.first_face + static_cast<std::uint32_t>(nodes_.scene().instances[instance].data().faces.size());
    std::vector<double> over(end - in.first_cluster, 0), room(over), taken(over);  // of nodes from the first cluster on, m^2
    for (std::uint32_t id = end; id-- > in.first_cluster;) {
        const std::uint32_t n = id - in.first_cluster;
        const Node& node = nodes_[id];
        if (id >= in.first_face) {
            const float own = irradiance[id * C], inherited = inherited_[id * C];
            const double hidden = hidden_share(own, inherited);
            scale_[id] = hidden > 0 ? static_cast<float>(1 - hidden / double(inherited)) : 1.0f;
            over[n] = node.area * hidden;
            if (inherited > 0 && hidden == 0) room[n] = node.area * std::max(0.0, 1 - double(own) - double(inherited));
        } else if (over[n] > 0 && room[n] > 0) {
            const double given = std::min(over[n], room[n]);
            taken[n] = given / room[n];
            over[n] -= given;
            room[n] -= given;
        }
        if (node.parent == kNoNode || nodes_[node.parent].group()) continue;
        over[node.parent - in.first_cluster] += over[n];
        room[node.parent - in.first_cluster] += room[n];
    }
    for (std::uint32_t id = in.first_cluster; id < end; ++id) {  // parts of the room that nodes above have taken, too
        const std::uint32_t n = id - in.first_cluster;
        const Node& node = nodes_[id];
        if (node.parent != kNoNode && !nodes_[node.parent].group()) {
            const double left = 1 - taken[node.parent - in.first_cluster];
            taken[n] = 1 - (1 - taken[n]) * left;
        }
        if (id >= in.first_face && room[n] > 0)
            scale_[id] += static_cast<float>(room[n] * taken[n] / (node.area * double(inherited_[id * C])));
    }
}

template <int C>
void PushDown<C>::push_elements(const InstanceNodes& in, Push what, const Passage<C>& light, std::vector<float>& irradiance) {
    for (const std::uint32_t id : in.elements) std::copy_n(light.received(id), C, &irradiance[id * C]);
    if (what == Push::BoundRows) gather_rows(in, irradiance);
    for (const std::uint32_t id : in.elements) {
        const std::uint32_t parent = nodes_[id].parent;
        if (what == Push::BoundRows && id == nodes_[parent].first_child) share_out(parent, irradiance);
        add_inherited(irradiance, id, &irradiance[parent * C]);
    }
}

// By the gradient of the node above, over the way from its centre.
template <int C>
void PushDown<C>::add_slope(std::vector<float>& to, std::uint32_t id) const {
    const Node &n = nodes_[id], &parent = nodes_[n.parent];
    const float* s = &vectors_[parent.slot * std::size_t(6 * C) + 3 * C];
    const Vec3 x = n.centre - parent.centre;
    for (std::size_t c = 0; c < C; ++c)
        to[id * C + c] += static_cast<float>(x.x * double(s[3 * c]) + x.y * double(s[3 * c + 1]) + x.z * double(s[3 * c + 2]));
}

// What a surface inherits, added to what its own links bring.
template <int C>
void PushDown<C>::add_inherited(std::vector<float>& irradiance, std::uint32_t id, const float* from) const {
    const float scale = scale_.empty() ? 1.0f : scale_[id];
    for (std::size_t c = 0; c < C; ++c) irradiance[id * C + c] += scale * from[c];
}

// Under unit radiosity: what the parts of every element bring it goes into inherited_, from the smallest parts up.
template <int C>
void PushDown<C>::gather_rows(const InstanceNodes& in, const std::vector<float>& irradiance) {
    for (const std::uint32_t id : in.elements) inherited_[id * C] = 0, scale_[id] = 1;
    for (auto it = in.elements.rbegin(); it != in.elements.rend(); ++it) {
        const std::uint32_t parent = nodes_[*it].parent;
        if (nodes_[parent].depth > 0) inherited_[parent * C] += (irradiance[*it * C] + inherited_[*it * C]) / 4;
    }
}

// The elements of a surface inherit its row alike, as if it came from everywhere. Yet where an element's own links, and those
// of its parts (in inherited_), fill more of its sky less is left for the rest: what would make a row greater than 1 goes to
// those beside it that have room.
template <int C>
void PushDown<C>::share_out(std::uint32_t parent, const std::vector<float>& irradiance) {
    const Node& n = nodes_[parent];
    const float inherited = irradiance[parent * C];
    double sum = 0, over = 0, room = 0;
    const auto row = [&](std::uint32_t id) { return irradiance[id * C] + inherited_[id * C] + inherited; };
    for (std::uint32_t id = n.first_child; id < n.first_child + n.child_count; ++id) sum += double(row(id));
    const double most = std::max(double(kMostElementRow), sum / n.child_count);
    const auto each = [&](const auto& visit) {
        for (std::uint32_t id = n.first_child; id < n.first_child + n.child_count; ++id) visit(id, most - double(row(id)));
    };
    each([&](std::uint32_t, double left) { (left > 0 ? room : over) += left > 0 ? left : std::min(-left, double(inherited)); });
    if (over == 0 || !(inherited > 0)) return;
    each([&](std::uint32_t id, double left) {
        const double more = left > 0 ? over * left / room : std::max(left, -double(inherited));
        scale_[id] = static_cast<float>(1 + more / double(inherited));
    });
}

template class PushDown<1>;
template class PushDown<3>;

}  // namespace rro
