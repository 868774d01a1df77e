// Sweeps until the light stands still, and what the rounds of a solve look at in between.
#pragma once

#include <vector>

#include "solver/solution.h"
#include "solver/transport/gather.h"
#include "solver/transport/outside_light.h"
#include "solver/transport/refine.h"

namespace rro {

/// How far sweeps have come.
struct Residual {
    int sweeps = 0;
    double relative = 0;  // ||r|| / ((1 - q) ||R||), q the ratio of the last two sweeps' ||r||
};

inline constexpr int kMostSweeps = 1000;  // where nothing else limits them

/// Sweeps until the remaining error is below `goal` of R.
template <int C>
Residual iterate(LightField<C>& field, double goal, double largest_reflectance, int most);

/// Sum of A R^2 (channels' mean) of the light from outside that leaves reflect, W^2/m^2.
double reflected_once(const Nodes& nodes, const std::vector<Rgb>& irradiance);

/// What later bounces make of an error in the light of one. Where errors agree in sign they grow like the light itself; where
/// light is reflected many times they come from all over the scene, agree no longer, and grow by the root. (In a room that
/// reflects nine tenths, light grows tenfold and estimates that grew with it told three to seven times the error.)
template <int C>
double amplification(const Nodes& nodes, const LightField<C>& field, const OutsideLight& outside);

/// What all surfaces of a scene emit and reflect, before any light is known.
struct Sources {
    double largest_reflectance = 0;  // and transmittance
    double emitted = 0;              // W, channels' mean
    double area = 0;                 // m^2
};
template <int C>
Sources sources_of(const Nodes& nodes, const LightField<C>& field);

/// What rounds of refinement tell about the estimate: the light changes by about what it was wrong by before.
class HindSight {
  public:
    /// Raises the estimate of every instance whose last one was too low, by as much.
    template <int C>
    void correct(ErrorEstimate& estimate, const Nodes& nodes, const LightField<C>& field);

  private:
    std::vector<float> reflected_;  // [faces * C] of all instances, as the last round left it
    std::vector<double> estimate_;  // [instances] of the last round, as the links gave it
};

/// Radiosity, irradiance and energy of the light as it is.
template <int C>
void store_light(const Nodes& nodes, const LightField<C>& field, const std::vector<Rgb>& outside, Solution& solution);

}  // namespace rro
