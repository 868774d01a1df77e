#include "solver/transport/gather.h"

#include <numbers>
#include <type_traits>

#include "format/parallel.h"
#include "solver/transport/channels.h"
#include "solver/transport/flat_light.h"

namespace rro {

namespace {

constexpr std::size_t kGrain = 256;  // receivers per parallel chunk
constexpr std::size_t kBatch = 1 << 16;  // links made ready at a time

constexpr float kClose = 0.5f;      // own links below that are no sign of something close; a row beyond 1 is noise
constexpr float kMostRow = 1.05f;  // rows that are a little above 1 are as many as those a little below

/// What is left of what a surface inherits where its own links bring so much that something hides the rest.
float bounded_scale(float own, float inherited) {
    return own > kClose && inherited > 0 && own + inherited > kMostRow ? std::max(0.0f, 1 - own) / inherited : 1.0f;
}

template <int C>
float component(const Rgb& rgb, std::size_t c) {
    static_assert(C == 1 || C == 3);
    return c == 0 ? rgb.x : c == 1 ? rgb.y : rgb.z;  // grey scenes carry equal components
}

/// What a way of d metres leaves per channel.
std::array<float, 3> tint_of(const Vec3& absorption, double d) {
    const Vec3 left = Medium{absorption}.transmittance(d);
    return {static_cast<float>(left.x), static_cast<float>(left.y), static_cast<float>(left.z)};
}

// One radiosity from the source, one irradiance for all of the receiver.
bool scalar_half(const Node& receiver, EndMode receiver_mode, const Node& source, EndMode source_mode) {
    return (receiver_mode == EndMode::Mean || receiver.kind == NodeKind::Surface) &&
           (source_mode == EndMode::Mean || source.kind != NodeKind::Bins);
}

}  // namespace

template <int C>
LightField<C>::LightField(const Nodes& nodes, const EndAreas& areas)
    : nodes_(nodes), areas_(areas), light_(nodes, areas) {
    for (std::uint32_t i = 0; i < nodes.scene().instances.size(); ++i) {
        const Instance& instance = nodes.scene().instances[i];
        std::vector<std::uint32_t>& others = other_side_.emplace_back();
        if (instance.transmittance.empty()) continue;
        for (const Face f : instance.data().faces) {
            const auto& side = f.side() == Side::Front ? instance.object->back_face : instance.object->front_face;
            const std::uint32_t other = side[f.triangle()];
            others.push_back(other == kNoFace ? kNoNode : nodes.instance(i).first_face + other);
        }
    }
    if (const auto& medium = nodes.scene().medium; medium && C > 1) {
        const Vec3 a = medium->absorption, beyond = a - Vec3{1, 1, 1} * std::min({a.x, a.y, a.z});
        if (beyond != Vec3{}) tint_ = beyond;
    }
    grow();
}

template <int C>
float LightField<C>::reflectance(std::uint32_t surface, std::size_t c) const {
    const Node& n = nodes_[surface];
    return component<C>(nodes_.scene().instances[n.instance].reflectance[nodes_.patch_of(n)], c);
}

template <int C>
float LightField<C>::transmittance(std::uint32_t surface, std::size_t c) const {
    const Node& n = nodes_[surface];
    return component<C>(nodes_.scene().instances[n.instance].transmittance_of(nodes_.patch_of(n)), c);
}

template <int C>
float LightField<C>::exitance(std::uint32_t surface, std::size_t c) const {
    const Node& n = nodes_[surface];
    const Instance& instance = nodes_.scene().instances[n.instance];
    const std::uint32_t patch = nodes_.patch_of(n);
    if (built_in("groups") && light_group_ != kAllGroups && instance.light_group_of(patch) != light_group_) return 0;
    return component<C>(instance.exitance[patch], c);
}

template <int C>
void LightField<C>::grow() {
    const std::size_t before = radiosity_.size() / C;
    radiosity_.resize(nodes_.size() * C, 0);
    irradiance_.resize(nodes_.size() * C, 0);
    inherited_.resize(nodes_.size() * C, 0);
    vectors_.resize(std::size_t(nodes_.flat_count()) * 6 * C, 0);
    scalar_row_.resize(nodes_.size());
    directed_row_.resize(nodes_.size());
    grow(light_);
    if (unit_) grow(*unit_);
    for (std::size_t id = before; id < nodes_.size(); ++id) {
        const Node& n = nodes_[static_cast<std::uint32_t>(id)];
        if (n.kind != NodeKind::Surface) continue;
        for (std::size_t c = 0; c < C; ++c) {
            radiosity_[id * C + c] = n.depth > 0 ? radiosity_[n.parent * C + c] : exitance(static_cast<std::uint32_t>(id), c);
            if (n.depth > 0) irradiance_[id * C + c] = irradiance_[n.parent * C + c];
        }
    }
    if (before > 0) return;
    for (std::uint32_t i = 0; i < nodes_.scene().instances.size(); ++i) pull_instance(i);
    pull_groups();
}

template <int C>
float LightField<C>::sources(std::uint32_t surface, std::size_t c) const {
    const float emitted = exitance(surface, c);
    return !lit_from_outside() ? emitted : emitted + reflectance(surface, c) * component<C>(outside_[surface], c);
}

template <int C>
void LightField<C>::begin() {
    for (std::uint32_t i = 0; i < nodes_.scene().instances.size(); ++i) {
        for_each_leaf(i, [&](std::uint32_t id) {
            for (std::size_t c = 0; c < C; ++c) {
                radiosity_[id * C + c] = sources(id, c);
                irradiance_[id * C + c] = !lit_from_outside() ? 0 : component<C>(outside_[id], c);
            }
        });
        pull_instance(i);
        if (transmits(i)) transmit(i), pull_instance(i);
    }
    pull_groups();
    push_all_ = true;
}

template <int C>
void LightField<C>::take_over(const LightField& from, const std::vector<std::uint32_t>& node) {
    for (std::size_t n = 0; n < node.size(); ++n)
        for (std::size_t c = 0; c < C && node[n] != kNoNode; ++c) irradiance_[node[n] * C + c] = from.irradiance_[n * C + c];
    relight();
    push_all_ = true;
}

template <int C>
void LightField<C>::add(const std::vector<float>& irradiance, double scale) {
    parallel_for(irradiance_.size(), kGrain, [&](std::size_t k) {
        irradiance_[k] = static_cast<float>(std::max(0.0, double(irradiance_[k]) + scale * double(irradiance[k])));
    });
    push_all_ = true;
}

template <int C>
void LightField<C>::relight() {
    parallel_for(nodes_.scene().instances.size(), 1, [&](std::size_t k) { reflect_instance(static_cast<std::uint32_t>(k)); });
    pull_groups();
}

template <int C>
void LightField<C>::fill_sources(Guide& guide) {
    const std::vector<float> radiosity = radiosity_, irradiance = irradiance_;
    begin();
    fill(guide);
    radiosity_ = radiosity;
    irradiance_ = irradiance;
}

// Diffuse transmittance: what one side of a face receives, the other sends on, too. Both may be divided into elements of
// their own; the other side's mean serves all of them.
template <int C>
void LightField<C>::transmit(std::uint32_t i) {
    const InstanceNodes& in = nodes_.instance(i);
    const Instance& instance = nodes_.scene().instances[i];
    const auto add = [&](std::uint32_t id, std::uint32_t face) {
        const std::uint32_t other = other_side_[i][face];
        if (other == kNoNode || !leaf(id)) return;
        const Rgb through = instance.transmittance_of(instance.object->patch_of_face[face]);
        for (std::size_t c = 0; c < C; ++c)
            radiosity_[id * C + c] += component<C>(through, c) * irradiance_[other * C + c];
    };
    for (std::uint32_t f = 0; f < other_side_[i].size(); ++f) add(in.first_face + f, f);
    for (const std::uint32_t id : in.elements) add(id, nodes_.face_of(nodes_[id]));
}

template <int C>
void LightField<C>::extinguish() {
    for (std::uint32_t i = 0; i < nodes_.scene().instances.size(); ++i) {
        for_each_leaf(i, [&](std::uint32_t id) {
            for (std::size_t c = 0; c < C; ++c) radiosity_[id * C + c] = exitance(id, c), irradiance_[id * C + c] = 0;
        });
        pull_instance(i);
    }
    pull_groups();
    push_all_ = true;
}

template <int C>
void LightField<C>::set_links(const std::vector<Link>& links) {
    for_each_passage([](Passage& p) {
        p.bins.reset();
        p.groups.reset();
        std::fill(p.from_bins.begin(), p.from_bins.end(), 0.0f);  // faces may have no bins above them any more
        p.whole = true;
    });
    scalar_row_.assign(nodes_.size(), {});
    directed_row_.assign(nodes_.size(), {});
    scalar_.clear();
    directed_.clear();
    half_links_ = 0;
    add_rows(links, std::vector<std::uint8_t>(nodes_.size(), 1));
}

template <int C>
void LightField<C>::follow() {
    if (unit_) return;
    unit_.emplace(nodes_, areas_);
    grow(*unit_);
    light_.bins.remember();
    unit_->bins.remember();
}

template <int C>
void LightField<C>::change_links(const std::vector<Link>& links, const std::vector<std::uint32_t>& ends) {
    constexpr std::size_t kMostOld = 2;  // half links that nothing refers to any more, for each one in use
    if (!unit_ || light_.whole || scalar_.size() + directed_.size() > kMostOld * half_links_) return set_links(links);
    std::vector<std::uint8_t> wanted(nodes_.size(), 0);
    for (const std::uint32_t n : ends) {
        if (wanted[n]) continue;
        wanted[n] = light_.stale[n] = unit_->stale[n] = 1;
        for (Row* row : {&scalar_row_[n], &directed_row_[n]}) {
            half_links_ -= row->last - row->first;
            *row = {};
        }
    }
    add_rows(links, wanted);
}

// Rows of the nodes wanted, which have none, are put behind those that there are.
template <int C>
void LightField<C>::add_rows(const std::vector<Link>& links, const std::vector<std::uint8_t>& wanted) {
    const auto count = [&](std::uint32_t receiver, EndMode receiver_mode, std::uint32_t source, EndMode source_mode) {
        if (!wanted[receiver]) return;
        const bool scalar = scalar_half(nodes_[receiver], receiver_mode, nodes_[source], source_mode);
        ++(scalar ? scalar_row_ : directed_row_)[receiver].last;
    };
    const auto use = [&](std::uint32_t id, EndMode mode) {
        if (!wanted[id] || (!nodes_[id].group() && (nodes_[id].kind != NodeKind::Bins || mode == EndMode::Mean))) return;
        for_each_passage([&](Passage& p) {
            if (nodes_[id].group()) p.groups.use(id);
            else p.bins.use(id, mode);
        });
    };
    for (const Link& l : links) {
        if ((l.base_a == 0 && l.base_b == 0) || !(wanted[l.a] || wanted[l.b])) continue;
        count(l.a, l.mode_a, l.b, l.mode_b);
        count(l.b, l.mode_b, l.a, l.mode_a);
        use(l.a, l.mode_a);
        use(l.b, l.mode_b);
    }
    for_each_passage([](Passage& p) {
        p.groups.allocate(p.bins);
        p.bins.allocate();
    });
    const auto lay_out = [&](std::vector<Row>& rows, auto& half_links) {
        auto next = static_cast<std::uint32_t>(half_links.size());
        for (std::size_t n = 0; n < rows.size(); ++n) {
            if (!wanted[n]) continue;
            const std::uint32_t size = rows[n].last;
            rows[n] = {next, next};  // filled below
            next += size;
            half_links_ += size;
        }
        half_links.resize(next);
    };
    lay_out(scalar_row_, scalar_);
    lay_out(directed_row_, directed_);
    if (tinted()) {
        scalar_tint_.resize(scalar_.size());
        directed_tint_.resize(directed_.size());
    }
    // Places in order, contents side by side.
    std::vector<Half> halves;
    const auto place = [&](const Link& l, bool at_a) {
        const std::uint32_t receiver = at_a ? l.a : l.b, source = at_a ? l.b : l.a;
        if (!wanted[receiver]) return;
        const bool scalar = scalar_half(nodes_[receiver], at_a ? l.mode_a : l.mode_b, nodes_[source], at_a ? l.mode_b : l.mode_a);
        halves.push_back({&l, (scalar ? scalar_row_ : directed_row_)[receiver].last++, at_a, scalar});
    };
    for (std::size_t begin = 0; begin < links.size(); begin += kBatch) {
        halves.clear();
        for (std::size_t k = begin; k < std::min(begin + kBatch, links.size()); ++k) {
            const Link& l = links[k];
            if ((l.base_a == 0 && l.base_b == 0) || !(wanted[l.a] || wanted[l.b])) continue;
            place(l, true);
            place(l, false);
        }
        parallel_for(halves.size(), kGrain, [&](std::size_t k) { set_half(halves[k]); });
    }
}

template <int C>
void LightField<C>::set_half(const Half& half) {
    const Link& l = *half.link;
    const std::uint32_t source = half.at_a ? l.b : l.a;
    const EndMode receiver_mode = half.at_a ? l.mode_a : l.mode_b, source_mode = half.at_a ? l.mode_b : l.mode_a;
    const Node &r = nodes_[half.at_a ? l.a : l.b], &s = nodes_[source];
    const Vec3 between = s.centre - r.centre;
    const double d = length(between);
    const Vec3 u = d > 0 ? between / d : Vec3{0, half.at_a ? 1.0 : -1.0, 0};
    double gain = double(half.at_a ? l.base_a : l.base_b);
    if (source_mode == EndMode::Mean || s.kind != NodeKind::Bins) gain *= std::numbers::inv_pi;
    if (receiver_mode == EndMode::Mean || r.kind == NodeKind::Surface) gain /= r.area;
    else if (r.kind == NodeKind::Flat) gain /= dot(r.area_vector, arrival(r, u));
    if constexpr (C == 3)
        if (tinted()) (half.scalar ? scalar_tint_ : directed_tint_)[half.at] = tint_of(*tint_, d);
    if (half.scalar) {
        scalar_[half.at] = {source, static_cast<float>(gain)};
        return;
    }
    DirectedLink& h = directed_[half.at];
    h = {source, static_cast<float>(gain), to_float(u), {}, static_cast<float>(d > 0 ? 1 / d : 0), source_mode, receiver_mode};
    if (r.kind == NodeKind::Flat) h.slope = to_float(slope(r, s, u, d));
}

template <int C>
std::array<float, C> LightField<C>::source_value(const Passage& p, const DirectedLink& link) const {
    if (nodes_[link.source].group()) return p.groups.intensity(link.source, -to_double(link.u));
    if (link.source_mode != EndMode::Mean && nodes_[link.source].kind == NodeKind::Bins)
        return p.bins.intensity(link.source, link.source_mode, -to_double(link.u));
    std::array<float, C> out;
    for (std::size_t c = 0; c < C; ++c) out[c] = p.sent[link.source * C + c];
    return out;
}

template <int C>
template <bool Tinted>
void LightField<C>::gather_surfaces(Passage& p) {
    const auto source_of = [&](std::uint32_t k) {
        auto value = source_value(p, directed_[k]);
        if constexpr (Tinted)
            for (std::size_t c = 0; c < C; ++c) value[c] *= directed_tint_[k][c];
        return value;
    };
    parallel_for(nodes_.size(), kGrain, [&](std::size_t id) {
        const Node& node = nodes_[static_cast<std::uint32_t>(id)];
        p.stale[id] = receives_anew(p, static_cast<std::uint32_t>(id));
        if (!p.stale[id]) return;
        const auto [first, last] = directed_row_[id];
        std::array<double, C> e{};
        for (std::uint32_t k = scalar_row_[id].first; k < scalar_row_[id].last; ++k)
            for (std::size_t c = 0; c < C; ++c)
                if constexpr (Tinted)
                    e[c] += double(scalar_[k].gain) * double(scalar_tint_[k][c]) * double(p.sent[scalar_[k].source * C + c]);
                else
                    e[c] += double(scalar_[k].gain) * double(p.sent[scalar_[k].source * C + c]);
        if (node.kind == NodeKind::Surface) {
            for (std::uint32_t k = first; k < last; ++k) {
                const auto value = source_of(k);
                for (std::size_t c = 0; c < C; ++c) e[c] += double(directed_[k].gain) * double(value[c]);
            }
        } else if (node.kind == NodeKind::Flat) {
            std::array<double, 6 * C> v{};
            for (std::uint32_t k = first; k < last; ++k) {
                const DirectedLink& link = directed_[k];
                const auto value = source_of(k);
                const Vec3 u = arrival(node, to_double(link.u)), s = to_double(link.slope);
                for (std::size_t c = 0; c < C; ++c) {
                    const double h = double(link.gain) * double(value[c]);
                    v[3 * c] += h * u.x;
                    v[3 * c + 1] += h * u.y;
                    v[3 * c + 2] += h * u.z;
                    v[3 * (C + c)] += h * s.x;
                    v[3 * (C + c) + 1] += h * s.y;
                    v[3 * (C + c) + 2] += h * s.z;
                }
            }
            for (std::size_t c = 0; c < 6 * C; ++c) p.vectors[node.slot * std::size_t(6 * C) + c] = static_cast<float>(v[c]);
        }
        for (std::size_t c = 0; c < C; ++c) p.received[id * C + c] = static_cast<float>(e[c]);
    });
}

template <int C>
template <bool Tinted>
void LightField<C>::gather_bins(Passage& p) {
    p.groups.clear_incoming();
    parallel_for(nodes_.size(), kGrain, [&](std::size_t n) {
        const auto id = static_cast<std::uint32_t>(n);
        if (nodes_[id].kind != NodeKind::Bins || !p.stale[id]) return;
        if (!nodes_[id].group()) p.bins.clear_incoming(id);
        for (std::uint32_t k = directed_row_[id].first; k < directed_row_[id].last; ++k) {
            const DirectedLink& link = directed_[k];
            auto h = source_value(p, link);
            for (float& x : h) x *= link.gain;
            if constexpr (Tinted)
                for (std::size_t c = 0; c < C; ++c) h[c] *= directed_tint_[k][c];
            if (nodes_[id].group()) p.groups.splat(id, to_double(link.u), double(link.inverse_distance), h);
            else p.bins.splat(id, link.receiver_mode, to_double(link.u), double(link.inverse_distance), h);
        }
    });
}

// Under unit radiosity: what the parts of every element bring it goes into inherited_, from the smallest parts up.
template <int C>
void LightField<C>::gather_rows(const InstanceNodes& in) {
    for (const std::uint32_t id : in.elements) inherited_[id * C] = 0, inherited_scale_[id] = 1;
    for (auto it = in.elements.rbegin(); it != in.elements.rend(); ++it) {
        const std::uint32_t parent = nodes_[*it].parent;
        if (nodes_[parent].depth > 0) inherited_[parent * C] += (irradiance_[*it * C] + inherited_[*it * C]) / 4;
    }
}

// The elements of a surface inherit its row alike, as if it came from everywhere. Yet where an element's own links, and those
// of its parts (in inherited_), fill more of its sky less is left for the rest: what would make a row greater than 1 goes to
// those beside it that have room.
template <int C>
void LightField<C>::share_out(std::uint32_t parent) {
    const Node& n = nodes_[parent];
    const float inherited = irradiance_[parent * C];
    double sum = 0, over = 0, room = 0;
    const auto row = [&](std::uint32_t id) { return irradiance_[id * C] + inherited_[id * C] + inherited; };
    for (std::uint32_t id = n.first_child; id < n.first_child + n.child_count; ++id) sum += double(row(id));
    const double most = std::max(double(kMostRow), sum / n.child_count);
    const auto each = [&](const auto& visit) {
        for (std::uint32_t id = n.first_child; id < n.first_child + n.child_count; ++id) visit(id, most - double(row(id)));
    };
    each([&](std::uint32_t, double left) { (left > 0 ? room : over) += left > 0 ? left : std::min(-left, double(inherited)); });
    if (over == 0 || !(inherited > 0)) return;
    each([&](std::uint32_t id, double left) {
        const double more = left > 0 ? over * left / room : std::max(left, -double(inherited));
        inherited_scale_[id] = static_cast<float>(1 + more / double(inherited));
    });
}

// Irradiance of clusters, flat nodes and faces goes down to the leaves; irradiance_ of a face with elements ends as their
// mean. A flat node's vector meets each face's own cosine, its gradient the place of the face.
template <int C>
void LightField<C>::push_instance(std::uint32_t i, Push what, const Passage& p) {
    const InstanceNodes& in = nodes_.instance(i);
    constexpr std::size_t kFlat = 6 * C;
    const auto take_own = [&](std::uint32_t id) { std::copy_n(&p.received[id * C], C, &irradiance_[id * C]); };
    const auto add_parent = [&](std::uint32_t id) {
        for (std::size_t c = 0; c < C; ++c) irradiance_[id * C + c] += irradiance_[nodes_[id].parent * C + c];
    };
    const auto add_slope = [&](std::vector<float>& to, std::uint32_t id) {
        const Node &n = nodes_[id], &parent = nodes_[n.parent];
        const float* s = &vectors_[parent.slot * kFlat + 3 * C];
        const Vec3 x = n.centre - parent.centre;
        for (std::size_t c = 0; c < C; ++c)
            to[id * C + c] += static_cast<float>(x.x * double(s[3 * c]) + x.y * double(s[3 * c + 1]) + x.z * double(s[3 * c + 2]));
    };
    for (std::uint32_t id = in.first_cluster; id < in.first_face; ++id) {
        const Node& n = nodes_[id];
        take_own(id);
        if (n.kind == NodeKind::Flat) std::copy_n(&p.vectors[n.slot * kFlat], kFlat, &vectors_[n.slot * kFlat]);
        if (n.parent == kNoNode) continue;
        add_parent(id);
        if (n.kind != NodeKind::Flat || nodes_[n.parent].kind != NodeKind::Flat) continue;
        add_slope(irradiance_, id);
        for (std::size_t c = 0; c < kFlat; ++c) vectors_[n.slot * kFlat + c] += vectors_[nodes_[n.parent].slot * kFlat + c];
    }
    // What a surface inherits, added to what its own links bring.
    const auto add_inherited = [&](std::uint32_t id, const float* from) {
        float* e = &irradiance_[id * C];
        const float scale = inherited_scale_.empty() ? 1.0f : inherited_scale_[id];
        for (std::size_t c = 0; c < C; ++c) e[c] += scale * from[c];
    };
    const std::size_t faces = nodes_.scene().instances[i].data().faces.size();
    for (std::uint32_t id = in.first_face; id < in.first_face + faces; ++id) {
        const Node& n = nodes_[id];
        const float* v = &vectors_[nodes_[n.parent].slot * kFlat];
        const Vec3 normal = n.normal();
        float* from = &inherited_[id * C];
        take_own(id);
        std::copy_n(&p.from_bins[id * C], C, from);
        for (std::size_t c = 0; c < C; ++c) {
            const double e = normal.x * double(v[3 * c]) + normal.y * double(v[3 * c + 1]) + normal.z * double(v[3 * c + 2]);
            from[c] += static_cast<float>(std::max(0.0, e)) + irradiance_[n.parent * C + c];
        }
        add_slope(inherited_, id);
        for (std::size_t c = 0; c < C; ++c) from[c] = std::max(0.0f, from[c]);
        if (what == Push::BoundRows) inherited_scale_[id] = bounded_scale(irradiance_[id * C], from[0]);
        add_inherited(id, from);
    }
    for (const std::uint32_t id : in.elements) take_own(id);
    if (what == Push::BoundRows) gather_rows(in);
    for (const std::uint32_t id : in.elements) {
        const std::uint32_t parent = nodes_[id].parent;
        if (what == Push::BoundRows && id == nodes_[parent].first_child) share_out(parent);
        add_inherited(id, &irradiance_[parent * C]);
    }
}

// Area-weighted means from leaves to roots.
template <int C>
void LightField<C>::pull_instance(std::uint32_t i) {
    const InstanceNodes& in = nodes_.instance(i);
    const auto mean = [&](std::uint32_t id, bool with_irradiance) {
        const Node& n = nodes_[id];
        std::array<double, C> b{}, e{};
        const auto add = [&](std::uint32_t child) {
            for (std::size_t c = 0; c < C; ++c) {
                b[c] += nodes_[child].area * double(radiosity_[child * C + c]);
                e[c] += nodes_[child].area * double(irradiance_[child * C + c]);
            }
        };
        if (n.second_child != 0) {
            add(n.first_child);
            add(n.second_child);
        } else {
            for (std::uint32_t k = 0; k < n.child_count; ++k) add(n.first_child + k);
        }
        if (!(n.area > 0)) return;
        for (std::size_t c = 0; c < C; ++c) {
            radiosity_[id * C + c] = static_cast<float>(b[c] / n.area);
            if (with_irradiance) irradiance_[id * C + c] = static_cast<float>(e[c] / n.area);
        }
    };
    for (auto it = in.elements.rbegin(); it != in.elements.rend(); ++it)
        if (!leaf(*it)) mean(*it, true);
    const auto faces = static_cast<std::uint32_t>(nodes_.scene().instances[i].data().faces.size());
    for (std::uint32_t f = faces; f-- > 0;)
        if (!leaf(in.first_face + f)) mean(in.first_face + f, true);
    for (std::uint32_t id = in.first_face; id-- > in.first_cluster;) mean(id, false);
}

template <int C>
void LightField<C>::pull_groups() {
    for (std::uint32_t g = nodes_.group_count(); g-- > 0;) {
        const Node &n = nodes_[g], &x = nodes_[n.first_child], &y = nodes_[n.second_child];
        for (std::size_t c = 0; c < C; ++c) {
            const double sum = x.area * double(radiosity_[n.first_child * C + c]) +
                               y.area * double(radiosity_[n.second_child * C + c]);
            radiosity_[g * C + c] = static_cast<float>(n.area > 0 ? sum / n.area : 0);
        }
    }
}

template <int C>
template <class F>
void LightField<C>::for_each_leaf(std::uint32_t i, const F& f) const {
    const InstanceNodes& in = nodes_.instance(i);
    const auto faces = static_cast<std::uint32_t>(nodes_.scene().instances[i].data().faces.size());
    for (std::uint32_t id = in.first_face; id < in.first_face + faces; ++id)
        if (leaf(id)) f(id);
    for (const std::uint32_t id : in.elements)
        if (leaf(id)) f(id);
}

template <int C>
void LightField<C>::grow(Passage& p) const {
    p.sent.resize(nodes_.size() * C, 0);
    p.received.resize(nodes_.size() * C, 0);
    p.vectors.resize(std::size_t(nodes_.flat_count()) * 6 * C, 0);
    p.from_bins.resize(nodes_.size() * C, 0);
    p.changed.resize(nodes_.size(), 0);
    p.stale.resize(nodes_.size(), 1);
}

// What has changed by more than the tolerance counts from now on.
template <int C>
void LightField<C>::send(Passage& p, double tolerance) {
    parallel_for(nodes_.size(), kGrain, [&](std::size_t id) {
        const double square = mean_over<C>([&](std::size_t c) {
            return std::pow(double(radiosity_[id * C + c]) - double(p.sent[id * C + c]), 2);
        });
        p.changed[id] = p.whole || square > tolerance * tolerance;
        if (p.changed[id]) std::copy_n(&radiosity_[id * C], C, &p.sent[id * C]);
    });
    p.bins.pull(p.sent, p.changed);
    p.groups.pull(p.bins, p.sent);
    if (p.groups.any()) std::fill_n(p.changed.begin(), nodes_.group_count(), std::uint8_t{1});
}

template <int C>
void LightField<C>::leave_unsent(double part) {
    unsent_part_ = part;
    tolerance_ = part > 0 ? part * reflected_norm() : 0;
}

template <int C>
double LightField<C>::find_unsent() const {
    if (tolerance_ <= 0) return 0;
    const std::size_t instances = nodes_.scene().instances.size();
    std::vector<double> square(instances, 0);
    parallel_for(instances, 1, [&](std::size_t i) {
        for_each_leaf(static_cast<std::uint32_t>(i), [&](std::uint32_t id) {
            square[i] += nodes_[id].area * mean_over<C>([&](std::size_t c) {
                return std::pow(double(radiosity_[id * C + c]) - double(light_.sent[id * C + c]), 2);
            });
        });
    });
    double sum = 0, area = 0;
    for (std::uint32_t i = 0; i < instances; ++i) sum += square[i], area += nodes_[nodes_.root(i)].area;
    return area > 0 ? std::sqrt(sum / area) : 0.0;
}

// What groups bring is not kept, so their members receive anew each time.
template <int C>
bool LightField<C>::receives_anew(const Passage& p, std::uint32_t node) const {
    if (p.whole || p.stale[node] || (p.groups.any() && nodes_[node].kind != NodeKind::Surface)) return true;
    for (std::uint32_t k = scalar_row_[node].first; k < scalar_row_[node].last; ++k)
        if (p.changed[scalar_[k].source]) return true;
    for (std::uint32_t k = directed_row_[node].first; k < directed_row_[node].last; ++k)
        if (p.changed[directed_[k].source]) return true;
    return false;
}

template <int C>
void LightField<C>::transport(Push what) {
    const bool light = what == Push::Light;
    Passage& p = light || !unit_ ? light_ : *unit_;
    const double tolerance = light ? tolerance_ : unsent_part_;  // of unit radiosity
    send(p, tolerance);
    if (tinted() && light) {
        gather_surfaces<true>(p);
        gather_bins<true>(p);
    } else {
        gather_surfaces<false>(p);
        gather_bins<false>(p);
    }
    p.groups.push(p.bins, p.vectors);
    reached_ = p.bins.push(p.from_bins, tolerance);
    parallel_for(nodes_.scene().instances.size(), 1, [&](std::size_t k) {
        const auto i = static_cast<std::uint32_t>(k);
        const InstanceNodes& in = nodes_.instance(i);
        const auto faces = static_cast<std::ptrdiff_t>(nodes_.scene().instances[i].data().faces.size());
        const auto first = p.stale.begin() + in.first_cluster, last = p.stale.begin() + in.first_face + faces;
        reached_[i] = reached_[i] || p.whole || (light && push_all_) || std::find(first, last, 1) != last ||
                      std::any_of(in.elements.begin(), in.elements.end(), [&](std::uint32_t id) { return p.stale[id] != 0; });
        if (reached_[i]) push_instance(i, what, p);
    });
    std::fill(p.stale.begin(), p.stale.end(), std::uint8_t{0});
    p.whole = false;
    if (light) push_all_ = false;
}

template <int C>
void LightField<C>::bound_rows() {
    const std::vector<float> radiosity = radiosity_, irradiance = irradiance_;
    std::fill(radiosity_.begin(), radiosity_.end(), 1.0f);
    inherited_scale_.resize(nodes_.size(), 1.0f);
    if (!unit_) light_.whole = true;
    transport(Push::BoundRows);
    if (!unit_) light_.whole = true;
    radiosity_ = radiosity;
    irradiance_ = irradiance;
}

template <int C>
double LightField<C>::close_rows() {
    constexpr float kMost = 2;  // beyond that a leaf is hidden in another part of the shell, not badly sampled
    const std::vector<float> kept = radiosity_;
    std::fill(radiosity_.begin(), radiosity_.end(), 1.0f);
    row_scale_.clear();
    light_.whole = true;
    transport();
    light_.whole = true;
    row_scale_.assign(nodes_.size(), 1.0f);
    double sum = 0, total = 0;
    for (std::uint32_t i = 0; i < nodes_.scene().instances.size(); ++i)
        for_each_leaf(i, [&](std::uint32_t id) {
            const float row = irradiance_[id * C];
            if (row < 1 / kMost || row > kMost) return;
            row_scale_[id] = 1 / row;
            sum += nodes_[id].area * double(row - 1) * double(row - 1);
            total += nodes_[id].area;
        });
    radiosity_ = kept;
    return total > 0 ? std::sqrt(sum / total) : 0.0;
}

template <int C>
void LightField<C>::reflect_instance(std::uint32_t i) {
    for_each_leaf(i, [&](std::uint32_t id) {
        for (std::size_t c = 0; c < C; ++c)
            radiosity_[id * C + c] = exitance(id, c) + reflectance(id, c) * irradiance_[id * C + c];
    });
    pull_instance(i);
    if (transmits(i)) transmit(i), pull_instance(i);
}

template <int C>
void LightField<C>::advance(double times) {
    parallel_for(nodes_.scene().instances.size(), 1, [&](std::size_t k) {
        const auto i = static_cast<std::uint32_t>(k);
        for_each_leaf(i, [&](std::uint32_t id) {
            for (std::size_t c = 0; c < C; ++c) {
                float& e = irradiance_[id * C + c];
                e = static_cast<float>(std::max(0.0, double(e) + times * (double(e) - double(before_[id * C + c]))));
            }
        });
        reflect_instance(i);
    });
    pull_groups();
    push_all_ = true;
}

template <int C>
double LightField<C>::sweep() {
    before_ = irradiance_;
    transport();
    unsent_ = find_unsent();
    const std::size_t instances = nodes_.scene().instances.size();
    std::vector<double> change(instances, 0), area(instances, 0);
    parallel_for(instances, 1, [&](std::size_t k) {
        const auto i = static_cast<std::uint32_t>(k);
        area[i] = nodes_[nodes_.root(i)].area;
        if (!reached_[i]) return;
        for_each_leaf(i, [&](std::uint32_t id) {
            std::array<double, C> square;
            for (std::size_t c = 0; c < C; ++c) {
                float& e = irradiance_[id * C + c];
                if (!row_scale_.empty()) e *= row_scale_[id];
                if (lit_from_outside()) e += component<C>(outside_[id], c);
                if (e < std::numeric_limits<float>::min()) e = 0;  // denormals are noise, and slow
                // In reflected light, not in radiosity: beside a strong exitance float would round it away.
                const double d = double(reflectance(id, c)) * (double(e) - double(before_[id * C + c]));
                square[c] = d * d;
            }
            change[i] += nodes_[id].area * mean_of(square);
        });
        reflect_instance(i);
    });
    pull_groups();
    double sum = 0, total = 0;
    for (std::size_t i = 0; i < instances; ++i) sum += change[i], total += area[i];
    return total > 0 ? std::sqrt(sum / total) : 0.0;
}

template <int C>
double LightField<C>::reflected_norm() const {
    const std::size_t instances = nodes_.scene().instances.size();
    std::vector<double> square(instances, 0);
    parallel_for(instances, 1, [&](std::size_t i) {
        for_each_leaf(static_cast<std::uint32_t>(i), [&](std::uint32_t id) {
            square[i] += nodes_[id].area * mean_over<C>([&](std::size_t c) {
                return std::pow(double(reflectance(id, c)) * double(irradiance_[id * C + c]), 2);
            });
        });
    });
    double sum = 0, total = 0;
    for (std::uint32_t i = 0; i < instances; ++i) sum += square[i], total += nodes_[nodes_.root(i)].area;
    return total > 0 ? std::sqrt(sum / total) : 0.0;
}

template <int C>
void LightField<C>::fill(Guide& guide) const {
    guide.radiosity.assign(nodes_.size(), 0);
    guide.irradiance.assign(nodes_.size(), 0);
    guide.variation.assign(nodes_.size(), 0);
    guide.reflectance.assign(nodes_.size(), 0);
    const auto grey = [](const std::vector<float>& v, std::size_t id) {
        return static_cast<float>(std::sqrt(mean_over<C>([&](std::size_t c) { return std::pow(double(v[id * C + c]), 2); })));
    };
    parallel_for(nodes_.size(), kGrain, [&](std::size_t id) {
        guide.radiosity[id] = grey(radiosity_, id);
        const Node& n = nodes_[static_cast<std::uint32_t>(id)];
        if (n.kind != NodeKind::Surface) return;
        // Channels count by the square of their light, as in the error: a red face in red light reflects most of it.
        const auto face = static_cast<std::uint32_t>(id);
        constexpr double kDark = 1e-60;  // where there is none, all alike
        std::array<double, C> sent, light;
        for (std::size_t c = 0; c < C; ++c) {
            const double rho = double(reflectance(face, c)) + double(transmittance(face, c));
            light[c] = std::pow(double(irradiance_[id * C + c]), 2) + kDark;
            sent[c] = rho * rho * light[c];
        }
        guide.reflectance[id] = static_cast<float>(std::sqrt(mean_of(sent) / mean_of(light)));
        guide.irradiance[id] = grey(irradiance_, id);
    });
    // Upwards: sums over children, which follow their parents.
    std::vector<double> square(nodes_.size(), 0);
    double area = 0;
    for (auto id = static_cast<std::uint32_t>(nodes_.size()); id-- > 0;) {
        const Node& n = nodes_[id];
        double rho = 0, e = 0, b2 = 0;
        const auto add = [&](std::uint32_t child) {
            rho += nodes_[child].area * double(guide.reflectance[child]);
            e += nodes_[child].area * double(guide.irradiance[child]);
            b2 += square[child];
        };
        if (n.second_child != 0) {
            add(n.first_child);
            add(n.second_child);
        } else {
            for (std::uint32_t k = 0; k < n.child_count; ++k) add(n.first_child + k);
        }
        const double b = double(guide.radiosity[id]);
        if (n.parent == kNoNode) area += n.area;
        if (n.child_count == 0 || !(n.area > 0)) {
            square[id] = n.area * b * b;
            continue;
        }
        square[id] = b2;
        if (b > 0) guide.variation[id] = static_cast<float>(std::sqrt(std::max(0.0, b2 / n.area - b * b)) / b);
        if (n.kind == NodeKind::Surface) continue;
        guide.reflectance[id] = static_cast<float>(rho / n.area);
        guide.irradiance[id] = static_cast<float>(e / n.area);
    }
    const double norm = reflected_norm();
    guide.reflected = area * norm * norm;
    guide.area = area;
}

template <int C>
std::uint64_t LightField<C>::bytes() const {
    return scalar_.size() * sizeof(ScalarLink) + directed_.size() * sizeof(DirectedLink) + light_.bins.bytes() + light_.groups.bytes() +
           (unit_ ? unit_->bins.bytes() + unit_->groups.bytes() : 0);
}

bool is_closed_shell(const Scene& scene) {
    if (scene.instances.size() != 1 || !scene.instances[0].data().meta.closed) return false;
    const Instance& instance = scene.instances[0];
    double volume = 0;  // three times the signed volume; negative where fronts look inwards
    for (const Face face : instance.data().faces) {
        const TriangleCorners c = instance.world_corners(face);
        volume += dot(c[0] - instance.bounds.centre(), area_vector(c));
    }
    return volume < 0;
}

template class LightField<1>;
template class LightField<3>;

}  // namespace rro
