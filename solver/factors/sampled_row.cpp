#include "solver/factors/sampled_row.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "format/parallel.h"
#include "format/sample_points.h"
#include "solver/factors/view_factors.h"

namespace rro {
namespace {

constexpr std::size_t kReplicates = 32;  // Student's t with 31 degrees of freedom: beyond 3 in 0.5 % of cases
constexpr std::uint32_t kFirstPoints = 1u << 11, kMostPoints = 1u << 20;  // of each replicate
constexpr double kShareOfTolerance = 1.0 / 3;
constexpr std::uint64_t kSeed = 0x766965772d666163ull;

/// A group's triangles with their areas summed up, to find the one under a share of the whole.
struct Emitter {
    std::vector<TriangleCorners> corners;
    std::vector<SceneTriangle> triangles;
    std::vector<double> sums;
};

/// Those that `may_see` (corners) says yes to.
template <class Predicate>
Emitter make_emitter(const RayScene& scene, std::uint32_t group, const Predicate& may_see) {
    Emitter emitter;
    double sum = 0;
    for (const GroupTriangle& t : scene.surfaces.triangles[group]) {
        const TriangleCorners corners = scene.scene.instances[t.instance].world_corners(t.face);
        if (!may_see(corners)) continue;
        sum += length(area_vector(corners));
        emitter.corners.push_back(corners);
        emitter.triangles.push_back({t.instance, t.face.triangle()});
        emitter.sums.push_back(sum);
    }
    return emitter;
}

/// A point of an emitter, by area.
struct EmitterPoint {
    std::size_t triangle = 0;
    Vec3 at, normal;
};

EmitterPoint point_of(const Emitter& emitter, double u, double v) {
    const double at = u * emitter.sums.back();
    const auto above = std::upper_bound(emitter.sums.begin(), emitter.sums.end(), at);
    const std::size_t t = std::min<std::size_t>(static_cast<std::size_t>(above - emitter.sums.begin()), emitter.sums.size() - 1);
    const double before = t == 0 ? 0 : emitter.sums[t - 1], area = emitter.sums[t] - before;
    const double first = area > 0 ? std::clamp((at - before) / area, 0.0, 1.0) : 0.5;
    const auto [b1, b2] = square_to_triangle(first, v);
    const TriangleCorners& corners = emitter.corners[t];
    return {t, triangle_point(corners, b1, b2), normalised(area_vector(corners))};
}

/// The group that a ray from the emitter reaches, or kNoGroup.
std::uint32_t reached(const RayScene& scene, const Emitter& emitter, const std::array<float, 4>& u) {
    const EmitterPoint from = point_of(emitter, static_cast<double>(u[0]), static_cast<double>(u[1]));
    const auto [x, y, z] = frame_about(from.normal);
    const Vec3 local = square_to_cosine_hemisphere(static_cast<double>(u[2]), static_cast<double>(u[3]));
    const Vec3 direction = x * local.x + y * local.y + z * local.z;
    const SceneHit hit = scene.rays.first_hit(from.at, direction, emitter.triangles[from.triangle]);
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
            if (const std::uint32_t to = reached(scene, emitter, sobol4(i, seed)); to != kNoGroup)
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

/// Is some of the box in front of the triangle?
bool may_see(const TriangleCorners& t, const Box3& box) {
    const Vec3 n = area_vector(t), far{n.x > 0 ? box.hi.x : box.lo.x, n.y > 0 ? box.hi.y : box.lo.y, n.z > 0 ? box.hi.z : box.lo.z};
    return dot(n, far - t[0]) > 0;
}

Box3 box_of(const RayScene& scene, std::uint32_t group) {
    Box3 box;
    for (const Polygon& face : scene.surfaces.faces[group])
        for (const Vec3& corner : face.corners) box.add(corner);
    return box;
}

/// cos cos' / (pi r^2) between two points, 0 where something is between; counts the ray.
double seen(const RayScene& scene, const Emitter& from, const EmitterPoint& p, const Emitter& to, const EmitterPoint& q, std::uint64_t& rays) {
    const Vec3 d = q.at - p.at;
    const double there = dot(p.normal, d), back = -dot(q.normal, d), d2 = length2(d);
    if (there <= 0 || back <= 0) return 0;
    ++rays;
    if (scene.rays.occluded(p.at, q.at, from.triangles[p.triangle], to.triangles[q.triangle])) return 0;
    return there * back / (std::numbers::pi * d2 * d2);
}

}  // namespace

SampledRow sampled_row(const RayScene& scene, std::uint32_t group, std::span<const std::uint32_t> wanted,
                       double accuracy) {
    const std::size_t groups = scene.surfaces.faces.size();
    SampledRow row{std::vector<double>(groups, 0), std::vector<double>(groups, 0), 0, false};
    const Emitter emitter = make_emitter(scene, group, [](const TriangleCorners&) { return true; });
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

bool lie_apart(const Box3& a, const Box3& b) {
    double gap2 = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const double gap = std::max({0.0, a.lo[axis] - b.hi[axis], b.lo[axis] - a.hi[axis]});
        gap2 += gap * gap;
    }
    return 4 * gap2 >= std::max(length2(a.extent()), length2(b.extent()));
}

SampledPair sampled_pair(const RayScene& scene, std::uint32_t from, std::uint32_t to, double accuracy) {
    const Box3 box_from = box_of(scene, from), box_to = box_of(scene, to);
    const Emitter a = make_emitter(scene, from, [&](const TriangleCorners& t) { return may_see(t, box_to); });
    const Emitter b = make_emitter(scene, to, [&](const TriangleCorners& t) { return may_see(t, box_from); });
    SampledPair pair;
    if (a.sums.empty() || b.sums.empty()) return pair;
    const double scale = a.sums.back() * b.sums.back() / scene.surfaces.area[from];
    std::vector<double> sums(kReplicates, 0);
    std::vector<std::uint64_t> rays(kReplicates, 0);
    for (std::uint32_t done = 0, points = kFirstPoints; points <= kMostPoints; done = points, points *= 2) {
        parallel_for(kReplicates, 1, [&](std::size_t r) {
            const std::uint64_t seed = mix64(mix64(kSeed + from * kReplicates + r) + to);
            for (std::uint32_t i = done; i < points; ++i) {
                const std::array<float, 4> u = sobol4(i, seed);
                const EmitterPoint p = point_of(a, static_cast<double>(u[0]), static_cast<double>(u[1]));
                sums[r] += seen(scene, a, p, b, point_of(b, static_cast<double>(u[2]), static_cast<double>(u[3])), rays[r]);
            }
        });
        const double n = static_cast<double>(kReplicates), mean = std::accumulate(sums.begin(), sums.end(), 0.0) / n;
        double squares = 0;
        for (const double sum : sums) squares += (sum - mean) * (sum - mean);
        // What no point has met may still be there, up to what one of all points would bring.
        const double unmet = mean > 0 ? 0 : 1 / (n * length2(box_from.centre() - box_to.centre()));
        pair.factor = scale * mean / points;
        pair.standard_error = scale * std::max(std::sqrt(squares / (n * (n - 1))), unmet) / points;
        if (pair.standard_error <= kShareOfTolerance * accuracy * std::max(pair.factor, kSmallFactor)) break;
    }
    pair.rays = std::accumulate(rays.begin(), rays.end(), std::uint64_t{0});
    return pair;
}

}  // namespace rro
