#include "solver/output/vertex_radiosity.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include "format/sample_points.h"

namespace rro {
namespace {

/// Determinant over squared trace below which points lie in a row, and say nothing about the slope across it.
constexpr double kInARow = 1e-4;

/// Vertex values from leaf means: every leaf gets a slope, every vertex the mean of what its leaves say it has. Gives
/// back exactly what is linear over a plane.
class VertexFit {
  public:
    VertexFit(const SurfaceMesh& mesh, const StitchedTriangles& parts, const std::vector<FaceGeometry>& faces,
              const std::vector<double>& area, const Affine3& to_world)
        : mesh_(mesh), parts_(parts), faces_(faces), area_(area) {
        for (const Vec3& p : mesh.positions) place_.push_back(to_world.point(p));
        for (const Rgb& b : parts.leaf_radiosity) wanted_.push_back(to_double(b));
        sum_up();
    }

    std::vector<Rgb> run() const {
        const std::vector<Slope> slope = slopes();
        const std::vector<Limits> limits = vertex_limits();
        std::vector<Vec3> sum(place_.size());
        for_each_corner([&](std::size_t t, std::uint32_t v) {
            const std::uint32_t l = parts_.leaf[t];
            const Vec3 from_centre = place_[v] - leaf_centre_[l];
            Vec3 value = wanted_[l];
            for (int c = 0; c < 3; ++c) value[c] += dot(slope[l][static_cast<std::size_t>(c)], from_centre);
            sum[v] += value * share(t, v);
        });
        std::vector<Rgb> out;
        for (std::size_t v = 0; v < sum.size(); ++v) {
            for (int c = 0; c < 3; ++c) sum[v][c] = std::clamp(sum[v][c], limits[v].lo[c], limits[v].hi[c]);
            out.push_back(to_float(sum[v]));
        }
        return out;
    }

  private:
    using Slope = std::array<Vec3, 3>;  // gradient of each channel, in the leaf's plane
    struct Limits {
        Vec3 lo, hi;
    };

    template <class Visit>
    void for_each_corner(const Visit& visit) const {
        for (std::size_t t = 0; t < area_.size(); ++t)
            for (const std::uint32_t v : mesh_.triangles[t]) visit(t, v);
    }

    /// The share of triangle t in the area about vertex v; equal shares where there is no area.
    double share(std::size_t t, std::uint32_t v) const {
        return vertex_area_[v] > 0 ? area_[t] / vertex_area_[v] : 1.0 / corners_[v];
    }

    void sum_up() {
        vertex_area_.resize(place_.size());
        corners_.resize(place_.size());
        leaf_centre_.resize(wanted_.size());
        std::vector<double> leaf_area(wanted_.size());
        for_each_corner([&](std::size_t t, std::uint32_t v) {
            vertex_area_[v] += area_[t];
            ++corners_[v];
            leaf_area[parts_.leaf[t]] += area_[t];
            leaf_centre_[parts_.leaf[t]] += place_[v] * area_[t];
        });
        for (std::size_t l = 0; l < leaf_area.size(); ++l)
            if (leaf_area[l] > 0) leaf_centre_[l] = leaf_centre_[l] / leaf_area[l];
        mean_.resize(place_.size());
        centre_.resize(place_.size());
        for_each_corner([&](std::size_t t, std::uint32_t v) {
            mean_[v] += wanted_[parts_.leaf[t]] * share(t, v);
            centre_[v] += leaf_centre_[parts_.leaf[t]] * share(t, v);
        });
    }

