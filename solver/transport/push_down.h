// Light that nodes have received goes down the trees, until surfaces know what they receive in all.
#pragma once

#include <cstdint>
#include <vector>

#include "solver/transport/passage.h"

namespace rro {

/// BoundRows: unit radiosity everywhere; finds how much of what a surface inherits is left beside its own links.
enum class Push { Light, BoundRows };

/// From clusters over flat nodes and faces to their elements, for C channels. Different instances may be pushed by different
/// threads.
template <int C>
class PushDown {
  public:
    explicit PushDown(const Nodes& nodes) : nodes_(nodes) {}

    /// New nodes inherit nothing.
    void grow();
    /// Makes room for what pushes of BoundRows find; without, all is inherited.
    void bound() { scale_.resize(nodes_.size(), 1.0f); }

    /// Irradiance of all nodes of an instance, [nodes * C]; of a face with elements, what they inherit of it.
    void push(std::uint32_t instance, Push what, const Passage<C>& light, std::vector<float>& irradiance);

  private:
    void push_clusters(const InstanceNodes& in, const Passage<C>& light, std::vector<float>& irradiance);
    void push_faces(std::uint32_t instance, Push what, const Passage<C>& light, std::vector<float>& irradiance);
    void push_elements(const InstanceNodes& in, Push what, const Passage<C>& light, std::vector<float>& irradiance);
    void add_slope(std::vector<float>& to, std::uint32_t id) const;
    void add_inherited(std::vector<float>& irradiance, std::uint32_t id, const float* from) const;
    void share_out_faces(std::uint32_t instance, const std::vector<float>& irradiance);
    void gather_rows(const InstanceNodes& in, const std::vector<float>& irradiance);
    void share_out(std::uint32_t parent, const std::vector<float>& irradiance);

    const Nodes& nodes_;
    std::vector<float> vectors_;    // [flat slots * 6 * C] as in Passage, of nodes above, too
    std::vector<float> inherited_;  // [nodes * C] what faces receive through nodes above them
    std::vector<float> scale_;      // [nodes] of what surfaces inherit; empty: all 1
};

}  // namespace rro
