// The multipole chain above the instances: intensities of roots -> groups -> (links) -> light per direction of groups ->
// roots, where DirectionBins takes over. Directions are those of one grid that is fixed in the world. Ends are Outside
// their instances: what an instance hides of itself is in its own table.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "format/direction_grid.h"
#include "solver/transport/direction_bins.h"

namespace rro {

/// Directional light state of all groups, for C channels.
template <int C>
class GroupBins {
  public:
    GroupBins(const Nodes& nodes, const EndAreas& areas);

    /// Forgets all ends and their light.
    void reset();
    /// Marks a group as the end of a link.
    void use(std::uint32_t group);
    /// Call once after all use(), before bins.allocate(): marks the roots below.
    void allocate(DirectionBins<C>& bins);
    void clear_incoming();
    /// Is any group used?
    bool any() const { return !intensity_.empty(); }

    /// Sums up the roots' intensities, after bins.pull(). radiosity: [nodes * C]
    void pull(const DirectionBins<C>& bins, const std::vector<float>& radiosity);

    /// Intensity of a group towards w (unit, world), W/sr per channel.
    std::array<float, C> intensity(std::uint32_t group, const Vec3& w) const;

    /// Adds perpendicular irradiance H arriving from direction u (unit, world, towards the source) at a group.
    void splat(std::uint32_t group, const Vec3& u, double inverse_distance, const std::array<float, C>& h);

    /// Translates light to the roots below: into the bins of round ones, before bins.push(); into the irradiance
    /// vectors of flat ones, vectors[slot * 3 C].
    void push(DirectionBins<C>& bins, std::vector<float>& vectors);

    std::uint64_t bytes() const;

  private:
    static constexpr std::size_t kIncoming = C + 4;  // planes H[C], Hu[3], H/d[1]
    std::array<float, C> root_intensity(const DirectionBins<C>& bins, const std::vector<float>& radiosity,
                                        std::uint32_t root, const Vec3& w) const;
    void push_to(std::uint32_t group, std::uint32_t child, DirectionBins<C>& bins, std::vector<float>& vectors);

    const Nodes& nodes_;
    const EndAreas& areas_;
    DirectionGrid grid_;
    std::vector<std::vector<std::uint32_t>> levels_;  // groups by their depth
    std::vector<std::uint8_t> used_;                  // [groups] an end, or below one
    std::vector<float> intensity_;                    // [groups * C * D]
    std::vector<float> incoming_;                     // [groups * kIncoming * D]
};

}  // namespace rro
