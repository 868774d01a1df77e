#include "solver/factors/polygon.h"

#include <cmath>

#include "format/sample_points.h"

namespace rro {
namespace {

constexpr double kParallelogram = 1e-9;  // how far the fourth corner may be off, relative to the size
constexpr double kSameDirection = 1 - 1e-9;  // cosine of normals that differ by rounding only

void add_node(PolygonRule& rule, const Vec3& at, double weight) {
    const std::size_t lane = rule.count % 4;
    if (lane == 0) {  // the others of the four stand at the same place and weigh nothing
        const Four x{at.x, at.x, at.x, at.x}, y{at.y, at.y, at.y, at.y}, z{at.z, at.z, at.z, at.z};
        rule.nodes.push_back({x, y, z});
        rule.weights.push_back(Four{});
    }
    FourVec3& nodes = rule.nodes.back();
    nodes.x[lane] = at.x;
    nodes.y[lane] = at.y;
    nodes.z[lane] = at.z;
    rule.weights.back()[lane] = weight;
    ++rule.count;
}

/// Gauss-Legendre nodes on [0, 1].
struct LineNode {
    double at, weight;
};
const std::array<LineNode, 2> kTwoNodes{{{0.5 - std::sqrt(1.0 / 12), 0.5}, {0.5 + std::sqrt(1.0 / 12), 0.5}}};
const std::array<LineNode, 3> kThreeNodes{
    {{0.5 - std::sqrt(0.15), 5.0 / 18}, {0.5, 4.0 / 9}, {0.5 + std::sqrt(0.15), 5.0 / 18}}};
const std::array<LineNode, 4> kFourNodes = [] {
    const double outer = std::sqrt(3.0 / 7 + 2.0 / 7 * std::sqrt(1.2)), inner = std::sqrt(3.0 / 7 - 2.0 / 7 * std::sqrt(1.2));
    const double light = (18 - std::sqrt(30.0)) / 72, heavy = (18 + std::sqrt(30.0)) / 72;
    return std::array<LineNode, 4>{{{0.5 - 0.5 * outer, light}, {0.5 - 0.5 * inner, heavy},
                                    {0.5 + 0.5 * inner, heavy}, {0.5 + 0.5 * outer, light}}};
}();

void add_tensor(PolygonRule& rule, const Polygon& p, std::span<const LineNode> line) {
    const Vec3 u = p.corners[1] - p.corners[0], v = p.corners[3] - p.corners[0];
    for (const LineNode& a : line)
        for (const LineNode& b : line) add_node(rule, p.corners[0] + u * a.at + v * b.at, p.area * a.weight * b.weight);
}

void add_fan(PolygonRule& rule, const Polygon& p, const TriangleRule& of_triangle) {
    for (std::size_t k = 1; k + 1 < p.corners.size(); ++k) {
        const TriangleCorners t{p.corners[0], p.corners[k], p.corners[k + 1]};
        const double area = length(area_vector(t));
        for (const auto& node : of_triangle.nodes) add_node(rule, triangle_point(t, node.b1, node.b2), area * node.weight);
    }
}

bool is_parallelogram(const Polygon& p) {
    if (p.corners.size() != 4) return false;
    return length(p.corners[0] + p.corners[2] - p.corners[1] - p.corners[3]) <= kParallelogram * p.radius;
}

}  // namespace

Polygon make_polygon(std::vector<Vec3> corners, double rounding) {
    Polygon p;
    p.corners = std::move(corners);
    p.rounding = rounding;
    derive_from_corners(p);
    return p;
}

void derive_from_corners(Polygon& p) {
    const Vec3 first = p.corners[0];
    Vec3 vector, moment;
    for (std::size_t k = 1; k + 1 < p.corners.size(); ++k) vector += area_vector(first, p.corners[k], p.corners[k + 1]);
    p.area = length(vector);
    p.normal = normalised(vector);
    for (std::size_t k = 1; k + 1 < p.corners.size(); ++k)  // relative to a corner: far from 0 nothing cancels
        moment += ((p.corners[k] - first) + (p.corners[k + 1] - first)) *
                  (dot(p.normal, area_vector(first, p.corners[k], p.corners[k + 1])) / 3);
    p.centre = p.area > 0 ? first + moment / p.area : first;
    p.offset = dot(p.normal, p.centre);
    p.radius = 0;
    for (const Vec3& c : p.corners) p.radius = std::max(p.radius, length(c - p.centre));
}

void add_rules(Polygon& p) {
    for (PolygonRule* rule : {&p.coarse, &p.fine, &p.finest}) {  // keeping their memory
        rule->nodes.clear();
        rule->weights.clear();
        rule->count = 0;
    }
    if (is_parallelogram(p)) {
        add_tensor(p.coarse, p, kTwoNodes);
        add_tensor(p.fine, p, kThreeNodes);
        add_tensor(p.finest, p, kFourNodes);
    } else {
        add_fan(p.coarse, p, triangle_rule(3));
        add_fan(p.fine, p, triangle_rule(6));
        add_fan(p.finest, p, triangle_rule(16));
    }
}

Polygon reversed(const Polygon& polygon) {
    Polygon back = polygon;
    std::reverse(back.corners.begin(), back.corners.end());
    back.normal = -back.normal;
    back.offset = -back.offset;
    return back;
}

void clip_to_front(std::span<const Vec3> polygon, const Vec3& normal, double offset, std::vector<Vec3>& part) {
    part.clear();
    Vec3 last = polygon.back();
    double last_height = dot(normal, last) - offset;
    for (const Vec3& next : polygon) {
        const double height = dot(normal, next) - offset;
        if ((height > 0) != (last_height > 0))
            part.push_back(last + (next - last) * (last_height / (last_height - height)));
        if (height > 0) part.push_back(next);
        last = next;
        last_height = height;
    }
    if (part.size() < 3) part.clear();
}

Lies lies(const Polygon& polygon, const Polygon& plane) {
    const double middle = plane.height(polygon.centre);
    if (middle > polygon.radius) return Lies::Front;
    if (middle < -polygon.radius) return Lies::Behind;
    bool front = false, behind = false;
    const double noise = 4e-16 * (std::abs(plane.offset) + polygon.radius);  // of the heights themselves
    for (const Vec3& c : polygon.corners) {
        const double h = plane.height(c);
        front = front || h > noise;
        behind = behind || h < -noise;
    }
    return !front ? Lies::Behind : behind ? Lies::Across : Lies::Front;
}

bool same_plane(const Polygon& a, const Polygon& b) {
    if (!(dot(a.normal, b.normal) > kSameDirection)) return false;
    const double rounding = std::max(a.rounding, b.rounding);
    for (const Vec3& c : b.corners)
        if (std::abs(a.height(c)) > rounding) return false;
    for (const Vec3& c : a.corners)
        if (std::abs(b.height(c)) > rounding) return false;
    return true;
}

double distance_below(const Vec3& p, const Polygon& polygon) {
    double beside = 0;
    for (std::size_t k = 0; k < polygon.corners.size(); ++k) {
        const Vec3& a = polygon.corners[k];
        const Vec3 edge = polygon.corners[k + 1 == polygon.corners.size() ? 0 : k + 1] - a;
        const double along = length(edge);
        if (along > 0) beside = std::max(beside, dot(cross(edge, polygon.normal), p - a) / along);
    }
    return std::hypot(polygon.height(p), beside);
}

}  // namespace rro
