#include "solver/transport/gather.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "format/parallel.h"
#include "solver/transport/channels.h"
#include "solver/transport/fill_guide.h"

namespace rro {

namespace {

constexpr std::size_t kGrain = 256;  // numbers per parallel chunk

}  // namespace

template <int C>
LightField<C>::LightField(const Nodes& nodes, const EndAreas& areas)
    : nodes_(nodes), areas_(areas), links_(nodes), light_(nodes, areas, links_), push_down_(nodes) {
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
    links_.grow();
    push_down_.grow();
    for_each_passage([](Passage<C>& p) { p.grow(); });
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
    fill_guide(nodes_, *this, guide);
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
    for_each_passage([](Passage<C>& p) { p.reset(); });
    links_.clear();
    add_links(links, std::vector<std::uint8_t>(nodes_.size(), 1));
}

template <int C>
void LightField<C>::follow() {
    if (unit_) return;
    unit_.emplace(nodes_, areas_, links_);
    unit_->grow();
    light_.remember();
    unit_->remember();
}

template <int C>
void LightField<C>::change_links(const std::vector<Link>& links, const std::vector<std::uint32_t>& ends) {
    if (!unit_ || !light_.known() || links_.mostly_unused()) return set_links(links);
    std::vector<std::uint8_t> wanted(nodes_.size(), 0);
    for (const std::uint32_t n : ends) {
        if (wanted[n]) continue;
        wanted[n] = 1;
        for_each_passage([&](Passage<C>& p) { p.relinked(n); });
        links_.drop(n);
    }
    add_links(links, wanted);
}

template <int C>
void LightField<C>::add_links(const std::vector<Link>& links, const std::vector<std::uint8_t>& wanted) {
    for_each_passage([&](Passage<C>& p) { p.use_ends(links, wanted); });
    links_.add(links, wanted);
}

// Area-weighted means from leaves to roots.
template <int C>
void LightField<C>::pull_instance(std::uint32_t i) {
    const InstanceNodes& in = nodes_.instance(i);
    const auto mean = [&](std::uint32_t id, bool with_irradiance) {
        const Node& n = nodes_[id];
        std::array<double, C> b{}, e{};
        n.for_each_child([&](std::uint32_t child) {
            for (std::size_t c = 0; c < C; ++c) {
                b[c] += nodes_[child].area * double(radiosity_[child * C + c]);
                e[c] += nodes_[child].area * double(irradiance_[child * C + c]);
            }
        });
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
                return std::pow(double(radiosity_[id * C + c]) - double(light_.sent(id)[c]), 2);
            });
        });
    });
    double sum = 0, area = 0;
    for (std::uint32_t i = 0; i < instances; ++i) sum += square[i], area += nodes_[nodes_.root(i)].area;
    return area > 0 ? std::sqrt(sum / area) : 0.0;
}

template <int C>
void LightField<C>::transport(Push what) {
    const bool light = what == Push::Light;
    Passage<C>& p = light || !unit_ ? light_ : *unit_;
    const double tolerance = light ? tolerance_ : unsent_part_;  // of unit radiosity
    reached_ = p.pass(radiosity_, tolerance, links_.tinted() && light);
    parallel_for(nodes_.scene().instances.size(), 1, [&](std::size_t i) {
        reached_[i] = reached_[i] || (light && push_all_);
        if (reached_[i]) push_down_.push(static_cast<std::uint32_t>(i), what, p, irradiance_);
    });
    if (light) push_all_ = false;
}

template <int C>
void LightField<C>::bound_rows() {
    const std::vector<float> radiosity = radiosity_, irradiance = irradiance_;
    std::fill(radiosity_.begin(), radiosity_.end(), 1.0f);
    push_down_.bound();
    if (!unit_) light_.forget();
    transport(Push::BoundRows);
    if (!unit_) light_.forget();
    radiosity_ = radiosity;
    irradiance_ = irradiance;
}

template <int C>
double LightField<C>::close_rows() {
    constexpr float kMost = 2;  // beyond that a leaf is hidden in another part of the shell, not badly sampled
    const std::vector<float> kept = radiosity_;
    std::fill(radiosity_.begin(), radiosity_.end(), 1.0f);
    row_scale_.clear();
    light_.forget();
    transport();
    light_.forget();
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
std::uint64_t LightField<C>::bytes() const {
    return links_.bytes() + light_.bytes() + (unit_ ? unit_->bytes() : 0);
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
