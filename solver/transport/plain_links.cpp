#include "solver/transport/plain_links.h"

#include <algorithm>
#include <numbers>

#include "format/form_factor.h"
#include "format/parallel.h"
#include "format/sample_points.h"

namespace rro {

namespace {

// The paper's first round. Points on faces that look away from one another are drawn anew: a closed body shows half its
// faces, so of two one draw in four counts.
constexpr std::uint32_t kRays = 16, kMostDraws = 8 * kRays;

// The kernel's own error: far below that of 16 rays.
constexpr double kKernelTolerance = 0.01;
constexpr int kKernelDepth = 4;

constexpr std::size_t kBatch = 1 << 16;  // pairs judged at a time; bounds the memory of the verdicts
constexpr std::size_t kGrain = 64;

double cone_angle(const Node& n) { return std::acos(std::clamp(double(n.cone_cosine), -1.0, 1.0)); }

/// False only where no point of `to` lies in front of any face of `from`.
bool may_see(const Node& from, const Node& to) {
    if (from.cone_cosine <= -1) return true;
    const Vec3 w = to.centre - from.centre;
    const double d = length(w), reach = double(to.radius) + (from.planar() ? 0.0 : double(from.radius));
    if (d <= reach) return true;
    const double tilt = std::acos(std::clamp(dot(from.normal(), w) / d, -1.0, 1.0));
    return tilt - cone_angle(from) - std::asin(reach / d) < 0.5 * std::numbers::pi;
}

/// The largest part of the hemisphere above a face of one that faces of the other can fill: what leaves the front of one
/// plane and reaches the front of another lies between them, a lune of form factor (1 - cos t) / 2 at an angle t.
double largest_share(const Node& a, const Node& b) {
    if (a.cone_cosine <= -1 || b.cone_cosine <= -1) return 1;
    const double t = std::acos(std::clamp(dot(a.normal(), b.normal()), -1.0, 1.0)) + cone_angle(a) + cone_angle(b);
    return t < std::numbers::pi ? 0.5 - 0.5 * std::cos(t) : 1.0;
}

/// No exchange area between the two is larger, m^2: each lies in a sphere.
double largest_exchange(const Node& a, const Node& b) {
    if (&a == &b) return a.cone_cosine > 0 ? a.area * (1 - double(a.cone_cosine) * double(a.cone_cosine)) : a.area;
    const double d = length(b.centre - a.centre), ra = double(a.radius), rb = double(b.radius);
    const auto cap = [](double radius, double distance) {
        return distance > radius ? radius * radius / (distance * distance) : 1.0;
    };
    return largest_share(a, b) * std::min(a.area * cap(rb, d - ra), b.area * cap(ra, d - rb));
}

struct Drawn {
    std::uint32_t surface;
    double rest;  // what of the random number is left, in [0, 1]
};

/// A face of a node by one random number, even over area (that of the archive, before the transform).
Drawn draw_face(const Nodes& nodes, const EndAreas& areas, std::uint32_t id, double u) {
    const Node& n = nodes[id];
    if (n.planar()) return {id, u};
    const auto range = nodes.faces(n);
    const std::vector<double>& sum = areas.tables(n.instance).face_area_sum;
    const double target = sum[range[0]] + u * (sum[range[1]] - sum[range[0]]);
    const auto above = std::upper_bound(sum.begin() + range[0] + 1, sum.begin() + range[1], target);
    const auto f = static_cast<std::uint32_t>(above - sum.begin() - 1);
    const double width = sum[f + 1] - sum[f];
    return {nodes.instance(n.instance).first_face + f, width > 0 ? std::clamp((target - sum[f]) / width, 0.0, 1.0) : 0.5};
}

Vec3 point_on(const Nodes& nodes, const Drawn& drawn, double v) {
    const auto b = square_to_triangle(drawn.rest, v);
    return triangle_point(nodes.corners(drawn.surface), b[0], b[1]);
}

/// Does all of `to` lie behind the face `from`?
bool behind(const Node& from, const Node& to) {
    return dot(from.area_vector, to.centre - from.centre) < -from.area * double(to.radius);
}

}  // namespace

PlainLinker::PlainLinker(const Nodes& nodes, const EndAreas& areas, const SceneRays& rays,
                         const TransportOptions& options, bool within_instances)
    : nodes_(nodes), areas_(areas), rays_(rays), options_(options), within_instances_(within_instances) {}

bool PlainLinker::hides_nothing_of_itself(const Node& n) const {
    return nodes_.instance(n.instance).planar || nodes_.scene().instances[n.instance].data().meta.convex;
}

double PlainLinker::most_power(std::uint32_t a, std::uint32_t b, const std::vector<float>& light) const {
    return double(std::max(light[a], light[b])) * largest_exchange(nodes_[a], nodes_[b]);
}

// The size of a node towards w: from the archive's tables, of the whole object where the other end lies outside its
// bounds and of the cluster by itself where it may lie within; where there is none, the faces' cosines.
PlainLinker::End PlainLinker::effective(const Node& n, const Node& other, const Vec3& w) const {
    const bool solid = hides_nothing_of_itself(n);
    if (n.planar()) return {std::max(0.0, dot(n.area_vector, w)), solid};
    const Instance& instance = nodes_.scene().instances[n.instance];
    const ObjectData& data = instance.data();
    const bool outside = n.instance != other.instance && !instance.bounds.overlaps(other.box);
    const auto table = outside ? data.whole_area : data.intrinsic_area;
    const std::uint32_t row = areas_.tables(n.instance).area_row[n.index];
    if (row != kNoNode && !table.empty() && !n.part()) {
        // A map changes the area projected along a line by its determinant over the stretch of that line.
        const Vec3 local = instance.to_local.vector(w);
        const double stretch = std::abs(instance.to_world.linear.determinant()) * length(local);
        const double scale = double(outside ? data.whole_area_scale[row] : data.intrinsic_area_scale[row]) / 255;
        const DirectionGrid& grid = instance.object->archive.grid();
        const double stored = grid.interpolate(table.subspan(std::size_t{row} * grid.size(), grid.size()), local);
        return {stored * scale * stretch, solid || outside};
    }
    double sum = 0;
    const auto range = nodes_.faces(n);
    const std::uint32_t first = nodes_.instance(n.instance).first_face;
    for (std::uint32_t f = range[0]; f < range[1]; ++f) sum += std::max(0.0, dot(nodes_[first + f].area_vector, w));
    return {sum, solid};
}

// The share of a fixed number of rays between random points of both ends that nothing blocks (paper 3). Rays at an end
// with an intrinsic area test all of its object: what the cluster hides of itself counts twice there.
PlainLinker::Visibility PlainLinker::visibility(std::uint32_t a, std::uint32_t b, bool own_counted_a,
                                                bool own_counted_b) const {
    Visibility v;
    if (options_.visibility == VisibilityMethod::None) return v;
    const Node &na = nodes_[a], &nb = nodes_[b];
    thread_local Candidates candidates;
    rays_.candidates(na.box, nb.box, candidates);
    std::erase_if(candidates, [&](std::uint32_t i) {
        return (own_counted_a && i == na.instance) || (own_counted_b && i == nb.instance);
    });
    if (candidates.empty()) return v;
    const std::uint64_t seed = mix64(mix64(std::uint64_t{a} << 32 | b) ^ options_.seed);
    std::uint32_t open = 0;
    for (std::uint32_t k = 0; k < kMostDraws && v.rays < kRays; ++k) {
        const auto s = sobol4(k, seed);
        const Drawn on_a = draw_face(nodes_, areas_, a, double(s[0])), on_b = draw_face(nodes_, areas_, b, double(s[2]));
        const Node &fa = nodes_[on_a.surface], &fb = nodes_[on_b.surface];
        if (behind(fa, fb) || behind(fb, fa)) continue;
        const Vec3 p = point_on(nodes_, on_a, double(s[1])), q = point_on(nodes_, on_b, double(s[3])), w = q - p;
        if (dot(fa.area_vector, w) <= 0 || dot(fb.area_vector, w) >= 0) continue;
        ++v.rays;
        if (!rays_.occluded(p, q, {fa.instance, nodes_.triangle_of(fa)}, {fb.instance, nodes_.triangle_of(fb)}, candidates))
            ++open;
    }
    v.mean = v.rays > 0 ? double(open) / v.rays : 0.0;  // 0: no two points face one another
    return v;
}

// Two coaxial disks of the ends' effective areas (paper 2, figure 5).
PlainLinker::Verdict PlainLinker::by_disks(std::uint32_t a, std::uint32_t b, PlainKind kind) const {
    const Node &na = nodes_[a], &nb = nodes_[b];
    const Vec3 between = nb.centre - na.centre;
    const double d = length(between);
    // Where a coarse link would carry nothing its parts still may, once there is more light.
    Verdict v;
    v.action = kind == PlainKind::Coarse ? Verdict::Action::Accept : Verdict::Action::Drop;
    v.link = {a, b, 0, kind};
    if (!(d > 0)) return v;
    const Vec3 w = between / d;
    const End end_a = effective(na, nb, w), end_b = effective(nb, na, -w);
    if (!(end_a.area > 0 && end_b.area > 0)) return v;
    const auto radius = [&](const End& e) { return std::sqrt(e.area * std::numbers::inv_pi) / d; };
    const double exchange =
        std::min(end_a.area * disk_to_disk(radius(end_a), radius(end_b)), largest_exchange(na, nb));
    const Visibility seen = visibility(a, b, end_a.own_counted, end_b.own_counted);
    v.rays = seen.rays;
    v.link.exchange = static_cast<float>(exchange * seen.mean);
    if (v.link.exchange > 0) v.action = Verdict::Action::Accept;
    return v;
}

PlainLinker::Verdict PlainLinker::by_kernel(std::uint32_t a, std::uint32_t b) const {
    const double exchange = exchange_area(nodes_.corners(a), nodes_.corners(b), kKernelTolerance, kKernelDepth);
    Verdict v;
    if (!(exchange > 0)) return v;
    const Visibility seen = visibility(a, b, hides_nothing_of_itself(nodes_[a]), hides_nothing_of_itself(nodes_[b]));
    v.rays = seen.rays;
    v.link = {a, b, static_cast<float>(exchange * seen.mean), PlainKind::Near};
    if (v.link.exchange > 0) v.action = Verdict::Action::Accept;
    return v;
}

PlainLinker::Verdict PlainLinker::judge(const PlainPair& pair, const std::vector<float>& light,
                                        double threshold) const {
    const auto [a, b] = pair;
    const Node &na = nodes_[a], &nb = nodes_[b];
    Verdict drop, wait, split;
    wait.action = Verdict::Action::Wait;
    split.action = Verdict::Action::SplitA;
    if (light[a] == 0 && light[b] == 0) return wait;
    if (a == b) {
        if (na.group()) return split;
        if (!within_instances_ || na.planar() || hides_nothing_of_itself(na)) return drop;
        return most_power(a, b, light) <= threshold ? wait : split;
    }
    if (!na.group() && !nb.group()) {
        if (!may_see(na, nb) || !may_see(nb, na)) return drop;
        const double d = length(nb.centre - na.centre);
        if (d >= options_.far_factor * double(std::max(na.radius, nb.radius)) && !na.box.overlaps(nb.box))
            return by_disks(a, b, PlainKind::Far);
        if (na.planar() && nb.planar()) return by_kernel(a, b);
        if (most_power(a, b, light) <= threshold) return by_disks(a, b, PlainKind::Coarse);
    }
    // Groups have no tables, so they are never ends; faces are never divided.
    const bool divide_b = na.planar() || (!nb.planar() && !na.group() && (nb.group() || nb.radius > na.radius));
    if (divide_b) split.action = Verdict::Action::SplitB;
    return split;
}

PlainLinks::PlainLinks(const Nodes& nodes) {
    if (nodes.group_count() > 0) {
        waiting.push_back({0, 0});
        return;
    }
    const auto count = static_cast<std::uint32_t>(nodes.scene().instances.size());
    for (std::uint32_t i = 0; i < count; ++i)
        for (std::uint32_t j = i; j < count; ++j) waiting.push_back({nodes.root(i), nodes.root(j)});
}

namespace {

/// Puts the pairs that a division makes onto the stack.
void split(const Nodes& nodes, std::uint32_t divided, std::uint32_t other, std::vector<PlainPair>& stack) {
    thread_local std::vector<std::uint32_t> children;
    nodes.children(divided, children);
    for (std::size_t i = 0; i < children.size(); ++i) {
        if (divided != other)
            stack.push_back({children[i], other});
        else
            for (std::size_t j = i; j < children.size(); ++j) stack.push_back({children[i], children[j]});
    }
}

}  // namespace

bool refine(PlainLinks& set, const PlainLinker& linker, const std::vector<float>& light, double threshold) {
    using Action = PlainLinker::Verdict::Action;
    std::vector<PlainPair> stack = std::move(set.waiting), batch;
    std::vector<PlainLinker::Verdict> verdicts;
    set.waiting.clear();
    const std::size_t removed = std::erase_if(set.links, [&](const PlainLink& l) {
        const bool grown = l.kind == PlainKind::Coarse && linker.most_power(l.a, l.b, light) > threshold;
        if (grown) stack.push_back({l.a, l.b});
        return grown;
    });
    const std::size_t kept = set.links.size();
    while (!stack.empty()) {
        const std::size_t count = std::min(kBatch, stack.size());
        batch.assign(stack.end() - static_cast<std::ptrdiff_t>(count), stack.end());
        stack.resize(stack.size() - count);
        verdicts.resize(count);
        parallel_for(count, kGrain, [&](std::size_t k) { verdicts[k] = linker.judge(batch[k], light, threshold); });
        for (std::size_t k = 0; k < count; ++k) {
            const auto [a, b] = batch[k];
            set.rays += verdicts[k].rays;
            switch (verdicts[k].action) {
                case Action::Drop: break;
                case Action::Wait: set.waiting.push_back(batch[k]); break;
                case Action::Accept: set.links.push_back(verdicts[k].link); break;
                case Action::SplitA: split(linker.nodes(), a, b, stack); break;
                case Action::SplitB: split(linker.nodes(), b, a, stack); break;
            }
        }
    }
    return removed > 0 || set.links.size() != kept;
}

}  // namespace rro
