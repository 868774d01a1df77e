// Which pairs become links: from the roots of all instances down, until every link's error fits its share.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "solver/transport/pair_tree.h"

namespace rro {

/// The links of a scene and the pairs that may become links once they carry light.
struct LinkSet {
    std::vector<Link> links;
    std::vector<Pair> pending;
    std::uint64_t rays = 0;  // so far
    double visibility_seconds = 0;  // so far, of wall time
    bool within_instances;   // does light go from an instance to itself?
    std::unique_ptr<PairTree> tree;  // of sets that follow edits; else none
    std::uint8_t round = 0;          // of refinement, for the tree
    LinkChange change;               // so far
    std::vector<std::uint32_t> ends;  // nodes whose links have changed, where there is a tree; for whoever clears it

    /// Starts from all pairs of instances.
    /// with_tree  remember how the links come about?
    LinkSet(const Nodes& nodes, bool within_instances, bool with_tree = false);

    /// Takes a link out; the last one gets its number. Sets with a tree only.
    void remove(std::uint32_t link);
    void add(const Link& link, std::uint32_t record);
    /// The same ends exchange light otherwise.
    void replace(std::uint32_t number, const Link& link);
    /// The links of these ends are no longer what they were.
    void note(const Link& link) { ends.insert(ends.end(), {link.a, link.b}); }
};

/// All pairs of instances and, where asked, every instance with itself; in groups where there are any.
std::vector<Pair> first_pairs(const Nodes& nodes, bool within_instances);

/// Has the error of a link outgrown what it was accepted with?
bool outgrown(const Link& link, const Nodes& nodes, const Guide& guide);

/// The pairs that a division makes, in the order in which the archive stores them. Subdivides faces.
void divide(const Pair& pair, Verdict::Action action, bool within_instances, Nodes& nodes, std::vector<Pair>& out);

/// New elements start with what is known of their faces.
void grow(Guide& guide, const Nodes& nodes);

/// Judges pending pairs and links whose error has outgrown their share; splits until all fit. Subdivides faces and
/// extends the guide to new elements. Pairs are judged in parallel and taken in order, so the outcome does not depend
/// on the number of threads.
void refine(LinkSet& set, Nodes& nodes, Guide& guide, const LinkBuilder& builder);

/// Relative errors of R, as solver/accuracy.md counts them: of the scene, and of each instance by itself.
struct ErrorEstimate {
    double whole = 0;
    std::vector<double> of_instance;
    std::vector<double> weight;       // [instances] share of the scene's sum of A R^2
    std::vector<double> power_share;  // [instances] of all reflected power
};

/// The errors that the links' own errors add up to; also leaves their sums per node in the guide. They agree in sign by
/// kAgreement, and that part grows over bounces by `growth`, as the light itself.
///
/// outside  [nodes] standard deviation of the light from sky, sun and lamps, W/m^2; empty where there is none
ErrorEstimate estimate_error(const LinkSet& set, const Nodes& nodes, double growth, std::span<const float> outside,
                             Guide& guide);

/// The instance with the largest error of those that count by themselves (solver/accuracy.md); -1 where none does.
std::int64_t worst_instance(const ErrorEstimate& estimate);

/// Lowers the guide's shares of links where errors are larger than allowed, relative. Returns whether they are small enough
/// everywhere.
bool lower_shares(const ErrorEstimate& estimate, double allowed, Guide& guide);

}  // namespace rro
