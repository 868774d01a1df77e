#include "solver/factors/view_factors.h"

#include <algorithm>
#include <atomic>
#include <mutex>
#include <numeric>

#include "format/parallel.h"
#include "solver/factors/pair_exchange.h"
#include "solver/factors/sampled_row.h"

namespace rro {
namespace {

// Seconds that a row may cost by cutting before its dearest pairs go to rays; a row of rays costs about as much.
constexpr double kRowSeconds = 6;

/// Tells how much of a phase is done, from any thread.
class Steps {
  public:
    Steps(const Progress& progress, const char* phase, double total) : progress_(progress), phase_(phase), total_(total) {}
    void add(double work) {
        if (!progress_) return;
        const std::lock_guard lock(mutex_);
        done_ += work;
        progress_(phase_, total_ > 0 ? done_ / total_ : 1);
    }

  private:
    const Progress& progress_;
    const char* phase_;
    double total_, done_ = 0;
    std::mutex mutex_;
};

/// Unordered pairs of groups that exchange, by the lesser group.
struct PairsOfRow {
    std::vector<ExactPair> exact;
    std::vector<GroupPair> open;  // with something between
};
using Rows = std::vector<PairsOfRow>;

Rows find_pairs(const PairWork& work, const Progress& progress) {
    const std::size_t count = work.surfaces.faces.size();
    std::vector<double> faces(count + 1, 0);
    double sum = 0, total = 0;
    for (std::size_t i = count; i-- > 0;) {
        sum += static_cast<double>(work.surfaces.faces[i].size());
        faces[i] = sum * static_cast<double>(work.surfaces.faces[i].size());
        total += faces[i];
    }
    Steps steps(progress, "factors", total);
    Rows rows(count);
    parallel_for(count, 1, [&](std::size_t i) {
        PairScratch scratch;
        for (std::size_t j = i; j < count; ++j) {
            GroupPair pair = find_pair(work, static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j), scratch);
            if (pair.sampled || !pair.obstructed.empty())
                rows[i].open.push_back(std::move(pair));
            else if (pair.exchange > 0)
                rows[i].exact.push_back({pair.to, pair.exchange});
        }
        steps.add(faces[i]);
    });
    return rows;
}

/// Rows that cost too much by cutting give their dearest pairs to the rays.
void choose_sampled(Rows& rows) {
    std::vector<std::vector<GroupPair*>> of_row(rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i)
        for (GroupPair& pair : rows[i].open)
            if (!pair.obstructed.empty()) {
                of_row[i].push_back(&pair);
                if (pair.to != i) of_row[pair.to].push_back(&pair);
            }
    for (auto& row : of_row) {
        double seconds = 0;
        for (const GroupPair* pair : row) seconds += pair->sampled ? 0 : pair->seconds;
        std::stable_sort(row.begin(), row.end(),
                         [](const GroupPair* a, const GroupPair* b) { return a->seconds > b->seconds; });
        for (GroupPair* pair : row) {
            if (seconds <= kRowSeconds) break;
            if (pair->sampled) continue;
            seconds -= pair->seconds;
            pair->sampled = true;
        }
    }
}

void cut_pairs(const PairWork& work, Rows& rows, const Progress& progress) {
    std::vector<GroupPair*> pairs;
    double total = 0;
    for (PairsOfRow& row : rows)
        for (GroupPair& pair : row.open) {
            if (pair.sampled) pair.obstructed = {};
            if (pair.obstructed.empty()) continue;
            pairs.push_back(&pair);
            total += pair.seconds;
        }
    Steps steps(progress, "shadows", total);
    parallel_for(pairs.size(), 1, [&](std::size_t k) {
        cut_out(work, *pairs[k]);
        steps.add(pairs[k]->seconds);
    });
}

/// Moves the pairs into both their rows, ascending.
void fill_rows(Rows& pairs, Factors& factors) {
    for (std::uint32_t i = 0; i < pairs.size(); ++i) {
        for (const ExactPair& pair : pairs[i].exact) {
            factors.rows[i].push_back({pair.to, 0, pair.exchange / factors.area[i]});
            if (pair.to != i) factors.rows[pair.to].push_back({i, 0, pair.exchange / factors.area[pair.to]});
        }
        pairs[i].exact = {};
        for (const GroupPair& pair : pairs[i].open) {
            if (pair.sampled) continue;
            const double a = factors.area[i], b = factors.area[pair.to];
            factors.rows[i].push_back({pair.to, static_cast<float>(pair.error_there / a), pair.there / a});
            if (pair.to != i)
                factors.rows[pair.to].push_back({i, static_cast<float>(pair.error_back / b), pair.back / b});
            if (pair.error_there > 0 || pair.error_back > 0) factors.counts.cut += pair.to == i ? 1 : 2;
        }
    }
}

void sample_rows(const Scene& scene, const SurfaceGroups& groups, const Surfaces& surfaces, const Rows& pairs,
                 Factors& factors, const Progress& progress) {
    std::vector<std::vector<std::uint32_t>> wanted(pairs.size());
    std::size_t rows = 0;
    for (std::uint32_t i = 0; i < pairs.size(); ++i)
        for (const GroupPair& pair : pairs[i].open)
            if (pair.sampled) {
                wanted[i].push_back(pair.to);
                if (pair.to != i) wanted[pair.to].push_back(i);
            }
    for (const auto& row : wanted) rows += !row.empty();
    if (rows == 0) return;
    const SceneRays rays(scene);
    const RayScene ray_scene{scene, groups, surfaces, rays, factors.options.sides};
    Steps steps(progress, "rays", static_cast<double>(rows));
    for (std::uint32_t i = 0; i < pairs.size(); ++i) {
        if (wanted[i].empty()) continue;
        const SampledRow row = sampled_row(ray_scene, i, wanted[i], factors.options.accuracy);
        for (const std::uint32_t to : wanted[i]) {
            factors.rows[i].push_back({to, static_cast<float>(row.standard_error[to]), row.factor[to]});
            factors.counts.missed +=
                row.standard_error[to] > 0.5 * factors.options.accuracy * std::max(row.factor[to], 0.01);
        }
        factors.counts.sampled += wanted[i].size();
        factors.counts.rays += row.rays;
        steps.add(1);
    }
}

}  // namespace