    /// Least squares through the means about a leaf's vertices, each held to lie at the centre of what it is a mean of.
    std::vector<Slope> slopes() const {
        struct Sums {
            double uu = 0, uv = 0, vv = 0;
            Vec3 u, v;  // of the differences, per channel
        };
        std::vector<Sums> sums(wanted_.size());
        for_each_corner([&](std::size_t t, std::uint32_t vertex) {
            const std::uint32_t l = parts_.leaf[t];
            const auto [along_u, along_v, normal] = frame_of(l);
            const Vec3 d = centre_[vertex] - leaf_centre_[l];
            const double u = dot(d, along_u), v = dot(d, along_v);
            const Vec3 difference = mean_[vertex] - wanted_[l];
            Sums& s = sums[l];
            s.uu += u * u, s.uv += u * v, s.vv += v * v;
            s.u += difference * u, s.v += difference * v;
        });
        std::vector<Slope> out(wanted_.size());
        for (std::uint32_t l = 0; l < out.size(); ++l) {
            const Sums& s = sums[l];
            const double trace = s.uu + s.vv, determinant = s.uu * s.vv - s.uv * s.uv;
            if (!(trace > 0)) continue;
            const auto [along_u, along_v, normal] = frame_of(l);
            const bool in_a_row = determinant < kInARow * trace * trace;
            for (int c = 0; c < 3; ++c) {
                const double du = in_a_row ? s.u[c] / trace : (s.vv * s.u[c] - s.uv * s.v[c]) / determinant;
                const double dv = in_a_row ? s.v[c] / trace : (s.uu * s.v[c] - s.uv * s.u[c]) / determinant;
                out[l][static_cast<std::size_t>(c)] = along_u * du + along_v * dv;
            }
        }
        return out;
    }

    std::array<Vec3, 3> frame_of(std::uint32_t leaf) const {
        const Vec3& normal = faces_[parts_.leaf_face[leaf]].normal;
        return frame_about(length2(normal) > 0 ? normal : Vec3{0, 0, 1});
    }

    /// Inside a surface a vertex lies between its leaves' means, so steps get no halo. At borders and creases it may
    /// leave them by half the range about them, so that slopes go on; never below black.
    std::vector<Limits> vertex_limits() const {
        std::vector<Box3> range(place_.size()), leaf_range(wanted_.size());
        std::vector<Vec3> beyond(place_.size());
        for_each_corner([&](std::size_t t, std::uint32_t v) { range[v].add(wanted_[parts_.leaf[t]]); });
        for_each_corner([&](std::size_t t, std::uint32_t v) { leaf_range[parts_.leaf[t]].add(range[v]); });
        for_each_corner([&](std::size_t t, std::uint32_t v) {
            const Vec3 about = leaf_range[parts_.leaf[t]].extent();
            for (int c = 0; c < 3; ++c) beyond[v][c] = std::max(beyond[v][c], 0.5 * about[c]);
        });
        const std::vector<std::uint8_t> border = border_vertices();
        std::vector<Limits> limits(place_.size());
        for (std::size_t v = 0; v < limits.size(); ++v) {
            limits[v] = {range[v].lo, range[v].hi};
            if (!border[v]) continue;
            limits[v].hi += beyond[v];
            for (int c = 0; c < 3; ++c) limits[v].lo[c] = std::max(0.0, limits[v].lo[c] - beyond[v][c]);
        }
        return limits;
    }

    /// 1 where the triangles about a vertex do not close a ring. Going round a ring, every neighbour is left once and
    /// entered once, so keyed sums cancel.
    std::vector<std::uint8_t> border_vertices() const {
        std::vector<std::uint64_t> balance(place_.size());
        for (const TriangleIndices& t : mesh_.triangles)
            for (std::size_t k = 0; k < 3; ++k) balance[t[k]] += mix64(t[(k + 1) % 3]) - mix64(t[(k + 2) % 3]);
        std::vector<std::uint8_t> border;
        for (const std::uint64_t b : balance) border.push_back(b != 0);
        return border;
    }

    const SurfaceMesh& mesh_;
    const StitchedTriangles& parts_;
    const std::vector<FaceGeometry>& faces_;
    const std::vector<double>& area_;            // [N] of triangles
    std::vector<Vec3> place_;                    // [V] world
    std::vector<Vec3> wanted_;                   // [L]
    std::vector<double> vertex_area_;            // [V] of the triangles about it
    std::vector<std::uint32_t> corners_;         // [V] how many
    std::vector<Vec3> leaf_centre_;              // [L] world
    std::vector<Vec3> mean_, centre_;            // [V] area-weighted over the leaves about it
};

}  // namespace

std::vector<Rgb> vertex_radiosity(const SurfaceMesh& mesh, const StitchedTriangles& parts,
                                  const std::vector<FaceGeometry>& faces, const std::vector<double>& area,
                                  const Affine3& to_world) {
    return VertexFit(mesh, parts, faces, area, to_world).run();
}

}  // namespace rro
