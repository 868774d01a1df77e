// Which triangles are one-sided: closedness and winding by OpenMesh's half-edges.
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Core/System/omstream.hh>
#include <algorithm>
#include <array>
#include <cassert>
#include <numeric>
#include <span>
#include <tuple>

#include "compiler/mesh_duplicates.h"
#include "compiler/mesh_import.h"
#include "compiler/mesh_weld.h"

namespace rro {
namespace {

using HalfEdges = OpenMesh::TriMesh_ArrayKernelT<>;

/// The triangles of a mesh and behind them its slits, which make no surface but are part of its topology.
struct Surface {
    const std::vector<Vec3>& positions;
    std::vector<TriangleIndices> triangles;

    explicit Surface(const Mesh& mesh) : positions(mesh.positions), triangles(mesh.triangles) {
        triangles.insert(triangles.end(), mesh.slits.begin(), mesh.slits.end());
    }
};

/// A side of a triangle: from corner k to corner k + 1.
struct Edge {
    std::uint32_t low, high;  // welded positions
    std::uint32_t triangle;
    std::uint8_t k;
    bool forward;  // runs from low to high

    bool joins(const Edge& other) const { return low == other.low && high == other.high; }
};

/// Union-find with path halving; the root of a set is its lowest member.
class Sets {
  public:
    explicit Sets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0u); }
    std::uint32_t root(std::uint32_t i) {
        while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
        return i;
    }
    void join(std::uint32_t a, std::uint32_t b) {
        a = root(a);
        b = root(b);
        parent_[std::max(a, b)] = std::min(a, b);
    }

  private:
    std::vector<std::uint32_t> parent_;
};

/// All sides of all triangles over welded positions; those of one edge stand together, in triangle order.
std::vector<Edge> sorted_edges(const Surface& surface) {
    const std::vector<std::uint32_t> welded = weld_positions(surface.positions);
    std::vector<Edge> edges;
    edges.reserve(3 * surface.triangles.size());
    for (std::uint32_t t = 0; t < surface.triangles.size(); ++t)
        for (std::uint8_t k = 0; k < 3; ++k) {
            const std::uint32_t a = welded[surface.triangles[t][k]], b = welded[surface.triangles[t][(k + 1u) % 3]];
            edges.push_back({std::min(a, b), std::max(a, b), t, k, a < b});
        }
    std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) {
        return std::tie(a.low, a.high, a.triangle, a.k) < std::tie(b.low, b.high, b.triangle, b.k);
    });
    return edges;
}

/// Calls visit(sides) for every edge, with the sides that meet there.
template <class Visit>
void for_each_edge(const std::vector<Edge>& edges, const Visit& visit) {
    for (std::size_t begin = 0, end; begin < edges.size(); begin = end) {
        for (end = begin + 1; end < edges.size() && edges[end].joins(edges[begin]);) ++end;
        visit(std::span(edges).subspan(begin, end - begin));
    }
}

/// Component of each triangle by shared edges, numbered by their lowest triangles.
std::vector<std::uint32_t> components(const Surface& surface, const std::vector<Edge>& edges, std::uint32_t& count) {
    Sets sets(surface.triangles.size());
    for_each_edge(edges, [&](std::span<const Edge> sides) {
        for (const Edge& side : sides) sets.join(sides[0].triangle, side.triangle);
    });
    std::vector<std::uint32_t> component(surface.triangles.size());
    count = 0;
    for (std::uint32_t t = 0; t < component.size(); ++t)
        component[t] = sets.root(t) == t ? count++ : component[sets.root(t)];
    return component;
}

/// OpenMesh's vertex of every corner [3 T]: corners around a position that edges connect are one. So surfaces that
/// merely touch in a point stay apart there, and OpenMesh refuses what is wrong along edges only.
std::vector<std::uint32_t> umbrellas(const Surface& surface, const std::vector<Edge>& edges) {
    Sets sets(3 * surface.triangles.size());
    const auto corner = [](const Edge& side, bool low) {
        return 3 * side.triangle + (low == side.forward ? side.k : (side.k + 1u) % 3);
    };
    for_each_edge(edges, [&](std::span<const Edge> sides) {
        for (const Edge& side : sides)
            for (const bool low : {true, false}) sets.join(corner(sides[0], low), corner(side, low));
    });
    std::vector<std::uint32_t> vertex(3 * surface.triangles.size());
    for (std::uint32_t i = 0; i < vertex.size(); ++i) vertex[i] = sets.root(i);
    return vertex;
}

/// Per component whether two triangles meet at each of its edges, and run against one another there.
std::vector<bool> paired_components(const std::vector<Edge>& edges, const std::vector<std::uint32_t>& component,
                                    std::uint32_t count) {
    std::vector<bool> paired(count, true);
    for_each_edge(edges, [&](std::span<const Edge> sides) {
        if (sides.size() != 2 || sides[0].forward == sides[1].forward) paired[component[sides[0].triangle]] = false;
    });
    return paired;
}

