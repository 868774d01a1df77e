#include "solver/effects/shape.h"

#include <array>
#include <cmath>
#include <set>

namespace rro {
namespace {

// Stored coordinates are float32: a point may lie off its plane by a few units in their last place.
constexpr double kRounding = 4 * 0x1p-24;

}  // namespace

bool is_flat(const ObjectData& object) {
    Vec3 largest;  // area vector of the largest triangle: the best known normal
    Vec3 on_plane;
    for (std::uint32_t t = 0; t < object.triangles.size(); ++t) {
        const TriangleCorners c = object.corners(t);
        if (const Vec3 a = area_vector(c); length2(a) > length2(largest)) {
            largest = a;
            on_plane = c[0];
        }
    }
    const Vec3 normal = normalised(largest);
    for (std::uint32_t t = 0; t < object.triangles.size(); ++t)
        for (const Vec3& corner : object.corners(t)) {
            const Vec3 stored = corner - object.origin;
            const double size =
                std::abs(stored.x) + std::abs(stored.y) + std::abs(stored.z) + length(corner - on_plane);
            if (std::abs(dot(normal, corner - on_plane)) > kRounding * size) return false;
        }
    return true;
}

bool sees_nothing_of_itself(const ObjectData& object) {
    return object.meta.convex || is_flat(object);
}

bool is_curved(const ObjectData& object) {
    constexpr double kSteps = 8;           // of a normal's coordinate from 0 to 1
    constexpr std::size_t kManyWays = 60;  // more than boxes and boards have, at any angle of a few of them
    std::set<std::array<int, 3>> ways;
    for (std::uint32_t t = 0; t < object.triangles.size() && ways.size() < kManyWays; ++t) {
        const Vec3 n = normalised(area_vector(object.corners(t))) * kSteps;
        ways.insert({static_cast<int>(std::lround(n.x)), static_cast<int>(std::lround(n.y)), static_cast<int>(std::lround(n.z))});
    }
    return ways.size() >= kManyWays;
}

double openness(const ObjectData& object) {
    Box3 box;
    for (std::uint32_t t = 0; t < object.triangles.size(); ++t)
        for (const Vec3& corner : object.corners(t)) box.add(corner);
    Vec3 sum;
    double area = 0, volume = 0;
    for (const Face face : object.faces) {
        if (face.side() != Side::Front) continue;
        const TriangleCorners c = object.corners(face);
        sum += area_vector(c);
        area += length(area_vector(c));
        volume += dot(area_vector(c), c[0] - box.centre());
    }
    return area > 0 && volume < 0 ? length(sum) / area : 1;
}

}  // namespace rro
