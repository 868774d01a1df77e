#include "solver/visibility/scene_rays.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <optional>

#include "solver/visibility/box_hull.h"
#include "solver/visibility/reciprocals.h"

namespace rro {
namespace {

// A ray's local origin is rounded to float, and Embree's plane distance sums some products of float-rounded
// coordinates: an error of about 2^-24 of the largest coordinate for each. 8 times the float epsilon 2^-23 is safely
// above their sum (an object of 10 m: 10 micrometres).
constexpr double kMargin = 8 * 0x1p-23;

// How far inside its own triangle a ray begins or ends at least. More than kMargin: a wall that meets the triangle at
// its edge is never skipped with the margin, and rounding never carries the point behind it.
constexpr double kClearance = 12 * 0x1p-23;

// Hits nearer than this many margins are decided again in double precision. Across a surface that a ray leaves at a
// grazing angle, float's error in height becomes one in length that is larger by the angle's reciprocal.
constexpr double kNear = 256;

// What double precision cannot tell from a point in the plane, of the largest coordinate.
constexpr double kInPlane = 0x1p-40;

// Instance boxes grow by this share of their largest coordinate, so that a box without thickness is met.
constexpr double kBoxMargin = 1e-7;

// A balanced tree over 2^32 instances is no deeper.
constexpr std::size_t kStack = 64;

constexpr std::size_t kBatch = 64;  // segments taken into local frames at once: four packets

double largest_coordinate(const Vec3& p) {
    return std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)});
}

Box3 enlarged(const Box3& box) {
    const double margin = kBoxMargin * std::max(largest_coordinate(box.lo), largest_coordinate(box.hi));
    return {box.lo - Vec3{margin, margin, margin}, box.hi + Vec3{margin, margin, margin}};
}

// By value, unlike std::min and std::max: these become one instruction each where those become branches that rays
// mispredict. A NaN in b leaves a.
double smaller(double a, double b) { return b < a ? b : a; }
double larger(double a, double b) { return b > a ? b : a; }

/// Where the line origin + t direction, t in [0, t_max], enters the box; nothing where it passes by. A coordinate of
/// the direction may be 0: its reciprocal is infinite, and a NaN never wins a comparison below.
std::optional<double> entry(const Box3& box, const Vec3& origin, const Vec3& reciprocal, double t_max) {
    double near = 0, far = t_max;
    const auto cut = [&](double lo, double hi, double o, double r) {  // the slab of one axis
        const double a = (lo - o) * r, b = (hi - o) * r;
        near = larger(near, smaller(a, b));
        far = smaller(far, larger(a, b));
    };
    cut(box.lo.x, box.hi.x, origin.x, reciprocal.x);
    cut(box.lo.y, box.hi.y, origin.y, reciprocal.y);
    cut(box.lo.z, box.hi.z, origin.z, reciprocal.z);
    if (near > far) return std::nullopt;
    return near;
}

/// The part of p + t (q - p) that counts as the open segment, in an object's frame: a margin is left out at both ends.
ObjectRay local_segment(const Affine3& to_local, double coordinates, const Vec3& p, const Vec3& q) {
    const Vec3 a = to_local.point(p), b = to_local.point(q);
    const Vec3 d = b - a;
    const double size = std::max({coordinates, largest_coordinate(a), largest_coordinate(b)});
    const double margin = kMargin * size / length(d);
    if (!(margin < 0.5)) return {to_float(a), to_float(d), 1, 0};  // too short for rays; Embree skips t_min > t_max
    return {to_float(a), to_float(d), static_cast<float>(margin), static_cast<float>(1 - margin)};
}

}  // namespace

/// Draws points of a triangle towards its centroid, by the share that keeps them kClearance from its edges.
struct SceneRays::Shrink {
    Vec3 centroid;
    double share = 0;

    Vec3 operator()(const Vec3& p) const { return p + (centroid - p) * share; }
};

SceneRays::Shrink SceneRays::shrink(const SceneTriangle& on) const {
    if (on.instance == kNoInstance) return {};
    const Place& place = places_[on.instance];
    const TriangleIndices& t = place.triangles[on.triangle];
    const Vec3 a = to_double(place.positions[t[0]]), b = to_double(place.positions[t[1]]),
               c = to_double(place.positions[t[2]]);
    const double longest2 = std::max({length2(b - a), length2(c - b), length2(a - c)});
    // The centroid is a third of the shortest altitude away from the nearest edge.
    const double share = kClearance * place.coordinates * 3 * std::sqrt(longest2 / length2(cross(b - a, c - a)));
    return {place.to_world.point((a + b + c) / 3), std::min(0.5, share)};
}

struct SceneRays::LocalHit {
    std::uint32_t triangle = kNoTriangle;
    Side side = Side::Front;
    double t = 0, b1 = 0, b2 = 0;
};

