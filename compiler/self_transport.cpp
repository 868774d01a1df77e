#include "compiler/self_transport.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numbers>
#include <optional>

#include "compiler/direction_images.h"
#include "format/form_factor.h"
#include "format/parallel.h"
#include "format/sample_points.h"
#include "format/self_links.h"

namespace rro {
namespace {

// The error that a link may bring to a patch of mean area, in units of the patch's own radiosity; to smaller ones less
// in power, more in radiosity.
constexpr double kTolerance = 0.01;
// Beyond so many pairs, and so many more for each patch, the tolerance grows with the square of their number: foliage, where everything
// sees a little of everything, would have hundreds of links for each patch, most of them of no consequence.
constexpr double kManyPairs = 40000, kPairsPerPatch = 20;
// Clusters whose normals lie within this cosine of their mean radiate and receive like a plate.
constexpr double kFlatCone = 0.8;
constexpr double kTiltError = 0.5;
// All links of a round cluster err the same way: too much for what looks away, too little for what looks there. So their
// errors add up instead of averaging out, some tens of links to a cluster.
constexpr double kRoundError = 10;
// What a patch receives through a partly hidden link differs from the link's mean by about this share of what single
// lines differ by: a patch sees the other end along many of them.
constexpr double kShadowShare = 0.5;
// One sample of a pair says little about clusters nearer than this many radii.
constexpr double kSeparated = 2;
// Patches nearer than this many radii, and of few faces, take the exact kernel.
constexpr double kKernelRadii = 3;
constexpr std::uint32_t kKernelFaces = 64;
constexpr std::uint32_t kKernelPoints = 16;
constexpr std::uint32_t kKernelLines = 4;  // from each point
constexpr std::uint32_t kCandidates = 4;   // for the far end of each of these lines

// Points on each cluster, evenly by area. Lines pair those of two clusters off, in several orders.
constexpr std::uint32_t kPoints = 32;
constexpr std::uint32_t kJudgeLines = 8;
// The lines of a link, others than those that judged it: a pair accepted for the little light that some lines found
// would keep too little. As many as its light deserves, and never fewer because they agree, for the same reason.
constexpr std::uint32_t kFewestLines = 8, kMostLines = 64;
constexpr double kVisibilityShare = 0.5;  // of the tolerance: standard deviation of half the lines blocked
constexpr std::uint32_t kNextOrder = 13;  // from one order of pairing off to the next; odd: never the same one soon
// Lines between points keep this share of their length from either end, and a few roundings of the coordinates.
constexpr float kLineMargin = 1e-4f;
constexpr float kRounding = 4e-7f;

struct Pair {
    std::uint32_t a, b;
};

Vec3f difference(const Vec3f& a, const Vec3f& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
float product(const Vec3f& a, const Vec3f& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

/// Faces of the object as samples need them; positions relative to its origin.
class FaceSampler {
  public:
    explicit FaceSampler(const ObjectData& object) : object_(object) {
        area_before_.reserve(object.faces.size() + 1);
        area_before_.push_back(0);
        normal_.reserve(object.faces.size());
        for (const Face f : object.faces) {
            const Vec3 area = area_vector(corners(f));
            normal_.push_back(normalised(area));
            area_before_.push_back(area_before_.back() + length(area));
        }
    }

    struct Point {
        Vec3 position, normal;
    };

    TriangleCorners corners(Face f) const {
        const TriangleIndices& t = object_.triangles[f.triangle()];
        TriangleCorners c{to_double(object_.positions[t[0]]), to_double(object_.positions[t[1]]),
                          to_double(object_.positions[t[2]])};
        if (f.side() == Side::Back) std::swap(c[1], c[2]);
        return c;
    }

    /// A point of the faces [begin, end), evenly by area over (u, v) in the unit square.
    Point point(std::uint32_t begin, std::uint32_t end, double u, double v) const {
        const double target = area_before_[begin] + u * area(begin, end);
        const auto first = area_before_.begin();
        auto f = static_cast<std::uint32_t>(std::upper_bound(first + begin + 1, first + end, target) - first - 1);
        f = std::min(f, end - 1);
        const double width = area_before_[f + 1] - area_before_[f];
        const double s = width > 0 ? std::clamp((target - area_before_[f]) / width, 0.0, 1.0) : 0.5;
        const std::array<double, 2> b = square_to_triangle(s, v);
        return {triangle_point(corners(object_.faces[f]), b[0], b[1]), normal_[f]};
    }

    double area(std::uint32_t begin, std::uint32_t end) const { return area_before_[end] - area_before_[begin]; }

  private:
    const ObjectData& object_;
    std::vector<double> area_before_;  // [F + 1]
    std::vector<Vec3> normal_;         // [F]
};

/// A cluster as the end of a pair.
struct End {
    std::uint32_t begin, end;  // faces
    Vec3 centre, normal;
    Box3 box;
    double area, radius, cone;  // cone: half angle, pi where normals look every way
    bool flat, patch;
};

/// What a pair becomes.
struct Verdict {
    PairStep step = PairStep::Dark;
    double exchange = 0, visibility = 0;
};

class PairJudge {
  public:
    PairJudge(const ObjectData& object, const ObjectRays& rays) : object_(object), rays_(rays), sampler_(object) {
        mean_area_ = object.meta.area / static_cast<double>(object.patches.size());
        for (const Vec3f& p : object.positions) rounding_ = std::max(rounding_, kRounding * std::sqrt(product(p, p)));
        ends_.reserve(object.clusters.size());
        for (const Cluster& c : object.clusters) ends_.push_back(make_end(c));
        points_.resize(ends_.size() * kPoints);
        parallel_for(ends_.size(), 64, [&](std::size_t c) {
            for (std::uint32_t k = 0; k < kPoints; ++k) {
                const auto s = sobol4(k, mix64(c));
                const auto at = sampler_.point(ends_[c].begin, ends_[c].end, double(s[0]), double(s[1]));
                points_[c * kPoints + k] = {to_float(at.position), to_float(at.normal)};
            }
        });
    }

    Verdict judge(const Pair& p, double tolerance) const {
        return p.a == p.b ? judge_self(p.a, tolerance) : judge_two(p.a, p.b, tolerance);
    }

  private:
    struct Point {
        Vec3f position, normal;
    };

    End make_end(const Cluster& c) const {
        End e;
        const Patch& last = object_.patches[c.first_patch + c.patch_count - 1];
        e.begin = object_.patches[c.first_patch].first_face;
        e.end = last.first_face + last.face_count;
        e.centre = c.centre();
        e.normal = to_double(c.normal);
        e.box.lo = to_double(c.lo), e.box.hi = to_double(c.hi);
        e.area = sampler_.area(e.begin, e.end);
        e.radius = static_cast<double>(c.radius);
        e.patch = c.right_child == 0;
        const double cosine = static_cast<double>(c.cone_cosine);
        e.flat = e.patch || cosine >= kFlatCone;
        e.cone = cosine > -1 && length2(e.normal) > 0 ? std::acos(std::min(1.0, cosine)) : std::numbers::pi;
        return e;
    }

    /// False only where no point of `to` lies in front of any face of `from`.
    static bool may_see(const End& from, const End& to) {
        const Vec3 w = to.centre - from.centre;
        const double d = length(w), reach = from.radius + to.radius;
        if (from.cone >= 0.5 * std::numbers::pi) return true;
        if (from.cone < 1e-3) {  // a plane, or planes one behind the other: the box is tighter than the sphere
            const Vec3& n = from.normal;
            const Vec3 farthest{n.x > 0 ? to.box.hi.x : to.box.lo.x, n.y > 0 ? to.box.hi.y : to.box.lo.y,
                                n.z > 0 ? to.box.hi.z : to.box.lo.z};
            const Vec3 lowest{n.x > 0 ? from.box.lo.x : from.box.hi.x, n.y > 0 ? from.box.lo.y : from.box.hi.y,
                              n.z > 0 ? from.box.lo.z : from.box.hi.z};
            return dot(n, farthest - lowest) > 1e-6 * reach;
        }
        if (d <= reach) return true;
        const double tilt = std::acos(std::clamp(dot(from.normal, w) / d, -1.0, 1.0));
        return tilt - from.cone - std::asin(reach / d) < 0.5 * std::numbers::pi;
    }

    /// Directions that leave the front of one and reach the front of the other lie in a lune between their planes: of
    /// form factor (1 - cos t) / 2 for an angle t between the normals.
    static double largest_share(const End& a, const End& b) {
        if (a.cone >= std::numbers::pi || b.cone >= std::numbers::pi) return 1;
        const double t = std::acos(std::clamp(dot(a.normal, b.normal), -1.0, 1.0)) + a.cone + b.cone;
        return t < std::numbers::pi ? 0.5 - 0.5 * std::cos(t) : 1;
    }

    static double relative_error(const End& e, double distance) {
        if (!e.flat) return kRoundError;
        return std::min(1.0, e.radius / distance + kTiltError * (1 - std::cos(e.cone)));
    }

    Verdict judge_self(std::uint32_t cluster, double patch_tolerance) const {
        const End& e = ends_[cluster];
        if (e.cone < 1e-6) return {};  // one plane, or several that look the same way
        if (!e.patch) return {PairStep::SplitSelf, 0, 0};
        if (e.end - e.begin == 1) return {};
        if (e.end - e.begin <= kKernelFaces) return link(near_by(e, e, mix64(cluster)));
        return link(lines_of_link(cluster, cluster, e.area, patch_tolerance * std::sqrt(e.area * mean_area_)));
    }

    Verdict judge_two(std::uint32_t first, std::uint32_t second, double patch_tolerance) const {
        const End &a = ends_[first], &b = ends_[second];
        if (!may_see(a, b) || !may_see(b, a)) return {};
        const double distance = length(b.centre - a.centre), widest = std::max(a.radius, b.radius);
        const double tolerance = patch_tolerance * std::sqrt(std::min(a.area, b.area) * mean_area_);
        const double gap = std::max(0.0, distance - a.radius - b.radius);
        const double most = std::min(largest_share(a, b) * std::min(a.area, b.area),
                                     a.area * b.area / (std::numbers::pi * std::max(gap * gap, 1e-300)));
        if (!a.patch || !b.patch) {
            const PairStep split =
                !a.patch && (b.patch || a.radius >= b.radius) ? PairStep::SplitFirst : PairStep::SplitSecond;
            const bool negligible = most <= tolerance;
            if (distance < kSeparated * widest && !negligible) return {split, 0, 0};
            const double shape = std::hypot(relative_error(a, distance), relative_error(b, distance));
            Lines lines = lines_of(first, second, 0, kJudgeLines);
            // Rays are for pairs about which they can decide: not where it is too much even if none gets through.
            constexpr double kLeast = 1 / (kJudgeLines + 2.0);
            if (!negligible && lines.measured.exchange * kLeast * std::hypot(shape, 1) > tolerance) return {split, 0, 0};
            const Measured m = traced(lines);
            // Laplace's rule: lines that agree are no proof, but a sign that there is no edge of a shadow here.
            const double v = m.share();
            const double shadow = m.agree() ? std::min(v, 1 - v) : kShadowShare * std::sqrt(v * (1 - v));
            if (!negligible && m.exchange * std::hypot(v * shape, shadow) > tolerance) return {split, 0, 0};
        }
        if (a.patch && b.patch && distance < kKernelRadii * widest) {
            // Points on the smaller end see all of the larger one; points on the larger one would miss the smaller.
            const bool a_is_smaller = a.area < b.area;
            const End &points = a_is_smaller ? a : b, &polygons = a_is_smaller ? b : a;
            if (polygons.end - polygons.begin <= kKernelFaces)
                return link(near_by(points, polygons, mix64(std::uint64_t{first} << 32 | second)));
        }
        return link(lines_of_link(first, second, most, tolerance));
    }

    /// What lines between two ends say.
    struct Measured {
        double exchange = 0;              // with nothing between, m^2
        double seen = 0, unoccluded = 0;  // sums of the lines' weights
        std::uint32_t lines = 0, open = 0;

        double visibility() const { return unoccluded > 0 ? seen / unoccluded : 1; }
        double share() const { return (open + 1.0) / (lines + 2.0); }
        bool agree() const { return open == 0 || open == lines; }
    };

    static Verdict link(const Measured& m) {
        return m.exchange > 0 ? Verdict{PairStep::Link, m.exchange, m.visibility()} : Verdict{};
    }

    Measured lines_of_link(std::uint32_t first, std::uint32_t second, double exchange, double tolerance) const {
        const double deserved = std::pow(0.5 * exchange / (kVisibilityShare * tolerance), 2);
        const auto count = static_cast<std::uint32_t>(std::clamp(deserved, double(kFewestLines), double(kMostLines)));
        return traced(lines_of(first, second, kPoints, (count + kFewestLines - 1) / kFewestLines * kFewestLines));
    }

    /// Patches that nearly touch: the contour formula from points of one end to all faces of the other, and from each
    /// point lines that are as many to a face as it sends light there.
    Measured near_by(const End& points, const End& polygons, std::uint64_t seed) const {
        Measured m;
        std::array<double, kKernelFaces> sum{};  // running, over the faces
        const std::uint32_t count = polygons.end - polygons.begin;
        for (std::uint32_t k = 0; k < kKernelPoints; ++k) {
            const auto s = sobol4(k, seed);
            const auto p = sampler_.point(points.begin, points.end, double(s[0]), double(s[1]));
            double all = 0;
            for (std::uint32_t f = 0; f < count; ++f)
                sum[f] = all += point_to_triangle(p.position, p.normal, sampler_.corners(object_.faces[polygons.begin + f]));
            m.exchange += all / kKernelPoints * points.area;
            for (std::uint32_t j = 0; j < kKernelLines && all > 0; ++j) {
                const double target = (j + double(s[2])) / kKernelLines * all;
                auto f = static_cast<std::uint32_t>(std::upper_bound(sum.begin(), sum.begin() + count, target) - sum.begin());
                f = polygons.begin + std::min(f, count - 1);
                const auto line = line_to(p, f, mix64(seed + k * kKernelLines + j), double(s[3]));
                if (!line) continue;
                ++m.lines;
                m.unoccluded += all;
                if (rays_.occluded(*line)) continue;
                m.seen += all;
                ++m.open;
            }
        }
        return m;
    }

    /// A line from a point to a face, to one of a few candidates there, spread by the solid angle that they fill, by how much
    /// light goes that way (resampled importance sampling; Talbot et al. 2005); nothing where no candidate is in front.
    std::optional<ObjectRay> line_to(const FaceSampler::Point& p, std::uint32_t face, std::uint64_t seed, double choice) const {
        const SeenTriangle seen(p.position, sampler_.corners(object_.faces[face]));
        if (!(seen.solid_angle() > 0)) return std::nullopt;
        std::array<Vec3, kCandidates> w;
        std::array<double, kCandidates> sum;
        double all = 0;
        for (std::uint32_t c = 0; c < kCandidates; ++c) {
            const auto s = sobol4(c, seed);
            w[c] = seen.point(double(s[0]), double(s[1])) - p.position;
            const double out = dot(p.normal, w[c]);
            if (out > 0) all += out / length(w[c]);
            sum[c] = all;
        }
        if (!(all > 0)) return std::nullopt;
        const auto chosen = static_cast<std::size_t>(std::upper_bound(sum.begin(), sum.end() - 1, choice * all) - sum.begin());
        const double margin = double(kLineMargin) + double(rounding_) / length(w[chosen]);
        if (!(margin < 0.5)) return std::nullopt;
        return ObjectRay{to_float(p.position), to_float(w[chosen]), static_cast<float>(margin), static_cast<float>(1 - margin)};
    }

    /// Lines of a pair that leave both fronts, and their share of the exchange each.
    struct Lines {
        std::array<ObjectRay, kMostLines> rays;
        std::array<double, kMostLines> weights;
        Measured measured;  // with nothing between
    };

    /// Lines number begin .. begin + count of the pair: the points of one end, with the points of the other in an order
    /// that differs from pair to pair.
    Lines lines_of(std::uint32_t first, std::uint32_t second, std::uint32_t begin, std::uint32_t count) const {
        const End &a = ends_[first], &b = ends_[second];
        const std::uint64_t seed = mix64(std::uint64_t{first} << 32 | second);
        Lines lines;
        Measured& m = lines.measured;
        for (std::uint32_t k = begin; k < begin + count; ++k) {
            const std::uint32_t round = k / kPoints, own = k % kPoints;
            const std::uint32_t other = own ^ static_cast<std::uint32_t>((seed + kNextOrder * round) % kPoints);
            const Point& p = points_[first * kPoints + own];
            const Point& q = points_[second * kPoints + other];
            const Vec3f w = difference(q.position, p.position);
            const float d2 = product(w, w), out = product(p.normal, w), in = -product(q.normal, w);
            if (out <= 0 || in <= 0 || d2 <= 0) continue;
            const float margin = kLineMargin + rounding_ / std::sqrt(d2);
            if (margin >= 0.5f) continue;
            const double square = static_cast<double>(d2);
            lines.weights[m.lines] = static_cast<double>(out) * static_cast<double>(in) / (square * square);
            lines.rays[m.lines] = {p.position, w, margin, 1 - margin};
            m.unoccluded += lines.weights[m.lines++];
        }
        const double mean = m.unoccluded / count * a.area * b.area / std::numbers::pi;
        // A patch's form factor is at most 1; faces of wider clusters may stand before one another and add up to more.
        m.exchange = a.patch && b.patch ? std::min({mean, a.area, b.area}) : mean;
        return lines;
    }

    /// What the object leaves of them.
    Measured traced(const Lines& lines) const {
        Measured m = lines.measured;
        for (std::uint32_t k = 0; k < m.lines; ++k) {
            if (rays_.occluded(lines.rays[k])) continue;  // too far apart for packets to pay
            m.seen += lines.weights[k];
            ++m.open;
        }
        return m;
    }

    const ObjectData& object_;
    const ObjectRays& rays_;
    FaceSampler sampler_;
    std::vector<End> ends_;      // [C]
    std::vector<Point> points_;  // [C * kPoints]
    double mean_area_ = 0;
    float rounding_ = 0;
};

/// A pair of the tree while it grows, level by level.
struct Growing {
    Pair pair;
    Verdict verdict;
    std::uint32_t first_child = 0, child_count = 0;
};

void push_children(const ObjectData& object, std::vector<Growing>& tree, std::size_t at) {
    const auto [a, b] = tree[at].pair;
    const auto right = [&](std::uint32_t c) { return object.clusters[c].right_child; };
    tree[at].first_child = static_cast<std::uint32_t>(tree.size());
    const auto push = [&](std::uint32_t x, std::uint32_t y) { tree.push_back({{x, y}, {}}); };
    switch (tree[at].verdict.step) {
        case PairStep::Dark:
        case PairStep::Link: break;
        case PairStep::SplitFirst: push(a + 1, b), push(right(a), b); break;
        case PairStep::SplitSecond: push(a, b + 1), push(a, right(b)); break;
        case PairStep::SplitSelf: push(a + 1, a + 1), push(a + 1, right(a)), push(right(a), right(a)); break;
    }
    tree[at].child_count = static_cast<std::uint32_t>(tree.size()) - tree[at].first_child;
}

/// Pairs whose whole subtree is hidden or dark become one link.
void join_hidden(std::vector<Growing>& tree) {
    for (std::size_t i = tree.size(); i-- > 0;) {
        Growing& g = tree[i];
        if (g.child_count == 0) continue;
        const auto children = std::span(tree).subspan(g.first_child, g.child_count);
        const bool hidden = std::all_of(children.begin(), children.end(), [](const Growing& c) {
            return c.child_count == 0 && c.verdict.visibility == 0;
        });
        if (!hidden) continue;
        double exchange = 0;
        for (const Growing& c : children) exchange += (g.pair.a == g.pair.b && c.pair.a != c.pair.b ? 2 : 1) * c.verdict.exchange;
        g.verdict = {exchange > 0 ? PairStep::Link : PairStep::Dark, exchange, 0};
        g.child_count = 0;
    }
}

/// No patch receives more than it would inside a closed white room: 1 under unit radiosity all around. Where links of a
/// cluster and of those above it say clearly more (small scraps between large faces, of which few lines hit the nearest
/// parts), its own links are scaled down. A little more is noise, as likely as a little less, and stays.
void bound_rows(const ObjectData& object, std::vector<Growing>& tree) {
    const std::size_t count = object.clusters.size();
    std::vector<double> direct(count, 0), above(count, 0), factor(count, 1);
    const auto area = [&](std::uint32_t c) { return std::max(static_cast<double>(object.clusters[c].area), 1e-300); };
    const auto is_link = [](const Growing& g) { return g.child_count == 0 && g.verdict.step == PairStep::Link; };
    for (const Growing& g : tree) {
        if (!is_link(g)) continue;
        const double seen = g.verdict.exchange * g.verdict.visibility;
        direct[g.pair.a] += seen / area(g.pair.a);
        if (g.pair.a != g.pair.b) direct[g.pair.b] += seen / area(g.pair.b);
    }
    for (std::uint32_t c = 0; c < count; ++c) {  // parents come first
        constexpr double kClearlyMore = 1.5;
        if (direct[c] > 0 && above[c] + direct[c] > kClearlyMore)
            factor[c] = std::max(0.0, kClearlyMore - above[c]) / direct[c];
        const double own = above[c] + factor[c] * direct[c];
        if (const std::uint32_t right = object.clusters[c].right_child; right != 0) above[c + 1] = above[right] = own;
    }
    for (Growing& g : tree)
        if (is_link(g)) g.verdict.exchange *= std::min(factor[g.pair.a], factor[g.pair.b]);
}

void write_preorder(const std::vector<Growing>& tree, SelfLinks& links) {
    std::vector<std::uint32_t> open{0};
    while (!open.empty()) {
        const Growing& g = tree[open.back()];
        open.pop_back();
        links.steps.push_back(static_cast<std::uint8_t>(g.verdict.step));
        if (g.verdict.step == PairStep::Link) {
            links.exchange.push_back(static_cast<float>(g.verdict.exchange));
            links.visibility.push_back(
                static_cast<std::uint8_t>(std::lround(255 * std::clamp(g.verdict.visibility, 0.0, 1.0))));
        }
        for (std::uint32_t k = g.child_count; k-- > 0;) open.push_back(g.first_child + k);
    }
}

}  // namespace

SelfLinks measure_self_links(const ObjectData& object, const ObjectRays& rays) {
    SelfLinks links;
    if (object.meta.convex) return links;
    const PairJudge judge(object, rays);
    std::vector<Growing> tree{{{0, 0}, {}}};
    for (std::size_t level = 0; level < tree.size();) {
        const std::size_t end = tree.size();
        constexpr std::size_t kGrain = 64;
        const double crowding =
            static_cast<double>(end) / (kManyPairs + kPairsPerPatch * static_cast<double>(object.patches.size()));
        const double tolerance = kTolerance * std::max(1.0, crowding * crowding);
        parallel_for(end - level, kGrain,
                     [&](std::size_t k) { tree[level + k].verdict = judge.judge(tree[level + k].pair, tolerance); });
        for (; level < end; ++level) push_children(object, tree, level);
    }
    join_hidden(tree);
    bound_rows(object, tree);
    const bool any = std::any_of(tree.begin(), tree.end(), [](const Growing& g) { return g.verdict.step == PairStep::Link; });
    if (any) write_preorder(tree, links);
    return links;
}

namespace {

/// Received light per patch under unit radiosity: links of a cluster are shared by its patches.
std::vector<float> received_shares(const ObjectData& object) {
    std::vector<double> cluster(object.clusters.size(), 0);
    for (const SelfPair& pair : self_pairs(object)) {
        if (pair.step != PairStep::Link) continue;
        const double seen = static_cast<double>(pair.seen);
        const auto add = [&](std::uint32_t c) {
            if (object.clusters[c].area > 0) cluster[c] += seen / static_cast<double>(object.clusters[c].area);
        };
        add(pair.a);
        if (pair.a != pair.b) add(pair.b);
    }
    std::vector<float> shares(object.patches.size(), 0);
    for (std::size_t c = 0; c < object.clusters.size(); ++c) {
        const std::uint32_t right = object.clusters[c].right_child;
        if (right == 0) {
            shares[object.clusters[c].first_patch] = static_cast<float>(cluster[c]);
        } else {
            cluster[c + 1] += cluster[c];
            cluster[right] += cluster[c];
        }
    }
    return shares;
}

}  // namespace

Closure measure_light_shares(const ObjectData& object, const ObjectRays& rays) {
    constexpr std::uint32_t kEscapeSamples = 128;  // of the table; a smooth function
    constexpr std::uint32_t kBlackSamples = 32;    // rays: a share is known to 0.05 or better
    const DirectionGrid grid(object.meta.grid_map, object.meta.grid_size);
    const FaceSampler sampler(object);
    const std::vector<std::uint32_t> face_by_side = faces_by_side(object);
    const bool has_black = object.faces.size() < 2 * object.triangles.size();
    const double reach = length(object.meta.bounds.extent()) * 2;
    Closure closure;
    closure.received = received_shares(object);
    closure.escape.resize(object.patches.size());
    closure.black.resize(object.patches.size());
    parallel_for(object.patches.size(), 16, [&](std::size_t p) {
        const Patch& patch = object.patches[p];
        const auto row = object.visibility.subspan(p * grid.size(), grid.size());
        const std::uint64_t seed = mix64(p);
        const auto draw = [&](std::uint32_t k) {
            const auto s = sobol4(k, seed);
            const auto from = sampler.point(patch.first_face, patch.first_face + patch.face_count, double(s[0]), double(s[1]));
            const auto frame = frame_about(from.normal);
            const Vec3 local = square_to_cosine_hemisphere(double(s[2]), double(s[3]));
            return std::pair{from.position, frame[0] * local.x + frame[1] * local.y + frame[2] * local.z};
        };
        double escape = 0;
        for (std::uint32_t k = 0; k < kEscapeSamples; ++k) escape += grid.interpolate(row, draw(k).second);
        closure.escape[p] = static_cast<float>(escape / (255.0 * kEscapeSamples));
        if (!has_black || object.meta.convex) return;
        std::array<ObjectRay, kBlackSamples> lines;
        std::array<ObjectHit, kBlackSamples> hits;
        for (std::uint32_t k = 0; k < kBlackSamples; ++k) {
            const auto [origin, direction] = draw(k);
            lines[k] = {to_float(origin), to_float(direction), static_cast<float>(1e-6 * reach), static_cast<float>(reach)};
        }
        rays.first_hits(lines, hits);
        std::uint32_t black = 0;
        for (std::uint32_t k = 0; k < kBlackSamples; ++k) {
            if (hits[k].triangle == kNoTriangle) continue;
            const bool front = dot(area_vector(object.corners(hits[k].triangle)), to_double(lines[k].direction)) < 0;
            const Face face = Face::make(hits[k].triangle, front ? Side::Front : Side::Back);
            black += face_by_side[face.packed] == kBlackSide ? 1 : 0;
        }
        closure.black[p] = static_cast<float>(black) / kBlackSamples;
    });
    return closure;
}

}  // namespace rro
