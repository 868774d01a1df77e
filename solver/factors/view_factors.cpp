#include "solver/factors/view_factors.h"

#include <algorithm>
#include <atomic>
#include <mutex>
#include <optional>

#include "format/parallel.h"
#include "solver/factors/closure.h"
#include "solver/factors/pair_exchange.h"
#include "solver/factors/previous_factors.h"
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

/// Pairs of groups with something between, or of so many polygons that their exchange is kept.
struct OpenPairs {
    std::vector<std::vector<GroupPair>> by_lesser;      // [G] ascending
    std::vector<std::vector<GroupPair*>> of_row;        // [G] all that a row has, ascending by the other group
};

OpenPairs find_pairs(const PairWork& work, const Unchanged& unchanged, const Progress& progress) {
    const std::size_t count = work.surfaces.faces.size();
    OpenPairs pairs{std::vector<std::vector<GroupPair>>(count), std::vector<std::vector<GroupPair*>>(count)};
    if (work.blockers.empty()) return pairs;
    std::vector<double> faces(count + 1, 0);
    double sum = 0, total = 0;
    for (std::size_t i = count; i-- > 0;) {
        sum += static_cast<double>(work.surfaces.faces[i].size());
        faces[i] = sum * static_cast<double>(work.surfaces.faces[i].size());
        total += faces[i];
    }
    Steps steps(progress, "what is between", total);
    parallel_for(count, 1, [&](std::size_t row) {
        PairScratch scratch;
        const auto i = static_cast<std::uint32_t>(row);
        for (std::uint32_t j = i; j < count; ++j) {
            if (unchanged.holds(i, j)) continue;
            GroupPair pair = find_pair(work, i, j, scratch);
            if (pair.sampled || pair.known) pairs.by_lesser[i].push_back(std::move(pair));
        }
        pairs.by_lesser[i].shrink_to_fit();
        steps.add(faces[i]);
    });
    for (std::vector<GroupPair>& row : pairs.by_lesser)
        for (GroupPair& pair : row) {
            pairs.of_row[pair.from].push_back(&pair);
            if (pair.to != pair.from) pairs.of_row[pair.to].push_back(&pair);
        }
    return pairs;
}

