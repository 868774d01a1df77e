#include "solver/output/exposure.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace rro {
namespace {

/// Share of the samples, by weight, that counts as lamps.
constexpr double kBrightest = 0.01;

/// Luminances below this share of the largest are black: what is left of light that a solver's iteration lets fade.
constexpr double kBlack = 1e-6;

}  // namespace

double automatic_exposure(std::span<WeightedLuminance> samples) {
    double largest = 0;
    for (const WeightedLuminance& s : samples) largest = std::max(largest, s.luminance);
    const auto lit_end = std::partition(samples.begin(), samples.end(), [&](const WeightedLuminance& s) {
        return s.luminance > kBlack * largest && s.weight > 0;
    });
    std::sort(samples.begin(), lit_end, [](const WeightedLuminance& a, const WeightedLuminance& b) {
        return a.luminance != b.luminance ? a.luminance < b.luminance : a.weight < b.weight;
    });
    double total = 0;
    for (auto s = samples.begin(); s != lit_end; ++s) total += s->weight;
    double weight = 0, sum = 0;
    for (auto s = samples.begin(); s != lit_end && weight < (1 - kBrightest) * total; ++s) {
        weight += s->weight;
        sum += s->weight * std::log(s->luminance);
    }
    return weight > 0 ? kMiddleGrey / std::exp(sum / weight) : 1.0;
}

double surface_exposure(const Scene& scene, const Solution& solution) {
    std::vector<WeightedLuminance> samples;
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const Instance& instance = scene.instances[i];
        const ObjectData& data = instance.data();
        for (std::size_t f = 0; f < data.faces.size(); ++f)
            samples.push_back({luminance(to_double(solution.instances[i].radiosity[f])),
                               length(area_vector(instance.world_corners(data.faces[f])))});
    }
    return automatic_exposure(samples);
}

}  // namespace rro
