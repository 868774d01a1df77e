#include "solver/study/quad_elements.h"

#include <algorithm>

namespace rro {
namespace {

// Corners this near to a plane, relative to the sizes, lie on it: neighbours in one wall do not see each other.
constexpr double kOnPlane = 1e-6;

void measure(QuadElement& e) {
    e.centre = (e.corner[0] + e.corner[1] + e.corner[2]) / 3.0;
    double squared = 0;
    for (const Vec3& p : e.corner) squared = std::max(squared, length2(p - e.centre));
    e.radius = static_cast<float>(std::sqrt(squared));
}

/// Lowest and highest corner of `e` above the plane through `on` with a unit normal.
std::array<double, 2> heights(const QuadElement& e, const Vec3& on, const Vec3& normal) {
    const double a = dot(normal, e.corner[0] - on), b = dot(normal, e.corner[1] - on), c = dot(normal, e.corner[2] - on);
    return {std::min(a, std::min(b, c)), std::max(a, std::max(b, c))};
}

}  // namespace

QuadElements::QuadElements(const Scene& scene) {
    for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
        const Instance& instance = scene.instances[i];
        for (std::uint32_t f = 0; f < instance.data().faces.size(); ++f) {
            const Face face = instance.data().faces[f];
            QuadElement root;
            root.corner = instance.world_corners(face);
            root.place = {{{0, 0}, {1, 0}, {0, 1}}};
            if (instance.determinant_sign < 0) std::swap(root.place[1], root.place[2]);
            const Vec3 normal = area_vector(root.corner);
            root.area = length(normal);
            root.face = root.parent = static_cast<std::uint32_t>(elements.size());
            measure(root);
            faces.push_back({i, f, {i, face.triangle()}, normalised(normal)});
            elements.push_back(root);
        }
    }
}

void QuadElements::subdivide(std::uint32_t id) {
    if (elements[id].children != 0) return;
    const auto first = static_cast<std::uint32_t>(elements.size());
    elements[id].children = first;
    const QuadElement whole = elements[id];
    std::array<Vec3, 3> middle;  // of the edge opposite to each corner
    std::array<std::array<float, 2>, 3> place;
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
        middle[k] = 0.5 * (whole.corner[i] + whole.corner[j]);
        place[k] = {0.5f * (whole.place[i][0] + whole.place[j][0]), 0.5f * (whole.place[i][1] + whole.place[j][1])};
    }
    for (std::size_t k = 0; k < 4; ++k) {
        QuadElement part;
        part.corner = middle;
        part.place = place;
        if (k < 3) {  // the corner stays, the other two are middles, in the same turn
            const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
            part.corner[k] = whole.corner[k], part.corner[i] = middle[j], part.corner[j] = middle[i];
            part.place[k] = whole.place[k], part.place[i] = place[j], part.place[j] = place[i];
        }
        part.area = 0.25 * whole.area;
        part.face = whole.face;
        part.parent = id;
        part.level = whole.level + 1;
        measure(part);
        elements.push_back(part);
    }
}

Facing facing(const QuadElements& all, const QuadElement& a, const QuadElement& b) {
    const double tiny = kOnPlane * (double(a.radius) + double(b.radius));
    const auto from_a = heights(b, a.centre, all.normal(a));
    if (from_a[1] <= tiny) return Facing::None;
    const auto from_b = heights(a, b.centre, all.normal(b));
    if (from_b[1] <= tiny) return Facing::None;
    return from_a[0] >= -tiny && from_b[0] >= -tiny ? Facing::Whole : Facing::Partly;
}

}  // namespace rro
