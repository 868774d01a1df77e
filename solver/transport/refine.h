// Which pairs become links: from the roots of all instances down, until every link's error fits its share.
#pragma once

#include <span>
#include <vector>

#include "solver/transport/link.h"

namespace rro {

/// The links of a scene and the pairs that may become links once they carry light.
struct LinkSet {
    std::vector<Link> links;
    std::vector<Pair> pending;
    std::uint64_t rays = 0;  // so far
    double visibility_seconds = 0;  // so far, of wall time
    bool within_instances;   // does light go from an instance to itself?

    /// All pairs of instances and, where asked, every instance with itself; in groups where there are any.
    LinkSet(const Nodes& nodes, bool within_instances);
};

/// Judges pending pairs and links whose error has outgrown their share; splits until all fit. Subdivides faces and
/// extends the guide to new elements. Pairs are judged in parallel and taken in order, so the outcome does not depend
/// on the number of threads.
void refine(LinkSet& set, Nodes& nodes, Guide& guide, const LinkBuilder& builder);

/// Relative errors of R (contract: accuracy): of the scene, and of each instance by itself.
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

}  // namespace rro
