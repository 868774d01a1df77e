#include "solver/transport/refine.h"

#include <span>

#include "format/clock.h"
#include "format/parallel.h"
#include "solver/transport/ticks.h"

namespace rro {

namespace {

constexpr std::size_t kBatch = 1 << 16;  // pairs judged at a time; bounds the memory of the verdicts
constexpr std::size_t kGrain = 64;

// A link is judged anew when its combined error exceeds its share clearly: judging accepts each term by itself.
constexpr double kOutgrown = 2.0;

// An instance by itself may be this many times worse than the scene, unless it holds less than this share of the reflected
// power: then it does not count by itself (solver/accuracy.md).
constexpr double kWorstInstance = 3;
constexpr double kCountingShare = 1e-3;

/// The stored pairs below a stored pair, in the order in which a division makes them.
class StoredChildren {
  public:
    StoredChildren(const Nodes& nodes, const Node& divided, std::uint32_t stored) : stored_(stored) {
        if (stored != kNotStored) pairs_ = nodes.scene().instances[divided.instance].object->self_pairs;
    }

    /// Below a link there are none: parts of its ends keep it.
    std::uint32_t operator[](std::size_t k) const {
        if (stored_ == kNotStored || pairs_[stored_].step == PairStep::Link || pairs_[stored_].step == PairStep::Dark)
            return stored_;
        std::uint32_t child = stored_ + 1;
        for (; k > 0; --k) child = pairs_[child].end;
        return child;
    }

  private:
    std::span<const SelfPair> pairs_;
    std::uint32_t stored_;
};

/// An instance with itself.
Pair self_pair(const Nodes& nodes, std::uint32_t instance) {
    const bool stored = !nodes.scene().instances[instance].object->self_pairs.empty();
    return {nodes.root(instance), nodes.root(instance), stored ? 0 : kNotStored};
}

class Refiner {
  public:
    Refiner(LinkSet& set, Nodes& nodes, Guide& guide, const LinkBuilder& builder)
        : set_(set), nodes_(nodes), guide_(guide), builder_(builder) {}

    void run() {
        stack_ = std::move(set_.pending);
        set_.pending.clear();
        std::size_t kept = 0;
        for (const Link& l : set_.links) {
            const auto k = static_cast<std::uint32_t>(&l - set_.links.data());
            if (outgrown(l, nodes_, guide_)) {
                ++set_.change.removed;
                stack_.push_back({l.a, l.b, l.stored, set_.tree ? set_.tree->record_of_link[k] : kNoNode});
                if (!set_.tree) continue;
                (*set_.tree)[stack_.back().record].fate = PairFate::Open;
                set_.note(l);
            } else {
                if (set_.tree) renumber(k, static_cast<std::uint32_t>(kept));
                set_.links[kept++] = l;
            }
        }
        set_.links.resize(kept);
        if (set_.tree) set_.tree->record_of_link.resize(kept);
        while (!stack_.empty()) {
            const std::size_t count = std::min(kBatch, stack_.size());
            batch_.assign(stack_.end() - static_cast<std::ptrdiff_t>(count), stack_.end());
            stack_.resize(stack_.size() - count);
            verdicts_.assign(count, {});
            const auto start = Clock::now();
            parallel_for(count, kGrain, [&](std::size_t k) {
                const std::uint64_t begun = ticks();
                verdicts_[k] = builder_.judge(batch_[k], guide_);
                verdicts_[k].ticks = ticks() - begun;
            });
            account(seconds_since(start));
            for (std::size_t k = 0; k < count; ++k) take(batch_[k], verdicts_[k]);
        }
    }

  private:
    // What all threads spent on visibility, as a share of what they spent on judging, in wall time.
    void account(double seconds) {
        double all = 0, visibility = 0;
        for (const Verdict& v : verdicts_) {
            all += static_cast<double>(v.ticks);
            visibility += static_cast<double>(v.visibility_ticks);
        }
        if (all > 0) set_.visibility_seconds += seconds * visibility / all;
    }

    void renumber(std::uint32_t from, std::uint32_t to) {
        PairTree& tree = *set_.tree;
        tree.record_of_link[to] = tree.record_of_link[from];
        tree[tree.record_of_link[to]].at = to;
    }

    void take(const Pair& pair, const Verdict& v) {
        set_.rays += v.rays;
        if (set_.tree) {
            PairRecord& record = (*set_.tree)[pair.record];
            record.round = set_.round;
            record.looked = v.looked;
            record.fate = v.action == Verdict::Action::Pending ? PairFate::Pending : PairFate::Dropped;
        }
        switch (v.action) {
            case Verdict::Action::Drop: break;
            case Verdict::Action::Pending: set_.pending.push_back(pair); break;
            case Verdict::Action::Accept: set_.add(v.link, pair.record); break;
            case Verdict::Action::SplitA:
            case Verdict::Action::SplitB: split(pair, v.action); break;
        }
    }

