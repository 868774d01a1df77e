#include "solver/effects/shape.h"

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

}  // namespace rro
