#include "solver/transport/link.h"

#include <bit>
#include <numbers>

#include "format/form_factor.h"
#include "format/sample_points.h"

namespace rro {

namespace {

constexpr int kDeepestElement = 7;            // levels of quadtree below a face
constexpr double kSmallestElementShare = 1e-6;  // of the scene's area

// Relative errors of one end's projected area, measured on the sample objects: whole-object tables are interpolated over
// a grid of 12 x 12 directions and shared by all faces of a patch, intrinsic ones are smoother.
constexpr double kWholeTableError = 0.12;
constexpr double kIntrinsicTableError = 0.04;
// A flat end's faces tilt against their mean normal; what the tilt does to one face against another.
constexpr double kTiltError = 0.5;
// First-order change of irradiance over a receiver's radius r at distance d, as a share: about r / d root mean square.
constexpr double kGradient = 1.0;
// Second-order error of treating a flat source of radius r as a point, as a share of (r / d)^2.
constexpr double kCurvature = 0.5;
// The visible side of a solid lies nearer than its centre; measured on busts and chairs, 0.13 at d = 5 r.
constexpr double kSolidSource = 0.5;    // of r / d
constexpr double kSolidReceiver = 0.15;  // of r / d, after translation to sub-clusters
// Flat ends need no table, so the error estimate alone may judge them from this many radii on.
constexpr double kNearestFlat = 2;
// How much a light gradient within one face counts. It does not move the face's mean, but links of different levels must
// agree about it: where one wall is followed up to a common edge and the others are not, edges come out too bright.
constexpr double kWithinFace = 0.4;
// The same for the edge of a shadow, which has no such counterpart.
constexpr double kShadowWithinFace = 0.12;

// Shafts with more candidates than this are not listed.
constexpr std::size_t kMostCandidates = 64;

constexpr std::uint32_t kFewestRays = 8, kFirstRays = 16, kMostRays = 256;
// Errors of links from one direction agree in sign, so a link that brings little light may bring little error: its
// tolerance falls with its share of a typical face's light to the power of 3/4, down to this part.
constexpr double kSmallestPart = 0.03;
// A pair whose light could at most be this part of a link's tolerance is taken as it is.
constexpr double kNegligible = 0.25;

// Light within a node is left out, not approximated, so it must be this much smaller than a link's tolerance.
constexpr double kDarkSelf = 0.05;

// What a pair's own object leaves of its light, where that is not known.
constexpr double kOwnUnknown = -1;

// Owen-scrambled points halve the deviation of independent ones at these counts (measured for penumbrae).
constexpr double kSobolGain = 0.6;

std::uint64_t hash_text(const std::string& s) {
    std::uint64_t h = 0x243f6a8885a308d3ull;
    for (const char c : s) h = mix64(h ^ static_cast<unsigned char>(c));
    return h;
}

// The largest share of one another's hemisphere that two ends can fill: directions that leave the front of one and
// reach the front of the other lie in a lune between their planes, of form factor (1 - cos t) / 2 for an angle t
// between the normals.
double largest_share(const Node& a, const Node& b) {
    if (a.cone_cosine <= -1 || b.cone_cosine <= -1) return 1;
    const auto angle = [](double cosine) { return std::acos(std::clamp(cosine, -1.0, 1.0)); };
    const double t = angle(dot(a.normal(), b.normal())) + angle(double(a.cone_cosine)) + angle(double(b.cone_cosine));
    return t < std::numbers::pi ? 0.5 - 0.5 * std::cos(t) : 1.0;
}

struct Projection {
    double area = 0;   // m^2
    double error = 0;  // relative
};

// Projected area of a node towards w, where the other end fills directions up to `spread` (its radius over the
// distance) about w: near the horizon part of it lies below. For cosines spread evenly over c - x .. c + x the mean of
// max(0, cosine) is (c + x)^2 / 4x.
Projection projection(const Node& n, const Vec3& w, double spread) {
    if (n.kind == NodeKind::Bins) return {0.25 * n.area, 0};  // Cauchy: a typical one, its table knows better
    const double area = length(n.area_vector);
    const double c = area > 0 ? dot(n.area_vector, w) / area : 0, x = 0.5 * spread;  // root mean square of a disk
    if (c >= x) return {area * c, 0};
    if (c <= -x) return {};
    const double mean = (c + x) * (c + x) / (4 * x);
    return {area * mean, 0.5 * (mean - std::max(0.0, c)) / mean};
}

}  // namespace

double link_tolerance(const Guide& guide, const Node& node) {
    const double ratio = guide.typical_area / std::max(node.area, 1e-300);
    // Equal errors in the norm would be the root of the ratio; clusters get the root of that, so that the many links of
    // small nodes do not outweigh the few of large ones.
    const double weight = ratio > 1 ? std::min(std::sqrt(ratio), 100.0) : std::max(std::sqrt(std::sqrt(ratio)), 0.25);
    return guide.tolerance * guide.typical_reflected * weight;
}

double reflected(const Guide& guide, const Nodes& nodes, std::uint32_t to, std::uint32_t from, double exchange) {
    const double area = nodes[to].area;
    return area > 0 ? double(guide.reflectance[to]) * double(guide.radiosity[from]) * exchange / area : 0.0;
}

LinkBuilder::LinkBuilder(const Nodes& nodes, const EndAreas& areas, const SceneRays& rays,
                         const TransportOptions& options)
    : nodes_(nodes), areas_(areas), rays_(rays), options_(options) {
    double area = 0;
    for (std::uint32_t i = 0; i < nodes.scene().instances.size(); ++i) {
        instance_key_.push_back(hash_text(nodes.scene().instances[i].name));
        area += nodes[nodes.root(i)].area;
    }
    smallest_area_ = kSmallestElementShare * area;
    for (const Group& group : nodes.groups().groups) {
        std::uint64_t key = 0;  // a sum, so that the order of the members does not matter
        for (std::uint32_t m = group.first; m < group.first + group.count; ++m)
            key += mix64(instance_key_[nodes.groups().members[m]]);
        group_key_.push_back(mix64(key));
    }
    // Members' tables err independently of one another.
    std::vector<double> square(nodes.group_count(), 0);
    for (std::uint32_t g = nodes.group_count(); g-- > 0;) {
        for (const std::uint32_t child : {nodes[g].first_child, nodes[g].second_child}) {
            const Node& n = nodes[child];
            square[g] += n.group() ? square[child] : exact_tables(n) ? 0.0 : std::pow(kWholeTableError * n.area, 2);
        }
    }
    for (std::uint32_t g = 0; g < nodes.group_count(); ++g)
        group_table_error_.push_back(nodes[g].area > 0 ? std::sqrt(square[g]) / nodes[g].area : 0.0);
}

bool LinkBuilder::divisible(const Node& n) const {
    return n.kind != NodeKind::Surface || (n.depth < kDeepestElement && n.area > smallest_area_);
}

Verdict LinkBuilder::split(std::uint32_t a, std::uint32_t b, bool prefer_a) const {
    const bool can_a = divisible(nodes_[a]), can_b = divisible(nodes_[b]);
    Verdict v;
    v.action = can_a && (prefer_a || !can_b) ? Verdict::Action::SplitA
               : can_b                       ? Verdict::Action::SplitB
                                             : Verdict::Action::Accept;
    return v;
}

// False only where no point of `to` can lie in front of any face of `from`.
bool LinkBuilder::may_see(const Node& from, const Node& to) const {
    if (from.kind == NodeKind::Surface) {
        const Vec3 n = from.normal();
        const Vec3 farthest{n.x > 0 ? to.box.hi.x : to.box.lo.x, n.y > 0 ? to.box.hi.y : to.box.lo.y,
                            n.z > 0 ? to.box.hi.z : to.box.lo.z};
        // Boxes of tilted planar nodes are not tight: a touching plane must not count as in front of itself.
        return dot(n, farthest - from.centre) > 1e-9 * double(from.radius + to.radius);
    }
    if (from.cone_cosine <= -1) return true;
    const Vec3 w = to.centre - from.centre;
    const double d = length(w), reach = double(from.radius) + double(to.radius);
    if (d <= reach) return true;
    const double tilt = std::acos(std::clamp(dot(from.normal(), w) / d, -1.0, 1.0));
    const double cone = std::acos(std::clamp(double(from.cone_cosine), -1.0, 1.0));
    return tilt - cone - std::asin(reach / d) < 0.5 * std::numbers::pi;
}

bool LinkBuilder::splits_self(std::uint32_t id, const Guide& guide) const {
    const Node& n = nodes_[id];
    if (n.kind == NodeKind::Surface) return false;
    if (n.group()) return true;  // one lamp can be bright where the group's mean is dark
    if (exact_tables(n)) return false;
    // Faces within a cone of half angle c around one normal meet at angles of at most 2 c, so they fill at most
    // (1 - cos 2c) / 2 of one another's hemisphere.
    const double c = double(n.cone_cosine);
    const double most = c > 0 ? 1 - c * c : 1.0;
    return reflected(guide, nodes_, id, id, most * n.area) > kDarkSelf * link_tolerance(guide, n);
}

bool LinkBuilder::exact_tables(const Node& n) const {
    if (n.group()) return false;
    return nodes_.scene().instances[n.instance].data().meta.convex || nodes_.instance(n.instance).planar;
}

EndMode LinkBuilder::end_mode(const Node& end, const Node& other, double affordable_error) const {
    if (end.group()) return EndMode::Outside;
    if (end.instance == other.instance || !areas_.has_outside(end)) return EndMode::Inside;
    if (nodes_.scene().instances[end.instance].bounds.overlaps(other.box)) return EndMode::Inside;
    return exact_tables(end) || kWholeTableError <= affordable_error ? EndMode::Outside : EndMode::Inside;
}

double LinkBuilder::weight(const Guide& guide, std::uint32_t to, std::uint32_t from, double exchange) const {
    const double share = reflected(guide, nodes_, to, from, exchange) / std::max(guide.typical_reflected, 1e-300);
    const double part = std::clamp(std::pow(share, 0.75), kSmallestPart, 1.0);
    return reflected(guide, nodes_, to, from, 1) / (link_tolerance(guide, nodes_[to]) * part);
}

Verdict LinkBuilder::judge(const Pair& pair, const Guide& guide) const {
    const auto [a, b, stored] = pair;
    Verdict v;
    v.action = Verdict::Action::Pending;
    if (guide.radiosity[a] == 0 && guide.radiosity[b] == 0) return v;
    if (stored == kNotStored) {
        if (a != b) return judge_by_geometry(a, b, guide, kOwnUnknown);
        if (splits_self(a, guide)) v.action = Verdict::Action::SplitA;
        return v;
    }
    const SelfPair& known = nodes_.scene().instances[nodes_[a].instance].object->self_pairs[stored];
    if (known.step == PairStep::Dark || known.seen == 0) return {};
    const bool whole = is_whole(known, pair);
    if (whole && nodes_.instance(nodes_[a].instance).similarity > 0) {
        v = judge_stored(pair, known, guide);
    } else if (a == b) {
        v.action = splits_self(a, guide) ? Verdict::Action::SplitA : Verdict::Action::Pending;
    } else {
        const bool open = known.step == PairStep::Link && known.seen == known.unoccluded;
        v = judge_by_geometry(a, b, guide, open ? 1 : whole ? double(known.seen) / double(known.unoccluded) : kOwnUnknown);
        const bool divides = v.action == Verdict::Action::SplitA || v.action == Verdict::Action::SplitB;
        if (whole && divides && known.step != PairStep::Link) v.action = stored_split(known, pair);
    }
    v.link.stored = stored;
    return v;
}

// Is the pair all of what is stored, rather than a part of a link's ends?
bool LinkBuilder::is_whole(const SelfPair& stored, const Pair& pair) const {
    const Node &na = nodes_[pair.a], &nb = nodes_[pair.b];
    const ObjectData& data = nodes_.scene().instances[na.instance].data();
    const auto all_of = [&](const Node& n, std::uint32_t c) {
        const auto range = nodes_.patches(n);
        const Cluster& cluster = data.clusters[c];
        if (range[0] != cluster.first_patch || range[1] - range[0] != cluster.patch_count) return false;
        return n.kind != NodeKind::Surface || (n.depth == 0 && data.patches[range[0]].face_count == 1);
    };
    return (all_of(na, stored.a) && all_of(nb, stored.b)) || (all_of(na, stored.b) && all_of(nb, stored.a));
}

// The end that the stored tree divides.
Verdict::Action LinkBuilder::stored_split(const SelfPair& stored, const Pair& pair) const {
    if (stored.step == PairStep::SplitSelf) return Verdict::Action::SplitA;
    const ObjectData& data = nodes_.scene().instances[nodes_[pair.a].instance].data();
    const std::uint32_t divided = stored.step == PairStep::SplitFirst ? stored.a : stored.b;
    const bool is_a = nodes_.patches(nodes_[pair.a])[0] == data.clusters[divided].first_patch;
    return is_a ? Verdict::Action::SplitA : Verdict::Action::SplitB;
}

Verdict LinkBuilder::judge_stored(const Pair& pair, const SelfPair& stored, const Guide& guide) const {
    const auto [a, b, number] = pair;
    const Node &na = nodes_[a], &nb = nodes_[b];
    const double scale = nodes_.instance(na.instance).similarity;
    const double g = scale * scale * double(stored.seen), own = double(stored.seen) / double(stored.unoccluded);
    const double over_a = weight(guide, a, b, g), over_b = weight(guide, b, a, g);
    const double d = std::max(length(nb.centre - na.centre), 1e-300);
    // What one irradiance for all of a receiver, and one radiosity for all of a source, may be wrong by.
    const auto received = [&](const Node& n) {
        const double r = std::min(10.0, double(n.radius) / d);
        if (n.kind == NodeKind::Surface) return kWithinFace * r;
        return n.kind == NodeKind::Flat ? kGradient * r * (1 + r) + kTiltError * (1 - double(n.cone_cosine)) : 1.0;
    };
    const auto sent = [&](const Node& n) {
        const double r = std::min(1.0, double(n.radius) / d);
        return n.kind == NodeKind::Surface || n.kind == NodeKind::Flat ? kCurvature * r * r : kCurvature;
    };
    const double shadow = std::sqrt(own * (1 - own));
    const auto share = [&](const Node& n) { return n.kind == NodeKind::Surface ? kShadowWithinFace : 1.0; };
    const double error_a = std::hypot(received(na), sent(nb), shadow * share(na));
    const double error_b = std::hypot(received(nb), sent(na), shadow * share(nb));
    Verdict v;
    const double harm_a = over_a * error_a * g, harm_b = over_b * error_b * g;
    if (std::max(harm_a, harm_b) > 1) {
        if (stored.step != PairStep::Link) {
            v.action = stored_split(stored, pair);
            return v;
        }
        if (a == b) {
            v.action = Verdict::Action::SplitA;
            return v;
        }
        return judge_by_geometry(a, b, guide, own == 1 ? 1 : kOwnUnknown);
    }
    Transmittance t;
    if (a != b) t = transmittance(a, b, EndMode::Inside, EndMode::Inside, g * std::max(over_a, over_b), 1);
    const double third = std::sqrt(t.spread);
    v.rays = t.rays;
    if (std::max(over_a * share(na), over_b * share(nb)) * third * g > 1) {
        v.action = stored.step != PairStep::Link ? stored_split(stored, pair) : split(a, b, na.radius >= nb.radius).action;
        if (v.action != Verdict::Action::Accept) return v;
    }
    v.action = Verdict::Action::Accept;
    v.link.a = a;
    v.link.b = b;
    v.link.near = true;
    v.link.base_a = static_cast<float>(g * t.mean * std::numbers::pi);
    v.link.base_b = a == b ? 0.0f : v.link.base_a;
    v.link.error_a = static_cast<float>(g * std::hypot(error_a * t.mean, share(na) * third * 0.5, std::sqrt(t.variance)));
    v.link.error_b = a == b ? 0.0f : static_cast<float>(g * std::hypot(error_b * t.mean, share(nb) * third * 0.5, std::sqrt(t.variance)));
    return v;
}

Verdict LinkBuilder::judge_by_geometry(std::uint32_t a, std::uint32_t b, const Guide& guide, double own) const {
    const Node &na = nodes_[a], &nb = nodes_[b];
    if (!may_see(na, nb) || !may_see(nb, na)) return {};
    return na.kind == NodeKind::Surface && nb.kind == NodeKind::Surface ? judge_near(a, b, guide, own)
                                                                        : judge_far(a, b, guide, own);
}

Verdict LinkBuilder::judge_near(std::uint32_t a, std::uint32_t b, const Guide& guide, double own) const {
    const Node &na = nodes_[a], &nb = nodes_[b];
    const TriangleCorners ca = nodes_.corners(a), cb = nodes_.corners(b);
    const double reach = double(na.radius) + double(nb.radius);
    const double nearness = length(nb.centre - na.centre) / std::max(reach, 1e-300);
    const TriangleRule rule = triangle_rule(nearness > 6 ? 1 : nearness > 2 ? 3 : nearness > 1 ? 6 : 12);

    // The same exchange area from points on either side; their difference tells the quadrature error.
    const auto gather = [&](const Node& from, const TriangleCorners& on, const TriangleCorners& to, double& spread) {
        const Vec3 n = from.normal();
        double mean = 0, square = 0;
        for (const TriangleRule::Node& q : rule.nodes) {
            const double f = point_to_triangle(triangle_point(on, q.b1, q.b2), n, to);
            mean += q.weight * f;
            square += q.weight * f * f;
        }
        spread = std::sqrt(std::max(0.0, square - mean * mean)) * from.area;
        return mean * from.area;
    };
    double spread_a = 0, spread_b = 0;
    const double ga = gather(na, ca, cb, spread_a), gb = gather(nb, cb, ca, spread_b);
    if (ga <= 0 && gb <= 0) return {};
    if (rule.nodes.size() == 1) {  // no spread from one point: the gradient over the radius
        spread_a = ga * double(na.radius) / (nearness * reach);
        spread_b = gb * double(nb.radius) / (nearness * reach);
    }
    const double g = 0.5 * (ga + gb);
    const double quadrature = 0.5 * std::abs(ga - gb);

    const double over_a = weight(guide, a, b, ga), over_b = weight(guide, b, a, gb);
    const double fail_a = over_a * std::hypot(quadrature, kWithinFace * spread_a);
    const double fail_b = over_b * std::hypot(quadrature, kWithinFace * spread_b);
    if (std::max(fail_a, fail_b) > 1) {
        // A gradient goes away only by dividing the end that it runs over.
        const Verdict v = split(a, b, fail_a >= fail_b);
        if (v.action != Verdict::Action::Accept) return v;
    }
    const Transmittance t = transmittance(a, b, EndMode::Inside, EndMode::Inside, g * std::max(over_a, over_b), own);
    const double shadow = kShadowWithinFace * g * std::sqrt(t.spread);
    if (std::max(over_a, over_b) * shadow > 1) {
        Verdict v = split(a, b, over_a * na.area >= over_b * nb.area);
        v.rays = t.rays;
        if (v.action != Verdict::Action::Accept) return v;
    }
    Verdict v;
    v.rays = t.rays;
    v.action = Verdict::Action::Accept;
    v.link.a = a;
    v.link.b = b;
    v.link.near = true;
    v.link.base_a = static_cast<float>(ga * t.mean * std::numbers::pi);
    v.link.base_b = static_cast<float>(gb * t.mean * std::numbers::pi);
    v.link.error_a = v.link.error_b = static_cast<float>(std::hypot(quadrature * t.mean, g * std::sqrt(t.variance)));
    return v;
}

// A small source may light a part of a large receiver, and each part by a source of its own: what matters is the part
// that lies nearest, about as large as the source or as the gap is wide, not the mean over the receiver.
double LinkBuilder::most_harm(std::uint32_t to, std::uint32_t from, double gap, const Guide& guide) const {
    const Node &nt = nodes_[to], &nf = nodes_[from];
    const double spread = std::numbers::pi * gap * gap;
    const double share = std::min(largest_share(nt, nf), nf.area / std::max(spread, 1e-300));
    Node part = nt;
    part.area = std::min(nt.area, std::max(nf.area, spread));
    return double(guide.reflectance[to]) * double(guide.radiosity[from]) * share / link_tolerance(guide, part);
}

Verdict LinkBuilder::judge_far(std::uint32_t a, std::uint32_t b, const Guide& guide, double own) const {
    const Node &na = nodes_[a], &nb = nodes_[b];
    if (na.kind == NodeKind::Cluster) return split(a, b, true);
    if (nb.kind == NodeKind::Cluster) return split(a, b, false);

    const Vec3 between = nb.centre - na.centre;
    const double distance = length(between), ra = double(na.radius), rb = double(nb.radius);

    const bool disjoint = !na.box.overlaps(nb.box);
    const double gap = std::max(0.0, distance - ra - rb);
    const bool negligible = std::max(most_harm(a, b, gap, guide), most_harm(b, a, gap, guide)) <= kNegligible;
    const double factor_a = na.kind == NodeKind::Bins ? options_.far_factor : kNearestFlat;
    const double factor_b = nb.kind == NodeKind::Bins ? options_.far_factor : kNearestFlat;
    if (!negligible && (!disjoint || distance < std::max(factor_a * ra, factor_b * rb)))
        return split(a, b, factor_a * ra >= factor_b * rb);

    // Never nearer than the larger radius: a negligible pair may overlap.
    const double d = std::max({distance, ra, rb});
    const Vec3 w = distance > 0 ? between / distance : Vec3{0, 1, 0};
    const Projection project_a = projection(na, w, rb / d), project_b = projection(nb, -w, ra / d);
    const double pa = project_a.area, pb = project_b.area;
    if (pa <= 0 || pb <= 0) return {};
    const double g = std::min({pa * pb / (std::numbers::pi * d * d), na.area, nb.area});
    const double over_a = weight(guide, a, b, g), over_b = weight(guide, b, a, g);
    const double strongest = g * std::max(over_a, over_b);
    const EndMode mode_a = end_mode(na, nb, 0.7 / strongest), mode_b = end_mode(nb, na, 0.7 / strongest);

    const auto end_error = [&](const Node& n, EndMode mode) {
        if (n.group()) return group_table_error_[n.index];
        if (n.kind == NodeKind::Surface || exact_tables(n)) return 0.0;
        if (mode == EndMode::Outside) return kWholeTableError;
        return n.kind == NodeKind::Bins ? kIntrinsicTableError : 0.0;
    };
    const double tables = std::hypot(end_error(na, mode_a), end_error(nb, mode_b));
    const auto point_error = [&](const Node& n, double r) {
        return n.kind == NodeKind::Bins ? kSolidSource * r / d : kCurvature * (r / d) * (r / d);
    };
    const auto receiver_error = [&](const Node& n, double r) {
        if (n.kind == NodeKind::Surface) return kWithinFace * r / d;
        if (n.kind == NodeKind::Bins) return kSolidReceiver * r / d;
        return std::hypot(kGradient * r / d, kTiltError * (1 - double(n.cone_cosine)));
    };
    const double horizons = std::hypot(project_a.error, project_b.error);
    const double far_a = std::hypot(std::hypot(tables, horizons), receiver_error(na, ra), point_error(nb, rb));
    const double far_b = std::hypot(std::hypot(tables, horizons), receiver_error(nb, rb), point_error(na, ra));
    if (!negligible && std::max(over_a * far_a, over_b * far_b) * g > 1) {
        // Split the end whose extent does more harm.
        const double harm_a = std::max(over_a * std::hypot(receiver_error(na, ra), end_error(na, mode_a), project_b.error),
                                       over_b * std::hypot(point_error(na, ra), end_error(na, mode_a), project_b.error));
        const double harm_b = std::max(over_b * std::hypot(receiver_error(nb, rb), end_error(nb, mode_b), project_a.error),
                                       over_a * std::hypot(point_error(nb, rb), end_error(nb, mode_b), project_a.error));
        const Verdict v = split(a, b, harm_a >= harm_b);
        if (v.action != Verdict::Action::Accept) return v;
    }

    // What an end hides of itself is part of what its object hides.
    const double share_a = own >= 0 ? 1 : areas_.visible_share(na, w, mode_a);
    const double share_b = own >= 0 ? 1 : areas_.visible_share(nb, -w, mode_b);
    const Transmittance t = transmittance(a, b, mode_a, mode_b, strongest * share_a * share_b, own);
    const double seen = g * share_a * share_b;
    const auto shadow_error = [&](const Node& n) {
        return (n.kind == NodeKind::Surface ? kShadowWithinFace : 1.0) * std::sqrt(t.spread);
    };
    if (!negligible && std::max(over_a * shadow_error(na), over_b * shadow_error(nb)) * seen > 1) {
        Verdict v = split(a, b, over_a * shadow_error(na) * na.area >= over_b * shadow_error(nb) * nb.area);
        v.rays = t.rays;
        if (v.action != Verdict::Action::Accept) return v;
    }
    Verdict v;
    v.rays = t.rays;
    v.action = Verdict::Action::Accept;
    v.link.a = a;
    v.link.b = b;
    v.link.mode_a = mode_a;
    v.link.mode_b = mode_b;
    // Bins hold their own projection and, outside, their own visibility.
    const auto strength = [](const Node& n, EndMode mode, double projection, double share) {
        if (n.kind != NodeKind::Bins) return projection * share;
        return mode == EndMode::Outside ? 1.0 : share;
    };
    const double sa = strength(na, mode_a, pa, share_a), sb = strength(nb, mode_b, pb, share_b);
    v.link.base_a = v.link.base_b = static_cast<float>(sa * sb * t.mean / (d * d));
    v.link.error_a = static_cast<float>(seen * std::hypot(far_a * t.mean, shadow_error(na) * 0.5, std::sqrt(t.variance)));
    v.link.error_b = static_cast<float>(seen * std::hypot(far_b * t.mean, shadow_error(nb) * 0.5, std::sqrt(t.variance)));
    return v;
}

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

LinkBuilder::Transmittance LinkBuilder::transmittance(std::uint32_t a, std::uint32_t b, EndMode mode_a, EndMode mode_b,
                                                      double need, double own) const {
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
    // Enough rays that the worst case, half of them blocked, would do; fewer once the answer is clearer.
    const double most = std::clamp(need * need * 0.25 * kSobolGain * kSobolGain, double(kFewestRays), double(kMostRays));
    const std::uint32_t limit = std::bit_ceil(static_cast<std::uint32_t>(most));
    double open = 0, total = 0;
    std::uint32_t hits = 0, count = 0;
    for (std::uint32_t end = std::min(kFirstRays, limit); count < limit; end = std::min(limit, 2 * end)) {
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
        // Laplace's rule has no certainty at 0 or 1: the first few agreeing rays do not end the count by themselves.
        const double m = t.rays, v = (m - hits + 1) / (m + 2);
        t.spread = v * (1 - v);
        t.variance = kSobolGain * kSobolGain * t.spread / std::max(1.0, m);
        if (need * need * t.variance <= 1) break;
    }
    const double known = own >= 0 ? own : 1;
    t.mean = total > 0 ? known * open / total : 0.0;  // 0: no pair of points faces one another
    if (hits == 0 || hits == t.rays) t.spread = 0;    // no sign of a shadow edge
    t.spread += known * (1 - known);
    return t;
}

}  // namespace rro