SceneRays::SceneRays(const Scene& scene) : scene_(scene) {
    for (const Instance& instance : scene.instances) {
        assert(instance.object->rays);
        const ObjectData& data = instance.data();
        const Affine3 from_origin{Mat3{}, data.origin}, to_origin{Mat3{}, -data.origin};
        Place place{to_origin * instance.to_local,
                    instance.to_world * from_origin,
                    0,
                    instance.object->rays.get(),
                    data.positions,
                    data.triangles};
        for (const Vec3f& p : data.positions)
            place.coordinates = std::max(place.coordinates, largest_coordinate(to_double(p)));
        order_.push_back(static_cast<std::uint32_t>(places_.size()));
        places_.push_back(place);
    }
    if (!order_.empty()) build(0, static_cast<std::uint32_t>(order_.size()));
}

/// Appends the tree over order_[first .. first + count): halves by the centres along the widest axis; equal centres
/// stay in manifest order.
void SceneRays::build(std::uint32_t first, std::uint32_t count) {
    const std::size_t self = nodes_.size();
    nodes_.emplace_back();
    Box3 box, centres;
    for (std::uint32_t i = first; i < first + count; ++i) {
        const Box3& bounds = scene_.instances[order_[i]].bounds;
        box.add(enlarged(bounds));
        centres.add(bounds.centre());
    }
    nodes_[self].box = box;
    if (count == 1) {
        nodes_[self].first = first, nodes_[self].count = 1;
        return;
    }
    const Vec3 extent = centres.extent();
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    std::sort(order_.begin() + first, order_.begin() + first + count, [&](std::uint32_t a, std::uint32_t b) {
        const double ca = scene_.instances[a].bounds.centre()[axis], cb = scene_.instances[b].bounds.centre()[axis];
        return ca != cb ? ca < cb : a < b;
    });
    build(first, count / 2);
    nodes_[self].right = static_cast<std::uint32_t>(nodes_.size());
    build(first + count / 2, count - count / 2);
}

/// The nearest hit in one object, t in (0, t_max].
///
/// Float rounding may put the start before or behind a surface that it touches. So the ray starts a margin early, and
/// hits so close to the start that rounding may have made or moved them are decided again in double precision:
/// neighbours in the start's own plane do not block.
SceneRays::LocalHit SceneRays::hit_in(const Place& place, const Vec3& origin, const Vec3& direction, double t_max,
                                      std::uint32_t ignored) {
    const Vec3 o = place.to_local.point(origin), d = place.to_local.vector(direction);
    assert(length(d) > 0);
    const double size = std::max(place.coordinates, largest_coordinate(o));
    const double margin = kMargin * size / length(d);
    ObjectRay ray{to_float(o - d * margin), to_float(d), 0, std::numeric_limits<float>::infinity()};
    // Rounded up, so that a hit as near as the nearest so far is found and the lower instance can win.
    if (t_max < std::numeric_limits<double>::infinity())
        ray.t_max = std::nextafter(static_cast<float>(t_max + margin), std::numeric_limits<float>::infinity());
    IgnoredTriangles ignore;
    ignore.a = ignored;
    for (;;) {
        const ObjectHit hit = place.rays->first_hit(ray, ignore);
        if (hit.triangle == kNoTriangle) return {};
        const TriangleIndices& t = place.triangles[hit.triangle];
        const Vec3 a = to_double(place.positions[t[0]]);
        const Vec3 e1 = to_double(place.positions[t[1]]) - a, e2 = to_double(place.positions[t[2]]) - a;
        const Vec3 n = cross(e1, e2);
        const double slope = dot(n, d);
        LocalHit found{hit.triangle, slope < 0 ? Side::Front : Side::Back, hit.t - margin, 0, 0};
        found.b1 = std::clamp<double>(hit.u, 0, 1);
        found.b2 = std::clamp<double>(hit.v, 0, 1 - found.b1);
        if (found.t > kNear * margin) return found;
        const double height = dot(n, a - o);  // of the plane above the start, in lengths of n along n
        if (slope != 0 && std::abs(height) > kInPlane * size * length(n) && height / slope > 0) {
            found.t = height / slope;
            const Vec3 q = o + d * found.t - a;  // inside the triangle, or float saw an edge that the ray passes
            const double n2 = dot(n, n), u = dot(cross(q, e2), n) / n2, v = dot(cross(e1, q), n) / n2;
            if (std::min({u, v, 1 - u - v}) >= -kInPlane) return found;
        }
        ray.t_min = std::nextafter(hit.t, std::numeric_limits<float>::infinity());
    }
}

