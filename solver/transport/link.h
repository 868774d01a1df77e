// Links: which pairs of nodes exchange light directly, how much, and how wrong that is.
#pragma once

#include <cstdint>
#include <vector>

#include "solver/transport/direction_bins.h"
#include "solver/transport/nodes.h"
#include "solver/transport/transport.h"
#include "solver/visibility/visibility.h"

namespace rro {

/// In place of a stored pair's number: none.
inline constexpr std::uint32_t kNotStored = 0xffffffffu;

/// Two nodes that may exchange light; a == b: within one node.
struct Pair {
    std::uint32_t a, b;
    std::uint32_t stored = kNotStored;  // the smallest of the archive's pairs that holds it; pairs of one object only
    std::uint32_t record = kNoNode;     // its number in a PairTree, where there is one
};

/// One link serves both directions. With w the direction between the centres and d their distance, base = transmittance /
/// d^2 times the visible projected area of every end that has no bins of directions (bins hold their own). Between two
/// ends without bins that is pi A F V, and where the exchange area A F V is known better, it is taken from there.
struct Link {
    std::uint32_t a = 0, b = 0;
    float base_a = 0, base_b = 0;    // for light that a receives, that b receives; equal but for near pairs
    float error_a = 0, error_b = 0;  // what the exchange area may be wrong by as it matters to a, to b; m^2
    float noise = 0;                 // standard deviation that a limited number of rays leaves in it, m^2
    EndMode mode_a = EndMode::Inside, mode_b = EndMode::Inside;
    std::uint32_t stored = kNotStored;  // as in Pair

    bool mean() const { return mode_a == EndMode::Mean && mode_b == EndMode::Mean; }
};

/// What refinement knows of the light so far: one number per node, the root mean square over channels.
struct Guide {
    std::vector<float> radiosity;    // [nodes] W/m^2
    std::vector<float> variation;    // [nodes] standard deviation of radiosity within the node, over its mean
    std::vector<float> irradiance;   // [nodes] W/m^2, area-weighted mean
    std::vector<float> reflectance;  // [nodes] area-weighted mean
    double reflected = 0;            // sum of A R^2 over the scene, W^2/m^2
    double area = 0;                 // of the scene, m^2
    std::vector<float> error;        // [nodes] W/m^2, sum of the links' errors of irradiance, agreeing or not
    std::vector<double> share;       // [instances] of `reflected` that one link may add to the squared error
    double scene_share = 0;          // the same for groups of instances

    /// What one link may add to the squared error at a node.
    double limit(const Nodes& nodes, std::uint32_t to) const;
};

/// What an error of `exchange` m^2 in the light that `to` receives from `from` adds to the squared error of the scene,
/// in links' shares: a link is good enough where this is at most 1.
///
/// An error e in a node's irradiance adds A rho^2 e^2 by itself. Besides, errors of links at one node agree in sign to
/// some degree (neighbours err alike, and lie in the same shadow), so it adds A rho^2 e times part of all the others'.
double harm(const Guide& guide, const Nodes& nodes, std::uint32_t to, std::uint32_t from, double exchange);

/// The same for an error of irradiance in W/m^2 over a part of `to` of this area.
double harm_to_part(const Guide& guide, const Nodes& nodes, std::uint32_t to, double area, double error);

/// The same for what a limited number of rays leaves undecided: errors of different links are independent, so each adds
/// up by its square alone.
double noise_harm(const Guide& guide, const Nodes& nodes, std::uint32_t to, std::uint32_t from, double noise);

/// What rays may leave undecided, as a part of a link's harm.
inline constexpr double kNoiseShare = 0.5;

/// How much of a shadow's edge within one face counts: it does not move the face's mean.
inline constexpr double kShadowWithinFace = 0.12;

/// How far errors of links at one node agree in sign.
inline constexpr double kAgreement = 0.25;

/// What becomes of a pair: nothing passes, a link, a division of an end, or to be asked again when there is light.
struct Verdict {
    enum class Action : std::uint8_t { Drop, Accept, SplitA, SplitB, Pending };
    Action action = Action::Drop;
    bool looked = false;  // decided by what lies between the two
    Link link;
    std::uint32_t rays = 0;
    std::uint64_t ticks = 0, visibility_ticks = 0;  // of all judging, of visibility alone
};

/// `auto` for links: rays. The ends of links are divided until they lie close to what casts shadows on them, so that
/// silhouettes answer for fewer than one in a hundred of the links that need rays (tests/bench/README.md).
VisibilityMethod link_method(VisibilityMethod asked);

/// Decides about pairs. Holds no state of its own beyond references; safe to use from many threads.
class LinkBuilder {
  public:
    LinkBuilder(const Nodes& nodes, const EndAreas& areas, const SceneRays& rays, const TransportOptions& options);

