#include "solver/output/surface_sampler.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace rro {
namespace {

/// Faces with fewer triangles are searched one by one.
constexpr std::uint32_t kSearchAll = 8;

/// Weights of a triangle's corners at a barycentric point of its face.
std::array<double, 3> weights(const std::array<std::array<float, 2>, 3>& corner, double b1, double b2) {
    const auto& [a, b, c] = corner;
    const double ux = double{b[0]} - a[0], uy = double{b[1]} - a[1];
    const double vx = double{c[0]} - a[0], vy = double{c[1]} - a[1];
    const double px = b1 - a[0], py = b2 - a[1];
    const double scale = 1.0 / (ux * vy - uy * vx);
    const double wb = (px * vy - py * vx) * scale, wc = (ux * py - uy * px) * scale;
    return {1.0 - wb - wc, wb, wc};
}

std::uint32_t cell_of(double b, std::uint32_t size) {
    return static_cast<std::uint32_t>(std::clamp(b * size, 0.0, size - 1.0));
}

/// Calls visit(cell) for the cells that a triangle's bounds meet.
template <class Visit>
void for_each_cell(const std::array<std::array<float, 2>, 3>& corner, std::uint32_t size, const Visit& visit) {
    const auto [lo_x, hi_x] = std::minmax({corner[0][0], corner[1][0], corner[2][0]});
    const auto [lo_y, hi_y] = std::minmax({corner[0][1], corner[1][1], corner[2][1]});
    for (std::uint32_t y = cell_of(lo_y, size); y <= cell_of(hi_y, size); ++y)
        for (std::uint32_t x = cell_of(lo_x, size); x <= cell_of(hi_x, size); ++x) visit(y * size + x);
}

}  // namespace

SurfaceSampler::SurfaceSampler(const SurfaceMesh& mesh) : mesh_(mesh), grids_(1), cell_begin_(1, 0) {
    grid_of_face_.assign(mesh.first.size() - 1, 0);
    for (std::uint32_t f = 0; f < grid_of_face_.size(); ++f)
        if (mesh.first[f + 1] - mesh.first[f] > kSearchAll) add_grid(f);
}

void SurfaceSampler::add_grid(std::uint32_t face) {
    const std::uint32_t begin = mesh_.first[face], end = mesh_.first[face + 1];
    const auto size = static_cast<std::uint32_t>(std::ceil(std::sqrt(static_cast<double>(end - begin))));
    grid_of_face_[face] = static_cast<std::uint32_t>(grids_.size());
    const auto first_cell = static_cast<std::uint32_t>(cell_begin_.size() - 1);
    grids_.push_back({size, first_cell});

    std::vector<std::uint32_t> next(std::size_t{size} * size + 1, 0);
    for (std::uint32_t t = begin; t < end; ++t)
        for_each_cell(mesh_.barycentric[t], size, [&](std::uint32_t cell) { ++next[cell + 1]; });
    next[0] = static_cast<std::uint32_t>(listed_.size());
    for (std::size_t c = 1; c < next.size(); ++c) next[c] += next[c - 1];
    cell_begin_.insert(cell_begin_.end(), next.begin() + 1, next.end());
    listed_.resize(next.back());
    for (std::uint32_t t = begin; t < end; ++t)
        for_each_cell(mesh_.barycentric[t], size, [&](std::uint32_t cell) { listed_[next[cell]++] = t; });
}

Vec3 SurfaceSampler::radiosity(std::uint32_t face, double b1, double b2) const {
    std::uint32_t best = mesh_.first[face];
    std::array<double, 3> best_weights{};
    double best_inside = -HUGE_VAL;
    const auto consider = [&](std::uint32_t t) {
        const std::array<double, 3> w = weights(mesh_.barycentric[t], b1, b2);
        const double inside = std::min({w[0], w[1], w[2]});
        if (inside > best_inside) best = t, best_weights = w, best_inside = inside;
        return inside >= 0;
    };
    const Grid& grid = grids_[grid_of_face_[face]];
    if (grid.size == 0) {
        for (std::uint32_t t = mesh_.first[face]; t < mesh_.first[face + 1] && !consider(t);) ++t;
    } else {
        const std::uint32_t cell = grid.first_cell + cell_of(b2, grid.size) * grid.size + cell_of(b1, grid.size);
        for (std::uint32_t i = cell_begin_[cell]; i < cell_begin_[cell + 1] && !consider(listed_[i]);) ++i;
    }
    // A hit on the border may lie outside of every triangle by rounding; weights kept in [0, 1] stay a mean.
    Vec3 sum;
    double total = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const double w = std::max(best_weights[k], 0.0);
        sum += to_double(mesh_.radiosity[mesh_.triangles[best][k]]) * w;
        total += w;
    }
    return total > 0 ? sum / total : to_double(mesh_.radiosity[mesh_.triangles[best][0]]);
}

}  // namespace rro
