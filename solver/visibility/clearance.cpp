#include "solver/visibility/clearance.h"

#include <array>
#include <cmath>

#include "format/layout.h"
#include "solver/visibility/box_hull.h"

namespace rro {
namespace {

// Boxes that are looked at: about as many as take the time of a few rays.
constexpr int kMostBoxes = 48;

// Boxes grow by this share of the coordinates (as those of instances for rays), so that lines which touch them meet them.
constexpr double kMargin = 1e-7;

// What lies in the plane of an end is behind it; of the coordinates. Well above the rounding of double.
constexpr double kInPlane = 1e-12;

double largest_coordinate(const Box3& b) {
    double most = 0;
    for (int i = 0; i < 3; ++i) most = std::max({most, std::abs(b.lo[i]), std::abs(b.hi[i])});
    return most;
}

/// The side of an end that its lines leave to, in another frame.
struct Front {
    Vec3 normal;
    double height, scale;

    Front(const ShaftEnd& end, const Affine3& to_world)
        : normal(to_world.linear.transposed() * end.front),
          height(end.height - dot(end.front, to_world.translation)),
          scale(length(normal)) {}

    bool hides(const Box3& box, double slack) const {
        if (scale == 0) return false;
        const double top = normal.x * (normal.x > 0 ? box.hi.x : box.lo.x) + normal.y * (normal.y > 0 ? box.hi.y : box.lo.y) +
                           normal.z * (normal.z > 0 ? box.hi.z : box.lo.z);
        return top <= height + slack * scale;
    }
};

}  // namespace

bool certainly_clear(const Shaft& shaft, const Instance& instance) {
    const ObjectData& object = instance.data();
    const Affine3 to_local = Affine3{Mat3{}, -object.origin} * instance.to_local;
    const Affine3 to_world = instance.to_world * Affine3{Mat3{}, object.origin};
    const Box3 a = to_local.box(shaft.a.box), b = to_local.box(shaft.b.box);
    const BoxHull hull(a, b);
    const Front front_a(shaft.a, to_world), front_b(shaft.b, to_world);
    const double size = std::max(largest_coordinate(a), largest_coordinate(b));
    std::array<std::uint32_t, layout::kMaxTreeDepth + 1> stack;
    std::size_t waiting = 0;
    stack[waiting++] = 0;
    for (int looked_at = 0; waiting > 0; ++looked_at) {
        if (looked_at == kMostBoxes) return false;
        const std::uint32_t at = stack[--waiting];
        const Cluster& cluster = object.clusters[at];
        Box3 box{to_double(cluster.lo), to_double(cluster.hi)};
        const double coordinates = std::max(size, largest_coordinate(box)), margin = kMargin * coordinates;
        if (front_a.hides(box, kInPlane * coordinates) || front_b.hides(box, kInPlane * coordinates)) continue;
        box.lo -= {margin, margin, margin};
        box.hi += {margin, margin, margin};
        if (hull.misses(box)) continue;
        if (cluster.right_child == 0) return false;
        stack[waiting++] = cluster.right_child;
        stack[waiting++] = at + 1;
    }
    return true;
}

}  // namespace rro
