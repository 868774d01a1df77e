// Links of the paper's own transport: which pairs of nodes exchange light directly, and how much, where clusters radiate
// and receive isotropically. The hierarchy below the far rule follows Hanrahan et al. 1991 [HANR 91]: BF refinement.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "solver/transport/direction_bins.h"
#include "solver/transport/nodes.h"
#include "solver/transport/transport.h"
#include "solver/visibility/scene_rays.h"

namespace rro {

/// Far: by the five-times rule, disk to disk. Near: two faces, by the exact kernel. Coarse: disk to disk although it is
/// not far, because its power is below the threshold.
enum class PlainKind : std::uint8_t { Far, Near, Coarse };

/// One link serves both directions: b receives exchange * B_a / A_b, a receives exchange * B_b / A_a.
struct PlainLink {
    std::uint32_t a = 0, b = 0;
    float exchange = 0;  // A F V, m^2; 0 only of a coarse link, whose parts may carry light yet
    PlainKind kind = PlainKind::Far;
};

using PlainPair = std::array<std::uint32_t, 2>;  // the same node twice: within it

/// Decides about pairs. Safe to use from many threads.
class PlainLinker {
  public:
    PlainLinker(const Nodes& nodes, const EndAreas& areas, const SceneRays& rays, const TransportOptions& options,
                bool within_instances);

    struct Verdict {
        enum class Action : std::uint8_t { Drop, Wait, Accept, SplitA, SplitB };
        Action action = Action::Drop;
        PlainLink link;
        std::uint32_t rays = 0;
    };

    /// light: [nodes] mean radiosity, W/m^2; threshold: power below which a link is not refined, W
    Verdict judge(const PlainPair& pair, const std::vector<float>& light, double threshold) const;

    /// The most power that could go between two nodes, W.
    double most_power(std::uint32_t a, std::uint32_t b, const std::vector<float>& light) const;

    const Nodes& nodes() const { return nodes_; }

  private:
    struct End {
        double area = 0;          // effective, m^2
        bool own_counted = false;  // nothing of its own object is left to be tested by rays
    };
    struct Visibility {
        double mean = 1;
        std::uint32_t rays = 0;
    };
    End effective(const Node& n, const Node& other, const Vec3& w) const;
    bool hides_nothing_of_itself(const Node& n) const;
    Visibility visibility(std::uint32_t a, std::uint32_t b, bool own_counted_a, bool own_counted_b) const;
    Verdict by_disks(std::uint32_t a, std::uint32_t b, PlainKind kind) const;
    Verdict by_kernel(std::uint32_t a, std::uint32_t b) const;

    const Nodes& nodes_;
    const EndAreas& areas_;
    const SceneRays& rays_;
    const TransportOptions& options_;
    bool within_instances_;
};

/// The links of a scene, and the pairs that may become links.
struct PlainLinks {
    std::vector<PlainLink> links;
    std::vector<PlainPair> waiting;  // no light yet, or too little within a node
    std::uint64_t rays = 0;          // so far

    /// Every instance with every other and itself.
    explicit PlainLinks(const Nodes& nodes);
};

/// Judges what waits and what is coarse with too much power by now; splits until all obey the rule or the threshold. Pairs
/// are judged in parallel and taken in order, so the outcome does not depend on the number of threads.
///
/// returns  whether links changed
bool refine(PlainLinks& set, const PlainLinker& linker, const std::vector<float>& light, double threshold);

}  // namespace rro
