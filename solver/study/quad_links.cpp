#include "solver/study/quad_links.h"

#include <algorithm>
#include <numbers>

#include "format/clock.h"
#include "format/form_factor.h"
#include "format/parallel.h"
#include "format/sample_points.h"

namespace rro {
namespace {

constexpr std::uint32_t kDeepest = 10;        // levels of a quadtree: links at a common edge must end somewhere
constexpr std::size_t kBatch = 1 << 16;       // pairs judged at a time
constexpr std::size_t kGrain = 128;
constexpr std::size_t kSampledRows = 256;     // faces whose partners are counted to foretell memory
constexpr double kNearby = 6;                 // radii: closer pairs take several points for the form factor
constexpr int kNearbyPoints = 6;
// Of a pair that no ray passed, the share that the oracle takes for open; where some ray passed it is all. Refining what
// looks bright and leaving what looks dark loses light in every penumbra (measured behind half a square: 3 % where the
// oracle takes the rays at their word, 2 % at 1/8, 1 % at 1/2).
constexpr double kUnseenShare = 0.5;

/// No exchange between the two is larger, m^2: a disk of the one's area at the least distance, or all that leaves.
double largest_exchange(const QuadElement& a, const QuadElement& b) {
    const double gap = length(a.centre - b.centre) - double(a.radius) - double(b.radius);
    const double smaller = std::min(a.area, b.area);
    return gap > 0 ? std::min(smaller, a.area * b.area / (std::numbers::pi * gap * gap)) : smaller;
}

/// Unoccluded exchange area, m^2: the form factor from points of the smaller end to all of the larger one.
double estimated_exchange(const QuadElements& all, const QuadElement& a, const QuadElement& b, Facing how) {
    const bool a_is_small = a.area <= b.area;
    const QuadElement &small = a_is_small ? a : b, &large = a_is_small ? b : a;
    const double reach = kNearby * (double(a.radius) + double(b.radius));
    const Vec3& normal = all.normal(small);
    if (how == Facing::Whole && length2(a.centre - b.centre) > reach * reach)
        return small.area * point_to_triangle(small.centre, normal, large.corner);
    double factor = 0;
    for (const TriangleRule::Node& node : triangle_rule(kNearbyPoints).nodes)
        factor += node.weight * point_to_triangle(triangle_point(small.corner, node.b1, node.b2), normal, large.corner);
    return small.area * factor;
}

Box3 box_of(const QuadElement& e) {
    Box3 box;
    for (const Vec3& p : e.corner) box.add(p);
    return box;
}

}  // namespace

struct QuadLinker::Verdict {
    enum class Action : std::uint8_t { Drop, Split, Look, Accept };
    Action action = Action::Drop;
    bool clear = false;
    std::uint8_t rays = 0;
    float exchange = 0, largest = 0;
};

QuadLinker::QuadLinker(const Scene& scene, QuadElements& elements, const SceneRays& rays)
    : scene_(scene), all_(elements), rays_(rays), words_((elements.faces.size() + 63) / 64) {}

std::uint64_t QuadLinker::bytes_of_root_links() const {
    const std::size_t n = all_.faces.size(), rows = std::min(n, kSampledRows);
    std::vector<std::uint64_t> facing_row(rows, 0);
    parallel_for(rows, 1, [&](std::size_t r) {
        const QuadElement& a = all_.elements[r * n / rows];
        for (std::size_t b = 0; b < n; ++b) facing_row[r] += facing(all_, a, all_.elements[b]) != Facing::None;
    });
    std::uint64_t pairs = 0;
    for (const std::uint64_t count : facing_row) pairs += count;
    if (rows > 0) pairs = static_cast<std::uint64_t>(double(pairs) / 2 * double(n) / double(rows));
    return pairs * kBytesPerQuadLink + n * words_ * 8 + n * sizeof(QuadElement);
}

std::vector<QuadLinker::Pair> QuadLinker::new_root_pairs(const QuadOracle& oracle, const std::vector<float>& light) {
    const std::size_t n = all_.faces.size();
    linked_.resize(n * words_, 0);
    std::vector<std::vector<Pair>> found(n);
    parallel_for(n, 4, [&](std::size_t a) {
        std::uint64_t* row = &linked_[a * words_];
        for (std::size_t b = a + 1; b < n; ++b) {
            const std::uint64_t bit = std::uint64_t{1} << (b % 64);
            const double brighter = double(std::max(light[a], light[b]));
            if (brighter == 0 || (row[b / 64] & bit)) continue;
            const QuadElement &ea = all_.elements[a], &eb = all_.elements[b];
            if (brighter * largest_exchange(ea, eb) <= oracle.root_power) continue;
            row[b / 64] |= bit;
            if (facing(all_, ea, eb) != Facing::None)
                found[a].push_back({static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b), false});
        }
    });
    std::vector<Pair> pairs;
    for (std::vector<Pair>& row : found) pairs.insert(pairs.end(), row.begin(), row.end());
    return pairs;
}

