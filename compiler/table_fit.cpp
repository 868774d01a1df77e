#include "compiler/table_fit.h"

#include <cassert>

namespace rro {
namespace {

constexpr int kSteps = 8;  // each takes about half of what is left; eight leave less than 8-bit tables round away
// A node is told by some nine samples; the prior counts like a hundredth of one, which decides only where there are none.
constexpr float kPriorWeight = 0.01f;

float interpolated(const DirectionTaps& taps, std::span<const float> nodes) {
    float sum = 0;
    for (std::size_t i = 0; i < 4; ++i) sum += taps.weight[i] * nodes[taps.node[i]];
    return sum;
}

void spread(const DirectionTaps& taps, float value, std::span<float> nodes) {
    for (std::size_t i = 0; i < 4; ++i) nodes[taps.node[i]] += taps.weight[i] * value;
}

double product(std::span<const float> a, std::span<const float> b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += static_cast<double>(a[i]) * static_cast<double>(b[i]);
    return sum;
}

}  // namespace

TableFit::TableFit(const DirectionGrid& grid, std::span<const Vec3> directions) : nodes_(grid.size()) {
    taps_.reserve(directions.size());
    for (const Vec3& w : directions) taps_.push_back(grid.taps(w));
}

void TableFit::fit(std::span<const float> samples, std::span<const float> weights, std::span<float> nodes) const {
    assert(samples.size() == taps_.size() && weights.size() == taps_.size() && nodes.size() == nodes_);
    float prior = 0;
    for (const float w : weights) prior += w;
    prior *= kPriorWeight / static_cast<float>(taps_.size());
    if (prior <= 0) return;
    // Normal equations (A^T W A + prior) x = A^T W r for the change x of the nodes, preconditioned by their diagonal.
    std::vector<float> change(nodes_, 0), residual(nodes_, 0), scaled(nodes_), step(nodes_), applied(nodes_), diagonal(nodes_, prior);
    for (std::size_t m = 0; m < taps_.size(); ++m) {
        spread(taps_[m], weights[m] * (samples[m] - interpolated(taps_[m], nodes)), residual);
        for (std::size_t i = 0; i < 4; ++i) diagonal[taps_[m].node[i]] += weights[m] * taps_[m].weight[i] * taps_[m].weight[i];
    }
    for (std::size_t k = 0; k < nodes_; ++k) scaled[k] = step[k] = residual[k] / diagonal[k];
    double length = product(residual, scaled);
    for (int iteration = 0; iteration < kSteps && length > 0; ++iteration) {
        for (std::size_t k = 0; k < nodes_; ++k) applied[k] = prior * step[k];
        for (std::size_t m = 0; m < taps_.size(); ++m) spread(taps_[m], weights[m] * interpolated(taps_[m], step), applied);
        const double curvature = product(step, applied);
        if (!(curvature > 0)) break;
        const auto alpha = static_cast<float>(length / curvature);
        for (std::size_t k = 0; k < nodes_; ++k) {
            change[k] += alpha * step[k];
            residual[k] -= alpha * applied[k];
            scaled[k] = residual[k] / diagonal[k];
        }
        const double next = product(residual, scaled);
        const auto beta = static_cast<float>(next / length);
        for (std::size_t k = 0; k < nodes_; ++k) step[k] = scaled[k] + beta * step[k];
        length = next;
    }
    for (std::size_t k = 0; k < nodes_; ++k) nodes[k] += change[k];
}

}  // namespace rro
