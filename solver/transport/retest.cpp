#include "solver/transport/retest.h"

#include <algorithm>
#include <map>
#include <utility>

#include "format/parallel.h"
#include "solver/visibility/box_hull.h"

namespace rro {
namespace {

constexpr std::size_t kBatch = 1 << 14;  // pairs judged at a time
constexpr std::size_t kGrain = 16;

// Boxes of blockers grow by this share of their coordinates, as rays have them.
constexpr double kMargin = 1e-6;

Box3 grown(Box3 box) {
    double most = 0;
    for (int i = 0; i < 3; ++i) most = std::max({most, std::abs(box.lo[i]), std::abs(box.hi[i])});
    const double margin = kMargin * most;
    box.lo -= {margin, margin, margin};
    box.hi += {margin, margin, margin};
    return box;
}

PairFate fate_of(Verdict::Action action) {
    switch (action) {
        case Verdict::Action::SplitA: return PairFate::SplitA;
        case Verdict::Action::SplitB: return PairFate::SplitB;
        case Verdict::Action::Accept: return PairFate::Linked;
        case Verdict::Action::Pending: return PairFate::Pending;
        case Verdict::Action::Drop: break;
    }
    return PairFate::Dropped;
}

void once_each(std::vector<std::uint32_t>& records) {
    std::sort(records.begin(), records.end());
    records.erase(std::unique(records.begin(), records.end()), records.end());
}

class Retest {
  public:
    Retest(LinkSet& set, Nodes& nodes, const LinkBuilder& builder, Schedule& schedule, Guide& guide, const Touched& touched)
        : set_(set), tree_(*set.tree), nodes_(nodes), builder_(builder), schedule_(schedule), guide_(guide), touched_(touched),
          work_(schedule.rounds.size()) {
        for (const Instance* blocker : touched.blockers) boxes_.push_back(grown(blocker->bounds));
    }

    void run() {
        index_upper(0);
        std::vector<Pair> first = first_pairs(nodes_, set_.within_instances);
        leave_row(0);
        below(0, PairFate::SplitA, first, 0);
        for (std::size_t round = 0; round < work_.size(); ++round) judge_round(round);
        clear_left_rows();
        renew_pending();
        tree_.reuse_gone();
    }

  private:
    bool touched(std::uint32_t n) const {
        return nodes_[n].group() ? touched_.group[n] : touched_.instance[nodes_[n].instance];
    }

    /// Pairs whose parts depend on how instances are grouped, and those that they end in.
    bool upper(const PairRecord& r) const { return nodes_[r.a].group() || nodes_[r.b].group(); }
    bool known_nodes(const PairRecord& r) const { return r.a != kNoNode && r.b != kNoNode; }

    void index_upper(std::uint32_t record) {
        const PairRecord& r = tree_[record];
        for (std::uint32_t k = 0; k < r.count; ++k) {
            const std::uint32_t at = r.at + k;
            const PairRecord& next = tree_[at];
            if (known_nodes(next)) upper_[std::minmax(next.a, next.b)] = at;
            // Of a group that is no more, parts may still be.
            if (next.split() && above_instances(next)) index_upper(at);
        }
    }
    bool above_instances(const PairRecord& r) const { return !known_nodes(r) || upper(r); }

    void leave_row(std::uint32_t record) {
        PairRecord& r = tree_[record];
        if (r.split() && r.count > 0) left_.push_back({r.at, r.count});
        r.count = 0;
        r.fate = PairFate::Open;
    }

    /// Puts pairs below a record: as they were, where they are known.
    void below(std::uint32_t record, PairFate fate, std::vector<Pair>& pairs, std::size_t round) {
        tree_.divide(record, fate, pairs);
        for (const Pair& pair : pairs) {
            const auto known = upper_.find(std::minmax(pair.a, pair.b));
            if (known == upper_.end()) {
                work_[round].push_back(pair.record);
                continue;
            }
            PairRecord& from = tree_[known->second];
            tree_[pair.record] = from;
            if (from.fate == PairFate::Linked) tree_.record_of_link[from.at] = pair.record;
            if (from.fate == PairFate::Pending) waiting_.push_back(pair.record);
            from.fate = PairFate::Gone;
            from.count = 0;
            upper_.erase(known);
            visit(pair.record);
        }
    }

