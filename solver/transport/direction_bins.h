// The multipole chain: patches -> outgoing intensity per direction -> (links) -> light per direction -> sub-clusters ->
// patches. Directions are the nodes of the archive's grid, in the instance's own frame; quantities are world quantities.
//
// Every Bins node has two faces to the world, each with a table of its own:
//   outside  other end beyond the instance's bounds: patches count with their stored visibility, which holds the
//            occlusion by the whole object
//   inside   other end may be within: patches count with their plain cosine, scaled by the cluster's intrinsic area
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "format/direction_grid.h"
#include "solver/transport/channels.h"
#include "solver/transport/nodes.h"

namespace rro {

/// Mean: no directions at all, the end has one radiosity and all its faces receive alike.
enum class EndMode : std::uint8_t { Inside = 0, Outside = 1, Mean = 2 };

/// Light of one direction bin as it arrives at another place.
struct Arrival {
    Vec3 direction;               // unit, world, towards the source
    double inverse_distance = 0;  // 0: from infinity
    float gain = 1;               // of its perpendicular irradiance
};

/// Takes light with this sum of strength times direction and of strength over distance to the place at `offset` from the
/// bins' centre.
Arrival translated(const Vec3& sum, double strength, double over_distance, const Vec3& offset);

/// Adds perpendicular irradiance H from direction u to planes of incoming light, H[C], Hu[3], H/d[1], `stride` apart.
template <std::size_t C>
void splat_into(float* planes, std::size_t stride, const DirectionTaps& taps, const Vec3& u, double inverse_distance,
                const std::array<float, C>& h) {
    const float strength = mean_of(h);
    const std::array<float, 4> shared{static_cast<float>(u.x) * strength, static_cast<float>(u.y) * strength,
                                      static_cast<float>(u.z) * strength,
                                      static_cast<float>(inverse_distance) * strength};
    for (std::size_t t = 0; t < 4; ++t) {
        float* at = planes + taps.node[t];
        for (std::size_t c = 0; c < C; ++c) at[c * stride] += taps.weight[t] * h[c];
        for (std::size_t s = 0; s < 4; ++s) at[(C + s) * stride] += taps.weight[t] * shared[s];
    }
}

/// Tables of one object that all its instances share. Immutable.
struct ObjectTables {
    std::uint32_t stride = 0;            // D rounded up to 8, so that loops need no remainder
    std::vector<float> cosine_area;      // [P * stride] sum_f A_f max(0, n_f . w_k), local m^2
    std::vector<float> visibility;       // [P * stride] in [0, 1]
    std::vector<std::uint32_t> area_row; // [C] row of a cluster in the area tables, or kNoNode
    std::vector<double> face_area_sum;   // [F + 1] running sum of local face areas, for sampling points
    std::vector<float> whole_share;      // [K * D] whole area over the sum of A max(0, n . w) of the cluster's faces
    std::vector<float> intrinsic_share;  // [K * D] the same of the intrinsic area
    std::vector<std::uint8_t> mixed;     // [C] closed objects: 1 where a cluster has patches that are seen from outside and such as are not

    explicit ObjectTables(const ObjectData& data, const DirectionGrid& grid);
};

/// Relative errors that tables bring to light that an end sends and receives.
struct TableError {
    double sent = 0, received = 0;
};

/// Projected areas of nodes as ends of links.
class EndAreas {
  public:
    /// before  may hold tables of the same objects, which are shared then
    explicit EndAreas(const Nodes& nodes, const EndAreas* before = nullptr);

    const ObjectTables& tables(std::uint32_t instance) const { return *of_instance_[instance]; }

    /// Share of a node's projected area towards w that is seen: 1 for surfaces and groups; by patch visibility or whole-object area outside; by intrinsic
    /// area of Bins nodes inside. In [0, 1] but for noise.
    double visible_share(const Node& node, const Vec3& w, EndMode mode) const;

    /// As the archive measured it, off the grid.
    TableError table_error(const Node& node, EndMode mode) const;

    /// Does the node hold both sides of its closed object's walls? What one side receives the other does not, and only whole
    /// objects' tables tell them apart.
    bool mixed(const Node& node) const;

    /// Does the archive hold what an Outside end at this node needs? Groups need nothing of their own.
    bool has_outside(const Node& node) const;

