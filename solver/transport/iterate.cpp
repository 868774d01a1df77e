#include "solver/transport/iterate.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "format/parallel.h"
#include "solver/transport/channels.h"

namespace rro {

namespace {

// Where a round of refinement shows that errors were larger than estimated, later estimates are raised by up to this.
constexpr double kMostDoubt = 4;

// Where light returns so nearly whole, and the share q of the last change that each sweep brings has settled to this part of
// 1 - q, all changes still to come are added at once: q / (1 - q) times the last one. Changes of less than this part of the
// light are rounding of single precision, which tells nothing of what is to come.
constexpr double kSlow = 0.9, kSettled = 0.1, kRounding = 1e-6;

// After about so many bounces' worth of light, the errors of what is reflected on are of either sign.
constexpr double kAlike = 2.3;

}  // namespace

template <int C>
Residual iterate(LightField<C>& field, double goal, double largest_reflectance, int most) {
    Residual out;
    double last = 0, ratio = 0, q = largest_reflectance, slowest = 0;
    const double most_q = std::clamp(largest_reflectance, 0.9999, 1 - 1e-7);  // single precision tells no more from 1
    int plain = 0;  // sweeps that followed one another
    for (out.sweeps = 1; out.sweeps <= most; ++out.sweeps) {
        const double r = field.sweep();
        const double norm = field.reflected_norm(), before = ratio;
        ratio = last > 0 ? r / last : 0;
        if (++plain >= 3) q = std::clamp(ratio, slowest, most_q);
        last = r;
        out.relative = norm > 0 ? (r + field.unsent()) / ((1 - q) * norm) : 0;
        if (out.relative <= goal) break;
        if (r < field.unsent()) field.leave_unsent(0);
        const bool settled = plain >= 4 && ratio >= kSlow && std::abs(ratio - before) <= kSettled * (1 - q);
        if (!settled || r < kRounding * norm) continue;
        field.advance(q / (1 - q));
        slowest = q;
        plain = 0;
    }
    out.sweeps = std::min(out.sweeps, most);
    return out;
}

double reflected_once(const Nodes& nodes, const std::vector<Rgb>& irradiance) {
    double sum = 0;
    for (std::uint32_t id = 0; id < irradiance.size(); ++id) {
        const Node& n = nodes[id];
        if (n.kind != NodeKind::Surface || n.child_count > 0) continue;
        const Vec3 rho = to_double(nodes.scene().instances[n.instance].reflectance[nodes.patch_of(n)]);
        sum += n.area * length2(hadamard(rho, to_double(irradiance[id]))) / 3;
    }
    return sum;
}

template <int C>
double amplification(const Nodes& nodes, const LightField<C>& field, const OutsideLight& outside) {
    const Scene& scene = nodes.scene();
    double all = 0, emitted = 0;
    if (outside.any())
        for (std::uint32_t id = 0; id < nodes.size(); ++id) {
            if (nodes[id].kind != NodeKind::Surface || nodes[id].child_count > 0) continue;
            const Vec3 e = to_double(outside.irradiance()[id]);
            emitted += nodes[id].area * mean_over<C>([&](std::size_t c) {
                return double(field.reflectance(id, c)) * (c == 0 ? e.x : c == 1 ? e.y : e.z);
            });
        }
    for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
        const InstanceNodes& in = nodes.instance(i);
        for (std::uint32_t f = 0; f < scene.instances[i].data().faces.size(); ++f) {
            const std::uint32_t id = in.first_face + f;
            all += nodes[id].area * mean_over<C>([&](std::size_t c) { return double(field.radiosity()[id * C + c]); });
            emitted += nodes[id].area * mean_over<C>([&](std::size_t c) { return double(field.exitance(id, c)); });
        }
    }
    const double light = emitted > 0 ? std::max(1.0, all / emitted) : 1.0;
    return light > kAlike ? std::sqrt(kAlike * light) : light;
}

template <int C>
Sources sources_of(const Nodes& nodes, const LightField<C>& field) {
    Sources out;
    for (std::uint32_t i = 0; i < nodes.scene().instances.size(); ++i) {
        const InstanceNodes& in = nodes.instance(i);
        for (std::uint32_t f = 0; f < nodes.scene().instances[i].data().faces.size(); ++f) {
            const std::uint32_t id = in.first_face + f;
            for (std::size_t c = 0; c < C; ++c) {
                const double sent_on = double(field.reflectance(id, c)) + double(field.transmittance(id, c));
                out.largest_reflectance = std::max(out.largest_reflectance, sent_on);
            }
            out.emitted += nodes[id].area * mean_over<C>([&](std::size_t c) { return double(field.exitance(id, c)); });
        }
        out.area += nodes[nodes.root(i)].area;
    }
    return out;
}

