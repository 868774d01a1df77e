#include "solver/transport/passage.h"

#include <cmath>

#include "format/parallel.h"
#include "solver/transport/channels.h"
#include "solver/transport/flat_light.h"

namespace rro {

namespace {

constexpr std::size_t kGrain = 256;  // receivers per parallel chunk

}  // namespace

template <int C>
Passage<C>::Passage(const Nodes& nodes, const EndAreas& areas, const HalfLinks<C>& links)
    : nodes_(nodes), links_(links), bins_(nodes, areas), groups_(nodes, areas) {}

template <int C>
void Passage<C>::grow() {
    sent_.resize(nodes_.size() * C, 0);
    received_.resize(nodes_.size() * C, 0);
    vectors_.resize(std::size_t(nodes_.flat_count()) * 6 * C, 0);
    from_bins_.resize(nodes_.size() * C, 0);
    changed_.resize(nodes_.size(), 0);
    stale_.resize(nodes_.size(), 1);
}

template <int C>
void Passage<C>::reset() {
    bins_.reset();
    groups_.reset();
    std::fill(from_bins_.begin(), from_bins_.end(), 0.0f);  // faces may have no bins above them any more
    whole_ = true;
}

template <int C>
void Passage<C>::use_ends(const std::vector<Link>& links, const std::vector<std::uint8_t>& wanted) {
    const auto use = [&](std::uint32_t id, EndMode mode) {
        if (!wanted[id]) return;
        if (nodes_[id].group()) groups_.use(id);
        else if (nodes_[id].kind == NodeKind::Bins && mode != EndMode::Mean) bins_.use(id, mode);
    };
    for (const Link& l : links) {
        if (!concerns(l, wanted)) continue;
        use(l.a, l.mode_a);
        use(l.b, l.mode_b);
    }
    groups_.allocate(bins_);
    bins_.allocate();
}

// What has changed by more than the tolerance counts from now on.
template <int C>
void Passage<C>::send(const std::vector<float>& radiosity, double tolerance) {
    parallel_for(nodes_.size(), kGrain, [&](std::size_t id) {
        const double square = mean_over<C>([&](std::size_t c) {
            return std::pow(double(radiosity[id * C + c]) - double(sent_[id * C + c]), 2);
        });
        changed_[id] = whole_ || square > tolerance * tolerance;
        if (changed_[id]) std::copy_n(&radiosity[id * C], C, &sent_[id * C]);
    });
    bins_.pull(sent_, changed_);
    groups_.pull(bins_, sent_);
    if (groups_.any()) std::fill_n(changed_.begin(), nodes_.group_count(), std::uint8_t{1});
}

// What groups bring is not kept, so their members receive anew each time.
template <int C>
bool Passage<C>::receives_anew(std::uint32_t node) const {
    if (whole_ || stale_[node] || (groups_.any() && nodes_[node].kind != NodeKind::Surface)) return true;
    const auto scalar = links_.scalar_row(node), directed = links_.directed_row(node);
    for (std::uint32_t k = scalar.first; k < scalar.last; ++k)
        if (changed_[links_.scalar(k).source]) return true;
    for (std::uint32_t k = directed.first; k < directed.last; ++k)
        if (changed_[links_.directed(k).source]) return true;
    return false;
}

template <int C>
std::array<float, C> Passage<C>::source_value(const typename HalfLinks<C>::Directed& link) const {
    if (nodes_[link.source].group()) return groups_.intensity(link.source, -to_double(link.u));
    if (link.source_mode != EndMode::Mean && nodes_[link.source].kind == NodeKind::Bins)
        return bins_.intensity(link.source, link.source_mode, -to_double(link.u));
    std::array<float, C> out;
    for (std::size_t c = 0; c < C; ++c) out[c] = sent_[link.source * C + c];
    return out;
}

template <int C>
template <bool Tinted>
std::array<float, C> Passage<C>::light_of(std::uint32_t directed) const {
    auto value = source_value(links_.directed(directed));
    if constexpr (Tinted)
        for (std::size_t c = 0; c < C; ++c) value[c] *= links_.directed_tint(directed)[c];
    return value;
}

template <int C>
template <bool Tinted>
std::array<double, C> Passage<C>::gather_scalar(std::uint32_t node) const {
    std::array<double, C> e{};
    const auto [first, last] = links_.scalar_row(node);
    for (std::uint32_t k = first; k < last; ++k) {
        const auto& link = links_.scalar(k);
        for (std::size_t c = 0; c < C; ++c)
            if constexpr (Tinted)
                e[c] += double(link.gain) * double(links_.scalar_tint(k)[c]) * double(sent_[link.source * C + c]);
            else
                e[c] += double(link.gain) * double(sent_[link.source * C + c]);
    }
    return e;
}

template <int C>
template <bool Tinted>
void Passage<C>::gather_flat(const Node& node, std::uint32_t id) {
    std::array<double, 6 * C> v{};
    const auto [first, last] = links_.directed_row(id);
    for (std::uint32_t k = first; k < last; ++k) {
        const auto& link = links_.directed(k);
        const auto value = light_of<Tinted>(k);
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
    for (std::size_t c = 0; c < 6 * C; ++c) vectors_[node.slot * std::size_t(6 * C) + c] = static_cast<float>(v[c]);
}

template <int C>
template <bool Tinted>
void Passage<C>::gather() {
    parallel_for(nodes_.size(), kGrain, [&](std::size_t n) {
        const auto id = static_cast<std::uint32_t>(n);
        const Node& node = nodes_[id];
        stale_[id] = receives_anew(id);
        if (!stale_[id]) return;
        std::array<double, C> e = gather_scalar<Tinted>(id);
        if (node.kind == NodeKind::Surface) {
            const auto [first, last] = links_.directed_row(id);
            for (std::uint32_t k = first; k < last; ++k) {
                const auto value = light_of<Tinted>(k);
                for (std::size_t c = 0; c < C; ++c) e[c] += double(links_.directed(k).gain) * double(value[c]);
            }
        } else if (node.kind == NodeKind::Flat) {
            gather_flat<Tinted>(node, id);
        }
        for (std::size_t c = 0; c < C; ++c) received_[id * C + c] = static_cast<float>(e[c]);
    });
    gather_bins<Tinted>();
}

template <int C>
template <bool Tinted>
void Passage<C>::gather_bins() {
    groups_.clear_incoming();
    parallel_for(nodes_.size(), kGrain, [&](std::size_t n) {
        const auto id = static_cast<std::uint32_t>(n);
        if (nodes_[id].kind != NodeKind::Bins || !stale_[id]) return;
        if (!nodes_[id].group()) bins_.clear_incoming(id);
        const auto [first, last] = links_.directed_row(id);
        for (std::uint32_t k = first; k < last; ++k) {
            const auto& link = links_.directed(k);
            auto h = source_value(link);
            for (float& x : h) x *= link.gain;
            if constexpr (Tinted)
                for (std::size_t c = 0; c < C; ++c) h[c] *= links_.directed_tint(k)[c];
            if (nodes_[id].group()) groups_.splat(id, to_double(link.u), double(link.inverse_distance), h);
            else bins_.splat(id, link.receiver_mode, to_double(link.u), double(link.inverse_distance), h);
        }
    });
}

template <int C>
std::vector<std::uint8_t> Passage<C>::pass(const std::vector<float>& radiosity, double tolerance, bool tinted) {
    send(radiosity, tolerance);
    if (tinted) gather<true>();
    else gather<false>();
    groups_.push(bins_, vectors_);
    std::vector<std::uint8_t> reached = bins_.push(from_bins_, tolerance);
    parallel_for(reached.size(), 1, [&](std::size_t k) {
        const auto i = static_cast<std::uint32_t>(k);
        const InstanceNodes& in = nodes_.instance(i);
        const auto faces = static_cast<std::ptrdiff_t>(nodes_.scene().instances[i].data().faces.size());
        const auto first = stale_.begin() + in.first_cluster, last = stale_.begin() + in.first_face + faces;
        reached[i] = reached[i] || whole_ || std::find(first, last, 1) != last ||
                     std::any_of(in.elements.begin(), in.elements.end(), [&](std::uint32_t id) { return stale_[id] != 0; });
    });
    std::fill(stale_.begin(), stale_.end(), std::uint8_t{0});
    whole_ = false;
    return reached;
}

template class Passage<1>;
template class Passage<3>;

}  // namespace rro
