// --method hierarchical: hierarchical radiosity between triangles, as the paper's opponent in its Table 2. It knows nothing
// of archives but their triangles.
//
// source  P. Hanrahan, D. Salzman, L. Aupperle, "A Rapid Hierarchical Radiosity Algorithm", SIGGRAPH 1991.
#pragma once

#include "format/result.h"
#include "solver/progress.h"
#include "solver/scene/scene.h"
#include "solver/solution.h"

namespace rro {

/// What the hierarchical method is asked for.
struct HierarchicalOptions {
    double accuracy = 0.02;                          // error aimed at; decides how much power a link may carry
    bool colour = true;                              // three channels, else one
    std::uint64_t memory = std::uint64_t{8} << 30;   // bytes for links and elements
};

/// BF refinement of element quadtrees over all faces, links between all pairs of faces that face each other (made once they
/// carry light), push, pull and gather until light settles, in rounds: each round refines by the light of the one before.
/// Form factors from points of the smaller end to the larger one; visibility by a fixed number of rays per pair.
///
/// returns  the mean radiosity of every face and element; links are pairs, and count as near ones. estimated_error takes
///          the errors of links for independent and each for the same share of what it carries. `converged` where
///          refinement and iteration ended. Light that black backs take counts as escaped
/// errors   Failed: more memory than allowed, with an estimate
Result<Solution> solve_hierarchical(const Scene& scene, const HierarchicalOptions& options, const Progress& progress = {});

}  // namespace rro
