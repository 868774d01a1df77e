// Transport inside one object: which of its clusters exchange light, how much, and what the object itself hides of it.
#pragma once

#include <cstdint>
#include <vector>

#include "format/object_data.h"
#include "format/rays/object_rays.h"

namespace rro {

/// The pair tree as the archive stores it (format/self_links.h).
struct SelfLinks {
    std::vector<std::uint8_t> steps;
    std::vector<float> exchange;           // [L] m^2
    std::vector<std::uint8_t> visibility;  // [L] / 255
};

/// Links of the object with itself; none for convex objects. Pairs split, the wider cluster first, until the error that
/// one constant per cluster brings to a mean patch is below a fixed share of its own radiosity, or both are patches.
/// Deterministic for any number of threads.
///
/// object   with patches and clusters; directions and tables are not used
/// source   hierarchical radiosity [Hanrahan, Salzman, Aupperle 1991], radiosity taken as 1 everywhere
SelfLinks measure_self_links(const ObjectData& object, const ObjectRays& rays);

/// Where the light of each patch goes, as shares of it. [P]
struct Closure {
    std::vector<float> escape;    // leaves the object, by the visibility table
    std::vector<float> received;  // meets faces of the object, by the self links
    std::vector<float> black;     // meets black backs, by rays
};

/// The three shares from three independent sources, so that their sum tells how far tables and links are off.
///
/// object   with visibility table and self links
Closure measure_light_shares(const ObjectData& object, const ObjectRays& rays);

}  // namespace rro