    /// Finds what is to be judged at and below a record.
    void visit(std::uint32_t record) {
        std::vector<std::uint32_t> stack{record};
        while (!stack.empty()) {
            const std::uint32_t at = stack.back();
            stack.pop_back();
            const PairRecord r = tree_[at];
            if (!known_nodes(r)) continue;  // dropped, and its elements are of no use any more
            if (touched(r.a) || touched(r.b)) {
                if (!upper(r)) clear(at);
                ask(at, upper(r) ? r.round : 0);
                continue;
            }
            const bool linked = r.fate == PairFate::Linked && r.a != r.b;
            if (!(linked || r.split()) || !blocked(r)) continue;
            if (linked || r.looked) {
                ask(at, r.round);
            } else {
                for (std::uint32_t k = 0; k < r.count; ++k) stack.push_back(r.at + k);
            }
        }
    }

    void ask(std::uint32_t record, std::size_t round) { work_[std::min(round, work_.size() - 1)].push_back(record); }

    /// May a blocker be or have been in the pair's shaft?
    bool blocked(const PairRecord& r) const {
        Box3 both = nodes_[r.a].box;
        both.add(nodes_[r.b].box);
        if (std::none_of(boxes_.begin(), boxes_.end(), [&](const Box3& box) { return both.overlaps(box); })) return false;
        const BoxHull hull(nodes_[r.a].box, nodes_[r.b].box);
        for (std::size_t k = 0; k < boxes_.size(); ++k)
            if (!hull.misses(boxes_[k]) && !((r.looked || r.fate == PairFate::Linked) && builder_.clears(r.a, r.b, *touched_.blockers[k])))
                return true;
        return false;
    }

    void clear(std::uint32_t record) {
        tree_.clear(record, [&](std::uint32_t link) { set_.remove(link); });
    }

    Guide& lead(std::size_t round) {
        Guide& guide = round == 0 ? schedule_.first : guide_;
        guide.share = schedule_.rounds[round].of_instance;
        guide.scene_share = schedule_.rounds[round].of_scene;
        return guide;
    }

    void judge_round(std::size_t round) {
        const Guide& guide = lead(round);
        std::vector<std::uint32_t>& work = work_[round];
        if (round > 0) {
            for (const std::uint32_t record : fresh_)
                if (tree_[record].fate == PairFate::Linked && outgrown(set_.links[tree_[record].at], nodes_, guide))
                    work.push_back(record);
            for (const std::uint32_t record : waiting_)
                if (tree_[record].fate == PairFate::Pending) work.push_back(record);
        }
        once_each(work);
        while (!work.empty()) {
            const std::size_t count = std::min(kBatch, work.size());
            batch_.assign(work.end() - static_cast<std::ptrdiff_t>(count), work.end());
            work.resize(work.size() - count);
            verdicts_.assign(count, {});
            parallel_for(count, kGrain, [&](std::size_t k) {
                verdicts_[k] = builder_.judge(tree_[batch_[k]].pair(batch_[k]), guide);
            });
            for (std::size_t k = 0; k < count; ++k) take(batch_[k], verdicts_[k], round);
        }
    }

    void take(std::uint32_t record, const Verdict& v, std::size_t round) {
        set_.rays += v.rays;
        PairRecord& r = tree_[record];
        const PairFate fate = fate_of(v.action);
        const bool is_upper = upper(r);
        if (r.fate == fate && r.split() && !is_upper) {
            r.looked = v.looked;
            for (std::uint32_t k = 0; k < r.count; ++k) visit(r.at + k);
            return;
        }
        r.looked = v.looked;
        r.round = static_cast<std::uint8_t>(round);
        if (r.fate == fate && fate == PairFate::Linked) {
            set_.replace(r.at, v.link);
            fresh_.push_back(record);
            return;
        }
        if (is_upper && r.split()) leave_row(record);
        else clear(record);
        tree_[record].fate = fate;
        if (fate == PairFate::Pending) waiting_.push_back(record);
        if (fate == PairFate::Linked) {
            set_.add(v.link, record);
            fresh_.push_back(record);
        }
        if (tree_[record].split()) {
            divide(tree_[record].pair(record), v.action, set_.within_instances, nodes_, pairs_);
            grow(schedule_.first, nodes_);
            grow(guide_, nodes_);
            if (is_upper) {
                below(record, fate, pairs_, round);
            } else {
                tree_.divide(record, fate, pairs_);
                for (const Pair& pair : pairs_) work_[round].push_back(pair.record);
            }
        }
    }

