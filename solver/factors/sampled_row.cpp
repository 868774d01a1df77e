#include "solver/factors/sampled_row.h"

#include <algorithm>
#include <cmath>

#include "format/parallel.h"
#include "format/sample_points.h"

namespace rro {
namespace {

constexpr std::size_t kReplicates = 32;  // Student's t with 31 degrees of freedom: beyond 3 in 0.5 % of cases
constexpr std::uint32_t kFirstPoints = 1u << 11, kMostPoints = 1u << 20;  // of each replicate
constexpr double kShareOfTolerance = 1.0 / 3;
constexpr double kSmallFactor = 0.01;  // below it the tolerance is absolute
constexpr std::uint64_t kSeed = 0x766965772d666163ull;

/// The group's triangles with their areas summed up, to find the one under a share of the whole.
struct Emitter {
    std::vector<TriangleCorners> corners;
    std::vector<double> sums;
};

Emitter make_emitter(const RayScene& scene, std::uint32_t group) {
    Emitter emitter;
    double sum = 0;
    for (const GroupTriangle& t : scene.surfaces.triangles[group]) {
        emitter.corners.push_back(scene.scene.instances[t.instance].world_corners(t.face));
        sum += length(area_vector(emitter.corners.back()));
        emitter.sums.push_back(sum);
    }
    return emitter;
}

/// The group that a ray from the emitter reaches, or kNoGroup.
std::uint32_t reached(const RayScene& scene, std::uint32_t group, const Emitter& emitter, const std::array<float, 4>& u) {
    const double at = static_cast<double>(u[0]) * emitter.sums.back();
    const auto above = std::upper_bound(emitter.sums.begin(), emitter.sums.end(), at);
    const std::size_t t = std::min<std::size_t>(static_cast<std::size_t>(above - emitter.sums.begin()), emitter.sums.size() - 1);
    const double before = t == 0 ? 0 : emitter.sums[t - 1], area = emitter.sums[t] - before;
    const double first = area > 0 ? std::clamp((at - before) / area, 0.0, 1.0) : 0.5;
    const auto [b1, b2] = square_to_triangle(first, static_cast<double>(u[1]));
    const TriangleCorners& corners = emitter.corners[t];
    const auto [x, y, z] = frame_about(normalised(area_vector(corners)));
    const Vec3 local = square_to_cosine_hemisphere(static_cast<double>(u[2]), static_cast<double>(u[3]));
    const Vec3 direction = x * local.x + y * local.y + z * local.z;
    const GroupTriangle& from = scene.surfaces.triangles[group][t];
    const SceneHit hit =
        scene.rays.first_hit(triangle_point(corners, b1, b2), direction, {from.instance, from.face.triangle()});
    if (hit.instance == kNoInstance) return kNoGroup;
    const Object& object = *scene.scene.instances[hit.instance].object;
    const bool counts = hit.side == Side::Front
                            ? object.front_face[hit.triangle] != kNoFace
                            : scene.sides == Sides::Both && object.back_face[hit.triangle] != kNoFace;
    return counts ? scene.groups.of(scene.scene, hit.instance, hit.triangle) : kNoGroup;
}

using Counts = std::vector<std::uint32_t>;  // [G] hits

void trace(const RayScene& scene, std::uint32_t group, const Emitter& emitter, std::uint32_t begin, std::uint32_t end,
           std::vector<Counts>& counts) {
    parallel_for(kReplicates, 1, [&](std::size_t r) {
        const std::uint64_t seed = mix64(kSeed + group * kReplicates + r);
        for (std::uint32_t i = begin; i < end; ++i)
            if (const std::uint32_t to = reached(scene, group, emitter, sobol4(i, seed)); to != kNoGroup)
                ++counts[r][to];
    });
}

void summarise(const std::vector<Counts>& counts, std::uint32_t points, SampledRow& row) {
    const double replicates = static_cast<double>(kReplicates), per_set = points;
    for (std::size_t g = 0; g < row.factor.size(); ++g) {
        double sum = 0, squares = 0;
        for (const Counts& c : counts) sum += c[g];
        const double mean = sum / replicates;
        for (const Counts& c : counts) squares += (c[g] - mean) * (c[g] - mean);
        // Counts are whole: what is rarer than one hit in all sets, or steadier, they do not tell.
        const double scatter = std::sqrt(squares / (replicates * (replicates - 1)));
        row.factor[g] = mean / per_set;
        row.standard_error[g] = std::max(scatter, 1 / replicates) / per_set;
    }
}

}  // namespace

SampledRow sampled_row(const RayScene& scene, std::uint32_t group, std::span<const std::uint32_t> wanted,
                       double accuracy) {
    const std::size_t groups = scene.surfaces.faces.size();
    SampledRow row{std::vector<double>(groups, 0), std::vector<double>(groups, 0), 0, false};
    const Emitter emitter = make_emitter(scene, group);
    std::vector<Counts> counts(kReplicates, Counts(groups, 0));
    for (std::uint32_t done = 0, points = kFirstPoints; !row.converged && points <= kMostPoints; points *= 2) {
        trace(scene, group, emitter, done, points, counts);
        done = points;
        row.rays = std::uint64_t{points} * kReplicates;
        summarise(counts, points, row);
        row.converged = std::all_of(wanted.begin(), wanted.end(), [&](std::uint32_t g) {
            return row.standard_error[g] <= kShareOfTolerance * accuracy * std::max(row.factor[g], kSmallFactor);
        });
    }
    return row;
}

}  // namespace rro
