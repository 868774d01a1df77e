#include "compiler/object_layout.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "format/parallel.h"

namespace rro {
namespace {

constexpr std::uint32_t kNone = 0xffffffffu;

/// Corners and area vectors of the stored faces, and the bounds over ranges of them.
struct FaceGeometry {
    std::vector<TriangleCorners> corners;  // [F]
    std::vector<Vec3> area_vector;         // [F]
};

FaceGeometry face_geometry(const CompiledObject& object) {
    FaceGeometry geometry;
    for (const Face f : object.faces) {
        const TriangleIndices& t = object.triangles[f.triangle()];
        TriangleCorners c{to_double(object.positions[t[0]]), to_double(object.positions[t[1]]),
                          to_double(object.positions[t[2]])};
        if (f.side() == Side::Back) std::swap(c[1], c[2]);
        geometry.corners.push_back(c);
        geometry.area_vector.push_back(area_vector(c));
    }
    return geometry;
}

float smallest_cosine(const FaceGeometry& geometry, std::uint32_t begin, std::uint32_t end, const Vec3f& normal) {
    double smallest = 1;
    for (std::uint32_t f = begin; f < end; ++f)
        smallest = std::min(smallest, dot(to_double(normal), normalised(geometry.area_vector[f])));
    return static_cast<float>(std::max(-1.0, smallest));
}

Patch make_patch(const FaceGeometry& geometry, const Surface& surface, std::span<const std::uint32_t> faces,
                 std::uint32_t first_face) {
    Patch patch{};
    patch.first_face = first_face;
    patch.face_count = static_cast<std::uint32_t>(faces.size());
    patch.material = surface.material[faces.front()];
    Vec3 centre, normal, reflectance;
    double area = 0;
    for (std::uint32_t k = 0; k < patch.face_count; ++k) {
        const TriangleCorners& c = geometry.corners[first_face + k];
        const double a = length(geometry.area_vector[first_face + k]);
        centre += (c[0] + c[1] + c[2]) * (a / 3);
        normal += geometry.area_vector[first_face + k];
        reflectance += surface.reflectance[faces[k]] * a;
        area += a;
    }
    patch.area = static_cast<float>(area);
    patch.reflectance = to_float(reflectance / area);
    patch.centre = to_float(centre / area);
    patch.normal = to_float(normalised(normal));
    patch.cone_cosine = smallest_cosine(geometry, first_face, first_face + patch.face_count, patch.normal);
    return patch;
}

/// The next float above, so that a bound survives rounding.
float rounded_up(double x) {
    return std::nextafter(static_cast<float>(x), std::numeric_limits<float>::infinity());
}

void bound_cluster(const FaceGeometry& geometry, std::uint32_t begin, std::uint32_t end, Cluster& cluster) {
    constexpr double kCancelled = 1e-6;  // of the area: below, rounding would choose the normal
    Box3 box;
    Vec3 normal;
    double area = 0;
    for (std::uint32_t f = begin; f < end; ++f) {
        for (const Vec3& p : geometry.corners[f]) box.add(p);
        normal += geometry.area_vector[f];
        area += length(geometry.area_vector[f]);
    }
    cluster.area = static_cast<float>(area);
    cluster.lo = to_float(box.lo);
    cluster.hi = to_float(box.hi);
    double radius2 = 0;
    for (std::uint32_t f = begin; f < end; ++f)
        for (const Vec3& p : geometry.corners[f]) radius2 = std::max(radius2, length2(p - cluster.centre()));
    cluster.radius = rounded_up(std::sqrt(radius2));
    const bool cancelled = length(normal) <= kCancelled * area;
    cluster.normal = cancelled ? Vec3f{} : to_float(normalised(normal));
    cluster.cone_cosine = cancelled ? -1 : smallest_cosine(geometry, begin, end, cluster.normal);
}

/// Faces in the tree's order (numbers of the surface's), and from them the new numbers of triangles and vertices.
void renumber(const Surface& surface, const PatchGroups& groups, const ClusterTree& tree, CompiledObject& object) {
    std::vector<std::uint32_t> new_triangle(surface.triangles.size(), kNone);
    std::vector<std::uint32_t> new_vertex(surface.positions.size(), kNone);
    for (const std::uint32_t p : tree.patch_order)
        for (const std::uint32_t f : groups.patch(p)) {
            const std::uint32_t old = surface.faces[f].triangle();
            if (new_triangle[old] == kNone) {
                new_triangle[old] = static_cast<std::uint32_t>(object.triangles.size());
                object.source_triangle.push_back(surface.source_triangle[old]);
                TriangleIndices corners = surface.triangles[old];
                for (std::uint32_t& v : corners) {
                    if (new_vertex[v] == kNone) {
                        new_vertex[v] = static_cast<std::uint32_t>(object.positions.size());
                        object.positions.push_back(surface.positions[v]);
                    }
                    v = new_vertex[v];
                }
                object.triangles.push_back(corners);
            }
            object.faces.push_back(Face::make(new_triangle[old], surface.faces[f].side()));
        }
}

}  // namespace

std::vector<ClusterSummary> summarise_patches(const Surface& surface, const PatchGroups& groups) {
    std::vector<ClusterSummary> summaries(groups.size());
    parallel_for(groups.size(), 256, [&](std::size_t p) {
        ClusterSummary& s = summaries[p];
        for (const std::uint32_t f : groups.patch(p)) {
            const double area = length(surface.area_vector[f]);
            for (const Vec3& corner : surface.corners(surface.faces[f].triangle())) s.box.add(corner);
            s.area_vector += surface.area_vector[f];
            s.area += area;
            s.reflectance_area += surface.reflectance[f] * area;
        }
    });
    return summaries;
}

void lay_out_object(const Surface& surface, const PatchGroups& groups, const ClusterTree& tree,
                    CompiledObject& object) {
    renumber(surface, groups, tree, object);
    const FaceGeometry geometry = face_geometry(object);
    std::uint32_t first_face = 0;
    for (const std::uint32_t p : tree.patch_order) {
        object.patches.push_back(make_patch(geometry, surface, groups.patch(p), first_face));
        first_face += object.patches.back().face_count;
    }
    object.clusters.resize(tree.nodes.size());
    parallel_for(tree.nodes.size(), 64, [&](std::size_t c) {
        const ClusterNode& node = tree.nodes[c];
        Cluster& cluster = object.clusters[c];
        cluster.first_patch = node.first_patch;
        cluster.patch_count = node.patch_count;
        cluster.right_child = node.right_child;
        const Patch& last = object.patches[node.first_patch + node.patch_count - 1];
        bound_cluster(geometry, object.patches[node.first_patch].first_face, last.first_face + last.face_count,
                      cluster);
    });
}

}  // namespace rro
