// Light that no surface sends: what faces and elements receive straight from sky, sun and lamps. It is found once, by
// rays between points of a face and the light, and enters every sweep as a source.
#pragma once

#include <cstdint>
#include <vector>

#include "solver/effects/effect.h"
#include "solver/transport/link.h"

namespace rro {

/// The irradiance of leaf surfaces, and how sure it is.
class OutsideLight {
  public:
    /// Keeps references. Does nothing, and costs nothing, where the plan calls for none of the three.
    OutsideLight(const Scene& scene, const Plan& plan, const LinkBuilder& builder, const SceneRays& rays,
                 const TransportOptions& options);

    bool any() const { return sky() || sun() || lights(); }

    /// Takes over what another one found in the same place. node: [nodes there] number here
    void take_over(const OutsideLight& from, const std::vector<std::uint32_t>& node);

    /// Finds the light of all leaf surfaces that have come since the last call: as many points as it takes until the mean of each
    /// is known to a part of the accuracy, relative to what it or a typical surface receives.
    void find(const Nodes& nodes);

    /// The leaf surfaces across which a shadow's edge runs, so that dividing them pays: where that would move the scene's
    /// squared error by more than a link's share (guide.reflected and the shares must be set).
    std::vector<std::uint32_t> shadow_edges(const Nodes& nodes, const Guide& guide) const;

    const std::vector<Rgb>& irradiance() const { return irradiance_; }  // [nodes] W/m^2; of surfaces that were leaves when found
    const std::vector<float>& error() const { return error_; }          // [nodes] W/m^2, standard deviation, channels' mean

    std::uint64_t rays() const { return rays_; }

  private:
    struct Estimate;
    struct Sums;
    bool sky() const { return built_in("sky") && sky_; }
    bool sun() const { return built_in("sun") && sun_; }
    bool lights() const { return built_in("lights") && lights_; }
    Estimate sample(const Nodes& nodes, std::uint32_t surface, double tolerance) const;
    void conclude(Estimate& e, double points, const Sums& sums) const;

    const Scene& scene_;
    const LinkBuilder& builder_;
    const SceneRays& rays_of_scene_;
    bool sky_, sun_, lights_, occlusion_;
    std::uint64_t seed_;
    double accuracy_;
    double typical_ = 0;  // W/m^2, root mean square over the area of the first call's leaves
    std::uint64_t rays_ = 0;
    std::vector<Rgb> irradiance_;
    std::vector<float> error_, partial_;  // partial_: v (1 - v) of the light's visibility v; 0 where all points agree
};

}  // namespace rro