/// Rows that cost too much by cutting give their dearest pairs to the rays.
void choose_sampled(const OpenPairs& pairs) {
    for (std::vector<GroupPair*> row : pairs.of_row) {
        double seconds = 0;
        for (const GroupPair* pair : row) seconds += pair->sampled ? 0 : pair->seconds;
        if (seconds <= kRowSeconds) continue;
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

void cut_pairs(const PairWork& work, OpenPairs& open, const Progress& progress) {
    std::vector<GroupPair*> pairs;
    double total = 0;
    for (std::vector<GroupPair>& row : open.by_lesser)
        for (GroupPair& pair : row) {
            if (pair.sampled) pair.obstructed = {};
            if (pair.obstructed.empty()) continue;
            pairs.push_back(&pair);
            total += pair.seconds;
        }
    Steps steps(progress, "shadows", total);
    parallel_for(pairs.size(), 1, [&](std::size_t k) {
        cut_out(work, *pairs[k]);
        pairs[k]->obstructed = {};
        steps.add(pairs[k]->seconds);
    });
}

/// What a row exchanges exactly; m^2.
struct ExactRow {
    struct Entry {
        std::uint32_t to = 0;
        double exchange = 0;
    };
    std::vector<Entry> before, after;  // with groups below the block; with itself and all that follow
};

ExactRow exact_row(const PairWork& work, const OpenPairs& open, const Unchanged& unchanged, std::uint32_t i,
                   std::uint32_t block) {
    ExactRow row;
    PairScratch scratch;
    const auto add = [&](std::uint32_t j, std::vector<ExactRow::Entry>& to) {
        if (unchanged.holds(i, j)) return;
        const double exchange = exact_exchange(work, std::min(i, j), std::max(i, j), scratch);
        if (exchange > 0) to.push_back({j, exchange});
    };
    auto next = open.of_row[i].begin();
    const auto is_open = [&](std::uint32_t j) {
        const auto other = [&] { return (*next)->from == i ? (*next)->to : (*next)->from; };
        while (next != open.of_row[i].end() && other() < j) ++next;
        return next != open.of_row[i].end() && other() == j;
    };
    for (std::uint32_t j = 0; j < block; ++j)
        if (!is_open(j)) add(j, row.before);
    for (std::uint32_t j = i; j < work.surfaces.faces.size(); ++j)
        if (!is_open(j)) add(j, row.after);
    return row;
}

/// Adds what has been found for pairs that are not exact, and what is taken over, to a row.
void complete_row(const OpenPairs& open, const Unchanged& unchanged, std::uint32_t i, double area, FactorRow& row) {
    const std::size_t exact = row.size();
    for (const GroupPair* pair : open.of_row[i]) {
        if (pair->sampled) continue;
        const bool there = pair->from == i;
        const double value = (there ? pair->there : pair->back) / area, error = there ? pair->error_there : pair->error_back;
        if (value > 0 || error > 0)
            row.push_back({there ? pair->to : pair->from, static_cast<float>(error / area), value});
    }
    unchanged.each_in_row(i, [&](const Factor& factor) { row.push_back(factor); });
    if (row.size() > exact)
        std::sort(row.begin(), row.end(), [](const Factor& a, const Factor& b) { return a.to < b.to; });
}

/// Traces the rays of a row that has pairs for them, and adds what they find to the row and to the pairs.
void sample_row(const PairWork& work, const RayScene& scene, const OpenPairs& open, std::uint32_t i, FactorTable& table, FactorRow& row) {
    const auto other = [&](const GroupPair& pair) { return pair.from == i ? pair.to : pair.from; };
    std::vector<std::uint32_t> near;
    std::vector<GroupPair*> wanted;
    for (GroupPair* pair : open.of_row[i]) {
        if (!pair->sampled) continue;
        wanted.push_back(pair);
        if (!lie_apart(work.boxes[i], work.boxes[other(*pair)])) near.push_back(other(*pair));
    }
    if (wanted.empty()) return;
    const double accuracy = table.options.accuracy;
    SampledRow found;
    if (!near.empty()) found = sampled_row(scene, i, near, accuracy);
    table.counts.rays += found.rays;
    for (GroupPair* pair : wanted) {
        const std::uint32_t to = other(*pair);
        SampledPair one;
        if (std::binary_search(near.begin(), near.end(), to))
            one = {found.factor[to], found.standard_error[to], 0};
        else
            one = sampled_pair(scene, i, to, accuracy);
        row.push_back({to, static_cast<float>(one.standard_error), one.factor});
        (pair->from == i ? pair->there : pair->back) = one.factor * table.area[i];
        if (pair->from == pair->to) pair->back = pair->there;
        table.counts.missed += one.standard_error > 0.5 * accuracy * std::max(one.factor, kSmallFactor);
        table.counts.rays += one.rays;
    }
    table.counts.sampled += wanted.size();
    std::sort(row.begin(), row.end(), [](const Factor& a, const Factor& b) { return a.to < b.to; });
}

/// Rows [begin, end), but for rays.
std::vector<FactorRow> block_of_rows(const PairWork& work, const OpenPairs& open, const Unchanged& unchanged,
                                     std::uint32_t begin, std::uint32_t end, Steps& steps) {
    std::vector<ExactRow> exact(end - begin);
    parallel_for(exact.size(), 1, [&](std::size_t k) {
        exact[k] = exact_row(work, open, unchanged, begin + static_cast<std::uint32_t>(k), begin);
        steps.add(1);
    });
    const std::vector<double>& area = work.surfaces.area;
    std::vector<FactorRow> rows(exact.size());
    for (std::size_t k = 0; k < rows.size(); ++k) {  // ascending: what earlier rows have given comes before a row's own
        const auto i = begin + static_cast<std::uint32_t>(k);
        if (k == 0)
            for (std::size_t r = 0; r < rows.size(); ++r) {
                for (const auto& entry : exact[r].before) rows[r].push_back({entry.to, 0, entry.exchange / area[begin + r]});
                exact[r].before = {};
            }
        for (const auto& entry : exact[k].after) {
            rows[k].push_back({entry.to, 0, entry.exchange / area[i]});
            if (entry.to > i && entry.to < end) rows[entry.to - begin].push_back({i, 0, entry.exchange / area[entry.to]});
        }
        exact[k].after = {};
    }
    parallel_for(rows.size(), 1, [&](std::size_t k) {
        const std::uint32_t i = begin + static_cast<std::uint32_t>(k);
        complete_row(open, unchanged, i, area[i], rows[k]);
    });
    return rows;
}

/// Reciprocity of what is not exact: of pairs computed now and of those taken over.
void measure_pairs(const OpenPairs& open, const std::vector<double>& area, ClosureMeter& meter) {
    for (std::uint32_t i = 0; i < area.size(); ++i)
        for (const GroupPair* pair : open.of_row[i])
            if (pair->from == i && pair->to != i) meter.add_pair(i, pair->to, pair->there, pair->back);
}
void measure_unchanged(const Unchanged& unchanged, std::uint32_t i, const std::vector<double>& area, ClosureMeter& meter) {
    unchanged.each_in_row(i, [&](const Factor& there) {
        if (there.standard_error > 0 && there.to > i)
            meter.add_pair(i, there.to, area[i] * there.value, area[there.to] * unchanged.value(there.to, i));
    });
}

FactorCounts counts_of(const OpenPairs& open, const Unchanged& unchanged, std::uint32_t groups) {
    FactorCounts counts;
    for (const auto& row : open.of_row)
        for (const GroupPair* pair : row) counts.cut += !pair->sampled && (pair->error_there > 0 || pair->error_back > 0);
    for (std::uint32_t i = 0; i < groups && !unchanged.empty(); ++i)
        for (std::uint32_t j = 0; j < groups; ++j) counts.reused += unchanged.holds(i, j);
    return counts;
}

Result<FactorTable> start_table(const Scene& scene, const FactorOptions& options, const SurfaceGroups& groups,
                                const Surfaces& surfaces) {
    for (std::size_t g = 0; g < surfaces.area.size(); ++g)
        if (!(surfaces.area[g] > 0))
            return bad_input(scene.manifest.path.string(), "\"" + groups.names[g] + "\" has no side with an area");
    FactorTable table;
    table.options = options;
    table.options.by = groups.by;
    table.names = groups.names;
    table.area = surfaces.area;
    table.instances = record_instances(scene, groups);
    table.polygons = surfaces.bodies.size();
    return table;
}

}  // namespace

Result<FactorTable> view_factors(const Scene& scene, const FactorOptions& options, const TakeRows& take,
                                 const Progress& progress) {
    const auto groups = surface_groups(scene, options.by);
    if (!groups) return groups.error();
    const Surfaces surfaces = gather_surfaces(scene, *groups, options.sides);
    auto started = start_table(scene, options, *groups, surfaces);
    if (!started) return started.error();
    FactorTable& table = *started;
    const Blockers blockers(surfaces);
    table.blockers = blockers.size();
    const PairWork work(surfaces, blockers, options.accuracy);
    Unchanged unchanged;
    if (options.previous) {
        auto found = Unchanged::between(*options.previous, table, work.boxes);
        if (!found) return found.error();
        unchanged = *std::move(found);
    }
    OpenPairs open = find_pairs(work, unchanged, progress);
    choose_sampled(open);
    cut_pairs(work, open, progress);

    const auto count = static_cast<std::uint32_t>(table.names.size());
    table.counts = counts_of(open, unchanged, count);
    std::optional<SceneRays> rays;
    for (const auto& row : open.by_lesser)
        if (!rays && std::any_of(row.begin(), row.end(), [](const GroupPair& pair) { return pair.sampled; }))
            rays.emplace(scene);
    ClosureMeter meter(table.area);
    Steps steps(progress, "factors", static_cast<double>(count) * (rays ? 2 : 1));
    const std::uint64_t at_a_time = std::max<std::uint64_t>(1, options.numbers_at_a_time / count);
    for (std::uint64_t begin = 0; begin < count; begin += at_a_time) {
        const auto first = static_cast<std::uint32_t>(begin);
        const auto end = static_cast<std::uint32_t>(std::min<std::uint64_t>(count, begin + at_a_time));
        std::vector<FactorRow> rows = block_of_rows(work, open, unchanged, first, end, steps);
        for (std::uint32_t i = first; i < end; ++i) {
            if (rays) {
                sample_row(work, {scene, *groups, surfaces, *rays, options.sides}, open, i, table, rows[i - first]);
                steps.add(1);
            }
            meter.add_row(rows[i - first]);
            measure_unchanged(unchanged, i, table.area, meter);
        }
        if (auto taken = take(table, first, rows); !taken) return taken.error();
    }
    measure_pairs(open, table.area, meter);
    table.closure = meter.report();
    const FactorCounts& c = table.counts;
    table.counts.exact = std::uint64_t{count} * count - c.cut - c.sampled - c.reused;
    return started;
}

Result<Factors> view_factors(const Scene& scene, const FactorOptions& options, const Progress& progress) {
    Factors factors;
    FactorOptions at_once = options;
    at_once.numbers_at_a_time = ~std::uint64_t{0};
    auto table = view_factors(
        scene, at_once,
        [&](const FactorTable&, std::uint32_t, std::span<const FactorRow> rows) -> Status {
            factors.rows.insert(factors.rows.end(), rows.begin(), rows.end());
            return Done{};
        },
        progress);
    if (!table) return table.error();
    static_cast<FactorTable&>(factors) = *std::move(table);
    return factors;
}

std::uint64_t factors_memory(const Scene& scene, const FactorOptions& options, bool whole) {
    constexpr std::uint64_t kPerNumber = 3 * sizeof(Factor);  // in vectors that have grown by doubling, and the mirror's
    constexpr std::uint64_t kPerTriangle = 3000;  // a polygon on both sides with its rules, where none are merged
    constexpr std::uint64_t kPerGroup = 1000;     // names, areas, records
    std::uint64_t groups = scene.instances.size();
    if (options.by == GroupBy::Group || (options.by == GroupBy::Auto && !scene.manifest.groups.empty()))
        groups = scene.manifest.groups.size();
    if (options.by == GroupBy::Material) {
        groups = 0;
        for (const Instance& i : scene.instances) groups += i.data().materials.size();
    }
    const std::uint64_t numbers = whole ? groups * groups : std::min(groups * groups, options.numbers_at_a_time + groups);
    return numbers * kPerNumber + groups * kPerGroup + scene.triangle_count() * kPerTriangle;
}

}  // namespace rro