/// Per component whether so many of its triangles share a vertex that OpenMesh, which goes round a vertex for each of
/// them, would take the square of their number: hours for a cone of a million triangles in no order.
std::vector<bool> crowded_components(const std::vector<std::uint32_t>& vertex,
                                     const std::vector<std::uint32_t>& component, std::uint32_t count) {
    constexpr std::uint32_t kCrowd = 1000;
    std::vector<std::uint32_t> around(vertex.size(), 0);
    std::vector<bool> crowded(count, false);
    for (std::size_t i = 0; i < vertex.size(); ++i)
        if (++around[vertex[i]] > kCrowd) crowded[component[i / 3]] = true;
    return crowded;
}

/// Per component whether it is closed and consistently wound. Paired edges are necessary for it; whether they suffice is
/// for OpenMesh to say, but where it would not end, they must.
std::vector<bool> closed_components(const Surface& surface, const std::vector<Edge>& edges,
                                    const std::vector<std::uint32_t>& component, std::uint32_t count) {
    // Refused faces are an answer here, nothing to print. Once: several meshes may be compiled at a time.
    [[maybe_unused]] static const bool silenced = (omerr().disable(), true);
    HalfEdges half_edges;
    const std::vector<std::uint32_t> vertex = umbrellas(surface, edges);
    std::vector<OpenMesh::VertexHandle> handle(vertex.size());
    for (std::size_t i = 0; i < vertex.size(); ++i)  // a root comes before its members
        handle[i] = vertex[i] == i ? half_edges.new_vertex() : handle[vertex[i]];
    std::vector<bool> closed = paired_components(edges, component, count);
    const std::vector<bool> crowded = crowded_components(vertex, component, count);
    std::vector<std::uint32_t> triangle_of_face;
    for (std::uint32_t t = 0; t < surface.triangles.size(); ++t) {
        if (crowded[component[t]]) continue;
        const OpenMesh::VertexHandle* corner = &handle[std::size_t{3} * t];
        const bool degenerate = corner[0] == corner[1] || corner[1] == corner[2] || corner[2] == corner[0];
        const bool refused = degenerate || !half_edges.add_face(corner[0], corner[1], corner[2]).is_valid();
        if (refused) closed[component[t]] = false;
        if (!refused) triangle_of_face.push_back(t);
    }
    for (const auto& face : half_edges.faces())
        for (const auto& edge : half_edges.fe_range(face))
            if (half_edges.is_boundary(edge))
                closed[component[triangle_of_face[static_cast<std::size_t>(face.idx())]]] = false;
    return closed;
}

/// One component's triangles with, for each, whether it must turn to run like the lowest; empty where the component
/// cannot be wound consistently (more than two triangles at an edge, or one-sided like a Moebius strip).
struct Orientation {
    std::vector<std::uint32_t> triangles;
    std::vector<bool> turned;
};

/// Neighbours across edges that exactly two triangles share, and whether the two run the same way there (then one of
/// them must turn). Components with other shared edges are marked.
struct Adjacency {
    struct Neighbour {
        std::uint32_t triangle;
        bool conflict;
    };
    std::vector<std::array<Neighbour, 3>> neighbours;  // itself where there is none
    std::vector<bool> manifold;                        // [components]
};

Adjacency adjacency_of(const std::vector<Edge>& edges, const std::vector<std::uint32_t>& component,
                       std::uint32_t count) {
    Adjacency adjacency;
    adjacency.manifold.assign(count, true);
    for (std::uint32_t t = 0; t < component.size(); ++t)
        adjacency.neighbours.push_back({{{t, false}, {t, false}, {t, false}}});
    for_each_edge(edges, [&](std::span<const Edge> sides) {
        if (sides.size() > 2) adjacency.manifold[component[sides[0].triangle]] = false;
        if (sides.size() != 2) return;
        const Edge &a = sides[0], &b = sides[1];
        const bool conflict = a.forward == b.forward;
        adjacency.neighbours[a.triangle][a.k] = {b.triangle, conflict};
        adjacency.neighbours[b.triangle][b.k] = {a.triangle, conflict};
    });
    return adjacency;
}

Orientation orient(std::uint32_t first, const Adjacency& adjacency, std::vector<std::int8_t>& turn) {
    constexpr std::int8_t kUnknown = -1;
    Orientation out{{first}, {}};
    turn[first] = 0;
    for (std::size_t next = 0; next < out.triangles.size(); ++next) {
        const std::uint32_t t = out.triangles[next];
        for (const auto& [neighbour, conflict] : adjacency.neighbours[t]) {
            const auto wanted = static_cast<std::int8_t>((turn[t] != 0) != conflict);
            if (turn[neighbour] == kUnknown) {
                turn[neighbour] = wanted;
                out.triangles.push_back(neighbour);
            } else if (turn[neighbour] != wanted) {
                return {};
            }
        }
    }
    for (const std::uint32_t t : out.triangles) out.turned.push_back(turn[t] != 0);
    return out;
}

