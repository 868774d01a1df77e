// Triangles of one plane -> convex polygons (surfaces.h).
#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>

#include "format/sample_points.h"
#include "solver/factors/surfaces.h"

namespace rro {
namespace {

constexpr double kFloatRounding = 1.5e-7;      // of an archive's coordinates, with the roundings of a transform
constexpr double kSameDirection = 1 - 1e-6;    // cosine of normals that may lie in one plane
constexpr std::size_t kLargestTry = 64;        // triangles of a region grown one by one; their loop is walked each time
constexpr double kWeldedCell = 1e-11;          // of the scene: corners this near are one, but for rounding
constexpr std::uint32_t kNone = 0xffffffffu;

struct Triangle {
    std::array<std::uint32_t, 3> corners;  // welded numbers, counter-clockwise in the world
    Vec3 normal;
    double area = 0;
    double rounding = 0;           // m
    std::uint32_t source = 0;      // what it was made from
    std::uint32_t region = kNone;
};

/// The triangles with corners that are equal in the archive given one number.
struct Sheet {
    std::vector<Vec3> points;
    std::vector<Triangle> triangles;
    std::unordered_map<std::uint64_t, std::uint32_t> of_edge;  // from -> to, packed: the triangle on its left

    static std::uint64_t key(std::uint32_t from, std::uint32_t to) { return (std::uint64_t{from} << 32) | to; }
    std::uint32_t across(std::uint32_t t, std::size_t k) const {
        const auto& c = triangles[t].corners;
        const auto found = of_edge.find(key(c[(k + 1) % 3], c[k]));
        return found == of_edge.end() ? kNone : found->second;
    }
};

struct PointHash {
    template <class Number>
    std::size_t operator()(const std::array<Number, 3>& p) const {
        std::uint64_t h = 0;
        for (const Number x : p) h = mix64(h ^ std::hash<Number>{}(x));
        return h;
    }
};

/// Adds a triangle whose corners have numbers.
void add_triangle(Sheet& sheet, const std::array<std::uint32_t, 3>& c, double rounding, std::uint32_t source) {
    Triangle triangle{c, {}, 0, rounding, source, kNone};
    const Vec3 vector = area_vector(sheet.points[c[0]], sheet.points[c[1]], sheet.points[c[2]]);
    triangle.area = length(vector);
    triangle.normal = normalised(vector);
    const auto t = static_cast<std::uint32_t>(sheet.triangles.size());
    for (std::size_t k = 0; k < 3; ++k)  // an edge with two triangles on one side joins nothing
        if (const auto [at, is_new] = sheet.of_edge.emplace(Sheet::key(c[k], c[(k + 1) % 3]), t); !is_new)
            at->second = kNone;
    sheet.triangles.push_back(triangle);
}

Sheet make_sheet(const Instance& instance, const std::vector<std::uint32_t>& numbers) {
    const ObjectData& data = instance.data();
    Sheet sheet;
    std::unordered_map<std::array<float, 3>, std::uint32_t, PointHash> welded;
    double reach = 0;
    for (const std::uint32_t number : numbers) {
        std::array<std::uint32_t, 3> corners{};
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3f p = data.positions[data.triangles[number][k]];
            const auto [at, is_new] = welded.emplace(std::array{p.x + 0.0f, p.y + 0.0f, p.z + 0.0f},
                                                     static_cast<std::uint32_t>(sheet.points.size()));
            if (is_new) {
                sheet.points.push_back(instance.to_world.point(data.origin + to_double(p)));
                reach = std::max(reach, length(instance.to_world.vector(to_double(p))));
            }
            corners[k] = at->second;
        }
        if (instance.determinant_sign < 0) std::swap(corners[1], corners[2]);
        add_triangle(sheet, corners, 0, number);
    }
    for (Triangle& triangle : sheet.triangles) triangle.rounding = kFloatRounding * reach;
    return sheet;
}

/// Corners of different polygons that are a rounding apart get one number.
Sheet make_sheet(const std::vector<Polygon>& polygons) {
    Sheet sheet;
    Box3 box;
    for (const Polygon& p : polygons)
        for (const Vec3& c : p.corners) box.add(c);
    const double cell = kWeldedCell * length(box.extent());
    std::unordered_map<std::array<double, 3>, std::uint32_t, PointHash> welded;
    for (std::uint32_t source = 0; source < polygons.size(); ++source) {
        const Polygon& p = polygons[source];
        std::vector<std::uint32_t> numbers;
        for (const Vec3& c : p.corners) {
            const Vec3 at = (c - box.lo) / cell;
            const auto [found, is_new] = welded.emplace(
                std::array{std::round(at.x), std::round(at.y), std::round(at.z)}, static_cast<std::uint32_t>(sheet.points.size()));
            if (is_new) sheet.points.push_back(c);
            numbers.push_back(found->second);
        }
        for (std::size_t k = 1; k + 1 < numbers.size(); ++k)
            add_triangle(sheet, {numbers[0], numbers[k], numbers[k + 1]}, p.rounding, source);
    }
    return sheet;
}

bool in_plane_of(const Sheet& sheet, const Triangle& seed, const Triangle& triangle) {
    if (!(dot(seed.normal, triangle.normal) > kSameDirection)) return false;
    const Vec3& base = sheet.points[seed.corners[0]];
    return std::all_of(triangle.corners.begin(), triangle.corners.end(), [&](std::uint32_t c) {
        return std::abs(dot(seed.normal, sheet.points[c] - base)) <= seed.rounding;
    });
}

/// The border of a region as one convex loop of corners; empty where it is not one.
std::vector<Vec3> convex_border(const Sheet& sheet, const std::vector<std::uint32_t>& region, std::uint32_t number) {
    std::unordered_map<std::uint32_t, std::uint32_t> next;
    double area = 0;
    for (const std::uint32_t t : region) {
        area += sheet.triangles[t].area;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t other = sheet.across(t, k);
            if (other != kNone && sheet.triangles[other].region == number) continue;
            const auto& c = sheet.triangles[t].corners;
            if (!next.emplace(c[k], c[(k + 1) % 3]).second) return {};
        }
    }
    if (next.size() < 3) return {};
    std::vector<Vec3> loop;
    const std::uint32_t start = sheet.triangles[region[0]].corners[0];
    std::uint32_t first = start;  // the lowest border corner: the same for any order of the map
    if (!next.count(first)) {
        first = kNone;
        for (const auto& [from, to] : next) first = std::min(first, from);
    }
    std::uint32_t at = first;
    do {
        loop.push_back(sheet.points[at]);
        const auto found = next.find(at);
        if (found == next.end() || loop.size() > next.size()) return {};
        at = found->second;
    } while (at != first);
    if (loop.size() != next.size()) return {};

