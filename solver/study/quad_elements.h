// Element quadtrees over the faces of a scene, one tree per face, for hierarchical radiosity.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "solver/scene/scene.h"
#include "solver/visibility/scene_rays.h"

namespace rro {

/// A face, or a quarter of a parent. Children are the corner parts 0, 1, 2 and the middle one, four in a row.
struct QuadElement {
    TriangleCorners corner;                     // world, counter-clockwise from the face's side
    std::array<std::array<float, 2>, 3> place;  // of the corners: barycentric, of ObjectData::corners(Face) 1 and 2
    Vec3 centre;
    double area = 0;                            // m^2
    float radius = 0;                           // m, about the centre
    std::uint32_t face = 0;                     // number among QuadElements::faces, which is also its root's number
    std::uint32_t parent = 0;                   // of a root: itself
    std::uint32_t children = 0;                 // the first one; 0 of a leaf
    std::uint32_t level = 0;                    // 0: the whole face
};

/// A face of the scene.
struct QuadFace {
    std::uint32_t instance = 0, face = 0;  // of the archive
    SceneTriangle triangle;
    Vec3 normal;                           // unit, world
};

/// Parents come before children: ascending loops push, descending ones pull.
struct QuadElements {
    std::vector<QuadFace> faces;        // of all instances, in their order
    std::vector<QuadElement> elements;  // begins with one root per face

    explicit QuadElements(const Scene& scene);

    const Vec3& normal(const QuadElement& e) const { return faces[e.face].normal; }
    /// Makes the four children of an element unless it has them.
    void subdivide(std::uint32_t id);
};

/// How two elements lie to one another's planes.
enum class Facing { None, Partly, Whole };
/// None: one of them lies behind the other's plane. Partly: a plane cuts the other.
Facing facing(const QuadElements& all, const QuadElement& a, const QuadElement& b);

}  // namespace rro