  private:
    const Nodes& nodes_;
    std::vector<std::shared_ptr<const ObjectTables>> tables_;  // [objects]
    std::vector<const ObjectTables*> of_instance_;
};

/// Directional light state of all instances, for C channels. It stays from sweep to sweep: what sends and receives as before
/// is neither pulled nor pushed again.
template <int C>
class DirectionBins {
  public:
    DirectionBins(const Nodes& nodes, const EndAreas& areas);

    /// Forgets all ends and their light.
    void reset();
    /// Marks a node as the end of a link; storage exists only for such nodes.
    void use(std::uint32_t node, EndMode mode);
    /// Call after use(). Ends that were there before keep their light.
    void allocate();
    /// Remembers from now on what has been pushed, so that push() can tell what differs.
    void remember() { remembers_ = true; }

    /// Nothing has arrived at a node.
    void clear_incoming(std::uint32_t node);

    /// Intensities of used nodes. radiosity: [nodes * C]
    /// changed  [nodes] in: faces that send otherwise than before; out: also the used nodes that do
    void pull(const std::vector<float>& radiosity, std::vector<std::uint8_t>& changed);

    /// Intensity of a Bins node towards w (unit, world), W/sr per channel.
    std::array<float, C> intensity(std::uint32_t node, EndMode mode, const Vec3& w) const;

    /// Adds perpendicular irradiance H arriving from direction u (unit, world, towards the source) at a Bins node.
    void splat(std::uint32_t node, EndMode mode, const Vec3& u, double inverse_distance, const std::array<float, C>& h);

    /// Translates to terminals and pushes to faces: sets irradiance[(first_face + f) * C + c]. With remember(), only where
    /// more than `tolerance` W/m^2 has changed since.
    /// returns  [instances] whether any of it was set
    std::vector<std::uint8_t> push(std::vector<float>& irradiance, double tolerance);

    std::uint64_t bytes() const;

  private:
    // Per used node and mode: C planes of intensity; and incoming planes H[C], Hu[3], H/d[1].
    static constexpr int kIncoming = C + 4;
    struct Face {                            // to the world: one of the two modes
        std::vector<std::uint32_t> nodes;    // used ones, ascending; their rows are numbered alike
        std::vector<std::uint32_t> above;    // [rows] row of the nearest used node above, or kNoNode
        std::vector<std::uint32_t> terminal; // [terminals] row of the nearest used node above or at it, or kNoNode
        std::vector<float> intensity;        // [rows * C * stride]
        std::vector<float> incoming;         // [rows * kIncoming * stride]
        std::vector<float> pushed;           // the same as faces have it; empty where that is not remembered
        std::vector<std::uint8_t> due;       // [rows] to be pulled
        std::vector<std::uint8_t> arrived;   // [rows] light has come anew: to be pushed
    };
    struct State {
        std::uint32_t stride = 0;
        Face face[2];
        std::vector<float> area_factor;         // [stride] world / local projected area
        bool grown = false;                     // has nodes that allocate() does not know
    };
    struct Task {
        std::uint32_t instance, terminal;
    };
    std::uint32_t row(EndMode mode, const Node& bins) const { return row_[static_cast<std::size_t>(mode)][bins.slot]; }
    void allocate(std::uint32_t i);
    void number_rows(std::uint32_t i, std::size_t mode);
    void find_due(std::uint32_t i, Face& face, const std::vector<std::uint8_t>& changed) const;
    void pull_instance(std::uint32_t i, EndMode mode, const std::vector<float>& radiosity);
    /// Leaves in `arrived` only rows that have changed by more than the tolerance.
    void find_arrived(Face& face, std::size_t stride, double tolerance) const;
    void push_terminal(std::uint32_t i, std::uint32_t t, EndMode mode, std::vector<float>& irradiance) const;

    const Nodes& nodes_;
    const EndAreas& areas_;
    std::vector<State> states_;  // per instance
    std::vector<std::uint32_t> row_[2];  // per mode: [bins slots] row within the instance's face, or kNoNode
    std::vector<Task> tasks_;    // terminals with used nodes above or at them; numbers within the instance
    bool remembers_ = false;
};

}  // namespace rro