    const Vec3 normal = sheet.triangles[region[0]].normal;
    std::vector<Vec3> corners;
    for (std::size_t k = 0; k < loop.size(); ++k) {
        const Vec3& before = corners.empty() ? loop[(k + loop.size() - 1) % loop.size()] : corners.back();
        const Vec3 in = loop[k] - before, out = loop[(k + 1) % loop.size()] - loop[k];
        const double turn = dot(cross(in, out), normal);
        const double flat = sheet.triangles[region[0]].rounding * (length(in) + length(out));
        if (turn < -flat) return {};
        if (turn > flat || dot(in, out) < 0) corners.push_back(loop[k]);
    }
    if (corners.size() < 3) return {};
    Vec3 vector;
    for (std::size_t k = 1; k + 1 < corners.size(); ++k) vector += area_vector(corners[0], corners[k], corners[k + 1]);
    return std::abs(dot(vector, normal) - area) <= 1e-6 * area ? corners : std::vector<Vec3>{};
}

/// All free triangles around a seed that lie in its plane.
std::vector<std::uint32_t> flood(Sheet& sheet, std::uint32_t seed, std::uint32_t number) {
    std::vector<std::uint32_t> region{seed};
    sheet.triangles[seed].region = number;
    for (std::size_t i = 0; i < region.size(); ++i)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t other = sheet.across(region[i], k);
            if (other == kNone || sheet.triangles[other].region != kNone) continue;
            if (!in_plane_of(sheet, sheet.triangles[seed], sheet.triangles[other])) continue;
            sheet.triangles[other].region = number;
            region.push_back(other);
        }
    return region;
}

