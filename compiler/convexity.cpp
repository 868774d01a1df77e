#include "compiler/convexity.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "format/sample_points.h"

namespace rro {
namespace {

constexpr double kDent = 1e-6;  // of the extent: what files with six digits leave in a flat side
constexpr std::size_t kSampledPlanes = 256;

/// Signed height of p over a face's plane.
double height_over(const Surface& surface, std::size_t face, const Vec3& p) {
    return dot(normalised(surface.area_vector[face]), p - surface.corners(surface.faces[face].triangle())[0]);
}

bool edges_are_convex(const Surface& surface, double dent) {
    const FaceAdjacency adjacency = face_adjacency(surface, -1);
    for (std::size_t f = 0; f < surface.faces.size(); ++f)
        for (std::uint32_t i = adjacency.first[f]; i < adjacency.first[f + 1]; ++i)
            for (const Vec3& p : surface.corners(surface.faces[adjacency.neighbour[i]].triangle()))
                if (height_over(surface, f, p) > dent) return false;
    return true;
}

/// Seen from the centre every face shows its back, and together they cover the sphere once: the surface is a star about
/// the centre, so convex edges make a convex body.
bool surrounds_its_centre(const Surface& surface, const Vec3& centre) {
    double angle = 0;
    for (std::size_t f = 0; f < surface.faces.size(); ++f) {
        if (height_over(surface, f, centre) >= 0) return false;
        angle -= solid_angle(surface.corners(surface.faces[f].triangle()), centre);
    }
    return std::abs(angle / (4 * std::numbers::pi) - 1) < 0.01;  // an integer up to rounding
}

bool all_behind_sampled_planes(const Surface& surface, double dent) {
    const std::size_t step = (surface.faces.size() + kSampledPlanes - 1) / kSampledPlanes;
    for (std::size_t f = 0; f < surface.faces.size(); f += step) {
        // Heights over one plane need its normal once; dents are measured over a whole side here, not one edge.
        const Vec3 normal = normalised(surface.area_vector[f]);
        const Vec3 on_plane = surface.corners(surface.faces[f].triangle())[0];
        for (const TriangleIndices& t : surface.triangles)
            for (const std::uint32_t v : t)
                if (dot(normal, to_double(surface.positions[v]) - on_plane) > 10 * dent) return false;
    }
    return true;
}

}  // namespace

bool is_convex(const Surface& surface) {
    if (!surface.closed || surface.faces.size() != surface.triangles.size()) return false;
    Vec3 centre;
    double area = 0;
    Box3 bounds;
    for (std::size_t f = 0; f < surface.faces.size(); ++f) {
        const TriangleCorners t = surface.corners(surface.faces[f].triangle());
        const double a = length(surface.area_vector[f]);
        centre += (t[0] + t[1] + t[2]) * (a / 3);
        area += a;
        for (const Vec3& p : t) bounds.add(p);
    }
    const double dent = kDent * max_component(bounds.extent());
    return surrounds_its_centre(surface, centre / area) && edges_are_convex(surface, dent) &&
           all_behind_sampled_planes(surface, dent);
}

}  // namespace rro
