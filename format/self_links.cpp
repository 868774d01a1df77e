#include "format/self_links.h"

#include <array>

namespace rro {
namespace {

struct Pair {
    std::uint32_t a, b;
};

/// The pairs that a step makes of a pair.
struct Children {
    std::array<Pair, 3> pairs{};
    std::size_t count = 0;
};

Children children_of(const std::span<const Cluster>& clusters, const Pair& p, PairStep step) {
    const auto left = [](std::uint32_t c) { return c + 1; };
    const auto right = [&](std::uint32_t c) { return clusters[c].right_child; };
    switch (step) {
        case PairStep::SplitFirst: return {{Pair{left(p.a), p.b}, Pair{right(p.a), p.b}}, 2};
        case PairStep::SplitSecond: return {{Pair{p.a, left(p.b)}, Pair{p.a, right(p.b)}}, 2};
        case PairStep::SplitSelf:
            return {{Pair{left(p.a), left(p.a)}, Pair{left(p.a), right(p.a)}, Pair{right(p.a), right(p.a)}}, 3};
        case PairStep::Dark:
        case PairStep::Link: break;
    }
    return {};
}

bool may_step(const std::span<const Cluster>& clusters, const Pair& p, PairStep step) {
    // Clusters may still be unverified here.
    const auto divisible = [&](std::uint32_t c) {
        return clusters[c].right_child > c + 1 && clusters[c].right_child < clusters.size();
    };
    switch (step) {
        case PairStep::Dark:
        case PairStep::Link: return true;
        case PairStep::SplitFirst: return p.a != p.b && divisible(p.a);
        case PairStep::SplitSecond: return p.a != p.b && divisible(p.b);
        case PairStep::SplitSelf: return p.a == p.b && divisible(p.a);
    }
    return false;
}

/// Pairs whose step is still to come, the next one last.
void push_children(const Children& children, std::vector<Pair>& open) {
    for (std::size_t k = children.count; k-- > 0;) open.push_back(children.pairs[k]);
}

}  // namespace

std::vector<SelfPair> self_pairs(const ObjectData& object) {
    std::vector<SelfPair> pairs;
    if (object.self_steps.empty()) return pairs;
    pairs.reserve(object.self_steps.size());
    std::vector<Pair> open{{0, 0}};
    std::size_t link = 0;
    for (const std::uint8_t byte : object.self_steps) {
        const Pair p = open.back();
        open.pop_back();
        SelfPair& pair = pairs.emplace_back();
        pair.a = p.a, pair.b = p.b;
        pair.step = static_cast<PairStep>(byte);
        pair.end = static_cast<std::uint32_t>(pairs.size());
        if (pair.step == PairStep::Link) {
            pair.unoccluded = object.self_exchange[link];
            pair.seen = pair.unoccluded * (static_cast<float>(object.self_visibility[link]) / 255.0f);
            ++link;
        }
        push_children(children_of(object.clusters, p, pair.step), open);
    }
    for (std::uint32_t i = static_cast<std::uint32_t>(pairs.size()); i-- > 0;) {
        SelfPair& pair = pairs[i];
        if (pair.step == PairStep::Dark || pair.step == PairStep::Link) continue;
        const auto count = pair.step == PairStep::SplitSelf ? 3 : 2;
        std::uint32_t child = i + 1;
        double unoccluded = 0, seen = 0;
        for (int k = 0; k < count; ++k, child = pairs[child].end) {
            // Between two halves of one cluster light goes both ways.
            const double ways = pair.a == pair.b && pairs[child].a != pairs[child].b ? 2 : 1;
            unoccluded += ways * static_cast<double>(pairs[child].unoccluded);
            seen += ways * static_cast<double>(pairs[child].seen);
        }
        pair.end = child;
        pair.unoccluded = static_cast<float>(unoccluded);
        pair.seen = static_cast<float>(seen);
    }
    return pairs;
}

std::optional<SelfPairFault> check_self_pairs(const ObjectData& object) {
    const std::size_t steps = object.self_steps.size();
    if (steps == 0 || object.clusters.empty()) {
        if (object.self_exchange.empty()) return std::nullopt;
        return SelfPairFault{0, "no step", "as many links as exchange areas"};
    }
    std::vector<Pair> open{{0, 0}};
    std::size_t links = 0;
    for (std::size_t i = 0; i < steps; ++i) {
        if (open.empty()) return SelfPairFault{i, "a step", "the end: all pairs have theirs"};
        const Pair p = open.back();
        open.pop_back();
        const std::uint8_t byte = object.self_steps[i];
        if (byte >= kPairSteps || !may_step(object.clusters, p, static_cast<PairStep>(byte)))
            return SelfPairFault{i, std::to_string(byte),
                                 p.a == p.b ? "0, 1, or 4 for a cluster with children" : "0, 1, 2 or 3 for clusters with children"};
        links += static_cast<PairStep>(byte) == PairStep::Link ? 1 : 0;
        push_children(children_of(object.clusters, p, static_cast<PairStep>(byte)), open);
    }
    if (!open.empty()) return SelfPairFault{steps, "the end", "steps for " + std::to_string(open.size()) + " more pairs"};
    if (links != object.self_exchange.size())
        return SelfPairFault{steps, std::to_string(links) + " links",
                             std::to_string(object.self_exchange.size()) + ", one per exchange area"};
    return std::nullopt;
}

}  // namespace rro
