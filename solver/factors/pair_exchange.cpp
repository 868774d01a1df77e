#include "solver/factors/pair_exchange.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "format/parallel.h"
#include "solver/factors/obstructed.h"
#include "solver/factors/view_factors.h"

namespace rro {
namespace {

constexpr std::size_t kFacesAtATime = 16;
constexpr std::uint64_t kFewPairs = 64;            // of polygons: computed rather than remembered
constexpr std::uint64_t kManyPairs = 4096;         // of polygons: worth several threads
constexpr std::uint64_t kMostShafts = 400'000;     // pairs of polygons looked at one by one: a second
constexpr std::size_t kMostBetween = 48;           // blockers that are cut out
constexpr double kSecondsForOne = 3;               // that cutting one pair of groups may take
constexpr double kShareOfTolerance = 0.3;          // that the rules may err by
constexpr double kQuickly = 1e-3;  // tolerance over open exchange from where two rules that agree are believed

/// Seconds to cut blockers out of one pair of polygons, both ways, as measured.
double cutting_seconds(const PairWork& work, const Between& between) {
    const double n = static_cast<double>(between.bodies.size() + 2 * between.solids.size());
    double edges = 0;
    for (const std::uint32_t solid : between.solids) edges += static_cast<double>(work.surfaces.solids[solid].edges.size());
    return 1e-6 * (40 + 60 * n + 8 * n * n + 0.6 * edges);
}

/// What stands between the two polygons of a facing pair. Solids that hold a part of them do not block as one.
/// returns  whether there is no more than can be cut out
bool look(const PairWork& work, PairScratch& scratch) {
    const Polygon& p = *scratch.facing.a;
    const Polygon& q = *scratch.facing.b;
    make_pair_hull(p.corners, {-p.normal, -p.offset}, q.corners, {-q.normal, -q.offset}, scratch.hull);
    if (!work.blockers.reach_into(scratch.hull, kMostBetween, true, scratch.between)) return false;
    for (const std::uint32_t number : scratch.between.solids) {
        const Solid& solid = work.surfaces.solids[number];
        const auto inside = [&](const Vec3& c) { return solid.contains(c); };
        if (std::any_of(p.corners.begin(), p.corners.end(), inside) ||
            std::any_of(q.corners.begin(), q.corners.end(), inside))
            return work.blockers.reach_into(scratch.hull, kMostBetween, false, scratch.between);
    }
    return true;
}

/// The part of a pair of groups that one chunk of faces has.
struct Share {
    double exchange = 0, seconds = 0;
    std::vector<ObstructedPair> obstructed;
    bool too_much = false;
};

/// What to find out about pairs of faces.
enum class Find { Exact, Between, Both };

void add_faces(const PairWork& work, std::uint32_t a, std::uint32_t b, const Polygon& from, const Polygon& to, Find find,
               PairScratch& scratch, Share& share) {
    FacingPair& facing = scratch.facing;
    if (!facing_parts(from, to, facing)) return;
    if (find != Find::Exact) {
        const bool few = look(work, scratch);
        share.too_much = share.too_much || !few;
        if (!few || !scratch.between.empty()) {
            share.obstructed.push_back({a, b});
            share.seconds += cutting_seconds(work, scratch.between);
            share.too_much = share.too_much || share.seconds > kSecondsForOne;
            return;
        }
    }
    if (find != Find::Between) share.exchange += facing_exchange(*facing.a, *facing.b);
}

/// Faces [begin, end) of group i with all of group j; of one group with itself, each pair once.
void add_chunk(const PairWork& work, std::uint32_t i, std::uint32_t j, std::size_t begin, std::size_t end, Find find,
               PairScratch& scratch, Share& share) {
    const auto& from = work.surfaces.faces[i];
    const auto& to = work.surfaces.faces[j];
    for (std::size_t a = begin; a < end; ++a)
        for (std::size_t b = i == j ? a + 1 : 0; b < to.size() && !share.too_much; ++b)
            add_faces(work, static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b), from[a], to[b], find, scratch,
                      share);
}

void add_share(Share&& share, Share& sum) {
    sum.exchange += share.exchange;
    sum.seconds += share.seconds;
    sum.too_much = sum.too_much || share.too_much;
    sum.obstructed.insert(sum.obstructed.end(), share.obstructed.begin(), share.obstructed.end());
}

/// All faces of one group with all of another.
Share add_groups(const PairWork& work, std::uint32_t i, std::uint32_t j, Find find, PairScratch& scratch) {
    const std::size_t count = work.surfaces.faces[i].size();
    Share sum;
    if (count * work.surfaces.faces[j].size() < kManyPairs) {
        add_chunk(work, i, j, 0, count, find, scratch, sum);
    } else {
        std::vector<Share> shares((count + kFacesAtATime - 1) / kFacesAtATime);
        parallel_chunks(count, kFacesAtATime, [&](std::size_t begin, std::size_t end) {
            PairScratch own;
            add_chunk(work, i, j, begin, end, find, own, shares[begin / kFacesAtATime]);
        });
        for (Share& share : shares) add_share(std::move(share), sum);
    }
    if (i == j) sum.exchange *= 2;
    return sum;
}

/// What `look` has found, as the cutting takes it.
struct Found {
    std::vector<const Polygon*> bodies;
    std::vector<const Solid*> solids;
};
Found found_in(const PairWork& work, const Between& between) {
    Found found;
    for (const std::uint32_t body : between.bodies) found.bodies.push_back(&work.surfaces.bodies[body].polygon);
    for (const std::uint32_t solid : between.solids) found.solids.push_back(&work.surfaces.solids[solid]);
    return found;
}

}  // namespace

