#include "solver/transport/link.h"

#include <bit>
#include <numbers>

#include "format/form_factor.h"
#include "format/sample_points.h"
#include "solver/transport/ticks.h"

namespace rro {

namespace {

constexpr int kDeepestElement = 7;              // levels of quadtree below a face
constexpr double kSmallestElementShare = 5e-6;  // of its instance's area: a lamp in a hall is small, and what counts

// What one link may be wrong by, relative to its light; r the radius of an end, d the distance.
// A flat or planar end as a point: second order.
constexpr double kCurvature = 0.5;  // of (r / d)^2
// How well archives know the exchange area of a self link and, as a share of the deviation of a line, its visibility;
// and what they know of the visibility of ends that nearly touch, whose radii add up to this part of the distance.
constexpr double kStoredExchange = 0.02, kStoredVisibility = 0.25, kStoredLines = 16;
constexpr double kStoredTouching = 0.6, kStoredDoubt = 0.4;
// Near ends count as several points (link_points.cpp); what is left is this part of the difference that they make, and of
// the second order that they do not see.
constexpr double kLeftOver = 0.3;
// Up to this share of the distance, ends whose mean lies below the other's horizon are dark to one another.
constexpr double kSureOfHorizon = 0.2;
// Where on a flat end its light comes from: first order.
constexpr double kPlace = 0.5;  // of its relative variation times r / d
// A flat end receives a vector and a gradient; what is left over its faces is of second order as well.
constexpr double kSecondOrder = 1.0;  // of (r / d)^2
// Faces that tilt against their mean normal: exact where light comes from above all of them.
constexpr double kTiltError = 0.1;
// One irradiance for all of a flat end: its gradient, and all of the tilt.
constexpr double kGradient = 1.0, kMeanTilt = 0.5;
// The visible side of a solid lies nearer than its centre; measured on busts and chairs, 0.13 at d = 5 r.
constexpr double kSolidSource = 0.5;     // of r / d
constexpr double kSolidReceiver = 0.15;  // of r / d, after translation to sub-clusters
// Flat ends need no table, so the error estimate alone may judge them from this many radii on.
constexpr double kNearestFlat = 2;
// Triangles this many times the sum of their radii apart need no kernel.
constexpr double kFarTriangles = 4;
// How much a light gradient within one face counts: it does not move the face's mean, but what the face sends on; and
// between faces that nearly touch, where it never ends.
constexpr double kOverFace = 0.2, kWithinFace = 0.1;
// Where points of one end differ this many times more than those of the other, the other's are believed.
constexpr double kUnevenPoints = 2;
// Within an object, parts that are lit alike see one another best: their errors agree in sign.
constexpr double kAlike = 2;
// A pair whose whole light would do this part of a link's harm is taken as it is; and one too near to be told as a whole,
// an object in a room: what is next to nothing for the scene may be all that lights a dark side.
constexpr double kNegligible = 0.25, kNegligibleNear = 0.01;
// Root mean square of distances between two ends about the one between their centres, as a part of the sum of their radii;
// and the part of what a medium makes of that which the mean over the ends does not cancel.
constexpr double kAlong = 0.35, kWithinMedium = 0.5;
// Tables that do this part of a link's harm are good enough; where they are not, rays find what they would have told.
constexpr double kAffordable = 0.5;
// However little an instance or a group matters to the scene, one link to it is off by no more than this part, squared, of
// the light that surfaces of its area receive on average: small things in a large room are not dark.
constexpr double kOwnShare = 0.25;
// What a table calls hidden may be seen through a gap between its directions.
constexpr double kMissedGap = 0.1;
// Light within a node is left out, not approximated, so it must be this much less harmful.
constexpr double kDarkSelf = 0.01;

// Of a cluster's area, the least that counts as turned to the other end before its table is asked.
constexpr double kLeastBins = 0.05;

// What a pair's own object leaves of its light, where that is not known.
constexpr double kOwnUnknown = -1;

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

}  // namespace

// Projected area of a node towards w, where the other end fills directions up to `spread` (its radius over the
// distance) about w: near the horizon part of it lies below. For cosines spread evenly over c - x .. c + x the mean of
// max(0, cosine) is (c + x)^2 / 4x.
LinkBuilder::Projection LinkBuilder::projection(const Node& n, const Vec3& w, double spread) {
    if (n.kind == NodeKind::Bins) return {n.area * std::max(kLeastBins, n.mean_cosine(w)), 0};  // its table knows better
    const double fan = 0.5 * spread;  // root mean square of a disk
    const double mean = n.mean_cosine(w, fan), plain = std::max(0.0, dot(n.area_vector, w) / std::max(n.area, 1e-300));
    if (mean <= 0) return {};
    return {n.area * mean, 0.5 * (mean - std::min(plain, mean)) / mean};
}

double Guide::limit(const Nodes& nodes, std::uint32_t to) const {
    const std::uint32_t instance = nodes[to].instance;
    const double own = nodes[to].group() ? nodes[to].area : nodes[nodes.root(instance)].area;
    return reflected * std::min(instance < share.size() ? share[instance] : scene_share, kOwnShare * own / area);
}

namespace {

// Where nothing is reflected there is no measure: no link is too bad, and none negligible.
double in_shares(double squared_error, double limit) { return limit > 0 ? squared_error / limit : 1.0; }

}  // namespace

double harm_to_part(const Guide& guide, const Nodes& nodes, std::uint32_t to, double area, double error) {
    const double rho = double(guide.reflectance[to]), others = kAgreement * kAgreement * double(guide.error[to]);
    return in_shares(area * rho * rho * error * (error + others), guide.limit(nodes, to));
}

double harm(const Guide& guide, const Nodes& nodes, std::uint32_t to, std::uint32_t from, double exchange) {
    const double area = nodes[to].area;
    return area > 0 ? harm_to_part(guide, nodes, to, area, double(guide.radiosity[from]) * exchange / area) : 0.0;
}

double noise_harm(const Guide& guide, const Nodes& nodes, std::uint32_t to, std::uint32_t from, double noise) {
    const double e = double(guide.reflectance[to]) * double(guide.radiosity[from]) * noise;
    return in_shares(e * e / std::max(nodes[to].area, 1e-300), guide.limit(nodes, to));
}

LinkBuilder::LinkBuilder(const Nodes& nodes, const EndAreas& areas, const SceneRays& rays,
                         const TransportOptions& options)
    : nodes_(nodes), areas_(areas), options_(options), visibility_(nodes.scene(), rays, link_method(options.visibility)) {
    for (const Instance& instance : nodes.scene().instances) instance_key_.push_back(hash_text(instance.name));
    if (const auto& medium = nodes.scene().medium) {
        const Vec3& a = medium->absorption;
        medium_ = std::min({a.x, a.y, a.z});
        medium_most_ = max_component(a);
    }
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
            square[g] += n.group() ? square[child] : std::pow(areas_.table_error(n, EndMode::Outside).sent * n.area, 2);
        }
    }
    for (std::uint32_t g = 0; g < nodes.group_count(); ++g)
        group_table_error_.push_back(nodes[g].area > 0 ? std::sqrt(square[g]) / nodes[g].area : 0.0);
}

