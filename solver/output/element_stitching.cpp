#include "solver/output/element_stitching.h"

#include <bit>
#include <cmath>
#include <cstddef>
#include <optional>
#include <unordered_map>

#include "format/sample_points.h"

namespace rro {
namespace {

/// Quadtree corners are exact in float; this only forgives a solver that rounded.
constexpr double kOnEdge = 1e-6;

/// Marks a point inside a face, where an edge has its second vertex.
constexpr std::uint32_t kInsideFace = 0xffffffffu;

/// What a point that is no vertex lies on: edge {lower vertex, higher vertex, weight of the higher, 0}, or inside of a
/// face {face, kInsideFace, barycentric}.
struct PlaceKey {
    std::uint32_t a = 0, b = 0;
    float s = 0, t = 0;
    bool operator==(const PlaceKey&) const = default;
};

struct PlaceHash {
    std::size_t operator()(const PlaceKey& k) const {
        const auto pair = [](std::uint32_t high, std::uint32_t low) { return (std::uint64_t{high} << 32) | low; };
        return mix64(pair(k.a, k.b) ^ mix64(pair(std::bit_cast<std::uint32_t>(k.s), std::bit_cast<std::uint32_t>(k.t))));
    }
};

struct PositionHash {
    std::size_t operator()(const Vec3f& p) const {
        const std::uint64_t xy =
            (std::uint64_t{std::bit_cast<std::uint32_t>(p.x)} << 32) | std::bit_cast<std::uint32_t>(p.y);
        return mix64(xy ^ mix64(std::bit_cast<std::uint32_t>(p.z)));
    }
};

/// For every vertex of the mesh the first one at its position.
std::vector<std::uint32_t> weld(std::span<const Vec3f> positions) {
    std::vector<std::uint32_t> welded(positions.size());
    std::unordered_map<Vec3f, std::uint32_t, PositionHash> seen;
    seen.reserve(positions.size());
    for (std::uint32_t v = 0; v < positions.size(); ++v) {
        const Vec3f& p = positions[v];
        const Vec3f without_negative_zero{p.x + 0.0f, p.y + 0.0f, p.z + 0.0f};
        welded[v] = seen.emplace(without_negative_zero, v).first->second;
    }
    return welded;
}

/// A corner of a leaf, or of a part of one.
struct Corner {
    std::uint32_t point = 0;
    Barycentric at{};
};

Barycentric midway(const Barycentric& a, const Barycentric& b) {
    return {0.5f * (a[0] + b[0]), 0.5f * (a[1] + b[1])};
}

/// The work in progress: vertices are points 0 .. V - 1, others are appended as they are met.
class Stitcher {
  public:
    explicit Stitcher(const ObjectData& object) : object_(object), welded_(weld(object.positions)) {
        out_.points.reserve(object.positions.size());
        for (const Vec3f& p : object.positions) out_.points.push_back(object.origin + to_double(p));
    }

    StitchedTriangles run(const InstanceSolution& solution) {
        for (const Element& e : solution.elements)
            for (const Barycentric& at : e.corner) add(e.face, at);
        auto element = solution.elements.begin();
        const auto end = solution.elements.end();
        for (std::uint32_t face = 0; face < object_.faces.size(); ++face) {
            out_.first.push_back(static_cast<std::uint32_t>(out_.triangles.size()));
            if (element == end || element->face != face)
                emit_leaf(face, {{{0, 0}, {1, 0}, {0, 1}}}, solution.radiosity[face]);
            for (; element != end && element->face == face; ++element)
                emit_leaf(face, element->corner, element->radiosity);
        }
        out_.first.push_back(static_cast<std::uint32_t>(out_.triangles.size()));
        return std::move(out_);
    }

  private:
    /// Welded vertices of a face, in its own winding.
    TriangleIndices vertices(std::uint32_t face) const {
        const Face f = object_.faces[face];
        TriangleIndices t = object_.triangles[f.triangle()];
        if (f.side() == Side::Back) std::swap(t[1], t[2]);
        return {welded_[t[0]], welded_[t[1]], welded_[t[2]]};
    }

