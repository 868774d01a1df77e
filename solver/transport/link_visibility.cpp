// How much of a pair's light gets past everything else: the pair as a shaft, whose lines join points of faces that look at one
// another.
#include <bit>
#include <functional>

#include "format/sample_points.h"
#include "solver/transport/link.h"
#include "solver/visibility/clearance.h"

namespace rro {

namespace {

// A point on an end of a link, on a face that looks towards `towards` where there is one.
struct EndPoint {
    Vec3 position, normal;
    SceneTriangle on;
};

// The member of a running sum that a share of the sum in [range[0], range[1]) falls to, and the share left within it.
struct Drawn {
    std::uint32_t member;
    double rest;
};

Drawn draw(const std::vector<double>& sum, const std::array<std::uint32_t, 2>& range, double u) {
    const double target = sum[range[0]] + u * (sum[range[1]] - sum[range[0]]);
    auto m = static_cast<std::uint32_t>(std::upper_bound(sum.begin() + range[0] + 1, sum.begin() + range[1], target) -
                                        sum.begin() - 1);
    m = std::min(m, range[1] - 1);
    const double width = sum[m + 1] - sum[m];
    return {m, width > 0 ? std::clamp((target - sum[m]) / width, 0.0, 1.0) : 0.5};
}

EndPoint end_point(const Nodes& nodes, const EndAreas& areas, std::uint32_t id, const Vec3& towards, double u, double v) {
    const Node& node = nodes[id];
    const auto on = [&](std::uint32_t surface, double s) {
        const Node& n = nodes[surface];
        const auto b = square_to_triangle(s, v);
        return EndPoint{triangle_point(nodes.corners(surface), b[0], b[1]), n.normal(), {n.instance, nodes.triangle_of(n)}};
    };
    if (node.kind == NodeKind::Surface) return on(id, u);

    constexpr int kTries = 8;  // a closed body shows half its faces; after eight draws one in 256 samples looks away
    constexpr double kGolden = 0.6180339887498949;
    for (int attempt = 0;; ++attempt) {
        std::uint32_t instance = node.instance;
        std::array<std::uint32_t, 2> range;
        double s = u;
        if (node.group()) {
            const Group& group = nodes.groups().groups[id];
            const Drawn member = draw(nodes.member_area_sum(), {group.first, group.first + group.count}, u);
            instance = nodes.groups().members[member.member];
            range = nodes.faces(nodes[nodes.root(instance)]);
            s = member.rest;
        } else {
            range = nodes.faces(node);
        }
        const Drawn face = draw(areas.tables(instance).face_area_sum, range, s);
        const std::uint32_t surface = nodes.instance(instance).first_face + face.member;
        if (attempt == kTries || dot(nodes[surface].normal(), towards - nodes[surface].centre) > 0)
            return on(surface, face.rest);
        u = u + kGolden < 1 ? u + kGolden : u + kGolden - 1;
    }
}

// Faces nearer than this many of their radii together.
constexpr double kNearFaces = 2;

// Rays whose agreement a proof is worth.
constexpr std::uint32_t kAgreed = 16;

/// Root mean square distance of an end's points from its centre, m.
double deviation(const ShaftEnd& end) {
    return std::sqrt(length2(end.spread[0]) + length2(end.spread[1]) + length2(end.spread[2]));
}

}  // namespace

VisibilityMethod link_method(VisibilityMethod asked) { return asked == VisibilityMethod::Auto ? VisibilityMethod::Rays : asked; }

std::uint64_t LinkBuilder::sample_key(std::uint32_t id) const {
    const Node& n = nodes_[id];
    if (n.group()) return group_key_[id];
    if (n.kind != NodeKind::Surface)
        return mix64(instance_key_[n.instance] ^ (std::uint64_t(n.kind) << 40 | (id - nodes_.root(n.instance))));
    if (n.depth == 0) return mix64(instance_key_[n.instance] ^ (std::uint64_t(n.kind) << 40 | n.index));
    std::uint64_t k = mix64(instance_key_[n.instance] ^ nodes_.face_of(n));
    for (const auto& corner : nodes_.element_corners(id))
        k = mix64(k ^ (std::uint64_t(std::bit_cast<std::uint32_t>(corner[0])) << 32 |
                       std::bit_cast<std::uint32_t>(corner[1])));
    return k;
}

Transmittance LinkBuilder::transmittance(const Offer& o, double noise, double edge) const {
    std::uint32_t a = o.a, b = o.b;
    EndMode mode_a = o.mode_a, mode_b = o.mode_b;
    // The pair is sampled the same way whichever end is named first and wherever the instance stands in the manifest.
    std::uint64_t key_a = sample_key(a), key_b = sample_key(b);
    if (key_a > key_b) {
        std::swap(a, b);
        std::swap(mode_a, mode_b);
        std::swap(key_a, key_b);
    }
    const Node &na = nodes_[a], &nb = nodes_[b];
    // An end's own object is in its table, or known, or cannot come between the end and anything in front of it.
    const auto passed = [&](const Node& n, EndMode mode, std::uint32_t i) {
        const bool cleared = o.own >= 0 || mode == EndMode::Outside || nodes_.instance(i).planar ||
                             (nodes_.scene().instances[i].data().meta.convex && n.kind == NodeKind::Surface);
        return cleared ? i : kNoInstance;
    };
    Shaft shaft;
    shaft.crowd = na.group() || nb.group();
    if (!shaft.crowd) shaft.passed = {passed(na, mode_a, na.instance), passed(nb, mode_b, nb.instance)};
    shaft.a = shaft_end(a);
    shaft.b = shaft_end(b);
    shaft.seed = mix64(key_a ^ mix64(key_b ^ options_.seed));
    const double nearest = std::max(0.25 * double(na.radius + nb.radius), 1e-3 * length(nb.centre - na.centre));
    // Of two faces as near as this, the points of the larger are spread by the solid angle they fill from those of the smaller:
    // few of them would lie near enough otherwise to say what is between.
    const bool near = na.kind == NodeKind::Surface && nb.kind == NodeKind::Surface &&
                      length(nb.centre - na.centre) < kNearFaces * double(na.radius + nb.radius);
    const bool from_a = na.area <= nb.area;
    const auto near_segment = [&](const std::array<float, 4>& s) {
        const std::uint32_t from = from_a ? a : b, to = from_a ? b : a;
        const EndPoint p = end_point(nodes_, areas_, from, {}, double(s[0]), double(s[1]));
        const SeenTriangle seen(p.position, nodes_.corners(to));
        const Node& n = nodes_[to];
        EndPoint q{n.centre, n.normal(), {n.instance, nodes_.triangle_of(n)}};
        double weight = 0;
        if (seen.solid_angle() > 0) {
            q.position = seen.point(double(s[2]), double(s[3]));
            const Vec3 w = q.position - p.position;
            weight = seen.solid_angle() * std::max(0.0, dot(p.normal, w)) / std::max(length(w), 1e-300);
        }
        const EndPoint &at_a = from_a ? p : q, &at_b = from_a ? q : p;
        return Segment{at_a.position, at_b.position, at_a.on, at_b.on, weight,
                       {passed(na, mode_a, at_a.on.instance), passed(nb, mode_b, at_b.on.instance)}};
    };
    const auto segment = [&](const std::array<float, 4>& s) {
        if (near) return near_segment(s);
        const EndPoint p = end_point(nodes_, areas_, a, nb.centre, double(s[0]), double(s[1]));
        const EndPoint q = end_point(nodes_, areas_, b, na.centre, double(s[2]), double(s[3]));
        const Vec3 w = q.position - p.position;
        const double d2 = length2(w);
        const double weight = std::max(0.0, dot(p.normal, w)) * std::max(0.0, -dot(q.normal, w)) /
                              std::max(d2, 1e-300) / std::max(d2, nearest * nearest);
        return Segment{p.position, q.position, p.on, q.on, weight,
                       {passed(na, mode_a, p.on.instance), passed(nb, mode_b, q.on.instance)}};
    };
    shaft.segment = std::cref(segment);
    const Demand demand = link_demand(noise, edge);
    Transmittance t = visibility_.transmittance(shaft, demand);
    if (t.proven) {
        // The error model of links was fitted with what Laplace's rule leaves to rays that agree: a share of it stands for
        // errors of other kinds at the same ends.
        const Transmittance agreeing = outcome(demand, {kAgreed, kAgreed, kAgreed, 1, 1, 0});
        t.variance = agreeing.variance;
        t.spread = agreeing.spread;
    }
    if (t.bias > 0) {
        // Silhouettes and tables count all lines of a shaft alike; lines of nearer points bring more light.
        const double uneven = 2 * (deviation(shaft.a) + deviation(shaft.b)) / length(shaft.b.centre - shaft.a.centre);
        t.variance += t.bias * t.bias + t.mean * (1 - t.mean) * uneven * uneven;
    }
    if (o.own >= 0) {
        t.mean *= o.own;
        t.spread += o.own * (1 - o.own);
    }
    return t;
}

bool LinkBuilder::clears(std::uint32_t a, std::uint32_t b, const Instance& instance) const {
    Shaft shaft;
    shaft.a = shaft_end(a);
    shaft.b = shaft_end(b);
    return certainly_clear(shaft, instance);
}

// Faces have their own shape and side; of clusters and groups only the box is known.
ShaftEnd LinkBuilder::shaft_end(std::uint32_t id) const {
    const Node& n = nodes_[id];
    ShaftEnd end{n.box, n.centre, {}, {}, 0};
    if (visibility_.looks_at_spread()) end.spread = (n.planar() ? triangle_end(nodes_.corners(id)) : box_end(n.box)).spread;
    if (n.planar()) {
        end.front = n.normal();
        end.height = dot(end.front, n.centre);
    }
    return end;
}

}  // namespace rro
