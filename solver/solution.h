// What a solver gives: radiosity per face and per element, and how the solve went.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "format/geometry.h"

namespace rro {

/// A part of a face, by quadtree subdivision. Leaves only: the elements of a face tile it.
struct Element {
    std::uint32_t face = 0;                     // of the archive
    std::array<std::array<float, 2>, 3> corner; // barycentric (of the face's corners 1 and 2, in the face's own winding
                                                // as ObjectData::corners(Face) gives them)
    Rgb radiosity, irradiance;                  // W/m^2, means over the element
};

/// The light of one instance of F faces.
struct InstanceSolution {
    std::vector<Rgb> radiosity;        // [F] W/m^2, mean over the face
    std::vector<Rgb> irradiance;       // [F] W/m^2
    std::vector<Rgb> standard_error;   // [F] of the radiosity; empty unless the method is the reference
    std::vector<Element> elements;     // of the faces that were subdivided, ascending by face; other faces are whole
};

/// Work, predicted.
struct Work {
    std::uint64_t links = 0, rays = 0, bytes = 0;
    double seconds = 0;  // wall clock
};

/// One line of the effect plan.
struct EffectPlan {
    std::string name;      // emitters interreflection occlusion self colour ...
    bool on = false;
    std::string reason;
    double seconds = 0;    // actual work, after the solve
    std::optional<Work> predicted = {};  // before it; none where there is no model of the work
};

/// Wall time of each phase; they do not overlap. Visibility is part of making links, and takes its share of the threads' time.
struct PhaseSeconds {
    double load = 0, plan = 0, links = 0, visibility = 0, iterate = 0, output = 0, total = 0;
    double outside = 0;  // part of visibility: sky, sun and lamps
};

/// Links, each for both directions: far, where directions count; near, between two ends of one radiosity each; self, within
/// one instance. Those of the hierarchical method are all near.
struct LinkCounts {
    std::uint64_t far = 0, near = 0, self = 0;
    std::uint64_t bytes = 0;  // that they take, with the reusable method the light on them too
    std::uint64_t total() const { return far + near + self; }
};

/// Where the power of all light goes, W per channel. Emitted includes sky, sun and lamps, as far as their light arrives. What
/// black backs and media take is absorbed with the reference, escaped with the other methods.
struct EnergyBalance {
    Vec3 emitted, absorbed, escaped;
};

/// All that a solve gives.
struct Solution {
    std::vector<InstanceSolution> instances;  // as in the scene
    std::vector<EffectPlan> effects;
    PhaseSeconds seconds;
    LinkCounts links;
    EnergyBalance energy;
    std::uint64_t rays = 0;
    std::uint64_t elements = 0;       // leaves: whole faces and elements
    double accuracy = 0;              // asked
    double estimated_error = 0;       // area-weighted relative RMS of the reflected radiosity
    std::int64_t worst_instance = -1; // of those that hold a thousandth of the reflected light or more; -1: not known
    double worst_estimate = 0;        // its own estimated error
    bool converged = false;           // the estimate met the accuracy; reference with samples, hierarchical: all was done
    int iterations = 0;               // sweeps of light over all links; reference: passes over all faces
    double residual = 0;              // of the iteration, relative to the reflected light
    std::vector<std::string> warnings;
};

}  // namespace rro