PairWork::PairWork(const Surfaces& surfaces_, const Blockers& blockers_, double accuracy_)
    : surfaces(surfaces_), blockers(blockers_), accuracy(accuracy_), boxes(surfaces_.faces.size()) {
    for (std::size_t g = 0; g < boxes.size(); ++g)
        for (const Polygon& face : surfaces.faces[g])
            for (const Vec3& corner : face.corners) boxes[g].add(corner);
}

double exact_exchange(const PairWork& work, std::uint32_t i, std::uint32_t j, PairScratch& scratch) {
    if (i == j && work.surfaces.convex[i]) return 0;
    return add_groups(work, i, j, Find::Exact, scratch).exchange;
}

GroupPair find_pair(const PairWork& work, std::uint32_t i, std::uint32_t j, PairScratch& scratch) {
    GroupPair pair;
    pair.from = i;
    pair.to = j;
    const Surfaces& s = work.surfaces;
    const std::uint64_t pairs = std::uint64_t{s.faces[i].size()} * s.faces[j].size();
    if (work.blockers.empty() || (i == j && s.convex[i])) return pair;
    if (pairs > 1 &&  // a convex group hides nothing of itself from outside
        !work.blockers.any_between(work.boxes[i], work.boxes[j], [&](std::uint32_t body) {
            const std::uint32_t group = s.bodies[body].group;
            return !((group == i && s.convex[i]) || (group == j && s.convex[j]));
        }))
        return pair;
    if (pairs > kMostShafts) {
        pair.sampled = true;
        return pair;
    }
    // The exact part of many pairs is summed up as they are looked at; that of few is not worth remembering.
    Share share = add_groups(work, i, j, pairs < kFewPairs ? Find::Between : Find::Both, scratch);
    pair.seconds = share.seconds;
    pair.sampled = share.too_much || share.seconds > kSecondsForOne;
    if (pair.sampled) return pair;
    pair.known = pairs >= kFewPairs || !share.obstructed.empty();
    if (pairs < kFewPairs && pairs > 1 && pair.known) share = add_groups(work, i, j, Find::Both, scratch);
    pair.exchange = pair.there = pair.back = share.exchange;
    pair.obstructed = std::move(share.obstructed);
    return pair;
}

void cut_out(const PairWork& work, GroupPair& pair) {
    const Surfaces& s = work.surfaces;
    const std::size_t count = pair.obstructed.size();
    const auto with_each = [&](const auto& body) {  // body(number, polygon of `from`, polygon of `to`, obstacles)
        parallel_for(count, 1, [&](std::size_t k) {
            PairScratch scratch;
            const Polygon& from = s.faces[pair.from][pair.obstructed[k].a];
            const Polygon& to = s.faces[pair.to][pair.obstructed[k].b];
            if (!facing_parts(from, to, scratch.facing)) return;
            look(work, scratch);
            const Found found = found_in(work, scratch.between);
            body(k, *scratch.facing.a, *scratch.facing.b, Obstacles{found.bodies, found.solids});
        });
    };
    std::vector<double> open(count, 0), rough(count, 0);
    with_each([&](std::size_t k, const Polygon& p, const Polygon& q, const Obstacles&) { open[k] = facing_exchange(p, q); });
    const double smaller = std::min(s.area[pair.from], s.area[pair.to]);
    const auto sum_of_all = [&](const std::vector<double>& each) {
        return (pair.from == pair.to ? 2 : 1) * std::accumulate(each.begin(), each.end(), 0.0);
    };
    if (pair.exchange + sum_of_all(open) > kSmallFactor * smaller)  // else the tolerance is absolute
        with_each([&](std::size_t k, const Polygon& p, const Polygon& q, const Obstacles& obstacles) {
            rough[k] = rough_exchange(p, q, obstacles);
        });
    const double about = pair.exchange + sum_of_all(rough);
    const auto tolerance = [&](std::uint32_t group) {  // m^2 for each pair of polygons; their errors add as squares
        const double factor = std::max(about / s.area[group], kSmallFactor);
        return kShareOfTolerance * work.accuracy * factor * s.area[group] / std::sqrt(static_cast<double>(count));
    };
    const double tolerance_there = tolerance(pair.from), tolerance_back = tolerance(pair.to);
    struct Both {
        ObstructedExchange there, back;
    };
    std::vector<Both> parts(count);
    with_each([&](std::size_t k, const Polygon& p, const Polygon& q, const Obstacles& obstacles) {
        const auto compute = [&](bool quick) {
            parts[k].there = obstructed_exchange(p, q, obstacles, tolerance_there,
                                                 quick && tolerance_there >= kQuickly * open[k]);
            parts[k].back = obstructed_exchange(q, p, obstacles, tolerance_back,
                                                quick && tolerance_back >= kQuickly * open[k]);
        };
        compute(true);
        if (std::abs(parts[k].there.value - parts[k].back.value) > tolerance_there + tolerance_back) compute(false);
    });
    double there2 = 0, back2 = 0;
    for (const Both& part : parts) {
        // Two ways to one number that differ by more than they say tell how far they are off.
        const double apart = 0.5 * std::abs(part.there.value - part.back.value);
        const double error_there = std::max(part.there.standard_error, apart);
        const double error_back = std::max(part.back.standard_error, apart);
        pair.there += part.there.value;
        pair.back += part.back.value;
        there2 += error_there * error_there;
        back2 += error_back * error_back;
    }
    if (pair.from == pair.to) {  // both ends are the group: the two estimates together are its own
        pair.there = pair.back = pair.there + pair.back - pair.exchange;
        there2 = back2 = there2 + back2;
    }
    pair.error_there = std::sqrt(there2);
    pair.error_back = std::sqrt(back2);
}

}  // namespace rro