/// Whether a consistent, closed component is inside out: its volume by signed tetrahedra is negative.
bool is_inward(const Surface& surface, const Orientation& orientation) {
    const Vec3 origin = surface.positions[surface.triangles[orientation.triangles[0]][0]];
    double volume = 0;
    for (std::size_t i = 0; i < orientation.triangles.size(); ++i) {
        const TriangleIndices& t = surface.triangles[orientation.triangles[i]];
        const double part = dot(surface.positions[t[0]] - origin,
                                cross(surface.positions[t[1]] - origin, surface.positions[t[2]] - origin));
        volume += orientation.turned[i] ? -part : part;
    }
    return volume < 0;
}

/// Turns triangles so that orientable components are consistent: closed ones outward, open ones as most of their
/// triangles are (as the lowest one, if as many run either way). Returns which were turned.
std::vector<bool> fix_winding_of(Surface& surface, const std::vector<Edge>& edges,
                                 const std::vector<std::uint32_t>& component, std::uint32_t count) {
    const Adjacency adjacency = adjacency_of(edges, component, count);
    std::vector<bool> has_border(count, false);
    for_each_edge(edges, [&](std::span<const Edge> sides) {
        if (sides.size() == 1) has_border[component[sides[0].triangle]] = true;
    });
    std::vector<std::int8_t> turn(component.size(), -1);
    std::vector<bool> turned(component.size(), false);
    std::uint32_t next_component = 0;
    for (std::uint32_t t = 0; t < component.size(); ++t) {
        if (component[t] != next_component) continue;  // components are numbered by their lowest triangle
        ++next_component;
        if (!adjacency.manifold[component[t]]) continue;
        Orientation orientation = orient(t, adjacency, turn);
        const auto wrong = std::count(orientation.turned.begin(), orientation.turned.end(), true);
        const bool flip_all =
            !orientation.triangles.empty() &&
            (has_border[component[t]] ? 2 * static_cast<std::size_t>(wrong) > orientation.turned.size()
                                      : is_inward(surface, orientation));
        for (std::size_t i = 0; i < orientation.triangles.size(); ++i) {
            if (orientation.turned[i] == flip_all) continue;
            TriangleIndices& corners = surface.triangles[orientation.triangles[i]];
            std::swap(corners[1], corners[2]);
            turned[orientation.triangles[i]] = true;
        }
    }
    return turned;
}

}  // namespace

void decide_sides(Mesh& mesh, TwoSided mode, bool fix_winding, ImportReport& report) {
    mesh.two_sided.clear();
    report.duplicate_triangles = drop_duplicates(mesh);
    Surface surface(mesh);
    std::vector<Edge> edges = sorted_edges(surface);
    std::uint32_t count = 0;
    const std::vector<std::uint32_t> component = components(surface, edges, count);
    const auto kept = static_cast<std::ptrdiff_t>(mesh.triangles.size());
    if (fix_winding) {
        const std::vector<bool> turned = fix_winding_of(surface, edges, component, count);
        report.winding_fixed = static_cast<std::uint32_t>(std::count(turned.begin(), turned.begin() + kept, true));
        mesh.triangles.assign(surface.triangles.begin(), surface.triangles.begin() + kept);
        mesh.slits.assign(surface.triangles.begin() + kept, surface.triangles.end());
        edges = sorted_edges(surface);
    }
    std::vector<bool> closed = closed_components(surface, edges, component, count);
    // Components of slits alone come last and are none.
    report.components = kept > 0 ? *std::max_element(component.begin(), component.begin() + kept) + 1 : 0;
    closed.resize(report.components);
    for_each_edge(edges, [&](std::span<const Edge> sides) {
        report.open_edges += sides.size() == 1 ? 1 : 0;
        report.non_manifold_edges += sides.size() > 2 ? 1 : 0;
    });
    report.closed_components = static_cast<std::uint32_t>(std::count(closed.begin(), closed.end(), true));
    mesh.closed = report.components > 0 && report.closed_components == report.components;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const bool two_sided = mode == TwoSided::Yes || (mode == TwoSided::Auto && !closed[component[t]]);
        mesh.two_sided.push_back(two_sided ? 1 : 0);
    }
    report.duplicate_triangles += drop_duplicates(mesh);
    report.two_sided_triangles =
        static_cast<std::uint32_t>(std::count(mesh.two_sided.begin(), mesh.two_sided.end(), std::uint8_t{1}));
    report.one_sided_triangles = static_cast<std::uint32_t>(mesh.triangles.size()) - report.two_sided_triangles;
}

}  // namespace rro