    /// Where a point of a face lies: a vertex (its number), or a place with a key.
    struct Place {
        std::optional<std::uint32_t> vertex;
        PlaceKey key;
    };
    Place place(std::uint32_t face, const Barycentric& at) const {
        const TriangleIndices v = vertices(face);
        const std::array<double, 3> weight{1.0 - at[0] - at[1], at[0], at[1]};
        for (std::size_t k = 0; k < 3; ++k)
            if (weight[k] > 1 - kOnEdge) return {v[k], {}};
        for (std::size_t k = 0; k < 3; ++k) {
            if (std::abs(weight[k]) > kOnEdge) continue;
            const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
            const std::size_t higher = v[i] > v[j] ? i : j;
            return {{}, {std::min(v[i], v[j]), std::max(v[i], v[j]), static_cast<float>(weight[higher]), 0}};
        }
        return {{}, {face, kInsideFace, at[0], at[1]}};
    }

    std::optional<std::uint32_t> find(std::uint32_t face, const Barycentric& at) const {
        const Place p = place(face, at);
        if (p.vertex) return p.vertex;
        const auto found = numbers_.find(p.key);
        return found == numbers_.end() ? std::nullopt : std::optional(found->second);
    }

    void add(std::uint32_t face, const Barycentric& at) {
        const Place p = place(face, at);
        if (p.vertex) return;
        const auto [entry, is_new] = numbers_.emplace(p.key, static_cast<std::uint32_t>(out_.points.size()));
        if (!is_new) return;
        if (p.key.b == kInsideFace) {
            const TriangleIndices v = vertices(face);
            out_.points.push_back(
                triangle_point({out_.points[v[0]], out_.points[v[1]], out_.points[v[2]]}, at[0], at[1]));
        } else {
            const Vec3 a = out_.points[p.key.a], b = out_.points[p.key.b];
            out_.points.push_back(a + (b - a) * p.key.s);
        }
    }

    void emit_leaf(std::uint32_t face, const std::array<Barycentric, 3>& at, const Rgb& radiosity) {
        std::array<Corner, 3> corners;
        const TriangleIndices v = vertices(face);
        const bool whole = at == std::array<Barycentric, 3>{{{0, 0}, {1, 0}, {0, 1}}};
        for (std::size_t k = 0; k < 3; ++k) corners[k] = {whole ? v[k] : *find(face, at[k]), at[k]};
        out_.leaf_face.push_back(face);
        out_.leaf_radiosity.push_back(radiosity);
        emit(face, corners);
    }

    /// Splits at the middle of the longest edge that has a point there, until none has. Quadtrees halve edges, so a
    /// point at a quarter implies one at the half.
    void emit(std::uint32_t face, const std::array<Corner, 3>& c) {
        std::optional<std::size_t> longest;
        Corner middle;
        double longest2 = -1;
        for (std::size_t k = 0; k < 3 && !numbers_.empty(); ++k) {
            const Corner &a = c[k], &b = c[(k + 1) % 3];
            const Barycentric at = midway(a.at, b.at);
            const double edge2 = length2(out_.points[a.point] - out_.points[b.point]);
            if (edge2 <= longest2) continue;
            const auto point = find(face, at);
            if (!point || *point == a.point || *point == b.point) continue;
            longest = k, longest2 = edge2, middle = {*point, at};
        }
        if (longest) {
            const Corner &a = c[*longest], &b = c[(*longest + 1) % 3], &opposite = c[(*longest + 2) % 3];
            emit(face, {a, middle, opposite});
            emit(face, {middle, b, opposite});
            return;
        }
        out_.triangles.push_back({c[0].point, c[1].point, c[2].point});
        out_.barycentric.push_back({c[0].at, c[1].at, c[2].at});
        out_.leaf.push_back(static_cast<std::uint32_t>(out_.leaf_face.size() - 1));
    }

    const ObjectData& object_;
    const std::vector<std::uint32_t> welded_;
    std::unordered_map<PlaceKey, std::uint32_t, PlaceHash> numbers_;
    StitchedTriangles out_;
};

}  // namespace

StitchedTriangles stitch_elements(const ObjectData& object, const InstanceSolution& solution) {
    return Stitcher(object).run(solution);
}

}  // namespace rro