bool LinkBuilder::divisible(const Node& n) const {
    return n.kind != NodeKind::Surface ||
           (n.depth < kDeepestElement && n.area > kSmallestElementShare * nodes_[nodes_.root(n.instance)].area);
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
    return harm(guide, nodes_, id, id, most * n.area) > kDarkSelf;
}

bool LinkBuilder::exact_tables(const Node& n) const {
    if (n.group()) return false;
    return nodes_.scene().instances[n.instance].data().meta.convex || nodes_.instance(n.instance).planar;
}

Verdict LinkBuilder::judge(const Pair& pair, const Guide& guide) const {
    const auto [a, b, stored, record] = pair;
    Verdict v;
    v.action = Verdict::Action::Pending;
    if (guide.radiosity[a] == 0 && guide.radiosity[b] == 0) return v;
    if (stored == kNotStored) {
        if (a != b) return judge_by_geometry(a, b, guide, kOwnUnknown);
        if (splits_self(a, guide)) v.action = Verdict::Action::SplitA;
        return v;
    }
    const SelfPair& known = nodes_.scene().instances[nodes_[a].instance].object->self_pairs[stored];
    // The compiler calls a pair dark, too, where none of its lines left both fronts.
    if (known.step == PairStep::Dark) return a == b ? Verdict{} : judge_by_geometry(a, b, guide, kOwnUnknown);
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
        return n.depth == 0 && (n.kind != NodeKind::Surface || data.patches[range[0]].face_count == 1);
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

double LinkBuilder::harm_of(const Guide& guide, const Offer& o, double error_a, double error_b) const {
    return std::max(harm(guide, nodes_, o.a, o.b, error_a), harm(guide, nodes_, o.b, o.a, error_b));
}

double LinkBuilder::sent_as_one(std::uint32_t id, double r, const Guide& guide) const {
    const Node& n = nodes_[id];
    const double variation = double(guide.variation[id]);
    r = std::min(r, 1.0);
    if (n.kind == NodeKind::Surface || n.kind == NodeKind::Flat) return kLeftOver * kCurvature * r * r + kPlace * variation * r;
    return kCurvature + variation;
}

Verdict LinkBuilder::judge_stored(const Pair& pair, const SelfPair& stored, const Guide& guide) const {
    const std::uint32_t a = pair.a, b = pair.b;
    const Node &na = nodes_[a], &nb = nodes_[b];
    const double scale = nodes_.instance(na.instance).similarity;
    const double g = scale * scale * double(stored.seen), own = double(stored.seen) / double(stored.unoccluded);
    const double d = length(nb.centre - na.centre);
    constexpr double kTouching = 2;  // nearer than that makes no difference
    const double near_a = d > 0 ? std::min(kTouching, double(na.radius) / d) : kTouching;
    const double near_b = d > 0 ? std::min(kTouching, double(nb.radius) / d) : kTouching;
    Offer o{a, b, EndMode::Mean, EndMode::Mean};
    // Flat ends receive by direction where that leaves less error than one mean for all faces.
    const auto received = [&](const Node& n, double r, EndMode& mode) {
        if (n.kind == NodeKind::Surface) return kOverFace * std::min(r, 1.0);
        const double tilt = 1 - double(n.cone_cosine);
        const double mean = n.kind == NodeKind::Flat ? kGradient * std::min(r, 1.0) * (1 + std::min(r, 1.0)) + kMeanTilt * tilt : 1.0;
        const double directed = kSecondOrder * r * r + kTiltError * tilt;
        if (n.kind != NodeKind::Flat || !n.may_end() || a == b || directed >= mean) return mean;
        mode = EndMode::Inside;
        return directed;
    };
    const double shadow = std::sqrt(own * (1 - own));
    // By Laplace's rule for the lines that the compiler drew: what it found hidden may have a gap.
    const double likely = own == 1 ? 1 : (own * kStoredLines + 1) / (kStoredLines + 2);
    const bool touching = near_a + near_b > kStoredTouching;  // few of the lines decide
    const double doubt = touching && own < 1 ? kStoredDoubt : kStoredVisibility * std::sqrt(likely * (1 - likely));
    const double known = scale * scale * double(stored.unoccluded) * std::hypot(kStoredExchange * own, doubt);
    const double error_a = std::hypot(received(na, near_a, o.mode_a), kAlike * sent_as_one(b, near_b, guide), shadow * shadow_share(na));
    const double error_b = std::hypot(received(nb, near_b, o.mode_b), kAlike * sent_as_one(a, near_a, guide), shadow * shadow_share(nb));
    o.error_a = std::hypot(g * error_a, known);
    o.error_b = a == b ? 0 : std::hypot(g * error_b, known);
    const double bad = harm_of(guide, o, o.error_a, o.error_b);
    if (g == 0 && bad <= kNegligible) return {};
    if (bad > 1 || areas_.mixed(na) || areas_.mixed(nb)) {
        Verdict v;
        if (stored.step == PairStep::Link && a != b) return judge_by_geometry(a, b, guide, own == 1 ? 1 : kOwnUnknown);
        v.action = stored.step == PairStep::Link ? Verdict::Action::SplitA : stored_split(stored, pair);
        return v;
    }
    o.own = 1;
    o.exchange = g;
    o.base_a = g * std::numbers::pi;
    o.base_b = a == b ? 0 : o.base_a;
    Verdict v = settle(o, guide);
    if (v.action != Verdict::Action::Accept && stored.step != PairStep::Link) v.action = stored_split(stored, pair);
    return v;
}

Verdict LinkBuilder::judge_by_geometry(std::uint32_t a, std::uint32_t b, const Guide& guide, double own) const {
    const Node &na = nodes_[a], &nb = nodes_[b];
    if (!may_see(na, nb) || !may_see(nb, na)) return {};
    if (na.kind != NodeKind::Surface || nb.kind != NodeKind::Surface) return judge_far(a, b, guide, own);
    const double reach = double(na.radius) + double(nb.radius);
    return length(nb.centre - na.centre) > kFarTriangles * reach ? judge_far(a, b, guide, own) : judge_near(a, b, guide, own);
}

Verdict LinkBuilder::judge_near(std::uint32_t a, std::uint32_t b, const Guide& guide, double own) const {
    const Node &na = nodes_[a], &nb = nodes_[b];
    const TriangleCorners ca = nodes_.corners(a), cb = nodes_.corners(b);
    const double reach = double(na.radius) + double(nb.radius);
    const double nearness = length(nb.centre - na.centre) / std::max(reach, 1e-300);
    const TriangleRule rule = triangle_rule(nearness > 2 ? 3 : nearness > 1 ? 6 : 12);

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
    double ga = gather(na, ca, cb, spread_a), gb = gather(nb, cb, ca, spread_b);
    if (ga <= 0 && gb <= 0) return {};
    double quadrature = 0.5 * std::abs(ga - gb);
    // Points of a large end miss a small one that is close to it, while all points of that see the large one alike.
    if (spread_a > kUnevenPoints * spread_b) ga = gb, quadrature = std::min(quadrature, spread_b);
    else if (spread_b > kUnevenPoints * spread_a) gb = ga, quadrature = std::min(quadrature, spread_a);

    Offer o{a, b, EndMode::Mean, EndMode::Mean};
    o.own = own;
    o.exchange = 0.5 * (ga + gb);
    o.base_a = ga * std::numbers::pi;
    o.base_b = gb * std::numbers::pi;
    o.error_a = std::hypot(quadrature, kWithinFace * spread_a);
    o.error_b = std::hypot(quadrature, kWithinFace * spread_b);
    // Seen from close by, a source is its nearest part, which may be brighter or darker than the whole.
    const auto uneven = [&](std::uint32_t id) { return std::min(1.0, 1 / nearness) * double(guide.variation[id]); };
    const double uneven_a = gb * uneven(a), uneven_b = ga * uneven(b);
    const double dark_a = harm(guide, nodes_, b, a, uneven_a), dark_b = harm(guide, nodes_, a, b, uneven_b);
    if (std::max(dark_a, dark_b) > 1) {
        const Verdict v = split(a, b, dark_a >= dark_b);
        if (v.action != Verdict::Action::Accept) return v;
    }
    o.error_a = std::hypot(o.error_a, uneven_b);
    o.error_b = std::hypot(o.error_b, uneven_a);
    // A gradient goes away only by dividing the end that it runs over.
    const double harm_a = harm(guide, nodes_, a, b, o.error_a), harm_b = harm(guide, nodes_, b, a, o.error_b);
    if (std::max(harm_a, harm_b) > 1) {
        const Verdict v = split(a, b, harm_a >= harm_b);
        if (v.action != Verdict::Action::Accept) return v;
    }
    return settle(o, guide);
}

// The mode and the errors of an end, r its radius over the distance. An end uses its whole object's tables where the other
// end lies outside the object and the tables are good enough for the light that is at stake.
LinkBuilder::End LinkBuilder::end_of(std::uint32_t id, std::uint32_t other, double r, const Projection& projection, double exchange,
                                     const Guide& guide) const {
    const Node &n = nodes_[id], &o = nodes_[other];
    End end;
    end.projection = projection.area;
    end.horizon = projection.error;
    if (n.group()) {
        end.mode = EndMode::Outside;
    } else if (n.instance != o.instance && areas_.has_outside(n) &&
               !nodes_.scene().instances[n.instance].bounds.overlaps(o.box)) {
        const TableError e = areas_.table_error(n, EndMode::Outside);
        const bool affordable = exact_tables(n) || std::max(harm(guide, nodes_, id, other, exchange * e.received),
                                                            harm(guide, nodes_, other, id, exchange * e.sent)) <= kAffordable;
        if (affordable) end.mode = EndMode::Outside;
    }
    const TableError tables = n.group() ? TableError{group_table_error_[n.index], group_table_error_[n.index]}
                                        : areas_.table_error(n, end.mode);
    if (n.kind == NodeKind::Bins) {
        end.received = std::hypot(kSolidReceiver * r, tables.received);
        end.sent = std::hypot(kSolidSource * r, tables.sent);
    } else {
        end.received = n.kind == NodeKind::Surface ? kOverFace * r + kLeftOver * kCurvature * r * r
                                                   : std::hypot(kSecondOrder * r * r + kTiltError * (1 - double(n.cone_cosine)), tables.received);
        end.sent = std::hypot(sent_as_one(id, r, guide), tables.sent);
    }
    return end;
}

// A small source may light a part of a large receiver, and each part by a source of its own: what matters is the part
// that lies nearest, about as large as the source or as the gap is wide, not the mean over the receiver.
double LinkBuilder::most_harm(std::uint32_t to, std::uint32_t from, double gap, const Guide& guide) const {
    const Node &nt = nodes_[to], &nf = nodes_[from];
    const double spread = std::numbers::pi * gap * gap;
    const double share = std::min(largest_share(nt, nf), nf.area / std::max(spread, 1e-300));
    const double part = std::min(nt.area, std::max(nf.area, spread));
    return harm_to_part(guide, nodes_, to, part, double(guide.radiosity[from]) * share);
}

Verdict LinkBuilder::judge_far(std::uint32_t a, std::uint32_t b, const Guide& guide, double own) const {
    const Node &na = nodes_[a], &nb = nodes_[b];
    if (!na.may_end()) return split(a, b, true);
    if (!nb.may_end()) return split(a, b, false);

    const Vec3 between = nb.centre - na.centre;
    const double distance = length(between), ra = double(na.radius), rb = double(nb.radius);
    Offer o{a, b};
    const double gap = std::max(0.0, distance - ra - rb);
    const bool near = distance < 2 * std::max(ra, rb);
    const bool negligible =
        std::max(most_harm(a, b, gap, guide), most_harm(b, a, gap, guide)) <= (near ? kNegligibleNear : kNegligible);
    const double factor_a = na.kind == NodeKind::Bins ? options_.far_factor : kNearestFlat;
    const double factor_b = nb.kind == NodeKind::Bins ? options_.far_factor : kNearestFlat;
    if (!negligible && (na.box.overlaps(nb.box) || distance < std::max(factor_a * ra, factor_b * rb)))
        return split(a, b, factor_a * ra >= factor_b * rb);

    // Never nearer than the larger radius: a negligible pair may overlap.
    const double d = std::max({distance, ra, rb});
    const Vec3 w = distance > 0 ? between / distance : Vec3{0, 1, 0};
    Projection project_a = projection(na, w, rb / d), project_b = projection(nb, -w, ra / d);
    // Ends so near that some of their points may face one another although their mean does not are divided.
    const bool sure = negligible || std::max(ra, rb) < kSureOfHorizon * d;
    const auto dark = [&] { return sure ? Verdict{} : split(a, b, ra >= rb); };
    if (project_a.area <= 0 || project_b.area <= 0) return dark();
    double g = project_a.area * project_b.area / (std::numbers::pi * d * d), points_error = 0;
    double uneven_a = 0, uneven_b = 0;
    const bool by_centres = negligible || na.kind == NodeKind::Bins || nb.kind == NodeKind::Bins;
    if (!by_centres) {
        const Quadrature q = by_points(a, b);
        if (q.exchange <= 0) return dark();
        points_error = kLeftOver * q.difference / q.exchange;
        uneven_a = q.received_a;
        uneven_b = q.received_b;
        project_a.area *= q.exchange / g;  // so that their product is what the points say
        g = q.exchange;
    }
    g = std::min({g, na.area, nb.area});
    End end_a = end_of(a, b, ra / d, project_a, g, guide), end_b = end_of(b, a, rb / d, project_b, g, guide);
    // Tables tell patches apart, one share for all of an end does not.
    const auto leaks = [&](const Node& n, EndMode mode) { return (mode != EndMode::Outside || n.kind != NodeKind::Bins) && areas_.mixed(n); };
    if (leaks(na, end_a.mode) || leaks(nb, end_b.mode)) return split(a, b, ra >= rb);
    end_a.received = std::hypot(end_a.received, uneven_a);
    end_b.received = std::hypot(end_b.received, uneven_b);
    const double low = by_centres ? std::hypot(end_a.horizon, end_b.horizon) : points_error;
    const double error_a = std::hypot(end_a.received, end_b.sent, low), error_b = std::hypot(end_b.received, end_a.sent, low);
    if (!negligible && harm_of(guide, o, g * error_a, g * error_b) > 1) {
        // Split the end that does more of it. What a low direction makes uncertain at one end, the other's extent causes.
        const double part_a = low * ra / (ra + rb), part_b = low * rb / (ra + rb);
        const double by_a = harm_of(guide, o, g * std::hypot(end_a.received, part_a), g * std::hypot(end_a.sent, part_a));
        const double by_b = harm_of(guide, o, g * std::hypot(end_b.sent, part_b), g * std::hypot(end_b.received, part_b));
        const Verdict v = split(a, b, by_a >= by_b);
        if (v.action != Verdict::Action::Accept) return v;
    }
    o.mode_a = end_a.mode;
    o.mode_b = end_b.mode;
    o.own = own;
    o.negligible = negligible;
    o.exchange = g;
    const double unknown = negligible && near ? 1.0 : 0.0;  // it may be too near for any of this
    o.error_a = std::hypot(error_a, unknown);
    o.error_b = std::hypot(error_b, unknown);
    return settle_far(o, end_a, end_b, w, d, guide);
}

// o: as if the ends' objects hid nothing of themselves, errors relative. w: from a to b; d: their distance.
Verdict LinkBuilder::settle_far(Offer o, const End& end_a, const End& end_b, const Vec3& w, double d, const Guide& guide) const {
    const Node &na = nodes_[o.a], &nb = nodes_[o.b];
    const double g = o.exchange;
    // What an end hides of itself is part of what its object hides.
    const double share_a = o.own >= 0 ? 1 : areas_.visible_share(na, w, end_a.mode);
    const double share_b = o.own >= 0 ? 1 : areas_.visible_share(nb, -w, end_b.mode);
    // One share for all of an end: which of its faces are hidden is known to Bins outside alone.
    const auto hidden = [&](const Node& n, EndMode mode, double share) {
        if (n.kind == NodeKind::Surface || (n.kind == NodeKind::Bins && mode == EndMode::Outside)) return 0.0;
        return std::hypot(std::sqrt(std::max(0.0, share * (1 - share))), kMissedGap * std::max(0.0, 1 - share));
    };
    const double hidden_a = hidden(na, end_a.mode, share_a), hidden_b = hidden(nb, end_b.mode, share_b);
    if (!o.negligible && harm_of(guide, o, g * hidden_a, g * hidden_b) > 1)
        return split(o.a, o.b, harm(guide, nodes_, o.a, o.b, g * hidden_a) >= harm(guide, nodes_, o.b, o.a, g * hidden_b));
    if (share_a <= 0 || share_b <= 0) return {};

    // Bins hold their own projection and, outside, their own visibility.
    const auto strength = [](const Node& n, const End& end, double share) {
        if (n.kind != NodeKind::Bins) return end.projection * share;
        return end.mode == EndMode::Outside ? 1.0 : share;
    };
    o.exchange = g * share_a * share_b;
    o.base_a = o.base_b = strength(na, end_a, share_a) * strength(nb, end_b, share_b) / (d * d);
    o.error_a = std::hypot(o.exchange * o.error_a, g * hidden_a);
    o.error_b = std::hypot(o.exchange * o.error_b, g * hidden_b);
    return settle(o, guide);
}

double LinkBuilder::shadow_share(const Node& n) const { return n.kind == NodeKind::Surface ? kShadowWithinFace : 1.0; }

Verdict LinkBuilder::settle(const Offer& o, const Guide& guide) const {
    const Node &na = nodes_[o.a], &nb = nodes_[o.b];
    const double loud = std::max(noise_harm(guide, nodes_, o.a, o.b, o.exchange), noise_harm(guide, nodes_, o.b, o.a, o.exchange));
    const double shadow_a = o.exchange * shadow_share(na), shadow_b = o.exchange * shadow_share(nb);
    const double edge = o.negligible ? 0.0 : harm_of(guide, o, shadow_a, shadow_b);
    Transmittance t;
    Verdict v;
    const std::uint64_t begun = ticks();
    if (o.a != o.b) t = transmittance(o, loud / kNoiseShare, edge);
    v.visibility_ticks = ticks() - begun;
    v.rays = t.rays;
    v.looked = true;
    const double deviation = std::sqrt(t.spread);
    if ((t.edge || o.own >= 0) && !o.negligible && harm_of(guide, o, deviation * shadow_a, deviation * shadow_b) > 1) {
        v.action = split(o.a, o.b, na.radius >= nb.radius).action;
        if (v.action != Verdict::Action::Accept) return v;
    }
    v.action = Verdict::Action::Accept;
    if (built_in("medium") && medium_most_ > 0) {
        // Absorbed over the distance between the centres; the rest of the ends lies nearer or farther. A link carries what all
        // channels lose; what some lose beyond that is the sweeps' (gather.h).
        const double extinct = medium_ * length(nb.centre - na.centre);
        const double spread = medium_most_ * double(na.radius + nb.radius) * kAlong;
        t.mean *= std::exp(-extinct);
        const double uneven = o.exchange * t.mean * std::min(1.0, spread);
        if (!o.negligible && o.a != o.b && harm_of(guide, o, uneven * kWithinMedium, uneven * kWithinMedium) > 1) {
            Verdict divided = split(o.a, o.b, na.radius >= nb.radius);
            divided.looked = true;
            if (divided.action != Verdict::Action::Accept) return divided;
        }
    }
    Link& l = v.link;
    l.a = o.a;
    l.b = o.b;
    l.base_a = static_cast<float>(o.base_a * t.mean);
    l.base_b = static_cast<float>(o.base_b * t.mean);
    l.error_a = static_cast<float>(std::hypot(o.error_a * t.mean, deviation * shadow_a));
    l.error_b = static_cast<float>(std::hypot(o.error_b * t.mean, deviation * shadow_b));
    l.noise = static_cast<float>(o.exchange * std::sqrt(t.variance));
    l.mode_a = o.mode_a;
    l.mode_b = o.mode_b;
    return v;
}

}  // namespace rro