SceneHit SceneRays::first_hit(const Vec3& start, const Vec3& direction, const SceneTriangle& ignored) const {
    const Vec3 origin = shrink(ignored)(start);
    SceneHit best;
    best.t = std::numeric_limits<double>::infinity();
    const auto visit = [&](std::uint32_t instance) {
        const std::uint32_t ignore = ignored.instance == instance ? ignored.triangle : kNoTriangle;
        const LocalHit hit = hit_in(places_[instance], origin, direction, best.t, ignore);
        if (hit.triangle == kNoTriangle) return;
        if (hit.t < best.t || (hit.t == best.t && instance < best.instance))
            best = {instance, hit.triangle, hit.side, hit.t, hit.b1, hit.b2};
    };
    const Vec3 reciprocal = reciprocals(direction);
    struct Waiting {
        std::uint32_t node;
        double entry;
    };
    std::array<Waiting, kStack> stack;
    std::size_t waiting = 0;
    const auto push = [&](std::uint32_t node, const std::optional<double>& at) {
        if (at) stack[waiting++] = {node, *at};
    };
    if (!nodes_.empty()) push(0, entry(nodes_[0].box, origin, reciprocal, best.t));
    while (waiting > 0) {
        const Waiting next = stack[--waiting];
        if (next.entry > best.t) continue;
        const Node& node = nodes_[next.node];
        if (node.count > 0) {
            visit(order_[node.first]);
            continue;
        }
        const std::uint32_t left = next.node + 1, right = node.right;
        const auto at_left = entry(nodes_[left].box, origin, reciprocal, best.t);
        const auto at_right = entry(nodes_[right].box, origin, reciprocal, best.t);
        const bool left_first = at_left && (!at_right || *at_left <= *at_right);
        push(left_first ? right : left, left_first ? at_right : at_left);
        push(left_first ? left : right, left_first ? at_left : at_right);
    }
    return best.instance == kNoInstance ? SceneHit{} : best;
}

bool SceneRays::candidates(const Box3& a, const Box3& b, Candidates& out, std::size_t most) const {
    out.clear();
    if (nodes_.empty()) return true;
    const BoxHull hull(a, b);
    std::array<std::uint32_t, kStack> stack;
    std::size_t waiting = 0;
    stack[waiting++] = 0;
    while (waiting > 0) {
        const std::uint32_t at = stack[--waiting];
        const Node& node = nodes_[at];
        if (hull.misses(node.box)) continue;
        if (node.count > 0) {
            if (out.size() == most) return false;
            out.push_back(order_[node.first]);
        } else {
            stack[waiting++] = node.right;
            stack[waiting++] = at + 1;
        }
    }
    std::sort(out.begin(), out.end());
    return true;
}

bool SceneRays::occluded_by(std::uint32_t instance, const Vec3& p, const Vec3& q, const SceneTriangle& p_on,
                            const SceneTriangle& q_on) const {
    const Place& place = places_[instance];
    IgnoredTriangles ignore;
    if (p_on.instance == instance) ignore.a = p_on.triangle;
    if (q_on.instance == instance) ignore.b = q_on.triangle;
    return place.rays->occluded(local_segment(place.to_local, place.coordinates, p, q), ignore);
}

bool SceneRays::occluded(const Vec3& from, const Vec3& to, const SceneTriangle& p_on, const SceneTriangle& q_on,
                         std::span<const std::uint32_t> candidates) const {
    const Vec3 p = shrink(p_on)(from), q = shrink(q_on)(to);
    return std::any_of(candidates.begin(), candidates.end(),
                       [&](std::uint32_t instance) { return occluded_by(instance, p, q, p_on, q_on); });
}

bool SceneRays::occluded(const Vec3& from, const Vec3& to, const SceneTriangle& p_on, const SceneTriangle& q_on,
                         const std::array<std::uint32_t, 2>& passed) const {
    if (nodes_.empty()) return false;
    const Vec3 p = shrink(p_on)(from), q = shrink(q_on)(to);
    const Vec3 reciprocal = reciprocals(q - p);
    std::array<std::uint32_t, kStack> stack;
    std::size_t waiting = 0;
    stack[waiting++] = 0;
    while (waiting > 0) {
        const std::uint32_t at = stack[--waiting];
        const Node& node = nodes_[at];
        if (!entry(node.box, p, reciprocal, 1)) continue;
        if (node.count > 0) {
            const std::uint32_t instance = order_[node.first];
            if (instance == passed[0] || instance == passed[1]) continue;
            if (occluded_by(instance, p, q, p_on, q_on)) return true;
        } else {
            stack[waiting++] = node.right;
            stack[waiting++] = at + 1;
        }
    }
    return false;
}

void SceneRays::occluded(std::span<const Vec3> p, std::span<const Vec3> q, const SceneTriangle& p_on,
                         const SceneTriangle& q_on, std::span<const std::uint32_t> candidates,
                         std::span<std::uint8_t> blocked) const {
    assert(p.size() == q.size() && p.size() == blocked.size());
    std::fill(blocked.begin(), blocked.end(), std::uint8_t{0});
    const Shrink shrink_p = shrink(p_on), shrink_q = shrink(q_on);
    std::array<ObjectRay, kBatch> rays;
    for (std::size_t first = 0; first < p.size(); first += kBatch) {
        const std::size_t count = std::min(kBatch, p.size() - first);
        const std::span<std::uint8_t> part = blocked.subspan(first, count);
        for (const std::uint32_t instance : candidates) {
            const Place& place = places_[instance];
            IgnoredTriangles ignore;
            if (p_on.instance == instance) ignore.a = p_on.triangle;
            if (q_on.instance == instance) ignore.b = q_on.triangle;
            for (std::size_t i = 0; i < count; ++i)
                if (!part[i])
                    rays[i] = local_segment(place.to_local, place.coordinates, shrink_p(p[first + i]),
                                            shrink_q(q[first + i]));
            place.rays->occluded(std::span(rays).first(count), part, ignore);
        }
    }
}

}  // namespace rro
