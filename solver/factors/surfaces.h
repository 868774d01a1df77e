// A scene as the factors see it: convex polygons that exchange and block, each of at most one group.
#pragma once

#include <cstdint>
#include <vector>

#include "solver/factors/polygon.h"
#include "solver/factors/solid.h"
#include "solver/factors/surface_groups.h"

namespace rro {

/// In place of a solid's number: none.
inline constexpr std::uint32_t kNoSolid = 0xffffffffu;

/// What blocks: sides that look the same way from one plane, of whichever groups they are.
struct Body {
    Polygon polygon;                 // its front; no rules
    std::uint32_t group = kNoGroup;  // of all of it, or none
    std::uint32_t solid = kNoSolid;  // that it is a face of, or none
};

/// A side of a triangle that exchanges, to draw points from.
struct GroupTriangle {
    std::uint32_t instance = 0;
    Face face;
};

/// A scene as view factors take it; G groups.
struct Surfaces {
    std::vector<Body> bodies;                   // every surface of the scene
    std::vector<std::vector<Polygon>> faces;    // [G] sides that exchange, by group
    std::vector<std::vector<GroupTriangle>> triangles;  // [G] the same, as triangles
    std::vector<double> area;         // [G] m^2, sum over the triangles' sides
    std::vector<Solid> solids;        // closed convex sets of bodies, of whichever groups
    std::vector<std::uint8_t> convex; // [G] nothing of the group stands before one of its faces
};

/// Triangles of a group that touch in one plane become one polygon where it is convex, so that a floor of thousands of
/// triangles is one surface.
///
/// departs  corners off the common plane by rounding of the archive's single precision are taken to lie on it
Surfaces gather_surfaces(const Scene& scene, const SurfaceGroups& groups, Sides sides);

/// Convex polygons that cover an instance's triangles, given by number; all of one group and sidedness.
std::vector<Polygon> merged_polygons(const Instance& instance, const std::vector<std::uint32_t>& triangles);

/// Bodies of any instances that touch in one plane, looking the same way, as one.
std::vector<Body> joined_bodies(const std::vector<Body>& bodies);

}  // namespace rro