    /// Judges a pair under the present guide.
    Verdict judge(const Pair& pair, const Guide& guide) const;

    /// Does the instance, here or where it stood before, certainly let all light of a pair pass? (It is none of its ends.)
    bool clears(std::uint32_t a, std::uint32_t b, const Instance& instance) const;

    /// Can a node be divided further?
    bool divisible(const Node& node) const;

    /// Names a node for its random numbers, wherever its instance stands in the manifest.
    std::uint64_t sample_key(std::uint32_t node) const;

  private:
    Verdict judge_by_geometry(std::uint32_t a, std::uint32_t b, const Guide& guide, double own) const;
    /// A pair that is one of the archive's, so that its exchange area is known.
    Verdict judge_stored(const Pair& pair, const SelfPair& stored, const Guide& guide) const;
    bool is_whole(const SelfPair& stored, const Pair& pair) const;
    Verdict::Action stored_split(const SelfPair& stored, const Pair& pair) const;
    /// Could light go within a node by more than its tolerance? If so its children must be paired.
    bool splits_self(std::uint32_t node, const Guide& guide) const;
    // own: what the ends' common object leaves, where that is known; else negative, and rays test it.
    Verdict judge_near(std::uint32_t a, std::uint32_t b, const Guide& guide, double own) const;
    Verdict judge_far(std::uint32_t a, std::uint32_t b, const Guide& guide, double own) const;
    /// The most harm that light from `from` may do to a part of `to` over this gap.
    double most_harm(std::uint32_t to, std::uint32_t from, double gap, const Guide& guide) const;
    Verdict split(std::uint32_t a, std::uint32_t b, bool prefer_a) const;
    bool may_see(const Node& from, const Node& to) const;
    /// Does the object hide nothing of itself, so that its visibility is 1 wherever it faces?
    bool exact_tables(const Node& n) const;
    /// Exchange area of two ends that are no Bins nodes, nothing between, by several points of each; and how much
    /// that differs from the one by their centres alone.
    /// received_a, received_b: how far, relative to the mean, a flat end's irradiance at its points lies from what it
    /// makes of the link's light (flat_light.h); root mean square.
    struct Quadrature {
        double exchange = 0, difference = 0;  // m^2
        double received_a = 0, received_b = 0;
    };
    Quadrature by_points(std::uint32_t a, std::uint32_t b) const;

    /// A surface's share in the error that a shadow edge across it makes.
    double shadow_share(const Node& n) const;

    struct Projection {
        double area = 0;   // m^2
        double error = 0;  // relative
    };
    static Projection projection(const Node& n, const Vec3& w, double spread);

    /// An end as a far link takes it. Errors are relative to the link's light.
    struct End {
        EndMode mode = EndMode::Inside;
        double projection = 0;  // m^2
        double horizon = 0, received = 0, sent = 0;
    };
    End end_of(std::uint32_t id, std::uint32_t other, double r, const Projection& projection, double exchange,
               const Guide& guide) const;

    /// A link whose light is known but for what lies between.
    struct Offer {
        std::uint32_t a, b;
        EndMode mode_a = EndMode::Inside, mode_b = EndMode::Inside;
        double own = -1;              // as below
        double exchange = 0;          // m^2
        double base_a = 0, base_b = 0, error_a = 0, error_b = 0;  // as in Link
        bool negligible = false;      // not worth a division
    };
    double harm_of(const Guide& guide, const Offer& o, double error_a, double error_b) const;
    /// What it may be wrong by that a node sends one radiosity, relative; r its radius over the distance.
    double sent_as_one(std::uint32_t id, double r, const Guide& guide) const;
    /// Takes what the ends' objects hide of themselves from a far link, and settles it.
    Verdict settle_far(Offer o, const End& end_a, const End& end_b, const Vec3& w, double d, const Guide& guide) const;
    /// Asks for the visibility and makes it a link, or divides where a shadow's edge crosses it.
    Verdict settle(const Offer& o, const Guide& guide) const;

    /// What gets past everything else, by the method asked for: as sure as `noise` times its variance at most 1, and, where
    /// all rays agree, edge * spread as well.
    Transmittance transmittance(const Offer& o, double noise, double edge) const;
    ShaftEnd shaft_end(std::uint32_t node) const;

    const Nodes& nodes_;
    const EndAreas& areas_;
    const TransportOptions& options_;
    const Visibility visibility_;
    std::vector<std::uint64_t> instance_key_;  // from the name
    std::vector<std::uint64_t> group_key_;     // from its members' names
    std::vector<double> group_table_error_;    // relative, of the projected area
    double medium_ = 0, medium_most_ = 0;      // least and largest absorption of the channels, 1/m
};

}  // namespace rro
