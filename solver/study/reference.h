// --method reference: an unbiased Monte Carlo solution per face, with standard errors. What all errors are measured
// against.
#pragma once

#include "format/result.h"
#include "solver/progress.h"
#include "solver/scene/scene.h"
#include "solver/solution.h"

namespace rro {

/// What the reference is asked for.
struct ReferenceOptions {
    double accuracy = 0.02;     // stop when the area-weighted relative standard error of R is below it
    std::uint32_t samples = 0;  // paths per face; 0: as many as `accuracy` needs
    std::uint64_t seed = 1;
};

/// Path tracing of irradiance from uniformly sampled points of every face: E = (pi/N) sum of L over cosine-weighted
/// directions, next-event estimation to emitters, sun, lights and skies with bright spots, Russian roulette. It knows every
/// effect: B = M + rho E + tau E of the other side; a medium leaves exp(-a d) of the light on every segment, and nothing of
/// sky and sun, which are infinitely far. Light groups are summed. Random streams are keyed by instance name, face and
/// sample, so the result does not depend on the number of threads.
///
/// returns  radiosity, irradiance and standard error per face; estimated_error is the relative standard error reached. What
///          sky, sun and lights emit is counted where it arrives at faces; what a medium takes is absorbed
/// errors   none
Result<Solution> solve_reference(const Scene& scene, const ReferenceOptions& options, const Progress& progress = {});

}  // namespace rro