bool QuadLinker::can_split(const QuadElement& a, const QuadElement& b) const {
    return (a.area >= b.area ? a : b).level < kDeepest;
}

/// The larger end gives way to its four parts.
void QuadLinker::split(const Pair& pair, std::vector<float>& light, std::vector<Pair>& pairs) {
    const bool first = all_.elements[pair.a].area >= all_.elements[pair.b].area;
    const std::uint32_t whole = first ? pair.a : pair.b, other = first ? pair.b : pair.a;
    all_.subdivide(whole);
    while (light.size() < all_.elements.size()) light.push_back(light[all_.elements[light.size()].parent]);
    for (std::uint32_t k = 0; k < 4; ++k) pairs.push_back({all_.elements[whole].children + k, other, pair.clear});
}

void QuadLinker::take_coarse_links(const QuadOracle& oracle, std::vector<float>& light, std::vector<Pair>& pairs) {
    std::size_t kept = 0;
    for (const QuadLink& link : links_) {
        const double power = double(std::max(light[link.a], light[link.b])) * double(link.largest);
        if (power > oracle.link_power && can_split(all_.elements[link.a], all_.elements[link.b]))
            split({link.a, link.b, false}, light, pairs);
        else
            links_[kept++] = link;
    }
    links_.resize(kept);
}

/// Judges by geometry alone.
void QuadLinker::weigh(const Pair& pair, double light, double limit, Verdict& v) const {
    const QuadElement &a = all_.elements[pair.a], &b = all_.elements[pair.b];
    const Facing how = facing(all_, a, b);
    if (how == Facing::None) return;
    const double exchange = estimated_exchange(all_, a, b, how);
    const double largest = how == Facing::Partly ? std::max(exchange, 0.5 * largest_exchange(a, b)) : exchange;
    v.exchange = static_cast<float>(exchange);
    v.largest = static_cast<float>(largest);
    if (exchange == 0 && light * largest <= limit) return;
    v.clear = pair.clear;
    v.action = pair.clear ? Verdict::Action::Accept : Verdict::Action::Look;
}

