#include "solver/output/surface_mesh.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <span>

#include "solver/output/element_stitching.h"
#include "solver/output/vertex_radiosity.h"

namespace rro {
namespace {

/// Faces that bend more than this apart keep a sharp edge between them (37 degrees).
constexpr double kSmoothCosine = 0.8;

/// Edges with more triangles than this compare neighbours in order only, which bounds the work at bad meshes.
constexpr std::size_t kPairwiseLimit = 16;

std::vector<FaceGeometry> face_geometry(const Instance& instance) {
    const ObjectData& data = instance.data();
    std::vector<FaceGeometry> out(data.faces.size());
    for (const Patch& patch : data.patches)
        for (std::uint32_t f = patch.first_face; f < patch.first_face + patch.face_count; ++f) {
            const Vec3 area = area_vector(instance.world_corners(data.faces[f]));
            out[f] = {normalised(area), length(area), patch.material};
        }
    return out;
}

/// Front and back of one triangle face apart, so sides never mix.
bool alike(const FaceGeometry& a, const FaceGeometry& b) {
    return a.material == b.material && dot(a.normal, b.normal) > kSmoothCosine;
}

/// Corners (3 * triangle + k) about each point: those of point p are corner[first[p]] .. corner[first[p + 1]].
struct CornersOfPoint {
    std::vector<std::uint32_t> first, corner;
};

CornersOfPoint corners_of_points(const StitchedTriangles& parts) {
    CornersOfPoint out;
    out.first.assign(parts.points.size() + 1, 0);
    for (const TriangleIndices& t : parts.triangles)
        for (const std::uint32_t p : t) ++out.first[p + 1];
    std::partial_sum(out.first.begin(), out.first.end(), out.first.begin());
    out.corner.resize(3 * parts.triangles.size());
    std::vector<std::uint32_t> next(out.first.begin(), out.first.end() - 1);
    for (std::uint32_t t = 0; t < parts.triangles.size(); ++t)
        for (std::uint32_t k = 0; k < 3; ++k) out.corner[next[parts.triangles[t][k]]++] = 3 * t + k;
    return out;
}

/// Sorts the corners about one point into groups that are shaded as one.
class PointGroups {
  public:
    PointGroups(const StitchedTriangles& parts, const std::vector<FaceGeometry>& faces)
        : parts_(parts), faces_(faces) {}

    /// group[i] = the first corner, by place in `corners`, of corner i's group.
    const std::vector<std::uint32_t>& find(std::span<const std::uint32_t> corners) {
        group_.resize(corners.size());
        std::iota(group_.begin(), group_.end(), 0u);
        spokes_.clear();
        for (std::uint32_t i = 0; i < corners.size(); ++i) {
            const TriangleIndices& t = parts_.triangles[corners[i] / 3];
            const std::uint32_t k = corners[i] % 3;
            spokes_.push_back({t[(k + 1) % 3], i});
            spokes_.push_back({t[(k + 2) % 3], i});
        }
        std::sort(spokes_.begin(), spokes_.end(), [](const Spoke& a, const Spoke& b) {
            return a.other != b.other ? a.other < b.other : a.place < b.place;
        });
        for (std::size_t begin = 0, end = 0; begin < spokes_.size(); begin = end) {
            while (end < spokes_.size() && spokes_[end].other == spokes_[begin].other) ++end;
            join_about_edge(corners, begin, end);
        }
        for (std::uint32_t i = 0; i < corners.size(); ++i) group_[i] = root(i);
        return group_;
    }

  private:
    struct Spoke {
        std::uint32_t other, place;  // far end of an edge at the point; corner by place
    };

    void join_about_edge(std::span<const std::uint32_t> corners, std::size_t begin, std::size_t end) {
        const bool pairwise = end - begin <= kPairwiseLimit;
        for (std::size_t i = begin; i < end; ++i)
            for (std::size_t j = i + 1; j < (pairwise ? end : std::min(end, i + 2)); ++j) {
                const std::uint32_t a = spokes_[i].place, b = spokes_[j].place;
                if (alike(face(corners[a]), face(corners[b]))) join(a, b);
            }
    }