/// Triangles around a seed, taken one by one while the border stays convex.
std::vector<std::uint32_t> grow_convex(Sheet& sheet, std::uint32_t seed, std::uint32_t number, std::vector<Vec3>& border) {
    std::vector<std::uint32_t> region{seed};
    sheet.triangles[seed].region = number;
    border = convex_border(sheet, region, number);
    for (std::size_t i = 0; i < region.size() && region.size() < kLargestTry; ++i)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t other = sheet.across(region[i], k);
            if (other == kNone || sheet.triangles[other].region != kNone) continue;
            if (!in_plane_of(sheet, sheet.triangles[seed], sheet.triangles[other])) continue;
            sheet.triangles[other].region = number;
            region.push_back(other);
            if (auto wider = convex_border(sheet, region, number); !wider.empty()) {
                border = std::move(wider);
            } else {
                sheet.triangles[other].region = kNone;
                region.pop_back();
            }
        }
    return region;
}

/// A convex polygon that covers a region.
struct Covered {
    Polygon polygon;
    std::vector<std::uint32_t> region;  // triangles of the sheet
};

Covered covered(const Sheet& sheet, std::vector<Vec3> border, std::vector<std::uint32_t> region) {
    double rounding = 0;
    for (const std::uint32_t t : region) rounding = std::max(rounding, sheet.triangles[t].rounding);
    return {make_polygon(std::move(border), rounding), std::move(region)};
}

/// Convex polygons that cover the sheet.
std::vector<Covered> cover(Sheet& sheet) {
    std::vector<Covered> polygons;
    std::uint32_t number = 0;
    for (std::uint32_t seed = 0; seed < sheet.triangles.size(); ++seed) {
        if (sheet.triangles[seed].region != kNone || !(sheet.triangles[seed].area > 0)) continue;
        const std::vector<std::uint32_t> flooded = flood(sheet, seed, number);
        std::vector<Vec3> border = convex_border(sheet, flooded, number++);
        if (!border.empty()) {
            polygons.push_back(covered(sheet, std::move(border), flooded));
            continue;
        }
        for (const std::uint32_t t : flooded) sheet.triangles[t].region = kNone;
        for (const std::uint32_t t : flooded) {
            if (sheet.triangles[t].region != kNone) continue;
            std::vector<std::uint32_t> region = grow_convex(sheet, t, number++, border);
            const auto& c = sheet.triangles[t].corners;
            if (border.empty()) border = {sheet.points[c[0]], sheet.points[c[1]], sheet.points[c[2]]};
            polygons.push_back(covered(sheet, std::move(border), std::move(region)));
        }
    }
    return polygons;
}

}  // namespace

std::vector<Polygon> merged_polygons(const Instance& instance, const std::vector<std::uint32_t>& numbers) {
    Sheet sheet = make_sheet(instance, numbers);
    std::vector<Polygon> polygons;
    for (Covered& c : cover(sheet)) polygons.push_back(std::move(c.polygon));
    return polygons;
}

std::vector<Body> joined_bodies(const std::vector<Body>& bodies) {
    std::vector<Polygon> polygons;
    for (const Body& body : bodies) polygons.push_back(body.polygon);
    Sheet sheet = make_sheet(polygons);
    std::vector<Body> joined;
    for (Covered& c : cover(sheet)) {
        Body body{std::move(c.polygon), bodies[sheet.triangles[c.region[0]].source].group};
        for (const std::uint32_t t : c.region)
            if (bodies[sheet.triangles[t].source].group != body.group) body.group = kNoGroup;
        joined.push_back(std::move(body));
    }
    return joined;
}

}  // namespace rro
