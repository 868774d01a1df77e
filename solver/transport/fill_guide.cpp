#include "solver/transport/fill_guide.h"

#include <algorithm>
#include <cmath>

#include "format/parallel.h"
#include "solver/transport/channels.h"

namespace rro {

namespace {

constexpr std::size_t kGrain = 256;  // nodes per parallel chunk

// Channels count by the square of their light, as in the error: a red face in red light reflects most of it.
template <int C>
float mean_reflectance(const LightField<C>& field, std::uint32_t surface) {
    constexpr double kDark = 1e-60;  // where there is none, all alike
    std::array<double, C> sent, light;
    for (std::size_t c = 0; c < C; ++c) {
        const double rho = double(field.reflectance(surface, c)) + double(field.transmittance(surface, c));
        light[c] = std::pow(double(field.irradiance()[surface * C + c]), 2) + kDark;
        sent[c] = rho * rho * light[c];
    }
    return static_cast<float>(std::sqrt(mean_of(sent) / mean_of(light)));
}

// Upwards: sums over children, which follow their parents. Returns the area of all roots.
double fill_upwards(const Nodes& nodes, Guide& guide) {
    std::vector<double> square(nodes.size(), 0);
    double area = 0;
    for (auto id = static_cast<std::uint32_t>(nodes.size()); id-- > 0;) {
        const Node& n = nodes[id];
        double rho = 0, e = 0, b2 = 0;
        n.for_each_child([&](std::uint32_t child) {
            rho += nodes[child].area * double(guide.reflectance[child]);
            e += nodes[child].area * double(guide.irradiance[child]);
            b2 += square[child];
        });
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
    return area;
}

}  // namespace

template <int C>
void fill_guide(const Nodes& nodes, const LightField<C>& field, Guide& guide) {
    guide.radiosity.assign(nodes.size(), 0);
    guide.irradiance.assign(nodes.size(), 0);
    guide.variation.assign(nodes.size(), 0);
    guide.reflectance.assign(nodes.size(), 0);
    const auto grey = [](const std::vector<float>& v, std::size_t id) {
        return static_cast<float>(std::sqrt(mean_over<C>([&](std::size_t c) { return std::pow(double(v[id * C + c]), 2); })));
    };
    parallel_for(nodes.size(), kGrain, [&](std::size_t id) {
        guide.radiosity[id] = grey(field.radiosity(), id);
        if (nodes[static_cast<std::uint32_t>(id)].kind != NodeKind::Surface) return;
        guide.reflectance[id] = mean_reflectance(field, static_cast<std::uint32_t>(id));
        guide.irradiance[id] = grey(field.irradiance(), id);
    });
    guide.area = fill_upwards(nodes, guide);
    const double norm = field.reflected_norm();
    guide.reflected = guide.area * norm * norm;
}

template void fill_guide(const Nodes&, const LightField<1>&, Guide&);
template void fill_guide(const Nodes&, const LightField<3>&, Guide&);

}  // namespace rro
