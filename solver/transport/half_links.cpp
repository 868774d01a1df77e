#include "solver/transport/half_links.h"

#include <algorithm>
#include <numbers>

#include "format/parallel.h"
#include "solver/transport/flat_light.h"

namespace rro {

namespace {

constexpr std::size_t kGrain = 256;      // half links per parallel chunk
constexpr std::size_t kBatch = 1 << 16;  // links made ready at a time
constexpr std::size_t kMostUnused = 2;   // half links that no row refers to any more, for each one in use

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
HalfLinks<C>::HalfLinks(const Nodes& nodes) : nodes_(nodes) {
    if (const auto& medium = nodes.scene().medium; medium && C > 1) {
        const Vec3 a = medium->absorption, beyond = a - Vec3{1, 1, 1} * std::min({a.x, a.y, a.z});
        if (beyond != Vec3{}) absorption_ = beyond;
    }
}

template <int C>
void HalfLinks<C>::grow() {
    scalar_row_.resize(nodes_.size());
    directed_row_.resize(nodes_.size());
}

template <int C>
void HalfLinks<C>::clear() {
    scalar_row_.assign(nodes_.size(), {});
    directed_row_.assign(nodes_.size(), {});
    scalar_.clear();
    directed_.clear();
    used_ = 0;
}

template <int C>
void HalfLinks<C>::drop(std::uint32_t node) {
    for (Row* row : {&scalar_row_[node], &directed_row_[node]}) {
        used_ -= row->last - row->first;
        *row = {};
    }
}

template <int C>
bool HalfLinks<C>::mostly_unused() const {
    return scalar_.size() + directed_.size() > kMostUnused * used_;
}

// Rows are put behind those that there are: first their sizes, as `last`, then their places.
template <int C>
void HalfLinks<C>::count(const std::vector<Link>& links, const std::vector<std::uint8_t>& wanted) {
    const auto count_half = [&](std::uint32_t receiver, EndMode receiver_mode, std::uint32_t source, EndMode source_mode) {
        if (!wanted[receiver]) return;
        const bool scalar = scalar_half(nodes_[receiver], receiver_mode, nodes_[source], source_mode);
        ++(scalar ? scalar_row_ : directed_row_)[receiver].last;
    };
    for (const Link& l : links) {
        if (!concerns(l, wanted)) continue;
        count_half(l.a, l.mode_a, l.b, l.mode_b);
        count_half(l.b, l.mode_b, l.a, l.mode_a);
    }
    const auto lay_out = [&](std::vector<Row>& rows, auto& half_links) {
        auto next = static_cast<std::uint32_t>(half_links.size());
        for (std::size_t n = 0; n < rows.size(); ++n) {
            if (!wanted[n]) continue;
            const std::uint32_t size = rows[n].last;
            rows[n] = {next, next};  // add() fills it
            next += size;
            used_ += size;
        }
        half_links.resize(next);
    };
    lay_out(scalar_row_, scalar_);
    lay_out(directed_row_, directed_);
    if (!tinted()) return;
    scalar_tint_.resize(scalar_.size());
    directed_tint_.resize(directed_.size());
}

template <int C>
void HalfLinks<C>::add(const std::vector<Link>& links, const std::vector<std::uint8_t>& wanted) {
    count(links, wanted);
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
            if (!concerns(links[k], wanted)) continue;
            place(links[k], true);
            place(links[k], false);
        }
        parallel_for(halves.size(), kGrain, [&](std::size_t k) { set(halves[k]); });
    }
}

template <int C>
void HalfLinks<C>::set(const Half& half) {
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
        if (tinted()) (half.scalar ? scalar_tint_ : directed_tint_)[half.at] = tint_of(*absorption_, d);
    if (half.scalar) {
        scalar_[half.at] = {source, static_cast<float>(gain)};
        return;
    }
    Directed& h = directed_[half.at];
    h = {source, static_cast<float>(gain), to_float(u), {}, static_cast<float>(d > 0 ? 1 / d : 0), source_mode, receiver_mode};
    if (r.kind == NodeKind::Flat) h.slope = to_float(slope(r, s, u, d));
}

template class HalfLinks<1>;
template class HalfLinks<3>;

}  // namespace rro
