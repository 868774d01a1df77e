#include "solver/visibility/tables.h"

#include <array>
#include <cassert>
#include <cmath>

#include "format/layout.h"
#include "format/sample_points.h"
#include "solver/visibility/reciprocals.h"

namespace rro {
namespace {

constexpr std::uint32_t kNoRow = 0xffffffffu;

// Edges of triangles are met by lines this far outside of them, so that none slips between two neighbours.
constexpr double kEdge = 1e-12;

struct Slabs {
    double near, far;
};

/// Where the line p + t / reciprocal lies in the box; near > far where it does not.
Slabs slabs(const Volume& v, const Vec3& p, const Vec3& reciprocal) {
    Slabs s{-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
    const auto cut = [&](float lo, float hi, double o, double r) {
        const double a = (static_cast<double>(lo) - o) * r, b = (static_cast<double>(hi) - o) * r;
        const double first = b < a ? b : a, last = b < a ? a : b;  // a NaN (on the face of a box without thickness) drops out
        s.near = first > s.near ? first : s.near;
        s.far = last < s.far ? last : s.far;
    };
    cut(v.lo.x, v.hi.x, p.x, reciprocal.x);
    cut(v.lo.y, v.hi.y, p.y, reciprocal.y);
    cut(v.lo.z, v.hi.z, p.z, reciprocal.z);
    return s;
}

double projected_area(const Volume& v, const Vec3& unit) {
    const Vec3 e = to_double(v.hi) - to_double(v.lo);
    return std::abs(unit.x) * e.y * e.z + std::abs(unit.y) * e.z * e.x + std::abs(unit.z) * e.x * e.y;
}

}  // namespace

HitTables::HitTables(const Archive& archive) : object_(archive.data()), grid_(archive.grid()) {
    assert(!object_.volumes.empty() && !object_.hit_volumes.empty());
    row_.assign(object_.volumes.size(), kNoRow);
    for (std::uint32_t q = 0; q < object_.hit_volumes.size(); ++q) row_[object_.hit_volumes[q]] = q;
    for (std::uint32_t node = 0; node < grid_.size(); ++node) line_.push_back(grid_.line(node));
}

double HitTables::probability(std::uint32_t row, bool intrinsic, const DirectionTaps& taps) const {
    const std::uint8_t* table = (intrinsic ? object_.intrinsic_hit : object_.whole_hit).data() + std::size_t{row} * grid_.lines();
    double sum = 0;
    for (std::size_t k = 0; k < taps.node.size(); ++k) sum += static_cast<double>(taps.weight[k]) * table[line_[taps.node[k]]];
    constexpr double kAlmost = 255 * (1 - 1e-6);  // weights are floats
    return sum >= kAlmost ? 1.0 : sum / 255;
}

bool HitTables::hits_triangle(const Volume& leaf, const Vec3& p, const Vec3& d) const {
    for (std::uint32_t i = leaf.first; i < leaf.first + leaf.count; ++i) {
        const TriangleIndices& t = object_.triangles[object_.volume_triangles[i]];
        const Vec3 a = to_double(object_.positions[t[0]]);
        const Vec3 e1 = to_double(object_.positions[t[1]]) - a, e2 = to_double(object_.positions[t[2]]) - a;
        const Vec3 n = cross(d, e2);
        const double det = dot(e1, n);
        if (det == 0) continue;
        const Vec3 s = p - a, m = cross(s, e1);
        const double u = dot(s, n) / det, v = dot(d, m) / det, at = dot(e2, m) / det;
        if (u >= -kEdge && v >= -kEdge && u + v <= 1 + kEdge && at > 0 && at < 1) return true;
    }
    return false;
}

double HitTables::passes(const Vec3& from, const Vec3& to, double missing, const TableOptions& options,
                         std::uint64_t key) const {
    const Vec3 p = from - object_.origin, d = to - from, reciprocal = reciprocals(d);
    const Vec3 unit = normalised(d);
    const DirectionTaps taps = grid_.taps(unit);
    const bool intrinsic = options.intrinsic && !object_.intrinsic_hit.empty();
    std::array<std::uint32_t, layout::kMaxTreeDepth + 1> stack;
    std::size_t waiting = 0;
    double pass = 1;
    stack[waiting++] = 0;
    while (waiting > 0) {
        const std::uint32_t at = stack[--waiting];
        const Volume& v = object_.volumes[at];
        const Slabs inside = slabs(v, p, reciprocal);
        if (inside.near > inside.far || inside.far < 0 || inside.near > 1) continue;
        if (row_[at] != kNoRow && inside.near > 0 && inside.far < 1) {
            const double hit = probability(row_[at], intrinsic, taps);
            if (hit == 1) return 0;
            if (projected_area(v, unit) * (1 - hit) <= missing) {
                if (!options.dice)
                    pass *= 1 - hit;
                else if (static_cast<double>(mix64(key ^ mix64(at)) >> 11) * 0x1p-53 < hit)
                    return 0;
                continue;
            }
        }
        if (v.right_child == 0) {
            if (hits_triangle(v, p, d)) return 0;
            continue;
        }
        stack[waiting++] = v.right_child;
        stack[waiting++] = at + 1;
    }
    return pass;
}

}  // namespace rro
