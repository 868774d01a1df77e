#include "solver/transport/refine.h"

#include <chrono>
#include <span>

#include "format/parallel.h"
#include "solver/transport/ticks.h"

namespace rro {

namespace {

constexpr std::size_t kBatch = 1 << 16;  // pairs judged at a time; bounds the memory of the verdicts
constexpr std::size_t kGrain = 64;

// A link is judged anew when its combined error exceeds its share clearly: judging accepts each term by itself.
constexpr double kOutgrown = 2.0;

bool outgrown(const Link& l, const Nodes& nodes, const Guide& guide) {
    return harm(guide, nodes, l.a, l.b, double(l.error_a)) > kOutgrown ||
           harm(guide, nodes, l.b, l.a, double(l.error_b)) > kOutgrown;
}

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
            if (outgrown(l, nodes_, guide_))
                stack_.push_back({l.a, l.b, l.stored});
            else
                set_.links[kept++] = l;
        }
        set_.links.resize(kept);
        while (!stack_.empty()) {
            const std::size_t count = std::min(kBatch, stack_.size());
            batch_.assign(stack_.end() - static_cast<std::ptrdiff_t>(count), stack_.end());
            stack_.resize(stack_.size() - count);
            verdicts_.assign(count, {});
            const auto start = std::chrono::steady_clock::now();
            parallel_for(count, kGrain, [&](std::size_t k) {
                const std::uint64_t begun = ticks();
                verdicts_[k] = builder_.judge(batch_[k], guide_);
                verdicts_[k].ticks = ticks() - begun;
            });
            account(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
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

    void take(const Pair& pair, const Verdict& v) {
        set_.rays += v.rays;
        switch (v.action) {
            case Verdict::Action::Drop: break;
            case Verdict::Action::Pending: set_.pending.push_back(pair); break;
            case Verdict::Action::Accept: set_.links.push_back(v.link); break;
            case Verdict::Action::SplitA:
                if (pair.a == pair.b) split_self(pair);
                else split(pair.a, pair.b, pair.stored);
                break;
            case Verdict::Action::SplitB: split(pair.b, pair.a, pair.stored); break;
        }
    }

    void split(std::uint32_t divided, std::uint32_t other, std::uint32_t stored) {
        if (nodes_[divided].kind == NodeKind::Surface) {
            const std::size_t before = nodes_.size();
            nodes_.subdivide(divided);
            for (std::size_t n = before; n < nodes_.size(); ++n) {
                guide_.radiosity.push_back(guide_.radiosity[divided]);
                guide_.variation.push_back(0);
                guide_.error.push_back(guide_.error[divided]);
                guide_.irradiance.push_back(guide_.irradiance[divided]);
                guide_.reflectance.push_back(guide_.reflectance[divided]);
            }
        }
        const StoredChildren below(nodes_, nodes_[divided], stored);
        nodes_.children(divided, children_);
        for (std::size_t k = 0; k < children_.size(); ++k) stack_.push_back({children_[k], other, below[k]});
    }

    void split_self(const Pair& pair) {
        if (nodes_[pair.a].group()) return split_group(nodes_[pair.a]);
        const StoredChildren below(nodes_, nodes_[pair.a], pair.stored);
        nodes_.children(pair.a, children_);
        std::size_t k = 0;
        for (std::size_t i = 0; i < children_.size(); ++i)
            for (std::size_t j = i; j < children_.size(); ++j, ++k)
                if (i != j || nodes_[children_[i]].kind != NodeKind::Surface)
                    stack_.push_back({children_[i], children_[j], below[k]});
    }

    void split_group(const Node& group) {
        const std::uint32_t left = group.first_child, right = group.second_child;
        for (const std::uint32_t child : {left, right})
            if (nodes_[child].group()) stack_.push_back({child, child});
            else if (set_.within_instances) stack_.push_back(self_pair(nodes_, nodes_[child].instance));
        stack_.push_back({left, right});
    }

    LinkSet& set_;
    Nodes& nodes_;
    Guide& guide_;
    const LinkBuilder& builder_;
    std::vector<Pair> stack_, batch_;
    std::vector<Verdict> verdicts_;
    std::vector<std::uint32_t> children_;
};

}  // namespace

LinkSet::LinkSet(const Nodes& nodes, bool within) : within_instances(within) {
    if (nodes.group_count() > 0) {
        pending.push_back({0, 0});
        return;
    }
    const auto count = static_cast<std::uint32_t>(nodes.scene().instances.size());
    for (std::uint32_t i = 0; i < count; ++i) {
        if (within) pending.push_back(self_pair(nodes, i));
        for (std::uint32_t j = i + 1; j < count; ++j) pending.push_back({nodes.root(i), nodes.root(j)});
    }
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
    std::vector<double> fourth(count, 0);  // what each link adds to the squared error, squared
    const auto add = [&](std::uint32_t to, std::uint32_t from, double error, double noise) {
        if (!(nodes[to].area > 0)) return;
        const double per = double(guide.radiosity[from]) / nodes[to].area;
        squares[to] += per * per * (error * error + noise * noise);
        plain[to] += per * error;
        const double one = nodes[to].area * std::pow(double(guide.reflectance[to]) * per, 2) * (error * error + noise * noise);
        if (!nodes[to].group()) fourth[nodes[to].instance] += one * one;
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

}  // namespace rro
