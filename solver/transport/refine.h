// Which pairs become links: from the roots of all instances down, until every link's error fits its share.
#pragma once

#include <vector>

#include "solver/transport/link.h"

namespace rro {

/// The links of a scene and the pairs that may become links once they carry light.
struct LinkSet {
    std::vector<Link> links;
    std::vector<Pair> pending;
    std::uint64_t rays = 0;  // so far
    bool within_instances;   // does light go from an instance to itself?

    /// All pairs of instances and, where asked, every instance with itself; in groups where there are any.
    LinkSet(const Nodes& nodes, bool within_instances);
};

/// Judges pending pairs and links whose error has outgrown their share; splits until all fit. Subdivides faces and
/// extends the guide to new elements. Pairs are judged in parallel and taken in order, so the outcome does not depend
/// on the number of threads.
void refine(LinkSet& set, Nodes& nodes, Guide& guide, const LinkBuilder& builder);

/// Area-weighted root mean square of the error of R over leaf surfaces that the links' own errors add up to, W/m^2.
/// Errors of different links are taken as independent.
double estimated_error(const LinkSet& set, const Nodes& nodes, const Guide& guide);

}  // namespace rro