    const FaceGeometry& face(std::uint32_t corner) const {
        return faces_[parts_.leaf_face[parts_.leaf[corner / 3]]];
    }
    std::uint32_t root(std::uint32_t i) const {
        while (group_[i] != i) i = group_[i];
        return i;
    }
    void join(std::uint32_t a, std::uint32_t b) {
        a = root(a), b = root(b);
        group_[std::max(a, b)] = std::min(a, b);
    }

    const StitchedTriangles& parts_;
    const std::vector<FaceGeometry>& faces_;
    std::vector<std::uint32_t> group_;
    std::vector<Spoke> spokes_;
};

/// Splits points into vertices, one for each group of corners; gives positions and triangles.
SurfaceMesh with_vertices(StitchedTriangles& parts, const std::vector<FaceGeometry>& faces) {
    SurfaceMesh mesh;
    mesh.triangles.resize(parts.triangles.size());
    const CornersOfPoint about = corners_of_points(parts);
    PointGroups groups(parts, faces);
    for (std::size_t p = 0; p < parts.points.size(); ++p) {
        const std::span corners(about.corner.data() + about.first[p], about.first[p + 1] - about.first[p]);
        const std::vector<std::uint32_t>& group = groups.find(corners);
        for (std::uint32_t i = 0; i < corners.size(); ++i) {
            std::uint32_t& vertex = mesh.triangles[corners[i] / 3][corners[i] % 3];
            if (group[i] == i) {
                vertex = static_cast<std::uint32_t>(mesh.positions.size());
                mesh.positions.push_back(parts.points[p]);
            } else {
                vertex = mesh.triangles[corners[group[i]] / 3][corners[group[i]] % 3];
            }
        }
    }
    mesh.barycentric = std::move(parts.barycentric);
    mesh.first = std::move(parts.first);
    return mesh;
}

/// World areas of the triangles, from the share of their face that they take.
std::vector<double> triangle_areas(const SurfaceMesh& mesh, const StitchedTriangles& parts,
                                   const std::vector<FaceGeometry>& faces) {
    std::vector<double> area(mesh.triangles.size());
    for (std::size_t t = 0; t < area.size(); ++t) {
        const auto& [a, b, c] = mesh.barycentric[t];
        const double share = (double{b[0]} - a[0]) * (double{c[1]} - a[1]) - (double{b[1]} - a[1]) * (double{c[0]} - a[0]);
        area[t] = faces[parts.leaf_face[parts.leaf[t]]].area * share;
    }
    return area;
}

/// World normals weighted by area, taken to the archive's frame (n_world = M^-T n, so n = M^T n_world).
std::vector<Vec3f> vertex_normals(const SurfaceMesh& mesh, const StitchedTriangles& parts,
                                  const std::vector<FaceGeometry>& faces, const std::vector<double>& area,
                                  const Affine3& to_world) {
    std::vector<Vec3> sum(mesh.positions.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (const std::uint32_t v : mesh.triangles[t])
            sum[v] += faces[parts.leaf_face[parts.leaf[t]]].normal * area[t];
    const Mat3 back = to_world.linear.transposed();
    std::vector<Vec3f> normals(sum.size());
    for (std::size_t v = 0; v < sum.size(); ++v) {
        const Vec3 n = normalised(back * normalised(sum[v]));
        normals[v] = to_float(length2(n) > 0 ? n : Vec3{0, 1, 0});  // any unit vector where there is no area
    }
    return normals;
}

}  // namespace

SurfaceMesh surface_mesh(const Instance& instance, const InstanceSolution& solution) {
    const std::vector<FaceGeometry> faces = face_geometry(instance);
    StitchedTriangles parts = stitch_elements(instance.data(), solution);
    SurfaceMesh mesh = with_vertices(parts, faces);
    const std::vector<double> area = triangle_areas(mesh, parts, faces);
    mesh.normals = vertex_normals(mesh, parts, faces, area, instance.to_world);
    mesh.radiosity = vertex_radiosity(mesh, parts, faces, area, instance.to_world);
    return mesh;
}

}  // namespace rro
