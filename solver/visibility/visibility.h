// How much of what two ends send one another gets past everything else: one question, several methods.
//
//   rays     exact lines between points of both ends (scene_rays.h), as many as a stop rule asks (sampling.h)
//   tables   the same lines, but an object's stored hit probabilities answer where that errs little (tables.h; paper 3, 5)
//   atlas    no lines: the objects' stored silhouettes under the shaft's cross-section, where it is wide enough (atlas.h);
//            rays elsewhere
//   none     nothing is in the way
//   auto     silhouettes where they are cheaper than rays and sure enough, else rays. (Links take `auto` for rays: link.h)
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "solver/scene/scene.h"
#include "solver/visibility/atlas.h"
#include "solver/visibility/sampling.h"
#include "solver/visibility/scene_rays.h"
#include "solver/visibility/shaft.h"
#include "solver/visibility/tables.h"

namespace rro {

/// As above: --visibility.
enum class VisibilityMethod { Auto, Atlas, Tables, Rays, None };

/// Sections of an archive that a method cannot do without.
SectionSet sections_of(VisibilityMethod method);

/// Answers by one method. Keeps references to the scene and its rays; safe to share between threads.
class Visibility {
  public:
    /// The archives must have the sections of the method (asserted).
    Visibility(const Scene& scene, const SceneRays& rays, VisibilityMethod method, const TableOptions& tables = {});

    /// The mean transmittance of a shaft through third objects, weighted by its segments. The same for any number of
    /// threads: rays are chosen by the shaft's seed alone.
    Transmittance transmittance(const Shaft& shaft, const Demand& demand) const;

    /// The same for shafts that lie side by side, such as those of one light to the patches of a floor. Where all rays of
    /// a shaft agree but a neighbour's do not, more are asked (best with StopRule::Paper, which is content
    /// with rays that agree).
    std::vector<Transmittance> transmittances(std::span<const Shaft> shafts, Neighbours neighbours, const Demand& demand) const;

    /// Does the answer depend on ShaftEnd::spread? It may be left 0 otherwise.
    bool looks_at_spread() const { return !silhouettes_.empty() || !tables_.empty(); }

  private:
    /// Who answers for the lines of one shaft.
    struct Lines {
        bool listed = false;
        Candidates candidates;
        std::vector<double> missing;  // [candidates] what tables may miss of each, m^2 in its frame
    };
    /// True where the answer is known without rays; else makes `lines` ready.
    bool settle(const Shaft& shaft, const Demand& demand, Lines& lines, Transmittance& out) const;
    void sort_along(const Shaft& shaft, Candidates& candidates) const;
    bool by_atlas(const Shaft& shaft, const Candidates& candidates, const Demand& demand, Transmittance& out) const;
    void prepare_tables(const Shaft& shaft, Lines& lines) const;
    double passes(const Lines& lines, const Segment& s) const;
    double passes_tables(const Lines& lines, const Segment& s) const;

    const Scene& scene_;
    const SceneRays& rays_;
    VisibilityMethod method_;
    TableOptions table_options_;
    std::vector<std::unique_ptr<SilhouetteSums>> silhouettes_;  // [objects], where the method uses them
    std::vector<std::unique_ptr<HitTables>> tables_;            // [objects], likewise
    std::vector<std::size_t> object_of_;                        // [instances]
};

}  // namespace rro
