// The scene as one forest of nodes in world space: groups of instances, every instance's cluster tree, the parts of patches
// of many faces, the faces, and the elements that faces are subdivided into on demand.
//
// Order: groups (preorder); an instance's clusters (preorder), then parts of its patches, then its faces, then the next
// instance; elements follow all instances. A child's number is always larger than its parent's, so one forward loop pushes down and one backward
// loop pulls up.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "solver/scene/scene.h"
#include "solver/transport/groups.h"

namespace rro {

/// In place of a node's number: none.
inline constexpr std::uint32_t kNoNode = 0xffffffffu;

/// What a node may be at the end of a link.
enum class NodeKind : std::uint8_t {
    Surface,  // a face or an element: planar, exact form factors, scalar irradiance
    Flat,     // several faces that look one way, or a part of a patch: mean radiosity out, irradiance vector in
    Bins,     // a cluster of many orientations, or a group: intensity per direction out, light per direction in
    Cluster,  // too small for bins, too round to be flat: never an end, always split
};

/// One node, in the world.
struct Node {
    Vec3 centre;                    // area-weighted centroid, world
    Box3 box;                       // world
    Vec3 area_vector;               // sum of area times normal, world, m^2
    std::array<double, 6> moments{};  // sum of area times nx nx, ny ny, nz nz, nx ny, ny nz, nz nx, m^2
    double area = 0;                // m^2
    float radius = 0;               // about centre, m
    float cone_cosine = -1;         // smallest cosine between the mean normal and a face's
    std::uint32_t instance = 0;     // kNoNode: a group
    std::uint32_t index = 0;        // cluster (of a part: its patch's), face, element or group number
    std::uint32_t parent = kNoNode;
    std::uint32_t first_child = 0;  // clusters, groups: the left child, whose sibling is second_child; else children in a row
    std::uint32_t second_child = 0;
    std::uint32_t child_count = 0;
    std::uint32_t slot = 0;         // Flat: number of its irradiance vector; Bins: of its direction bins
    NodeKind kind = NodeKind::Cluster;
    std::uint8_t depth = 0;         // of an element below its face, of a part below its patch

    Vec3 normal() const { return normalised(area_vector); }

    /// Mean over the faces' area of max(0, n . w), for w unit and, where `fan` > 0, spread by that much to either side.
    /// Normals are taken as spread evenly about their mean with their own variance along w, so that
    /// for cosines in c - x .. c + x the mean is (c + x)^2 / 4x. 
    double mean_cosine(const Vec3& w, double fan = 0) const;
    bool planar() const { return kind == NodeKind::Surface; }
    /// Faces of one patch, but not all of them.
    bool part() const { return kind == NodeKind::Flat && depth > 0; }
    /// Can light be told to arrive at it, or to leave it, as a whole? Not where the normals of a patch add up to nothing.
    bool may_end() const { return kind != NodeKind::Cluster && (kind != NodeKind::Flat || cone_cosine > -1); }
    bool group() const { return instance == kNoNode; }

    template <class F>
    void for_each_child(const F& f) const {
        if (second_child != 0) {
            f(first_child);
            f(second_child);
        } else {
            for (std::uint32_t k = 0; k < child_count; ++k) f(first_child + k);
        }
    }
};

/// Where an instance's nodes lie.
struct InstanceNodes {
    std::uint32_t first_cluster = 0, first_face = 0;
    std::vector<std::uint32_t> elements;   // node numbers, ascending
    std::vector<std::uint32_t> terminals;  // Bins nodes without Bins children: light reaches patches from these
    bool planar = false;                   // all in one plane: it cannot block itself
    double similarity = 0;                 // factor of lengths where the transform keeps shapes, else 0
};

/// An element's corners within its face, barycentric.
using ElementCorners = std::array<std::array<float, 2>, 3>;

/// The forest. Keeps a reference to the scene.
class Nodes {
  public:
    explicit Nodes(const Scene& scene);

    const Scene& scene() const { return *scene_; }
    /// The same instances in the same places, of other materials.
    void set_materials(const Scene& scene) { scene_ = &scene; }
    /// The same instances in the same groups; those moved keep shape and size. Nodes keep their numbers.
    void move(const Scene& scene, std::span<const std::uint8_t> moved);
    std::size_t size() const { return nodes_.size(); }
    const Node& operator[](std::uint32_t n) const { return nodes_[n]; }
    const InstanceNodes& instance(std::uint32_t i) const { return instances_[i]; }
    std::uint32_t root(std::uint32_t i) const { return instances_[i].first_cluster; }
    /// Groups are the first nodes, numbered alike. There are none above few instances.
    const GroupTree& groups() const { return groups_; }
    std::uint32_t group_count() const { return static_cast<std::uint32_t>(groups_.groups.size()); }
    /// Running sum of the members' areas in the order of groups().members, m^2. [members + 1]
    const std::vector<double>& member_area_sum() const { return member_area_sum_; }
    std::uint32_t flat_count() const { return flat_count_; }
    std::uint32_t bins_count() const { return bins_count_; }

    /// The face that a surface node is or is part of, and its patch.
    std::uint32_t face_of(const Node& surface) const;
    std::uint32_t patch_of(const Node& surface) const {
        return scene_->instances[surface.instance].object->patch_of_face[face_of(surface)];
    }
    std::uint32_t triangle_of(const Node& surface) const {
        return scene_->instances[surface.instance].data().faces[face_of(surface)].triangle();
    }

    /// World corners of a surface node, counter-clockwise from its side.
    TriangleCorners corners(std::uint32_t surface) const;
    const ElementCorners& element_corners(std::uint32_t element) const { return element_corners_[nodes_[element].index]; }

    /// Half-open range of numbers of the patches that a node holds, or of the one that it is part of; not of a group.
    std::array<std::uint32_t, 2> patches(const Node& node) const;

    /// Half-open range of face numbers below a node; not of a group.
    std::array<std::uint32_t, 2> faces(const Node& node) const;

    /// Children as ends of links: a patch of one face is skipped in favour of the face.
    void children(std::uint32_t node, std::vector<std::uint32_t>& out) const;

    /// Gives a surface node four elements, if it has none. Not thread-safe.
    void subdivide(std::uint32_t surface);

  private:
    void add_instance(std::uint32_t i);
    void add_parts(std::uint32_t node, std::uint32_t first_face, std::uint32_t count, std::uint32_t& next);
    void place_instance(std::uint32_t i);
    void sum_children(std::uint32_t node);
    void set_groups();
    void set_surface(Node& node, const TriangleCorners& c) const;

    const Scene* scene_;
    GroupTree groups_;
    std::vector<double> member_area_sum_;
    std::vector<Node> nodes_;
    std::vector<InstanceNodes> instances_;
    std::vector<ElementCorners> element_corners_;
    std::vector<std::uint32_t> element_face_;  // per element: face number
    std::uint32_t flat_count_ = 0, bins_count_ = 0;
};

}  // namespace rro
