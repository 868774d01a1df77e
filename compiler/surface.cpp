#include "compiler/surface.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <numeric>
#include <string>

namespace rro {
namespace {

// Squares of lengths beyond these leave the range of float. The importer refuses the same, by file.
constexpr double kLargestExtent = 1e15, kSmallestExtent = 1e-13;  // m
constexpr double kExtentsFromZero = 16;                           // beyond, float would lose four bits of the shape

Vec3 choose_origin(const Box3& bounds) {
    const double extent = max_component(bounds.extent());
    double furthest = 0;
    for (int axis = 0; axis < 3; ++axis)
        furthest = std::max({furthest, std::abs(bounds.lo[axis]), std::abs(bounds.hi[axis])});
    return furthest > kExtentsFromZero * extent ? bounds.centre() : Vec3{};
}

Vec3 face_reflectance(const Mesh& mesh, std::size_t triangle) {
    const Material& material = mesh.materials[mesh.material[triangle]];
    return material.textured && !mesh.reflectance.empty() ? to_double(mesh.reflectance[triangle])
                                                          : material.reflectance;
}

void add_face(Surface& surface, const Mesh& mesh, std::size_t mesh_triangle, Side side, const Vec3& front) {
    const auto triangle = static_cast<std::uint32_t>(surface.triangles.size() - 1);
    surface.faces.push_back(Face::make(triangle, side));
    surface.area_vector.push_back(side == Side::Front ? front : -front);
    surface.material.push_back(mesh.material[mesh_triangle]);
    surface.reflectance.push_back(face_reflectance(mesh, mesh_triangle));
}

struct HalfEdge {
    std::uint32_t lo, hi;  // welded vertices, lo < hi
    std::uint32_t face;
    std::uint32_t forward;  // 1 where the face walks from lo to hi

    auto operator<=>(const HalfEdge&) const = default;
};

std::vector<HalfEdge> sorted_half_edges(const Surface& surface) {
    const std::vector<std::uint32_t> welded = weld(surface.positions);
    std::vector<HalfEdge> edges;
    edges.reserve(surface.faces.size() * 3);
    for (std::uint32_t f = 0; f < surface.faces.size(); ++f) {
        TriangleIndices t = surface.triangles[surface.faces[f].triangle()];
        if (surface.faces[f].side() == Side::Back) std::swap(t[1], t[2]);
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t from = welded[t[k]], to = welded[t[(k + 1) % 3]];
            edges.push_back({std::min(from, to), std::max(from, to), f, from < to ? 1u : 0u});
        }
    }
    std::sort(edges.begin(), edges.end());
    return edges;
}

}  // namespace

Result<Surface> make_surface(const Mesh& mesh) {
    assert(mesh.two_sided.size() == mesh.triangles.size() && "decide_sides has run");
    Box3 bounds;
    for (const TriangleIndices& t : mesh.triangles)
        for (const std::uint32_t v : t) bounds.add(mesh.positions[v]);
    if (bounds.empty()) return bad_input("", "the mesh has no triangle with an area");
    const double extent = max_component(bounds.extent());
    if (!(extent <= kLargestExtent && extent >= kSmallestExtent))
        return bad_input("", "the object is " + std::to_string(extent) + " m large, expected 1e-13 to 1e15 m",
                         "state its unit: --unit m, cm, mm or in");

    Surface surface;
    surface.origin = choose_origin(bounds);
    surface.closed = mesh.closed;
    surface.positions.reserve(mesh.positions.size());
    for (const Vec3& p : mesh.positions) surface.positions.push_back(to_float(p - surface.origin));
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        surface.triangles.push_back(mesh.triangles[t]);
        surface.source_triangle.push_back(mesh.source_triangle[t]);
        const Vec3 front = area_vector(surface.corners(static_cast<std::uint32_t>(surface.triangles.size() - 1)));
        if (!(static_cast<float>(length(front)) > 0)) {
            surface.triangles.pop_back();
            surface.source_triangle.pop_back();
            ++surface.dropped_by_rounding;
            continue;
        }
        add_face(surface, mesh, t, Side::Front, front);
        if (mesh.two_sided[t]) add_face(surface, mesh, t, Side::Back, front);
    }
    if (surface.faces.empty()) return bad_input("", "no triangle has an area in single precision");
    return surface;
}

std::vector<std::uint32_t> weld(std::span<const Vec3f> positions) {
    std::vector<std::uint32_t> order(positions.size()), first_at(positions.size());
    std::iota(order.begin(), order.end(), 0u);
    const auto key = [&](std::uint32_t v) { return std::array{positions[v].x, positions[v].y, positions[v].z}; };
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        const auto ka = key(a), kb = key(b);
        return ka < kb || (ka == kb && a < b);
    });
    for (std::size_t i = 0; i < order.size(); ++i)
        first_at[order[i]] = i > 0 && key(order[i]) == key(order[i - 1]) ? first_at[order[i - 1]] : order[i];
    return first_at;
}

FaceAdjacency face_adjacency(const Surface& surface, double smallest_cosine) {
    // An edge that hundreds of faces share (a fan of blades, say) would cost quadratically; only near ones are
    // compared.
    constexpr std::size_t kWindow = 16;
    const std::vector<HalfEdge> edges = sorted_half_edges(surface);
    const auto continues = [&](const HalfEdge& a, const HalfEdge& b) {
        if (a.forward == b.forward) return false;
        const Vec3 &na = surface.area_vector[a.face], &nb = surface.area_vector[b.face];
        return dot(na, nb) >= smallest_cosine * length(na) * length(nb);
    };
    std::vector<std::array<std::uint32_t, 2>> pairs;
    for (std::size_t i = 0; i < edges.size(); ++i)
        for (std::size_t j = i + 1; j < edges.size() && j <= i + kWindow; ++j) {
            if (edges[j].lo != edges[i].lo || edges[j].hi != edges[i].hi) break;
            if (!continues(edges[i], edges[j])) continue;
            pairs.push_back({edges[i].face, edges[j].face});
            pairs.push_back({edges[j].face, edges[i].face});
        }
    std::sort(pairs.begin(), pairs.end());
    pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());

    FaceAdjacency adjacency;
    adjacency.first.assign(surface.faces.size() + 1, 0);
    for (const auto& [face, other] : pairs) {
        ++adjacency.first[face + 1];
        adjacency.neighbour.push_back(other);
    }
    std::partial_sum(adjacency.first.begin(), adjacency.first.end(), adjacency.first.begin());
    return adjacency;
}

}  // namespace rro