template <int C>
void HindSight::correct(ErrorEstimate& estimate, const Nodes& nodes, const LightField<C>& field) {
    const Scene& scene = nodes.scene();
    std::vector<float> reflected;
    std::vector<double> change, square;
    std::size_t k = 0;
    for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
        const InstanceNodes& in = nodes.instance(i);
        double moved = 0, all = 0;
        for (std::uint32_t f = 0; f < scene.instances[i].data().faces.size(); ++f) {
            const std::uint32_t id = in.first_face + f;
            std::array<double, C> step{}, light;
            for (std::size_t c = 0; c < C; ++c, ++k) {
                const double r = double(field.reflectance(id, c)) * double(field.irradiance()[id * C + c]);
                reflected.push_back(static_cast<float>(r));
                if (!reflected_.empty()) step[c] = std::pow(r - double(reflected_[k]), 2);
                light[c] = r * r;
            }
            moved += nodes[id].area * mean_of(step);
            all += nodes[id].area * mean_of(light);
        }
        change.push_back(all > 0 ? std::sqrt(moved / all) : 0);
    }
    reflected_ = std::move(reflected);
    const std::vector<double> before = std::exchange(estimate_, estimate.of_instance);
    if (before.empty()) return;
    double sum = 0;
    for (std::size_t i = 0; i < change.size(); ++i) {
        if (before[i] > 0) estimate.of_instance[i] *= std::clamp(change[i] / before[i], 1.0, kMostDoubt);
        sum += estimate.weight[i] * std::pow(estimate.of_instance[i], 2);
    }
    estimate.whole = std::sqrt(sum);
}

namespace {

template <int C>
void store_instance(const Nodes& nodes, const LightField<C>& field, std::uint32_t i, InstanceSolution& out, EnergyBalance& energy) {
    const InstanceNodes& in = nodes.instance(i);
    const auto faces = static_cast<std::uint32_t>(nodes.scene().instances[i].data().faces.size());
    const auto rgb = [](const std::vector<float>& v, std::size_t id) {
        return C == 1 ? Rgb{v[id], v[id], v[id]} : Rgb{v[id * C], v[id * C + 1 % C], v[id * C + 2 % C]};
    };
    out.radiosity.reserve(faces);
    out.irradiance.reserve(faces);
    for (std::uint32_t id = in.first_face; id < in.first_face + faces; ++id) {
        out.radiosity.push_back(rgb(field.radiosity(), id));
        out.irradiance.push_back(rgb(field.irradiance(), id));
        for (std::size_t c = 0; c < 3; ++c) {
            const std::size_t k = C == 1 ? 0 : c;
            const auto ch = static_cast<int>(c);
            const double e = double(field.irradiance()[id * C + k]) * nodes[id].area;
            energy.emitted[ch] += double(field.exitance(id, k)) * nodes[id].area;
            energy.absorbed[ch] += (1 - double(field.reflectance(id, k)) - double(field.transmittance(id, k))) * e;
        }
    }
    for (const std::uint32_t id : in.elements)
        if (nodes[id].child_count == 0)
            out.elements.push_back({nodes.face_of(nodes[id]), nodes.element_corners(id), rgb(field.radiosity(), id),
                                    rgb(field.irradiance(), id)});
    std::stable_sort(out.elements.begin(), out.elements.end(), [](const Element& x, const Element& y) { return x.face < y.face; });
}

}  // namespace

template <int C>
void store_light(const Nodes& nodes, const LightField<C>& field, const std::vector<Rgb>& outside, Solution& solution) {
    const Scene& scene = nodes.scene();
    const std::size_t count = scene.instances.size();
    std::vector<EnergyBalance> energy(count);
    solution.instances.resize(count);
    parallel_for(count, 1, [&](std::size_t i) {
        store_instance(nodes, field, static_cast<std::uint32_t>(i), solution.instances[i], energy[i]);
    });
    for (std::uint32_t i = 0; i < count; ++i) {
        solution.energy.emitted += energy[i].emitted;
        solution.energy.absorbed += energy[i].absorbed;
        const InstanceNodes& in = nodes.instance(i);
        const auto faces = static_cast<std::uint32_t>(scene.instances[i].data().faces.size());
        for (std::uint32_t id = in.first_face; id < in.first_face + faces; ++id)
            if (nodes[id].child_count == 0) ++solution.elements;
        solution.elements += solution.instances[i].elements.size();
    }
    for (std::uint32_t id = 0; id < outside.size(); ++id)
        if (nodes[id].kind == NodeKind::Surface && nodes[id].child_count == 0)
            solution.energy.emitted += to_double(outside[id]) * nodes[id].area;
    solution.energy.escaped = solution.energy.emitted - solution.energy.absorbed;
}

template Residual iterate(LightField<1>&, double, double, int);
template double amplification(const Nodes&, const LightField<1>&, const OutsideLight&);
template Sources sources_of(const Nodes&, const LightField<1>&);
template void HindSight::correct(ErrorEstimate&, const Nodes&, const LightField<1>&);
template void store_light(const Nodes&, const LightField<1>&, const std::vector<Rgb>&, Solution&);
template Residual iterate(LightField<3>&, double, double, int);
template double amplification(const Nodes&, const LightField<3>&, const OutsideLight&);
template Sources sources_of(const Nodes&, const LightField<3>&);
template void HindSight::correct(ErrorEstimate&, const Nodes&, const LightField<3>&);
template void store_light(const Nodes&, const LightField<3>&, const std::vector<Rgb>&, Solution&);

}  // namespace rro
