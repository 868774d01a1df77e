// Light groups that are dimmed as a whole, over links that stay: the scene's light is a sum, with no more sweeps.
#pragma once

#include <map>
#include <memory>
#include <vector>

#include "solver/transport/group_light.h"
#include "solver/transport/iterate.h"
#include "solver/transport/stage.h"

namespace rro {

/// A solve that has ended, as far as light of single groups follows from it.
template <int C>
struct Settled {
    Stage<C>& stage;
    const LinkSet& set;
    const Guide& guide;
    const Sources& sources;
    double accuracy;
    bool closed;         // light leaves nowhere
    Residual& residual;  // of the light as it is
};

/// What is known of groups' light over the links of one solve.
template <int C>
class Dimming {
  public:
    /// The links, or what surfaces make of light, are others now.
    void forget();

    /// Adds or takes away light of groups that are dimmed as a whole; false, and nothing done, where more than that differs.
    /// before  the scene whose light the field holds; the stage's has the new materials
    bool dim(const Settled<C>& solve, const std::shared_ptr<const Scene>& before, const std::vector<std::uint32_t>& groups);

    /// After dim(): the solution that it led to, from which again() goes on where it was one group.
    /// error_square, light_square  estimated and of the light itself, sums of A R^2, W^2/m^2
    void remember(const Scene& scene, const std::vector<std::uint32_t>& groups, const Solution& solution, double error_square,
                  double light_square);

    /// The same group dimmed once more: the sum of solutions alone, while the light field stays. False, and nothing done,
    /// where it is another group, or where the error is not known or larger than `allowed` of R.
    /// area  of the scene, m^2
    bool again(const Scene& scene, const std::vector<std::uint32_t>& groups, double area, double allowed, double accuracy,
               Solution& solution);

    /// Gives the light field what sums have been told since. scene: as they have it
    void catch_up(Stage<C>& stage, const Scene& scene);

  private:
    /// One group, dimmed more than once while all else stays.
    struct Dimmer {
        std::uint32_t group = LightField<C>::kAllGroups;
        SquareByLevel error, light;  // of all light together, sum of A R^2, W^2/m^2
        double level = 0;            // of `base` and of the light field
        double now = 0;              // of the solution last given
        Solution base;
    };

    std::map<std::uint32_t, GroupLight> groups_;  // by number
    Dimmer dimmer_;
};

}  // namespace rro
