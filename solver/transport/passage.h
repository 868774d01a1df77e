// Light on its way over the links: what nodes send goes into their directions, over the links, and into what nodes receive.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "solver/transport/direction_bins.h"
#include "solver/transport/group_bins.h"
#include "solver/transport/half_links.h"

namespace rro {

/// One light, C channels, on its way. It stays from sweep to sweep, so that only what has changed passes again.
template <int C>
class Passage {
  public:
    Passage(const Nodes& nodes, const EndAreas& areas, const HalfLinks<C>& links);

    /// New nodes have sent and received nothing.
    void grow();
    /// Forgets the links' ends and all light: new links follow.
    void reset();
    /// Nothing of the light is known any more; the ends stay.
    void forget() { whole_ = true; }
    bool known() const { return !whole_; }
    /// Remembers from now on what bins have pushed (DirectionBins).
    void remember() { bins_.remember(); }
    /// The links at a node are others than before.
    void relinked(std::uint32_t node) { stale_[node] = 1; }
    /// Makes room for the light of links at the nodes wanted, [nodes].
    void use_ends(const std::vector<Link>& links, const std::vector<std::uint8_t>& wanted);

    /// Sends radiosity, [nodes * C], where it has changed by more than the tolerance, W/m^2, and receives it.
    /// tinted   by the medium
    /// returns  [instances] whether anything received there may differ
    std::vector<std::uint8_t> pass(const std::vector<float>& radiosity, double tolerance, bool tinted);

    /// Radiosity as receivers have it.
    const float* sent(std::uint32_t node) const { return &sent_[node * std::size_t(C)]; }
    /// Irradiance over a node's own links.
    const float* received(std::uint32_t node) const { return &received_[node * std::size_t(C)]; }
    /// What a face receives through bins.
    const float* from_bins(std::uint32_t face) const { return &from_bins_[face * std::size_t(C)]; }
    /// What a flat node receives over its own links, 6 C numbers: irradiance vectors, then gradients of irradiance.
    const float* vectors(const Node& flat) const { return &vectors_[flat.slot * std::size_t(6 * C)]; }

    std::uint64_t bytes() const { return bins_.bytes() + groups_.bytes(); }

  private:
    void send(const std::vector<float>& radiosity, double tolerance);
    bool receives_anew(std::uint32_t node) const;
    std::array<float, C> source_value(const typename HalfLinks<C>::Directed& link) const;
    template <bool Tinted>
    std::array<float, C> light_of(std::uint32_t directed) const;
    template <bool Tinted>
    void gather();
    template <bool Tinted>
    std::array<double, C> gather_scalar(std::uint32_t node) const;
    template <bool Tinted>
    void gather_flat(const Node& node, std::uint32_t id);
    template <bool Tinted>
    void gather_bins();

    const Nodes& nodes_;
    const HalfLinks<C>& links_;
    DirectionBins<C> bins_;
    GroupBins<C> groups_;
    std::vector<float> sent_, received_;  // [nodes * C]
    std::vector<float> vectors_;          // [flat slots * 6 * C]
    std::vector<float> from_bins_;        // [nodes * C]
    std::vector<std::uint8_t> changed_;   // [nodes] sends otherwise than it did
    std::vector<std::uint8_t> stale_;     // [nodes] has other links than before, or receives otherwise than before
    bool whole_ = true;                   // nothing of this is known
};

}  // namespace rro
