// What a solve will cost, told from counts of the scene alone, and what it did cost, per effect.
#pragma once

#include "solver/effects/effect.h"

namespace rro {

/// Fills `predicted` of the plan's effects that are on, for the reusable method: links between objects and the sweeps over
/// them (interreflection, or emitters where nothing is reflected), rays (occlusion), links inside objects (self), the
/// channels beyond the first (colour). What the reusable method has no pass for stays without a prediction.
///
/// The model is a fit to solves of the samples and of halls (tests/bench/README.md); its constants stand in cost.cpp.
/// seconds  wall seconds on so many threads of the machine of the fit
/// returns  the sum over effects
Work predict_work(const Scene& scene, double accuracy, unsigned threads, Plan& plan);

/// Fills `seconds` of the effects after a solve by the reusable method: what was spent on the plan's links is divided by
/// their number, sweeps belong to interreflection (or emitters), visibility to occlusion, rays to sky, sun and lamps to
/// those that are on, in equal parts.
void account_seconds(Solution& solution);

}  // namespace rro
