// Links: which pairs of nodes exchange light directly, how much, and how wrong that is.
#pragma once

#include <cstdint>
#include <vector>

#include "solver/transport/direction_bins.h"
#include "solver/transport/nodes.h"
#include "solver/transport/transport.h"
#include "solver/visibility/scene_rays.h"

namespace rro {

inline constexpr std::uint32_t kNotStored = 0xffffffffu;

/// Two nodes that may exchange light; a == b: within one node.
struct Pair {
    std::uint32_t a, b;
    std::uint32_t stored = kNotStored;  // the smallest of the archive's pairs that holds it; pairs of one object only
};

/// One link serves both directions. Far: with w the direction between the centres and d their distance, base =
/// transmittance / d^2 times, for every end that is no Bins node, its visible projected area. Near: pi A F V instead,
/// from the exact kernel at points of the receiver or from the archive's self links, so that what a point receives from all
/// around sums to one; all faces of either end count alike.
struct Link {
    std::uint32_t a = 0, b = 0;
    float base_a = 0, base_b = 0;    // for light that a receives, that b receives; equal for far pairs
    float error_a = 0, error_b = 0;  // standard error of the exchange area as it matters to a, to b; m^2
    EndMode mode_a = EndMode::Inside, mode_b = EndMode::Inside;
    bool near = false;
    std::uint32_t stored = kNotStored;  // as in Pair
};

/// What refinement knows of the light so far: one number per node, the root mean square over channels.
struct Guide {
    std::vector<float> radiosity;    // [nodes] W/m^2
    std::vector<float> reflectance;  // [nodes] area-weighted mean
    double typical_reflected = 0;    // root mean square of R over the scene, W/m^2
    double typical_area = 0;         // mean area of a face, m^2
    double tolerance = 0;            // error in R that a link may bring to a face of typical area, over typical_reflected
};

/// Error in reflected radiosity that one link may bring to a node, W/m^2. Large nodes count for more in the total error
/// than small ones, so they get less.
double link_tolerance(const Guide& guide, const Node& node);

/// Reflected radiosity at `to` that an exchange area in m^2 brings from `from`, W/m^2.
double reflected(const Guide& guide, const Nodes& nodes, std::uint32_t to, std::uint32_t from, double exchange);

struct Verdict {
    enum class Action : std::uint8_t { Drop, Accept, SplitA, SplitB, Pending };
    Action action = Action::Drop;
    Link link;
    std::uint32_t rays = 0;
};

/// Decides about pairs. Holds no state of its own beyond references; safe to use from many threads.
class LinkBuilder {
  public:
    LinkBuilder(const Nodes& nodes, const EndAreas& areas, const SceneRays& rays, const TransportOptions& options);

    /// Judges a pair under the present guide.
    Verdict judge(const Pair& pair, const Guide& guide) const;

    /// Can a node be divided further?
    bool divisible(const Node& node) const;

  private:
    Verdict judge_by_geometry(std::uint32_t a, std::uint32_t b, const Guide& guide, double own) const;
    /// A pair that is one of the archive's, so that its exchange area is known.
    Verdict judge_stored(const Pair& pair, const SelfPair& stored, const Guide& guide) const;
    bool is_whole(const SelfPair& stored, const Pair& pair) const;
    Verdict::Action stored_split(const SelfPair& stored, const Pair& pair) const;
    /// Could light go within a node by more than its tolerance? If so its children must be paired.
    bool splits_self(std::uint32_t node, const Guide& guide) const;
    /// Tolerances that one m^2 of exchange area uses up at `to`, for a pair of this exchange area.
    double weight(const Guide& guide, std::uint32_t to, std::uint32_t from, double exchange) const;
    // own: what the ends' common object leaves, where that is known; else negative, and rays test it.
    Verdict judge_near(std::uint32_t a, std::uint32_t b, const Guide& guide, double own) const;
    Verdict judge_far(std::uint32_t a, std::uint32_t b, const Guide& guide, double own) const;
    /// The most reflected radiosity, in tolerances, that `from` may bring to a part of `to` over this gap.
    double most_harm(std::uint32_t to, std::uint32_t from, double gap, const Guide& guide) const;
    Verdict split(std::uint32_t a, std::uint32_t b, bool prefer_a) const;
    bool may_see(const Node& from, const Node& to) const;
    /// Does the object hide nothing of itself, so that its visibility is 1 wherever it faces?
    bool exact_tables(const Node& n) const;
    /// Names a node for the random numbers of its pairs, wherever its instance stands in the manifest.
    std::uint64_t sample_key(std::uint32_t node) const;
    EndMode end_mode(const Node& end, const Node& other, double affordable_error) const;

    /// Mean transmittance between two ends and the variance of that mean. `need`: the ray count doubles until its
    /// standard deviation times `need` is below 1. `own` as above.
    struct Transmittance {
        double mean = 1, variance = 0, spread = 0;  // spread: variance of one ray
        std::uint32_t rays = 0;
    };
    Transmittance transmittance(std::uint32_t a, std::uint32_t b, EndMode mode_a, EndMode mode_b, double need,
                                double own) const;

    const Nodes& nodes_;
    const EndAreas& areas_;
    const SceneRays& rays_;
    const TransportOptions& options_;
    std::vector<std::uint64_t> instance_key_;  // from the name
    std::vector<std::uint64_t> group_key_;     // from its members' names
    std::vector<double> group_table_error_;    // relative, of the projected area
    double smallest_area_ = 0;                 // of an element, m^2
};

}  // namespace rro
