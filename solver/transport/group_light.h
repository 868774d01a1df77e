// Light is linear in what is emitted: the light of one light group by itself, from which dimmed scenes are added up.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "solver/scene/scene.h"
#include "solver/solution.h"

namespace rro {

/// What surfaces receive of one light group's light, all bounces included.
struct GroupLight {
    std::shared_ptr<const Scene> lit_in;  // with the group's exitance in this scene
    std::vector<float> irradiance;        // as LightField::irradiance()
    double residual = 0;                  // of R, as LightField::reflected_norm()
    Solution solution;                    // instances and energy of this light alone
    double error_square = 0;              // estimated, sum of A R^2, W^2/m^2
    double light_square = 0;              // sum of A R^2 itself, W^2/m^2
};

/// Squares of a sum of two parts, one of them times a level: a parabola, whose leading coefficient is the square of that part.
class SquareByLevel {
  public:
    SquareByLevel() = default;
    explicit SquareByLevel(double leading) : leading_(leading) {}
    void add(double level, double square);
    /// Known from two levels on; at least 0.
    std::optional<double> at(double level) const;

  private:
    double leading_ = 0;
    std::vector<std::array<double, 2>> points_;  // no more than two, of different levels
};

/// A sum of light: `light` times a factor more than there is in `base`. Links and all else are those of the base.
Solution sum_of_light(const Solution& base, const Solution& light, double times);

/// The light groups whose exitance differs between two scenes that are otherwise the same; empty where surfaces of no group
/// differ, too, or groups have other names.
std::vector<std::uint32_t> changed_groups(const Scene& before, const Scene& after);

/// Does any surface of the group emit?
bool shines(const Scene& scene, std::uint32_t group);

/// How many times brighter all surfaces of a group are than in another scene, where it shines; none where they differ in
/// other ways.
std::optional<double> level_of_group(const Scene& scene, std::uint32_t group, const Scene& than);

}  // namespace rro