    void split(const Pair& pair, Verdict::Action action) {
        divide(pair, action, set_.within_instances, nodes_, below_);
        grow(guide_, nodes_);
        if (set_.tree)
            set_.tree->divide(pair.record, action == Verdict::Action::SplitA ? PairFate::SplitA : PairFate::SplitB, below_);
        stack_.insert(stack_.end(), below_.begin(), below_.end());
    }

    LinkSet& set_;
    Nodes& nodes_;
    Guide& guide_;
    const LinkBuilder& builder_;
    std::vector<Pair> stack_, batch_, below_;
    std::vector<Verdict> verdicts_;
};

}  // namespace

LinkSet::LinkSet(const Nodes& nodes, bool within, bool with_tree)
    : pending(first_pairs(nodes, within)), within_instances(within) {
    if (!with_tree) return;
    tree = std::make_unique<PairTree>();
    tree->divide(0, PairFate::SplitA, pending);
}

void LinkSet::add(const Link& link, std::uint32_t record) {
    if (tree) {
        (*tree)[record].fate = PairFate::Linked;
        (*tree)[record].at = static_cast<std::uint32_t>(links.size());
        tree->record_of_link.push_back(record);
        note(link);
    }
    links.push_back(link);
    ++change.added;
}

void LinkSet::replace(std::uint32_t number, const Link& link) {
    links[number] = link;
    note(link);
    ++change.retested;
}

void LinkSet::remove(std::uint32_t link) {
    note(links[link]);
    const std::uint32_t last = tree->record_of_link.back();
    (*tree)[last].at = link;
    tree->record_of_link[link] = last;
    tree->record_of_link.pop_back();
    links[link] = links.back();
    links.pop_back();
    ++change.removed;
}

std::vector<Pair> first_pairs(const Nodes& nodes, bool within) {
    if (nodes.group_count() > 0) return {{0, 0}};
    std::vector<Pair> out;
    const auto count = static_cast<std::uint32_t>(nodes.scene().instances.size());
    for (std::uint32_t i = 0; i < count; ++i) {
        if (within) out.push_back(self_pair(nodes, i));
        for (std::uint32_t j = i + 1; j < count; ++j) out.push_back({nodes.root(i), nodes.root(j)});
    }
    return out;
}

bool outgrown(const Link& l, const Nodes& nodes, const Guide& guide) {
    return harm(guide, nodes, l.a, l.b, double(l.error_a)) > kOutgrown ||
           harm(guide, nodes, l.b, l.a, double(l.error_b)) > kOutgrown ||
           std::max(noise_harm(guide, nodes, l.a, l.b, double(l.noise)), noise_harm(guide, nodes, l.b, l.a, double(l.noise))) >
               kOutgrown * kNoiseShare;
}

void grow(Guide& guide, const Nodes& nodes) {
    for (auto n = static_cast<std::uint32_t>(guide.radiosity.size()); n < nodes.size(); ++n) {
        const std::uint32_t from = nodes[n].parent;
        guide.radiosity.push_back(guide.radiosity[from]);
        guide.variation.push_back(0);
        guide.error.push_back(guide.error[from]);
        guide.irradiance.push_back(guide.irradiance[from]);
        guide.reflectance.push_back(guide.reflectance[from]);
    }
}

void divide(const Pair& pair, Verdict::Action action, bool within, Nodes& nodes, std::vector<Pair>& out) {
    out.clear();
    const bool first = action == Verdict::Action::SplitA;
    const std::uint32_t divided = first ? pair.a : pair.b, other = first ? pair.b : pair.a;
    if (nodes[divided].group() && pair.a == pair.b) {
        const std::uint32_t left = nodes[divided].first_child, right = nodes[divided].second_child;
        for (const std::uint32_t child : {left, right})
            if (nodes[child].group()) out.push_back({child, child});
            else if (within) out.push_back(self_pair(nodes, nodes[child].instance));
        out.push_back({left, right});
        return;
    }
    if (nodes[divided].kind == NodeKind::Surface) nodes.subdivide(divided);
    const StoredChildren below(nodes, nodes[divided], pair.stored);
    std::vector<std::uint32_t> children;
    nodes.children(divided, children);
    if (pair.a != pair.b) {
        for (std::size_t k = 0; k < children.size(); ++k) out.push_back({children[k], other, below[k]});
        return;
    }
    for (std::size_t i = 0, k = 0; i < children.size(); ++i)
        for (std::size_t j = i; j < children.size(); ++j, ++k)
            if (i != j || nodes[children[i]].kind != NodeKind::Surface) out.push_back({children[i], children[j], below[k]});
}

void refine(LinkSet& set, Nodes& nodes, Guide& guide, const LinkBuilder& builder) {
    Refiner(set, nodes, guide, builder).run();
}

ErrorEstimate estimate_error(const LinkSet& set, const Nodes& nodes, double growth, std::span<const float> outside,
                             Guide& guide) {
    // Errors of E that links bring to each node, added by squares and plainly; then down to the leaves (children follow
    // their parents).
    std::vector<double> squares(nodes.size(), 0), plain(nodes.size(), 0), below(nodes.size(), 0);
    const std::size_t count = nodes.scene().instances.size();
    std::vector<double> fourth(count + 1, 0);  // what each link adds to the squared error, squared; groups at the end
    struct Receiver {  // what links ask of a node, close together
        double per_area, reflecting;
        std::uint32_t instance;
    };
    std::vector<Receiver> receivers(nodes.size());
    parallel_for(nodes.size(), kGrain, [&](std::size_t n) {
        const Node& node = nodes[static_cast<std::uint32_t>(n)];
        receivers[n] = {node.area > 0 ? 1 / node.area : 0, node.area * std::pow(double(guide.reflectance[n]), 2),
                        node.group() ? static_cast<std::uint32_t>(count) : node.instance};
    });
    const auto add = [&](std::uint32_t to, std::uint32_t from, double error, double noise) {
        const Receiver& r = receivers[to];
        const double per = double(guide.radiosity[from]) * r.per_area, square = per * per * (error * error + noise * noise);
        squares[to] += square;
        plain[to] += per * error;
        fourth[r.instance] += r.reflecting * square * (r.reflecting * square);
    };
    for (const Link& l : set.links) {
        add(l.a, l.b, double(l.error_a), double(l.noise));
        if (l.a != l.b) add(l.b, l.a, double(l.error_b), double(l.noise));
    }
    std::vector<double> error(count, 0), light(count, 0), power(count, 0);
    for (std::uint32_t n = 0; n < nodes.size(); ++n) {
        const Node& node = nodes[n];
        if (node.parent != kNoNode) {
            squares[n] += squares[node.parent];
            plain[n] += plain[node.parent];
        }
        if (node.kind != NodeKind::Surface || node.child_count > 0) continue;
        if (!outside.empty()) squares[n] += std::pow(double(outside[n]), 2);
        const double rho = double(guide.reflectance[n]), together = kAgreement * growth * plain[n];
        error[node.instance] += node.area * rho * rho * (squares[n] + together * together);
        light[node.instance] += node.area * std::pow(rho * double(guide.irradiance[n]), 2);
        power[node.instance] += node.area * rho * double(guide.irradiance[n]);
    }
    for (auto n = static_cast<std::uint32_t>(nodes.size()); n-- > 0;) {
        const Node& node = nodes[n];
        if (node.child_count > 0 && node.area > 0) plain[n] = below[n] / node.area;
        if (node.parent != kNoNode) below[node.parent] += node.area * plain[n];
    }
    guide.error.assign(plain.begin(), plain.end());
    ErrorEstimate e;
    double sum = 0, all = 0;
    for (const double p : power) all += p;
    for (std::size_t i = 0; i < count; ++i) {
        error[i] += std::sqrt(2 * fourth[i]);  // few large ones add up to their mean by chance only
        sum += error[i];
        e.power_share.push_back(all > 0 ? power[i] / all : 0);
        e.weight.push_back(guide.reflected > 0 ? light[i] / guide.reflected : 0);
        e.of_instance.push_back(light[i] > 0 ? std::sqrt(error[i] / light[i]) : 0);
    }
    e.whole = guide.reflected > 0 ? std::sqrt(sum / guide.reflected) : 0;
    return e;
}

std::int64_t worst_instance(const ErrorEstimate& estimate) {
    std::int64_t worst = -1;
    for (std::size_t i = 0; i < estimate.of_instance.size(); ++i)
        if (estimate.power_share[i] > kCountingShare &&
            (worst < 0 || estimate.of_instance[i] > estimate.of_instance[static_cast<std::size_t>(worst)]))
            worst = static_cast<std::int64_t>(i);
    return worst;
}

bool lower_shares(const ErrorEstimate& estimate, double allowed, Guide& guide) {
    bool good = true;
    for (std::size_t i = 0; i < guide.share.size(); ++i) {
        // Errors add up by their squares, to which a few bright spots may bring nearly everything; but what most of the
        // light comes from is what is looked at, and so is held to the accuracy asked, too.
        const bool counts = estimate.power_share[i] > kCountingShare;
        const double worse = std::min(kWorstInstance, 1 / std::sqrt(std::max(estimate.power_share[i], 1e-300)));
        const double over = std::min(allowed / std::max(estimate.whole, 1e-300),
                                     counts ? worse * allowed / std::max(estimate.of_instance[i], 1e-300) : 1.0);
        if (over >= 1) continue;
        good = false;
        guide.share[i] *= std::clamp(0.7 * over * over * over, 1.0 / 30, 0.7);
        guide.scene_share = std::min(guide.scene_share, guide.share[i]);
    }
    return good;
}

}  // namespace rro
