// The effect plan with what it will cost, for people and for programs.
#pragma once

#include <string>

#include "solver/effects/effect.h"
#include "solver/scene/scene.h"

namespace rro {

/// What is told besides the plan.
struct Outlook {
    double accuracy = 0;
    Work work;                  // predicted, of all effects
    std::uint64_t memory = 0;   // bytes, of the open scene and its solve
};

/// Predicts the plan's work for an accuracy (beats the manifest's, which beats 0.02) on this machine's threads.
Outlook outlook(const Scene& scene, std::optional<double> accuracy, Plan& plan);

/// A table: effect, on or off, predicted links, rays, memory and seconds, reason.
std::string explain_text(const Scene& scene, const Plan& plan, const Outlook& outlook);

/// The same as one JSON object.
std::string explain_json(const Scene& scene, const Plan& plan, const Outlook& outlook);

/// "39 MiB".
std::string size_text(std::uint64_t bytes);

}  // namespace rro
