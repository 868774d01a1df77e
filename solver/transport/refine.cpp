#include "solver/transport/refine.h"

#include "format/parallel.h"

namespace rro {

namespace {

constexpr std::size_t kBatch = 1 << 16;  // pairs judged at a time; bounds the memory of the verdicts
constexpr std::size_t kGrain = 64;

// A link is judged anew when its combined error exceeds its share clearly: judging accepts each term by itself.
constexpr double kOutgrown = 2.0;

bool outgrown(const Link& l, const Nodes& nodes, const Guide& guide) {
    return reflected(guide, nodes, l.a, l.b, double(l.error_a)) > kOutgrown * link_tolerance(guide, nodes[l.a]) ||
           reflected(guide, nodes, l.b, l.a, double(l.error_b)) > kOutgrown * link_tolerance(guide, nodes[l.b]);
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
                stack_.push_back({l.a, l.b});
            else
                set_.links[kept++] = l;
        }
        set_.links.resize(kept);
        while (!stack_.empty()) {
            const std::size_t count = std::min(kBatch, stack_.size());
            batch_.assign(stack_.end() - static_cast<std::ptrdiff_t>(count), stack_.end());
            stack_.resize(stack_.size() - count);
            verdicts_.assign(count, {});
            parallel_for(count, kGrain, [&](std::size_t k) {
                const auto [a, b] = batch_[k];
                if (a != b) verdicts_[k] = builder_.judge(a, b, guide_);
                else verdicts_[k].action = builder_.splits_self(a, guide_) ? Verdict::Action::SplitA : Verdict::Action::Pending;
            });
            for (std::size_t k = 0; k < count; ++k) take(batch_[k], verdicts_[k]);
        }
    }

  private:
    void take(const LinkSet::Pair& pair, const Verdict& v) {
        set_.rays += v.rays;
        switch (v.action) {
            case Verdict::Action::Drop: break;
            case Verdict::Action::Pending: set_.pending.push_back(pair); break;
            case Verdict::Action::Accept: set_.links.push_back(v.link); break;
            case Verdict::Action::SplitA:
                if (pair.a == pair.b) split_self(pair.a);
                else split(pair.a, pair.b);
                break;
            case Verdict::Action::SplitB: split(pair.b, pair.a); break;
        }
    }

    void split(std::uint32_t divided, std::uint32_t other) {
        if (nodes_[divided].kind == NodeKind::Surface) {
            const std::size_t before = nodes_.size();
            nodes_.subdivide(divided);
            for (std::size_t n = before; n < nodes_.size(); ++n) {
                guide_.radiosity.push_back(guide_.radiosity[divided]);
                guide_.reflectance.push_back(guide_.reflectance[divided]);
            }
        }
        nodes_.children(divided, children_);
        for (const std::uint32_t child : children_) stack_.push_back({child, other});
    }

    void split_self(std::uint32_t node) {
        nodes_.children(node, children_);
        for (std::size_t i = 0; i < children_.size(); ++i)
            for (std::size_t j = i; j < children_.size(); ++j)
                if (i != j || nodes_[children_[i]].kind != NodeKind::Surface)
                    stack_.push_back({children_[i], children_[j]});
    }

    LinkSet& set_;
    Nodes& nodes_;
    Guide& guide_;
    const LinkBuilder& builder_;
    std::vector<LinkSet::Pair> stack_, batch_;
    std::vector<Verdict> verdicts_;
    std::vector<std::uint32_t> children_;
};

}  // namespace

LinkSet::LinkSet(const Nodes& nodes, bool within_instances) {
    const auto count = static_cast<std::uint32_t>(nodes.scene().instances.size());
    for (std::uint32_t i = 0; i < count; ++i)
        for (std::uint32_t j = within_instances ? i : i + 1; j < count; ++j) pending.push_back({nodes.root(i), nodes.root(j)});
}

void refine(LinkSet& set, Nodes& nodes, Guide& guide, const LinkBuilder& builder) {
    Refiner(set, nodes, guide, builder).run();
}

double estimated_error(const LinkSet& set, const Nodes& nodes, const Guide& guide) {
    // Variance of E that links bring to each node, then down to the leaves (children follow their parents).
    std::vector<double> variance(nodes.size(), 0);
    const auto add = [&](std::uint32_t to, std::uint32_t from, double error) {
        if (!(nodes[to].area > 0)) return;
        const double e = double(guide.radiosity[from]) * error / nodes[to].area;
        variance[to] += e * e;
    };
    for (const Link& l : set.links) {
        add(l.a, l.b, double(l.error_a));
        add(l.b, l.a, double(l.error_b));
    }
    double sum = 0, area = 0;
    for (std::uint32_t n = 0; n < nodes.size(); ++n) {
        const Node& node = nodes[n];
        if (node.parent != kNoNode) variance[n] += variance[node.parent];
        if (node.kind != NodeKind::Surface || node.child_count > 0) continue;
        const double rho = double(guide.reflectance[n]);
        sum += node.area * rho * rho * variance[n];
        area += node.area;
    }
    return area > 0 ? std::sqrt(sum / area) : 0;
}

}  // namespace rro
