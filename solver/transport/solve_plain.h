// --transport plain: the transport as the paper describes it, to compare ours with. Clusters radiate and receive alike in
// all directions; only their size depends on where they are seen from.
#pragma once

#include "solver/transport/transport.h"

namespace rro {

/// Rounds of refining links under the light known so far and iterating that light, as in solve_reusable, with the links
/// of plain_links.h. Faces are not divided into elements.
///
/// returns  radiosity and irradiance per face. `estimated_error` is what this transport can know: the share of all
///          received power that coarse links carry, and the residual of the iteration; it knows nothing of what
///          isotropy, tables and a fixed number of rays are wrong by, which is more. Links: far are disk to disk, near
///          are pairs of faces, self are both within one instance
/// errors   none
/// source   paper sections 2 and 3 (16 rays); [HANR 91] for the refinement below the five-times rule
/// departs  its equation 2 lacks 1 / pi; objects are not gathered into larger clusters
Result<Solution> solve_plain(const Scene& scene, const Plan& plan, const TransportOptions& options,
                             const Progress& progress = {});

}  // namespace rro