    /// What nothing has been put below any more.
    void clear_left_rows() {
        for (const auto& [first, count] : left_) {
            for (std::uint32_t k = 0; k < count; ++k) {
                clear(first + k);
                tree_[first + k].fate = PairFate::Gone;
            }
            tree_.release(first, count);
        }
    }

    void renew_pending() {
        for (const Pair& pair : set_.pending) waiting_.push_back(pair.record);
        once_each(waiting_);
        set_.pending.clear();
        for (const std::uint32_t record : waiting_)
            if (tree_[record].fate == PairFate::Pending) set_.pending.push_back(tree_[record].pair(record));
    }

    LinkSet& set_;
    PairTree& tree_;
    Nodes& nodes_;
    const LinkBuilder& builder_;
    Schedule& schedule_;
    Guide& guide_;
    const Touched& touched_;
    std::vector<Box3> boxes_;  // of the blockers
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> upper_;  // records above and of pairs of instances
    std::vector<std::pair<std::uint32_t, std::uint32_t>> left_;               // rows without a record above
    std::vector<std::vector<std::uint32_t>> work_;  // [rounds] records to be judged
    std::vector<std::uint32_t> fresh_, waiting_;    // links and pending pairs that have come
    std::vector<std::uint32_t> batch_;
    std::vector<Verdict> verdicts_;
    std::vector<Pair> pairs_;
};

}  // namespace

UsedElements used_elements(const LinkSet& set, const Nodes& nodes) {
    UsedElements used(nodes.size(), 0);
    for (const PairRecord& r : set.tree->records())
        if (&r != set.tree->records().data() && (r.split() || r.fate == PairFate::Linked || r.fate == PairFate::Pending))
            used[r.a] = used[r.b] = 1;
    return used;
}

void renumber(LinkSet& set, const std::vector<std::uint32_t>& map) {
    const auto renumber = [&](std::uint32_t& node) {
        if (node < map.size()) node = map[node];
    };
    for (PairRecord& r : set.tree->records()) renumber(r.a), renumber(r.b);
    for (Link& l : set.links) renumber(l.a), renumber(l.b);
    for (Pair& p : set.pending) renumber(p.a), renumber(p.b);
}

Touched touched_by(const SceneChange& change, const Scene& before, const Nodes& nodes, std::span<const std::uint32_t> renewed) {
    Touched touched{change.moved, std::vector<std::uint8_t>(nodes.group_count(), !renewed.empty()), {}};
    for (const std::uint32_t g : renewed)
        if (g != kNoNode) touched.group[g] = 0;
    for (std::uint32_t g = nodes.group_count(); g-- > 0;)
        for (const std::uint32_t child : {nodes[g].first_child, nodes[g].second_child})
            touched.group[g] |= nodes[child].group() ? touched.group[child] : touched.instance[nodes[child].instance];
    for (std::uint32_t i = 0; i < change.moved.size(); ++i) {
        if (!change.moved[i]) continue;
        touched.blockers.push_back(&nodes.scene().instances[i]);
        if (change.before[i] != SceneChange::kPlaced) touched.blockers.push_back(&before.instances[change.before[i]]);
    }
    for (const std::uint32_t i : change.deleted) touched.blockers.push_back(&before.instances[i]);
    return touched;
}

void carry(Guide& guide, Schedule& schedule, const std::vector<std::uint32_t>& map, const SceneChange& change, const Nodes& nodes) {
    std::vector<float> error(nodes.size(), 0.0f);
    for (std::size_t n = 0; n < map.size(); ++n)
        if (map[n] != kNoNode) error[map[n]] = guide.error[n];
    guide.error = std::move(error);
    const std::vector<Instance>& instances = nodes.scene().instances;
    for (Shares& round : schedule.rounds) {
        const std::vector<double> before = std::exchange(round.of_instance, {});
        for (std::size_t i = 0; i < instances.size(); ++i) {
            std::size_t like = i;
            for (std::size_t k = 0; k < instances.size() && change.before[like] == SceneChange::kPlaced; ++k)
                if (instances[k].object == instances[i].object && change.before[k] != SceneChange::kPlaced) like = k;
            const std::uint32_t number = change.before[like];
            round.of_instance.push_back(number != SceneChange::kPlaced ? before[number]
                                                                      : *std::max_element(before.begin(), before.end()));
        }
    }
}

void retest(LinkSet& set, Nodes& nodes, const LinkBuilder& builder, Schedule& schedule, Guide& guide, const Touched& touched) {
    Retest(set, nodes, builder, schedule, guide, touched).run();
}

}  // namespace rro
