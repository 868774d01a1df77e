#include "compiler/triangle_pairs.h"

#include <algorithm>
#include <array>
#include <limits>
#include <tuple>
#include <utility>

namespace rro {
namespace {

TriangleCorners rotated(const TriangleCorners& c, std::size_t by) {
    return {c[by], c[(by + 1) % 3], c[(by + 2) % 3]};
}

/// The corners as one sequence that does not depend on which comes first.
using CornerKey = std::array<double, 9>;

CornerKey corner_key(const TriangleCorners& c) {
    const auto sequence = [&](std::size_t first) {
        const auto [p, q, r] = rotated(c, first);
        return CornerKey{p.x, p.y, p.z, q.x, q.y, q.z, r.x, r.y, r.z};
    };
    return std::min({sequence(0), sequence(1), sequence(2)});
}

/// A triangle and what it is found by.
template <class Key>
struct Entry {
    Key key;
    std::uint32_t number, triangle;

    bool operator<(const Entry& other) const {
        return std::tie(key, number, triangle) < std::tie(other.key, other.number, other.triangle);
    }
};

std::vector<Entry<std::uint32_t>> by_number(const ObjectData& data, const std::vector<std::uint32_t>& triangles) {
    std::vector<Entry<std::uint32_t>> entries;
    entries.reserve(triangles.size());
    for (const std::uint32_t t : triangles) entries.push_back({data.source_triangle[t], data.source_triangle[t], t});
    return entries;
}

std::vector<Entry<CornerKey>> by_corners(const ObjectData& data, const std::vector<std::uint32_t>& triangles) {
    std::vector<Entry<CornerKey>> entries;
    entries.reserve(triangles.size());
    for (const std::uint32_t t : triangles)
        entries.push_back({corner_key(data.corners(t)), data.source_triangle[t], t});
    return entries;
}

struct Merged {
    std::vector<TrianglePair> pairs;  // of equal keys, one by one
    std::vector<std::uint32_t> rest_a, rest_b;
};

template <class Key>
Merged merge(std::vector<Entry<Key>> a, std::vector<Entry<Key>> b) {
    std::sort(a.begin(), a.end());
    std::sort(b.begin(), b.end());
    Merged merged;
    auto i = a.begin();
    auto j = b.begin();
    while (i != a.end() || j != b.end()) {
        if (j == b.end() || (i != a.end() && i->key < j->key))
            merged.rest_a.push_back((i++)->triangle);
        else if (i == a.end() || j->key < i->key)
            merged.rest_b.push_back((j++)->triangle);
        else
            merged.pairs.push_back({(i++)->triangle, (j++)->triangle});
    }
    return merged;
}

std::vector<std::uint32_t> all_triangles(const ObjectData& data) {
    std::vector<std::uint32_t> triangles(data.triangles.size());
    for (std::uint32_t t = 0; t < triangles.size(); ++t) triangles[t] = t;
    return triangles;
}

}  // namespace

std::vector<TrianglePair> TrianglePairs::all() const {
    std::vector<TrianglePair> pairs = kept;
    for (const auto* more : {&turned, &renumbered, &moved}) pairs.insert(pairs.end(), more->begin(), more->end());
    return pairs;
}

TrianglePairs pair_triangles(const ObjectData& a, const ObjectData& b) {
    TrianglePairs result;
    Merged numbered = merge(by_number(a, all_triangles(a)), by_number(b, all_triangles(b)));
    for (const TrianglePair& pair : numbered.pairs) {
        const TriangleCorners after = b.corners(pair.b);
        const CornerKey key = corner_key(a.corners(pair.a));
        if (key == corner_key(after))
            result.kept.push_back(pair);
        else if (key == corner_key({after[0], after[2], after[1]}))
            result.turned.push_back(pair);
        else {
            numbered.rest_a.push_back(pair.a);
            numbered.rest_b.push_back(pair.b);
        }
    }
    // Where triangles were taken out of a file, all that follow have other numbers: first find those by their corners.
    Merged placed = merge(by_corners(a, numbered.rest_a), by_corners(b, numbered.rest_b));
    std::sort(placed.pairs.begin(), placed.pairs.end(), [&](const TrianglePair& x, const TrianglePair& y) {
        return std::pair(a.source_triangle[x.a], x.a) < std::pair(a.source_triangle[y.a], y.a);
    });
    result.renumbered = std::move(placed.pairs);
    Merged last = merge(by_number(a, placed.rest_a), by_number(b, placed.rest_b));
    result.moved = std::move(last.pairs);
    result.removed = std::move(last.rest_a);
    result.added = std::move(last.rest_b);
    return result;
}

CornerShift corner_shift(const TriangleCorners& a, const TriangleCorners& b) {
    CornerShift best{std::numeric_limits<double>::infinity(), {}, {}};
    for (std::size_t first = 0; first < 3; ++first) {
        const TriangleCorners after = rotated(b, first);
        CornerShift shift{-1, {}, {}};
        for (std::size_t k = 0; k < 3; ++k)
            if (const double distance = length(after[k] - a[k]); distance > shift.distance)
                shift = {distance, a[k], after[k]};
        if (shift.distance < best.distance) best = shift;
    }
    return best;
}

}  // namespace rro
