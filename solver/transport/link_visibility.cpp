// How much of a pair's light gets past everything else: rays between points of both ends.
#include <bit>
#include <tuple>

#include "format/sample_points.h"
#include "solver/transport/link.h"

namespace rro {

namespace {

// Shafts with more candidates than this are not listed.
constexpr std::size_t kMostCandidates = 64;

constexpr std::uint32_t kFirstRays = 4, kMostRays = 256, kAgreeingRays = 16;

// Where all rays agree there is mostly no edge at all: what Laplace's rule allows for it counts by this part.
constexpr double kUnseenEdge = 0.1;
// An edge that is this many times too strong divides the link without further rays.
constexpr double kClearEdge = 4;

// Owen-scrambled points halve the deviation of independent ones at these counts (measured for penumbrae).
constexpr double kSobolGain = 0.6;

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

}  // namespace

std::uint64_t LinkBuilder::sample_key(std::uint32_t id) const {
    const Node& n = nodes_[id];
    if (n.group()) return group_key_[id];
    if (n.kind != NodeKind::Surface || n.depth == 0)
        return mix64(instance_key_[n.instance] ^ (std::uint64_t(n.kind) << 40 | n.index));
    std::uint64_t k = mix64(instance_key_[n.instance] ^ nodes_.face_of(n));
    for (const auto& corner : nodes_.element_corners(id))
        k = mix64(k ^ (std::uint64_t(std::bit_cast<std::uint32_t>(corner[0])) << 32 |
                       std::bit_cast<std::uint32_t>(corner[1])));
    return k;
}

LinkBuilder::Transmittance LinkBuilder::transmittance(const Offer& o, double noise, double edge) const {
    auto [a, b, mode_a, mode_b] = std::tuple(o.a, o.b, o.mode_a, o.mode_b);
    const double own = o.own;
    Transmittance t;
    if (own >= 0) {
        t.mean = own;
        t.spread = own * (1 - own);
    }
    if (options_.visibility == TransportOptions::Visibility::None) return t;
    // The pair is sampled the same way whichever end is named first and wherever the instance stands in the manifest.
    std::uint64_t key_a = sample_key(a), key_b = sample_key(b);
    if (key_a > key_b) {
        std::swap(a, b);
        std::swap(mode_a, mode_b);
        std::swap(key_a, key_b);
    }
    const Node &na = nodes_[a], &nb = nodes_[b];
    // An end's own object is in its table, or known, or cannot come between the end and anything in front of it.
    const auto cleared = [&](const Node& n, EndMode mode, std::uint32_t i) {
        return own >= 0 || mode == EndMode::Outside || nodes_.instance(i).planar ||
               (nodes_.scene().instances[i].data().meta.convex && n.kind == NodeKind::Surface);
    };
    thread_local Candidates candidates;
    // Rays find their own way through a crowd, and to the members of groups.
    const bool listed = !na.group() && !nb.group() && rays_.candidates(na.box, nb.box, candidates, kMostCandidates);
    if (listed) {
        std::erase_if(candidates, [&](std::uint32_t i) {
            return (na.instance == i && cleared(na, mode_a, i)) || (nb.instance == i && cleared(nb, mode_b, i));
        });
        if (candidates.empty()) return t;
    }
    const auto blocked = [&](const EndPoint& p, const EndPoint& q) {
        if (listed) return rays_.occluded(p.position, q.position, p.on, q.on, candidates);
        const std::uint32_t i = p.on.instance, j = q.on.instance;
        return rays_.occluded(p.position, q.position, p.on, q.on,
                              {cleared(na, mode_a, i) ? i : kNoInstance, cleared(nb, mode_b, j) ? j : kNoInstance});
    };

    const std::uint64_t seed = mix64(key_a ^ mix64(key_b ^ options_.seed));
    const double distance = length(nb.centre - na.centre);
    const double nearest2 = std::pow(std::max(0.25 * double(na.radius + nb.radius), 1e-3 * distance), 2);
    double open = 0, total = 0;
    std::uint32_t hits = 0, count = 0;
    for (std::uint32_t end = kFirstRays; count < kMostRays; end *= 2) {
        for (; count < end; ++count) {
            const auto s = sobol4(count, seed);
            const EndPoint p = end_point(nodes_, areas_, a, nb.centre, double(s[0]), double(s[1]));
            const EndPoint q = end_point(nodes_, areas_, b, na.centre, double(s[2]), double(s[3]));
            const Vec3 w = q.position - p.position;
            const double d2 = length2(w);
            const double weight = std::max(0.0, dot(p.normal, w)) * std::max(0.0, -dot(q.normal, w)) /
                                  std::max(d2, 1e-300) / std::max(d2, nearest2);
            if (weight <= 0) continue;
            total += weight;
            ++t.rays;
            if (blocked(p, q))
                ++hits;
            else
                open += weight;
        }
        // Laplace's rule has no certainty at 0 or 1: rays that agree may have missed an edge.
        const double m = t.rays, v = (m - hits + 1) / (m + 2);
        const bool agree = hits == 0 || hits == t.rays;
        t.variance = kSobolGain * kSobolGain * v * (1 - v) / std::max(1.0, m);
        t.edge = !agree;
        t.spread = v * (1 - v) * (agree ? kUnseenEdge : 1.0);
        if (!agree && edge * t.spread > kClearEdge) break;
        if (noise * t.variance <= 1 && (!agree || m >= kAgreeingRays || edge * std::sqrt(t.spread) <= 1)) break;
    }
    const double known = own >= 0 ? own : 1;
    t.mean = total > 0 ? known * open / total : 0.0;  // 0: no pair of points faces one another
    t.spread += known * (1 - known);
    return t;
}

}  // namespace rro
