#include "solver/transport/nodes.h"

#include <cassert>

namespace rro {

namespace {

// A cluster whose normals lie within this cosine of their mean radiates and receives like a tilted plate.
constexpr float kFlatConeCosine = 0.8f;

// Light that reaches an object through one link is translated to about this many sub-clusters before it is pushed to
// patches: one link then does as well as a hundred without (measured on busts, chairs and scans).
constexpr std::uint32_t kTerminalsPerObject = 48;
constexpr std::uint32_t kSmallestTerminal = 8;  // patches

// A patch of more faces than that divides into parts before it divides into faces: a fine mesh makes no more links than a
// coarse one. Faces of a patch follow a space-filling curve, so that a row of them lies together.
constexpr std::uint32_t kFacesInRow = 8, kPartsInRow = 4;

/// Parts below a patch, or a part, of so many faces.
std::uint32_t count_parts(std::uint32_t faces) {
    if (faces <= kFacesInRow) return 0;
    std::uint32_t parts = kPartsInRow;
    for (std::uint32_t k = 0; k < kPartsInRow; ++k)
        parts += count_parts(faces * (k + 1) / kPartsInRow - faces * k / kPartsInRow);
    return parts;
}

// Corners of the four children of a triangle in its own barycentric coordinates: three at the corners, one inside.
ElementCorners child_corners(const ElementCorners& c, int child) {
    const auto middle = [](const std::array<float, 2>& a, const std::array<float, 2>& b) {
        return std::array<float, 2>{0.5f * (a[0] + b[0]), 0.5f * (a[1] + b[1])};
    };
    const auto m01 = middle(c[0], c[1]), m12 = middle(c[1], c[2]), m20 = middle(c[2], c[0]);
    switch (child) {
        case 0: return {c[0], m01, m20};
        case 1: return {m01, c[1], m12};
        case 2: return {m20, m12, c[2]};
        default: return {m12, m20, m01};
    }
}

/// The factor by which a map changes all lengths; 0 where there is no such factor.
double similarity_of(const Affine3& map) {
    constexpr double kSame = 1e-6;  // relative; exchange areas are known to no more than that
    const std::array<Vec3, 3> axes{map.vector({1, 0, 0}), map.vector({0, 1, 0}), map.vector({0, 0, 1})};
    const double square = length2(axes[0]);
    for (std::size_t k = 0; k < 3; ++k)
        if (std::abs(length2(axes[k]) - square) > kSame * square ||
            std::abs(dot(axes[k], axes[(k + 1) % 3])) > kSame * square)
            return 0;
    return std::sqrt(square);
}

/// Forgets what is summed up over the children.
void clear_sums(Node& node) {
    node.centre = node.area_vector = {};
    node.box = {};
    node.moments = {};
    node.area = 0;
}

}  // namespace

double Node::mean_cosine(const Vec3& w, double fan) const {
    if (!(area > 0)) return 0;
    const double c = dot(area_vector, w) / area;
    const std::array<double, 6>& m = moments;
    const double square = (m[0] * w.x * w.x + m[1] * w.y * w.y + m[2] * w.z * w.z +
                           2 * (m[3] * w.x * w.y + m[4] * w.y * w.z + m[5] * w.z * w.x)) / area;
    const double x = std::sqrt(3 * std::max(0.0, square - c * c) + fan * fan);
    if (c >= x) return c;
    return c > -x ? (c + x) * (c + x) / (4 * x) : 0.0;
}

Nodes::Nodes(const Scene& scene)
    : scene_(&scene), groups_(group_instances(scene)), instances_(scene.instances.size()) {
    std::size_t count = group_count();
    for (const Instance& i : scene.instances) count += i.data().clusters.size() + i.data().faces.size();
    nodes_.reserve(count + count / 4);
    nodes_.resize(group_count());
    for (std::uint32_t i = 0; i < scene.instances.size(); ++i) add_instance(i);
    set_groups();
}

void Nodes::move(const Scene& scene, std::span<const std::uint8_t> moved) {
    scene_ = &scene;
    for (std::uint32_t i = 0; i < moved.size(); ++i)
        if (moved[i]) place_instance(i);
    set_groups();
}

void Nodes::set_groups() {
    if (group_count() == 0) return;
    member_area_sum_.assign(1, 0);
    for (const std::uint32_t i : groups_.members)
        member_area_sum_.push_back(member_area_sum_.back() + nodes_[root(i)].area);
    for (std::uint32_t g = group_count(); g-- > 0;) {
        const auto node_of = [&](std::uint32_t child) {
            return groups_.is_group(child) ? child : root(groups_.instance(child));
        };
        Node& node = nodes_[g];
        clear_sums(node);
        node.kind = NodeKind::Bins;
        node.instance = kNoNode;
        node.index = g;
        node.first_child = node_of(groups_.groups[g].child[0]);
        node.second_child = node_of(groups_.groups[g].child[1]);
        node.child_count = 2;
        const std::array<std::uint32_t, 2> both{node.first_child, node.second_child};
        for (const std::uint32_t child : both) {
            Node& n = nodes_[child];
            n.parent = g;
            node.area += n.area;
            node.area_vector += n.area_vector;
            node.centre += n.centre * n.area;
            node.box.add(n.box);
        }
        node.centre = node.area > 0 ? node.centre / node.area : node.box.centre();
        // Both bounds hold: the children's spheres, and the farthest corner of the box.
        double spheres = 0;
        for (const std::uint32_t child : both)
            spheres = std::max(spheres, length(nodes_[child].centre - node.centre) + double(nodes_[child].radius));
        const Vec3 lo = node.centre - node.box.lo, hi = node.box.hi - node.centre;
        const double corner = length({std::max(lo.x, hi.x), std::max(lo.y, hi.y), std::max(lo.z, hi.z)});
        node.radius = static_cast<float>(std::min(spheres, corner));
    }
}

void Nodes::set_surface(Node& node, const TriangleCorners& c) const {
    node.kind = NodeKind::Surface;
    node.area_vector = area_vector(c);
    node.area = length(node.area_vector);
    node.centre = (c[0] + c[1] + c[2]) / 3.0;
    const Vec3 n = node.normal();
    node.moments = {n.x * n.x, n.y * n.y, n.z * n.z, n.x * n.y, n.y * n.z, n.z * n.x};
    for (double& m : node.moments) m *= node.area;
    node.cone_cosine = 1;
    double r2 = 0;
    for (const Vec3& p : c) {
        node.box.add(p);
        r2 = std::max(r2, length2(p - node.centre));
    }
    node.radius = static_cast<float>(std::sqrt(r2));
}

/// Gives a patch's node, or a part's, its children: faces first_face .. first_face + count - 1 in parts, or themselves.
/// next  number of the next part
void Nodes::add_parts(std::uint32_t id, std::uint32_t first_face, std::uint32_t count, std::uint32_t& next) {
    nodes_[id].first_child = first_face;
    nodes_[id].child_count = count;
    if (count <= kFacesInRow) return;
    const std::uint32_t row = next;
    next += kPartsInRow;
    nodes_[id].first_child = row;
    nodes_[id].child_count = kPartsInRow;
    for (std::uint32_t k = 0; k < kPartsInRow; ++k) {
        Node& part = nodes_[row + k];
        part.instance = nodes_[id].instance;
        part.index = nodes_[id].index;
        part.depth = static_cast<std::uint8_t>(nodes_[id].depth + 1);
        part.kind = NodeKind::Flat;
        part.slot = flat_count_++;
        const std::uint32_t begin = count * k / kPartsInRow, end = count * (k + 1) / kPartsInRow;
        add_parts(row + k, first_face + begin, end - begin, next);
    }
}

void Nodes::sum_children(std::uint32_t id) {
    Node& node = nodes_[id];
    clear_sums(node);
    const auto add = [&](std::uint32_t child) {
        Node& n = nodes_[child];
        n.parent = id;
        node.area += n.area;
        node.area_vector += n.area_vector;
        for (std::size_t k = 0; k < 6; ++k) node.moments[k] += n.moments[k];
        node.centre += n.centre * n.area;
        node.box.add(n.box);
    };
    node.for_each_child(add);
    node.centre = node.area > 0 ? node.centre / node.area : node.box.centre();
}

void Nodes::add_instance(std::uint32_t i) {
    const Instance& instance = scene_->instances[i];
    const ObjectData& data = instance.data();
    InstanceNodes& in = instances_[i];
    const auto cluster_count = static_cast<std::uint32_t>(data.clusters.size());
    const auto face_count = static_cast<std::uint32_t>(data.faces.size());
    const auto patch_count = static_cast<std::uint32_t>(data.patches.size());
    std::uint32_t part_count = 0;
    for (const Patch& patch : data.patches) part_count += count_parts(patch.face_count);
    in.first_cluster = static_cast<std::uint32_t>(nodes_.size());
    in.first_face = in.first_cluster + cluster_count + part_count;
    nodes_.resize(std::size_t(in.first_face) + face_count);

    for (std::uint32_t f = 0; f < face_count; ++f) {
        nodes_[in.first_face + f].instance = i;
        nodes_[in.first_face + f].index = f;
    }
    std::uint32_t next_part = in.first_cluster + cluster_count;
    for (std::uint32_t c = 0; c < cluster_count; ++c) {
        const Cluster& cluster = data.clusters[c];
        Node& node = nodes_[in.first_cluster + c];
        node.instance = i;
        node.index = c;
        if (cluster.right_child == 0) {
            const Patch& patch = data.patches[cluster.first_patch];
            add_parts(in.first_cluster + c, in.first_face + patch.first_face, patch.face_count, next_part);
        } else {
            node.first_child = in.first_cluster + c + 1;
            node.second_child = in.first_cluster + cluster.right_child;
            node.child_count = 2;
        }
    }
    place_instance(i);

    // Kinds, top-down.
    const std::uint32_t terminal = std::max(kSmallestTerminal, patch_count / kTerminalsPerObject);
    for (std::uint32_t c = 0; c < cluster_count; ++c) {
        Node& node = nodes_[in.first_cluster + c];
        const Cluster& cluster = data.clusters[c];
        const bool parent_flat = c > 0 && nodes_[node.parent].kind == NodeKind::Flat;
        if (parent_flat || node.cone_cosine >= kFlatConeCosine || cluster.right_child == 0) {
            node.kind = NodeKind::Flat;
            node.slot = flat_count_++;
        } else if (c == 0 || (nodes_[node.parent].kind == NodeKind::Bins &&
                              data.clusters[node.parent - in.first_cluster].patch_count > terminal)) {
            node.kind = NodeKind::Bins;
            node.slot = bins_count_++;
            if (cluster.patch_count <= terminal) in.terminals.push_back(in.first_cluster + c);
        }
    }
    // A Bins node above the terminal size hands its light to Bins or Flat children only; Flat children of such a node
    // receive through their own faces, so they are terminals of their own.
    for (std::uint32_t c = 1; c < cluster_count; ++c) {
        const Node& node = nodes_[in.first_cluster + c];
        const Node& parent = nodes_[node.parent];
        if (node.kind == NodeKind::Flat && parent.kind == NodeKind::Bins &&
            data.clusters[parent.index].patch_count > terminal)
            in.terminals.push_back(in.first_cluster + c);
    }
    std::sort(in.terminals.begin(), in.terminals.end());

    in.similarity = similarity_of(instance.to_world);
    const Node& root = nodes_[in.first_cluster];
    const Vec3 n = root.normal();
    in.planar = root.cone_cosine > 1 - 1e-6f;
    for (std::uint32_t f = 0; f < face_count && in.planar; ++f)
        in.planar = std::abs(dot(n, nodes_[in.first_face + f].centre - root.centre)) <= 1e-6 * root.radius;
}

void Nodes::place_instance(std::uint32_t i) {
    const Instance& instance = scene_->instances[i];
    const ObjectData& data = instance.data();
    const InstanceNodes& in = instances_[i];
    const auto face_count = static_cast<std::uint32_t>(data.faces.size());
    const auto place_surface = [&](std::uint32_t id, const TriangleCorners& corners) {
        nodes_[id].box = {};
        set_surface(nodes_[id], corners);
    };
    for (std::uint32_t f = 0; f < face_count; ++f) place_surface(in.first_face + f, instance.world_corners(data.faces[f]));
    for (const std::uint32_t id : in.elements) place_surface(id, corners(id));
    for (std::uint32_t id = in.first_face; id-- > in.first_cluster;) sum_children(id);

    // Extents and cones are taken over the faces below, exactly: each face visits its ancestors.
    std::vector<Vec3> normals(in.first_face - in.first_cluster);
    for (std::uint32_t k = 0; k < normals.size(); ++k) {
        Node& node = nodes_[in.first_cluster + k];
        node.radius = 0;
        node.cone_cosine = length(node.area_vector) > 1e-6 * node.area ? 1.0f : -1.0f;
        normals[k] = node.normal();
    }
    for (std::uint32_t f = 0; f < face_count; ++f) {
        const Node& face = nodes_[in.first_face + f];
        const Vec3 normal = face.normal();
        for (std::uint32_t a = face.parent; a != kNoNode && !nodes_[a].group(); a = nodes_[a].parent) {
            Node& node = nodes_[a];
            node.radius = std::max(node.radius, static_cast<float>(length(face.centre - node.centre) + face.radius));
            if (node.cone_cosine > -1)
                node.cone_cosine = std::min(node.cone_cosine, static_cast<float>(dot(normals[a - in.first_cluster], normal)));
        }
    }
}

std::uint32_t Nodes::face_of(const Node& surface) const {
    assert(surface.kind == NodeKind::Surface);
    return surface.depth == 0 ? surface.index : element_face_[surface.index];
}

TriangleCorners Nodes::corners(std::uint32_t surface) const {
    const Node& node = nodes_[surface];
    const Instance& instance = scene_->instances[node.instance];
    const Face face = instance.data().faces[face_of(node)];
    if (node.depth == 0) return instance.world_corners(face);
    // Element corners are relative to the face's own corners; mirrored instances swap at the end.
    TriangleCorners c = instance.data().corners(face);
    for (Vec3& p : c) p = instance.to_world.point(p);
    TriangleCorners e;
    for (std::size_t k = 0; k < 3; ++k) {
        const std::array<float, 2>& b = element_corners_[node.index][k];
        e[k] = c[0] + (c[1] - c[0]) * double(b[0]) + (c[2] - c[0]) * double(b[1]);
    }
    if (instance.determinant_sign < 0) std::swap(e[1], e[2]);
    return e;
}

std::array<std::uint32_t, 2> Nodes::patches(const Node& node) const {
    assert(!node.group());
    if (node.kind == NodeKind::Surface) {
        const std::uint32_t p = patch_of(node);
        return {p, p + 1};
    }
    const Cluster& cluster = scene_->instances[node.instance].data().clusters[node.index];
    return {cluster.first_patch, cluster.first_patch + cluster.patch_count};
}

std::array<std::uint32_t, 2> Nodes::faces(const Node& node) const {
    assert(!node.group());
    if (node.kind == NodeKind::Surface) {
        const std::uint32_t f = face_of(node);
        return {f, f + 1};
    }
    const ObjectData& data = scene_->instances[node.instance].data();
    if (node.part()) {
        const Node *first = &node, *last = &node;
        while (!first->planar()) first = &nodes_[first->first_child];
        while (!last->planar()) last = &nodes_[last->first_child + last->child_count - 1];
        return {first->index, last->index + 1};
    }
    const Cluster& cluster = data.clusters[node.index];
    const Patch& last = data.patches[cluster.first_patch + cluster.patch_count - 1];
    return {data.patches[cluster.first_patch].first_face, last.first_face + last.face_count};
}

void Nodes::children(std::uint32_t id, std::vector<std::uint32_t>& out) const {
    out.clear();
    nodes_[id].for_each_child([&](std::uint32_t child) {
        const Node& n = nodes_[child];
        out.push_back(n.kind != NodeKind::Surface && n.child_count == 1 ? n.first_child : child);
    });
}

void Nodes::subdivide(std::uint32_t surface) {
    assert(nodes_[surface].kind == NodeKind::Surface);
    if (nodes_[surface].child_count > 0) return;
    const Node parent = nodes_[surface];
    const ElementCorners whole{{{0, 0}, {1, 0}, {0, 1}}};
    const ElementCorners base = parent.depth == 0 ? whole : element_corners_[parent.index];
    const auto first = static_cast<std::uint32_t>(nodes_.size());
    const std::uint32_t face = face_of(parent);
    for (int k = 0; k < 4; ++k) {
        Node child;
        child.instance = parent.instance;
        child.parent = surface;
        child.index = static_cast<std::uint32_t>(element_corners_.size());
        child.depth = static_cast<std::uint8_t>(parent.depth + 1);
        child.kind = NodeKind::Surface;
        element_corners_.push_back(child_corners(base, k));
        element_face_.push_back(face);
        nodes_.push_back(child);
        const auto id = static_cast<std::uint32_t>(nodes_.size() - 1);
        set_surface(nodes_[id], corners(id));
        instances_[parent.instance].elements.push_back(id);
    }
    nodes_[surface].first_child = first;
    nodes_[surface].child_count = 4;
}

}  // namespace rro
