#include <algorithm>
#include <array>

#include "compiler/archive_diff_parts.h"
#include "compiler/diff_words.h"

namespace rro {
namespace {

std::vector<std::uint32_t> numbers_of(const ObjectData& data, const std::vector<std::uint32_t>& triangles) {
    std::vector<std::uint32_t> numbers;
    for (const std::uint32_t t : triangles) numbers.push_back(data.source_triangle[t]);
    return numbers;
}

std::vector<std::uint32_t> numbers_before(const ObjectData& a, const std::vector<TrianglePair>& pairs) {
    std::vector<std::uint32_t> numbers;
    for (const TrianglePair& pair : pairs) numbers.push_back(a.source_triangle[pair.a]);
    return numbers;
}

/// A change of some triangles: their count and numbers, and "12 triangles VERB: 3-14".
Change some_triangles(const std::string& kind, const std::string& verb, const std::vector<std::uint32_t>& numbers) {
    const NumberRanges ranges = ranges_of(numbers);
    return {"geometry",
            kind,
            verb,
            {},
            {},
            {{"count", std::uint64_t{numbers.size()}}, {"triangles", ranges}},
            counted(numbers.size(), "triangle") + " " + verb + ": " + range_text(ranges)};
}

Change moved_triangles(const ObjectData& a, const ObjectData& b, const std::vector<TrianglePair>& pairs) {
    CornerShift largest;
    std::uint32_t where = 0;
    for (const TrianglePair& pair : pairs)
        if (const CornerShift shift = corner_shift(a.corners(pair.a), b.corners(pair.b));
            shift.distance > largest.distance) {
            largest = shift;
            where = a.source_triangle[pair.a];
        }
    Change change = some_triangles("triangles_moved", "moved", numbers_before(a, pairs));
    const double diagonal = length(a.meta.bounds.extent());
    change.before = largest.from;
    change.after = largest.to;
    change.more.insert(change.more.end(), {{"largest", largest.distance},
                                           {"largest_relative", diagonal > 0 ? largest.distance / diagonal : 0.0},
                                           {"largest_triangle", std::uint64_t{where}}});
    change.text += "; the farthest by " + number(largest.distance) + " m";
    if (diagonal > 0) change.text += ", " + number(100 * largest.distance / diagonal, 2) + " % of the diagonal";
    change.text += ": a corner of " + std::to_string(where) + ", " + from_to(largest.from, largest.to);
    return change;
}

Change renumbered_triangles(const ObjectData& a, const ObjectData& b, const std::vector<TrianglePair>& pairs) {
    Change change = some_triangles("triangles_renumbered", "renumbered", numbers_before(a, pairs));
    std::vector<std::uint32_t> after;
    for (const TrianglePair& pair : pairs) after.push_back(b.source_triangle[pair.b]);
    std::sort(after.begin(), after.end());
    const NumberRanges ranges = ranges_of(after);
    change.more.emplace_back("triangles_after", ranges);
    change.text += " -> " + range_text(ranges);
    return change;
}

void compare_triangles(const ObjectData& a, const ObjectData& b, const TrianglePairs& t, Changes& out) {
    if (t.kept.size() == a.triangles.size() && t.kept.size() == b.triangles.size()) return;
    out.push_back({"geometry",
                   "triangles",
                   "triangles",
                   std::uint64_t{a.triangles.size()},
                   std::uint64_t{b.triangles.size()},
                   {{"kept", std::uint64_t{t.kept.size()}}},
                   "triangles: " + from_to(a.triangles.size(), b.triangles.size()) + "; " +
                       std::to_string(t.kept.size()) + " with the same number and corners"});
    if (!t.removed.empty()) out.push_back(some_triangles("triangles_removed", "removed", numbers_of(a, t.removed)));
    if (!t.added.empty()) out.push_back(some_triangles("triangles_added", "added", numbers_of(b, t.added)));
    if (!t.renumbered.empty()) out.push_back(renumbered_triangles(a, b, t.renumbered));
    if (!t.moved.empty()) out.push_back(moved_triangles(a, b, t.moved));
    if (!t.turned.empty())
        out.push_back(some_triangles("triangles_turned", "wound the other way", numbers_before(a, t.turned)));
}

/// Bit 0: the front is a face, bit 1: the back is. [T]
std::vector<std::uint8_t> sides_of(const ObjectData& data) {
    std::vector<std::uint8_t> sides(data.triangles.size());
    for (const Face f : data.faces)
        sides[f.triangle()] = static_cast<std::uint8_t>(sides[f.triangle()] | (f.side() == Side::Front ? 1 : 2));
    return sides;
}

void compare_sides(const ObjectData& a, const ObjectData& b, const TrianglePairs& triangles, Changes& out) {
    constexpr std::array kNames{"black on both sides", "one-sided", "one-sided on the back", "two-sided"};
    const std::vector<std::uint8_t> before = sides_of(a), after = sides_of(b);
    std::array<std::vector<std::uint32_t>, 16> numbers;  // by sides before * 4 + after
    for (const TrianglePair& pair : triangles.all())
        if (before[pair.a] != after[pair.b])
            numbers[before[pair.a] * std::size_t{4} + after[pair.b]].push_back(a.source_triangle[pair.a]);
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        if (numbers[i].empty()) continue;
        std::sort(numbers[i].begin(), numbers[i].end());
        const std::string was = kNames[i / 4], is = kNames[i % 4];
        Change& change = out.emplace_back(some_triangles("triangles_sides", was + " -> " + is, numbers[i]));
        change.what = "sides";
        change.before = was;
        change.after = is;
    }
}

void compare_point(const std::string& kind, const std::string& what, const Vec3& before, const Vec3& after,
                   Changes& out) {
    if (before == after) return;
    out.push_back({"geometry", kind, what, before, after, {}, what + ": " + from_to(before, after) + " m"});
}

void compare_flag(const std::string& kind, bool before, bool after, Changes& out) {
    if (before == after) return;
    out.push_back({"geometry", kind, kind, before, after, {}, after ? "now " + kind : "no longer " + kind});
}

}  // namespace

void compare_geometry(const ObjectData& a, const ObjectData& b, const TrianglePairs& triangles, bool mesh_differs,
                      Changes& out) {
    const std::size_t start = out.size();
    compare_triangles(a, b, triangles, out);
    compare_sides(a, b, triangles, out);
    compare_count("geometry", "vertices", "vertices", a.positions.size(), b.positions.size(), out);
    compare_point("origin", "origin of the coordinates", a.origin, b.origin, out);
    if (mesh_differs && out.size() == start)
        out.push_back({"geometry",
                       "stored_order",
                       "order of storage",
                       {},
                       {},
                       {},
                       "the same triangles, vertices and sides, stored in another order"});
    compare_count("geometry", "source_triangles", "triangles in the source", a.meta.source_triangles, b.meta.source_triangles, out);
    compare_point("bounds_lo", "bounds from", a.meta.bounds.lo, b.meta.bounds.lo, out);
    compare_point("bounds_hi", "bounds to", a.meta.bounds.hi, b.meta.bounds.hi, out);
    if (a.meta.area != b.meta.area)
        out.push_back({"geometry",
                       "area",
                       "area",
                       a.meta.area,
                       b.meta.area,
                       {{"relative", relative_change(a.meta.area, b.meta.area)}},
                       "area: " + from_to(a.meta.area, b.meta.area) + " m^2" + in_percent(a.meta.area, b.meta.area)});
    compare_flag("closed", a.meta.closed, b.meta.closed, out);
    compare_flag("convex", a.meta.convex, b.meta.convex, out);
}

}  // namespace rro
