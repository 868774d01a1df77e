#include "solver/visibility/visibility.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>

#include "format/parallel.h"
#include "format/sample_points.h"
#include "solver/visibility/clearance.h"

namespace rro {
namespace {

// Shafts with more candidates than this are not listed: rays find their own way through a crowd.
constexpr std::size_t kMostCandidates = 64;

// Silhouettes of objects in line correlate: their product is off by this much of the light that two or more of them share
// out (measured with visibility_bench).
constexpr double kProductError = 0.09;

// The cost model of `auto`, nanoseconds (fitted to visibility_bench; figures there).
constexpr double kAtlasCost = 350, kRayCost = 300;  // per candidate; per candidate and ray

constexpr std::size_t kGrain = 16;  // shafts, in parallel loops
constexpr std::uint32_t kMany = 1 << 20;

/// Rays that a partial transmittance v asks for.
double expected_rays(const Demand& demand, double v) {
    if (demand.rule == StopRule::Fixed) return demand.most;
    const double needed = v * (1 - v) / (demand.deviation * demand.deviation);
    return std::clamp<double>(needed, demand.first, demand.most);
}

}  // namespace

SectionSet sections_of(VisibilityMethod method) {
    if (method == VisibilityMethod::Atlas) return Section::Atlas;
    if (method == VisibilityMethod::Tables) return Section::Hbv | Section::Hit;
    return {};
}

Visibility::Visibility(const Scene& scene, const SceneRays& rays, VisibilityMethod method, const TableOptions& tables)
    : scene_(scene), rays_(rays), method_(method), table_options_(tables) {
    for (const Instance& instance : scene.instances) {
        const auto at = std::find_if(scene.objects.begin(), scene.objects.end(),
                                     [&](const auto& object) { return object.get() == instance.object; });
        assert(at != scene.objects.end());
        object_of_.push_back(static_cast<std::size_t>(at - scene.objects.begin()));
    }
    const bool any_atlas = std::any_of(scene.objects.begin(), scene.objects.end(),
                                       [](const auto& object) { return !object->data().atlas_coverage.empty(); });
    const bool atlas = method == VisibilityMethod::Atlas || (method == VisibilityMethod::Auto && any_atlas);
    for (const auto& object : scene.objects) {
        const bool has = !object->data().atlas_coverage.empty();
        assert(has || method != VisibilityMethod::Atlas);
        if (atlas) silhouettes_.push_back(has ? std::make_unique<SilhouetteSums>(object->data()) : nullptr);
        if (method == VisibilityMethod::Tables) tables_.push_back(std::make_unique<HitTables>(object->archive));
    }
}

Transmittance Visibility::transmittance(const Shaft& shaft, const Demand& demand) const {
    thread_local Lines lines;
    Transmittance known;
    if (settle(shaft, demand, lines, known)) return known;
    return outcome(demand, sample(shaft, demand, [&](const Segment& s) { return passes(lines, s); }));
}

std::vector<Transmittance> Visibility::transmittances(std::span<const Shaft> shafts, Neighbours neighbours,
                                                      const Demand& demand) const {
    std::vector<Lines> lines(shafts.size());
    std::vector<Transmittance> out(shafts.size());
    std::vector<Tally> tallies(shafts.size());
    std::vector<std::uint8_t> settled(shafts.size());
    const auto ask = [&](std::size_t i) { return [&, i](const Segment& s) { return passes(lines[i], s); }; };
    parallel_for(shafts.size(), kGrain, [&](std::size_t i) {
        settled[i] = settle(shafts[i], demand, lines[i], out[i]);
        if (!settled[i]) tallies[i] = sample(shafts[i], demand, ask(i));
        // What is known counts for the neighbours as if very many rays had said so.
        else tallies[i].drawn = tallies[i].rays = kMany, tallies[i].passed = out[i].mean * kMany;
    });
    for (auto again = doubtful(tallies, neighbours); !again.empty(); again = doubtful(tallies, neighbours))
        parallel_for(again.size(), kGrain, [&](std::size_t k) {
            const std::uint32_t i = again[k];
            Tally& t = tallies[i];
            do extend(t, shafts[i], demand.points, std::max(t.drawn + 1, next_round(demand, t.drawn)), ask(i));
            while (!t.unanimous() && next_round(demand, t.drawn) > t.drawn && !suffices(demand, t));
        });
    for (std::size_t i = 0; i < shafts.size(); ++i)
        if (!settled[i]) out[i] = outcome(demand, tallies[i]);
    return out;
}

bool Visibility::settle(const Shaft& shaft, const Demand& demand, Lines& lines, Transmittance& out) const {
    if (method_ == VisibilityMethod::None) return true;
    lines.listed = !shaft.crowd && rays_.candidates(shaft.a.box, shaft.b.box, lines.candidates, kMostCandidates);
    if (!lines.listed) return false;
    std::erase_if(lines.candidates, [&](std::uint32_t i) { return i == shaft.passed[0] || i == shaft.passed[1]; });
    out.proven = std::erase_if(lines.candidates, [&](std::uint32_t i) { return certainly_clear(shaft, scene_.instances[i]); }) > 0;
    if (lines.candidates.empty()) return true;
    if (looks_at_spread()) sort_along(shaft, lines.candidates);
    if (!silhouettes_.empty() && by_atlas(shaft, lines.candidates, demand, out)) return true;
    if (!tables_.empty()) prepare_tables(shaft, lines);
    return false;
}

double Visibility::passes(const Lines& lines, const Segment& s) const {
    if (!lines.listed) return rays_.occluded(s.p, s.q, s.p_on, s.q_on, s.passed) ? 0.0 : 1.0;
    if (!tables_.empty()) return passes_tables(lines, s);
    return rays_.occluded(s.p, s.q, s.p_on, s.q_on, lines.candidates) ? 0.0 : 1.0;
}

// From one end to the other: products of rounded numbers must not depend on the order of the manifest.
void Visibility::sort_along(const Shaft& shaft, Candidates& candidates) const {
    const Vec3 axis = shaft.b.centre - shaft.a.centre;
    const auto place = [&](std::uint32_t i) { return dot(scene_.instances[i].bounds.centre(), axis); };
    std::sort(candidates.begin(), candidates.end(), [&](std::uint32_t i, std::uint32_t j) {
        const double a = place(i), b = place(j);
        return a != b ? a < b : i < j;
    });
}

// Several objects in line let through the product of what each does.
bool Visibility::by_atlas(const Shaft& shaft, const Candidates& candidates, const Demand& demand, Transmittance& out) const {
    out.proven = false;
    double mean = 1, squares = 0;
    std::size_t partial = 0;
    bool unknown = false;
    for (const std::uint32_t i : candidates) {
        const SilhouetteSums* sums = silhouettes_[object_of_[i]].get();
        const Cover c = sums ? sums->cover(LocalShaft(shaft, scene_.instances[i].to_local)) : Cover{};
        if (c.kind == Cover::Kind::Dark) {
            out.mean = 0;
            return true;
        }
        unknown = unknown || c.kind == Cover::Kind::Unknown;
        mean *= 1 - c.share;
        squares += c.error * c.error;
        if (c.kind == Cover::Kind::Partial && c.share > 0) ++partial;
    }
    if (unknown) return false;
    const double product = partial > 1 ? kProductError * std::sqrt(mean * (1 - mean)) : 0.0;
    out.mean = mean;
    out.bias = std::sqrt(squares + product * product);
    out.spread = mean * (1 - mean);
    out.edge = mean > 0 && mean < 1;
    if (method_ == VisibilityMethod::Atlas) return true;
    const bool cheaper = kAtlasCost <= kRayCost * expected_rays(demand, mean);
    return cheaper && out.bias <= demand.deviation;
}

void Visibility::prepare_tables(const Shaft& shaft, Lines& lines) const {
    lines.missing.clear();
    for (const std::uint32_t i : lines.candidates) {
        const Instance& instance = scene_.instances[i];
        const LocalShaft local(shaft, instance.to_local);
        const CrossSection section = cross_section(local, instance.to_local.point(instance.bounds.centre()));
        lines.missing.push_back(table_options_.tolerance * section.area());
    }
}

// An end's own object lies too near for tables: rays ask it.
double Visibility::passes_tables(const Lines& lines, const Segment& s) const {
    double pass = 1;
    for (std::size_t k = 0; k < lines.candidates.size() && pass > 0; ++k) {
        const std::uint32_t i = lines.candidates[k];
        if (i == s.p_on.instance || i == s.q_on.instance) {
            if (rays_.occluded(s.p, s.q, s.p_on, s.q_on, {&i, 1})) pass = 0;
            continue;
        }
        const Affine3& to_local = scene_.instances[i].to_local;
        const Vec3 p = to_local.point(s.p), q = to_local.point(s.q);
        const std::uint64_t key = mix64(std::bit_cast<std::uint64_t>(p.x) ^ mix64(std::bit_cast<std::uint64_t>(q.y)));
        pass *= tables_[object_of_[i]]->passes(p, q, lines.missing[k], table_options_, key);
    }
    return pass;
}

}  // namespace rro
