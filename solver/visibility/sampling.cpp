#include "solver/visibility/sampling.h"

#include <algorithm>
#include <cmath>

#include "format/sample_points.h"

namespace rro {
namespace {

constexpr std::uint32_t kFirstLinkRays = 4, kMostLinkRays = 256, kAgreeingRays = 16;
// Where all rays agree there is mostly no edge at all: what Laplace's rule allows for it counts by this part.
constexpr double kUnseenEdge = 0.1;
// An edge that is this many times too strong divides the link without further rays.
constexpr double kClearEdge = 4;

// What hit probabilities say of single lines errs together for neighbouring ones: this part of their own deviation stays
// in the mean (fitted to visibility_bench).
constexpr double kProbabilityBias = 0.35;

// Rays that agree beside a shadow's edge: after so many it is believed to end between the shafts.
constexpr std::uint32_t kConvincingRays = 25;

double gain(const Demand& demand) { return demand.points == LinePoints::Sobol ? kSobolGain : 1.0; }

double laplace(const Tally& t) { return (t.passed + 1) / (t.rays + 2.0); }

}  // namespace

Demand link_demand(double noise, double edge) {
    Demand d;
    d.rule = StopRule::Edge;
    d.deviation = 1 / std::sqrt(std::max(noise, 1e-300));
    d.first = kFirstLinkRays;
    d.most = kMostLinkRays;
    d.edge = edge;
    return d;
}

double Transmittance::error() const { return std::sqrt(variance + bias * bias); }

std::array<float, 4> line_point(LinePoints points, std::uint32_t index, std::uint64_t seed) {
    if (points == LinePoints::Sobol) return sobol4(index, seed);
    constexpr float kScale = 0x1p-24f;
    const std::uint64_t low = mix64(seed ^ mix64(index)), high = mix64(low);
    const auto unit = [](std::uint64_t bits) { return static_cast<float>(bits & 0xffffff) * kScale; };
    return {unit(low), unit(low >> 32), unit(high), unit(high >> 32)};
}

std::uint32_t next_round(const Demand& demand, std::uint32_t drawn) {
    if (demand.rule == StopRule::Fixed) return demand.most;
    if (drawn == 0) return std::min(demand.first, demand.most);
    if (demand.rule == StopRule::Edge) return std::max(drawn, std::min(2 * drawn, demand.most));
    const auto root = static_cast<std::uint32_t>(std::lround(std::sqrt(drawn)));
    return std::max(drawn, std::min((root + 1) * (root + 1), demand.most));
}

bool suffices(const Demand& demand, const Tally& tally) {
    const double m = std::max<double>(1, tally.rays), v = laplace(tally), mean = tally.passed / m;
    switch (demand.rule) {
        case StopRule::Fixed: return true;
        case StopRule::Paper: return std::sqrt(mean * (1 - mean) / m) < demand.deviation;
        case StopRule::Laplace: return std::sqrt(v * (1 - v) / m) < demand.deviation;
        case StopRule::Edge: break;
    }
    const bool agree = tally.unanimous();
    if (!agree && demand.edge * v * (1 - v) > kClearEdge) return true;
    const double quiet = gain(demand) * gain(demand) * v * (1 - v) / m;
    return quiet <= demand.deviation * demand.deviation &&
           (!agree || tally.rays >= kAgreeingRays || demand.edge * std::sqrt(kUnseenEdge * v * (1 - v)) <= 1);
}

Transmittance outcome(const Demand& demand, const Tally& tally) {
    Transmittance t;
    t.rays = tally.rays;
    t.mean = tally.weight > 0 ? tally.open / tally.weight : 0.0;  // 0: no pair of points faces one another
    // Laplace's rule has no certainty at 0 or 1: rays that agree may have missed an edge.
    const double m = std::max<double>(1, tally.rays), v = laplace(tally);
    t.variance = gain(demand) * gain(demand) * v * (1 - v) / m;
    t.bias = kProbabilityBias * std::sqrt(tally.undecided / m);
    t.edge = !tally.unanimous();
    t.spread = v * (1 - v) * (t.edge ? 1.0 : kUnseenEdge);
    return t;
}

std::vector<std::uint32_t> doubtful(std::span<const Tally> tallies, Neighbours neighbours) {
    std::vector<std::uint32_t> out;
    for (std::uint32_t i = 0; i < tallies.size(); ++i) {
        if (!tallies[i].unanimous() || tallies[i].drawn >= kConvincingRays) continue;
        const auto differs = [&](std::uint32_t n) {
            return !tallies[n].unanimous() || (tallies[n].passed > 0) != (tallies[i].passed > 0);
        };
        if (std::any_of(neighbours[i].begin(), neighbours[i].end(), differs)) out.push_back(i);
    }
    return out;
}

}  // namespace rro