Result<Factors> view_factors(const Scene& scene, const FactorOptions& options, const Progress& progress) {
    auto groups = surface_groups(scene, options.by);
    if (!groups) return groups.error();
    const Surfaces surfaces = gather_surfaces(scene, *groups, options.sides);
    for (std::size_t g = 0; g < surfaces.area.size(); ++g)
        if (!(surfaces.area[g] > 0))
            return bad_input(scene.manifest.path.string(), "\"" + groups->names[g] + "\" has no side with an area");
    const Blockers blockers(surfaces);
    Factors factors;
    factors.options = options;
    factors.options.by = groups->by;
    factors.names = groups->names;
    factors.area = surfaces.area;
    factors.rows.resize(groups->names.size());
    factors.polygons = surfaces.bodies.size();
    factors.blockers = blockers.size();

    const PairWork work(surfaces, blockers, options.accuracy);
    Rows pairs = find_pairs(work, progress);
    choose_sampled(pairs);
    cut_pairs(work, pairs, progress);
    fill_rows(pairs, factors);
    sample_rows(scene, *groups, surfaces, pairs, factors, progress);
    for (auto& row : factors.rows)
        std::sort(row.begin(), row.end(), [](const Factor& a, const Factor& b) { return a.to < b.to; });
    const std::uint64_t all = std::uint64_t{factors.names.size()} * factors.names.size();
    factors.counts.exact = all - factors.counts.cut - factors.counts.sampled;
    return factors;
}

std::uint64_t factors_memory(const Scene& scene, GroupBy by) {
    // Two numbers in vectors that have grown by doubling, and what they were made from.
    constexpr std::uint64_t kPerPair = 2 * sizeof(Factor) + sizeof(ExactPair);
    constexpr std::uint64_t kPerTriangle = 3000;  // a polygon on both sides with its rules, where none are merged
    std::uint64_t groups = scene.instances.size();
    if (by == GroupBy::Group || (by == GroupBy::Auto && !scene.manifest.groups.empty()))
        groups = scene.manifest.groups.size();
    if (by == GroupBy::Material) {
        groups = 0;
        for (const Instance& i : scene.instances) groups += i.data().materials.size();
    }
    return groups * groups * kPerPair + scene.triangle_count() * kPerTriangle;
}

}  // namespace rro