/// Multiplies by the share of rays that pass, random points on both ends.
void QuadLinker::look(const Pair& pair, double light, double limit, Verdict& v) const {
    if (v.action == Verdict::Action::Look) {
        v.action = Verdict::Action::Accept;
        const QuadElement &a = all_.elements[pair.a], &b = all_.elements[pair.b];
        const QuadFace &fa = all_.faces[a.face], &fb = all_.faces[b.face];
        thread_local Candidates candidates;
        rays_.candidates(box_of(a), box_of(b), candidates);
        std::erase_if(candidates, [&](std::uint32_t i) {  // what faces other things never hides them behind itself
            return (i == fa.instance || i == fb.instance) && scene_.instances[i].data().meta.convex;
        });
        v.clear = candidates.empty();
        if (!v.clear) {
            std::array<Vec3, kRaysPerQuadLink> p, q;
            std::array<std::uint8_t, kRaysPerQuadLink> blocked;
            std::size_t n = 0;
            const std::uint64_t seed = mix64(std::uint64_t{pair.a} << 32 | pair.b);
            const bool dim = light * double(v.largest) < kDimShare * limit;
            const std::uint32_t wanted = dim ? kRaysPerDimLink : kRaysPerQuadLink;
            for (std::uint32_t k = 0; k < wanted; ++k) {
                const auto s = sobol4(k, seed);
                const auto u = square_to_triangle(double(s[0]), double(s[1]));
                const auto w = square_to_triangle(double(s[2]), double(s[3]));
                const Vec3 from = triangle_point(a.corner, u[0], u[1]), to = triangle_point(b.corner, w[0], w[1]);
                if (dot(fa.normal, to - from) <= 0 || dot(fb.normal, from - to) <= 0) continue;
                p[n] = from, q[n] = to, ++n;
            }
            rays_.occluded({p.data(), n}, {q.data(), n}, fa.triangle, fb.triangle, candidates, {blocked.data(), n});
            v.rays = static_cast<std::uint8_t>(n);
            std::size_t open = 0;
            for (std::size_t k = 0; k < n; ++k) open += blocked[k] == 0;
            const double seen = n > 0 ? double(open) / double(n) : 1.0;
            v.exchange *= static_cast<float>(seen);
            if (open == 0) v.largest *= static_cast<float>(kUnseenShare);
        }
    }
    if (v.action != Verdict::Action::Accept) return;
    if (light * double(v.largest) > limit && can_split(all_.elements[pair.a], all_.elements[pair.b]))
        v.action = Verdict::Action::Split;
    else if (v.exchange == 0)
        v.action = Verdict::Action::Drop;
}

Result<bool> QuadLinker::refine(const QuadOracle& oracle, std::vector<float>& light, const Progress& progress) {
    auto start = Clock::now();
    std::vector<Pair> pairs = new_root_pairs(oracle, light), next;
    take_coarse_links(oracle, light, pairs);
    const bool changed = !pairs.empty();
    std::vector<Verdict> verdicts;
    for (; !pairs.empty(); pairs.swap(next), next.clear())
        for (std::size_t begin = 0; begin < pairs.size(); begin += kBatch) {
            const std::size_t n = std::min(kBatch, pairs.size() - begin);
            const auto brighter = [&](const Pair& p) { return double(std::max(light[p.a], light[p.b])); };
            verdicts.assign(n, {});
            parallel_for(n, kGrain, [&](std::size_t k) {
                const Pair& pair = pairs[begin + k];
                weigh(pair, brighter(pair), oracle.link_power, verdicts[k]);
            });
            link_seconds_ += seconds_since(start), start = Clock::now();
            parallel_for(n, kGrain, [&](std::size_t k) {
                const Pair& pair = pairs[begin + k];
                look(pair, brighter(pair), oracle.link_power, verdicts[k]);
            });
            visibility_seconds_ += seconds_since(start), start = Clock::now();
            for (std::size_t k = 0; k < n; ++k) {
                Pair pair = pairs[begin + k];
                pair.clear = verdicts[k].clear;
                rays_traced_ += verdicts[k].rays;
                if (verdicts[k].action == Verdict::Action::Split) split(pair, light, next);
                if (verdicts[k].action == Verdict::Action::Accept)
                    links_.push_back({pair.a, pair.b, verdicts[k].exchange, verdicts[k].largest});
            }
            const std::uint64_t bytes =
                (links_.size() + next.size()) * kBytesPerQuadLink + all_.elements.size() * sizeof(QuadElement);
            if (bytes > oracle.memory)
                return failed("", "hierarchical radiosity needs more memory than is allowed: " +
                                      std::to_string(links_.size()) + " links so far",
                              "ask for less with --accuracy, or allow more with --memory");
            if (progress) progress("links", double(begin + n) / double(pairs.size() + next.size()));
        }
    link_seconds_ += seconds_since(start);
    return changed;
}

}  // namespace rro
