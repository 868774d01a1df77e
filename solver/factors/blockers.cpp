#include "solver/factors/blockers.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "format/parallel.h"

namespace rro {
namespace {

constexpr std::uint32_t kLeaf = 4;
constexpr std::size_t kStack = 128;  // deeper than any tree of halves
constexpr std::size_t kFewCorners = 12;  // with more, a hull takes every n-th edge

Box3 box_of(const Polygon& polygon) {
    Box3 box;
    for (const Vec3& c : polygon.corners) box.add(c);
    return box;
}

/// Largest normal . x over a box.
double reach(const Box3& box, const Vec3& n) {
    return n.x * (n.x > 0 ? box.hi.x : box.lo.x) + n.y * (n.y > 0 ? box.hi.y : box.lo.y) +
           n.z * (n.z > 0 ? box.hi.z : box.lo.z);
}

/// Planes through edges of `a` that have all of `b` and of `a` on the inner side.
void add_sides(std::span<const Vec3> a, std::span<const Vec3> b, PairHull& hull) {
    const std::size_t step = a.size() / kFewCorners + 1;
    for (std::size_t k = 0; k < a.size(); k += step) {
        const Vec3& from = a[k];
        const Vec3 edge = a[k + 1 == a.size() ? 0 : k + 1] - from;
        Vec3 normal = cross(edge, b[0] - from);
        for (const Vec3& corner : b)
            if (dot(normal, corner - from) > 0) normal = cross(edge, corner - from);
        const double size = length(normal);
        if (!(size > 0)) continue;
        normal *= 1 / size;
        const double offset = dot(normal, from);
        double beyond = 0;  // where edge and corner are nearly in line, rounding has turned the plane
        for (const Vec3& corner : a) beyond = std::max(beyond, dot(normal, corner) - offset);
        for (const Vec3& corner : b) beyond = std::max(beyond, dot(normal, corner) - offset);
        hull.sides.push_back({normal, offset + beyond});
    }
}

bool outside(const Polygon& body, const PairHull& hull) {
    for (const HullSide& side : hull.sides) {
        double least = std::numeric_limits<double>::infinity();
        for (const Vec3& c : body.corners) least = std::min(least, dot(side.normal, c));
        if (least >= side.offset - body.rounding) return true;
    }
    return false;
}

bool outside(const Box3& box, const PairHull& hull) {
    if (!box.overlaps(hull.box)) return true;
    for (const HullSide& side : hull.sides)
        if (-reach(box, -side.normal) >= side.offset) return true;
    return false;
}

}  // namespace

void make_pair_hull(std::span<const Vec3> a, const HullSide& behind_a, std::span<const Vec3> b, const HullSide& behind_b,
                    PairHull& hull) {
    hull.sides.clear();
    hull.box = {};
    hull.sides.push_back(behind_a);
    hull.sides.push_back(behind_b);
    add_sides(a, b, hull);
    add_sides(b, a, hull);
    for (const Vec3& c : a) hull.box.add(c);
    for (const Vec3& c : b) hull.box.add(c);
}

Blockers::Blockers(const Surfaces& surfaces)
    : bodies_(surfaces.bodies), boxes_(surfaces.bodies.size()) {
    const std::vector<Body>& bodies = bodies_;
    if (bodies.empty()) return;
    parallel_for(bodies.size(), 1024, [&](std::size_t i) { boxes_[i] = box_of(bodies[i].polygon); });
    order_.resize(bodies.size());
    std::iota(order_.begin(), order_.end(), 0u);
    build(0, static_cast<std::uint32_t>(order_.size()));
    // Is any of the scene farther than rounding along this direction?
    const auto reaches = [&](const Vec3& normal, double offset) {
        std::array<std::uint32_t, kStack> stack{0};
        std::size_t waiting = 1;
        while (waiting > 0) {
            const std::uint32_t at = stack[--waiting];
            const Node& node = nodes_[at];
            if (reach(node.box, normal) <= offset) continue;
            if (node.count == 0) {
                stack[waiting++] = node.right;
                stack[waiting++] = at + 1;
                continue;
            }
            for (std::uint32_t k = 0; k < node.count; ++k) {
                const Polygon& other = bodies_[order_[node.first + k]].polygon;
                for (const Vec3& c : other.corners)
                    if (dot(normal, c) > offset + other.rounding) return true;
            }
        }
        return false;
    };
    std::vector<std::uint8_t> blocks(bodies.size(), 0);
    parallel_for(bodies.size(), 64, [&](std::size_t i) {
        const Polygon& body = bodies_[i].polygon;
        blocks[i] = reaches(body.normal, body.offset + body.rounding) &&
                    reaches(-body.normal, -body.offset + body.rounding);
    });
    order_.clear();
    nodes_.clear();
    for (std::uint32_t i = 0; i < bodies.size(); ++i)
        if (blocks[i]) order_.push_back(i);
    if (!order_.empty()) build(0, static_cast<std::uint32_t>(order_.size()));
}

void Blockers::build(std::uint32_t first, std::uint32_t count) {
    const std::size_t at = nodes_.size();
    nodes_.emplace_back();
    Box3 box, centres;
    for (std::uint32_t k = first; k < first + count; ++k) {
        box.add(boxes_[order_[k]]);
        centres.add(boxes_[order_[k]].centre());
    }
    nodes_[at].box = box;
    if (count <= kLeaf) {
        nodes_[at].first = first;
        nodes_[at].count = count;
        return;
    }
    const Vec3 extent = centres.extent();
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    const auto begin = order_.begin() + first;
    std::nth_element(begin, begin + count / 2, begin + count, [&](std::uint32_t a, std::uint32_t b) {
        const double ca = boxes_[a].centre()[axis], cb = boxes_[b].centre()[axis];
        return ca != cb ? ca < cb : a < b;
    });
    build(first, count / 2);
    nodes_[at].right = static_cast<std::uint32_t>(nodes_.size());
    build(first + count / 2, count - count / 2);
}

bool Blockers::reach_into(const PairHull& hull, std::size_t most, bool whole, Between& found) const {
    found.bodies.clear();
    found.solids.clear();
    if (nodes_.empty()) return true;
    std::array<std::uint32_t, kStack> stack{0};
    std::size_t waiting = 1;
    while (waiting > 0) {
        const std::uint32_t at = stack[--waiting];
        const Node& node = nodes_[at];
        if (outside(node.box, hull)) continue;
        if (node.count == 0) {
            stack[waiting++] = node.right;
            stack[waiting++] = at + 1;
            continue;
        }
        for (std::uint32_t k = 0; k < node.count; ++k) {
            const std::uint32_t body = order_[node.first + k], solid = bodies_[body].solid;
            const bool of_solid = whole && solid != kNoSolid;
            if (of_solid && std::find(found.solids.begin(), found.solids.end(), solid) != found.solids.end()) continue;
            if (outside(bodies_[body].polygon, hull)) continue;
            if (found.bodies.size() + found.solids.size() == most) return false;
            if (of_solid)
                found.solids.push_back(solid);
            else
                found.bodies.push_back(body);
        }
    }
    std::sort(found.bodies.begin(), found.bodies.end());
    std::sort(found.solids.begin(), found.solids.end());
    return true;
}

bool Blockers::any_between(const Box3& a, const Box3& b, const std::function<bool(std::uint32_t)>& counts) const {
    if (nodes_.empty()) return false;
    Box3 both = a;
    both.add(b);
    std::array<std::uint32_t, kStack> stack{0};
    std::size_t waiting = 1;
    while (waiting > 0) {
        const std::uint32_t at = stack[--waiting];
        const Node& node = nodes_[at];
        if (!node.box.overlaps(both)) continue;
        if (node.count == 0) {
            stack[waiting++] = node.right;
            stack[waiting++] = at + 1;
            continue;
        }
        for (std::uint32_t k = 0; k < node.count; ++k) {
            const std::uint32_t body = order_[node.first + k];
            if (boxes_[body].overlaps(both) && counts(body)) return true;
        }
    }
    return false;
}

}  // namespace rro
