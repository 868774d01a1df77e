#include "solver/factors/surfaces.h"

#include <map>

#include "format/parallel.h"

namespace rro {
namespace {

constexpr std::size_t kFewestFaces = 4;  // of a solid

/// Triangles of one instance that are alike in group and sidedness.
struct Bucket {
    std::uint32_t instance = 0, group = kNoGroup;
    bool front = false, back = false;  // whether the side exchanges
    std::vector<std::uint32_t> triangles;
    double area = 0;  // of one side
    std::vector<Polygon> polygons;
};

std::vector<Bucket> make_buckets(const Scene& scene, const SurfaceGroups& groups) {
    std::vector<Bucket> buckets;
    for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
        const Object& object = *scene.instances[i].object;
        std::map<std::tuple<std::uint32_t, bool, bool>, std::size_t> known;
        for (std::uint32_t t = 0; t < object.data().triangles.size(); ++t) {
            const bool front = object.front_face[t] != kNoFace, back = object.back_face[t] != kNoFace;
            if (!front && !back) continue;
            const std::uint32_t group = groups.of(scene, i, t);
            const auto [at, is_new] = known.emplace(std::tuple(group, front, back), buckets.size());
            if (is_new) buckets.push_back({i, group, front, back, {}, 0, {}});
            buckets[at->second].triangles.push_back(t);
        }
    }
    return buckets;
}

void fill(const Scene& scene, Bucket& bucket) {
    const Instance& instance = scene.instances[bucket.instance];
    for (const std::uint32_t t : bucket.triangles)
        bucket.area += length(area_vector(instance.world_corners(Face::make(t, Side::Front))));
    bucket.polygons = merged_polygons(instance, bucket.triangles);
    for (Polygon& polygon : bucket.polygons) add_rules(polygon);
}

std::vector<const Polygon*> pointers_to(const std::vector<Polygon>& polygons) {
    std::vector<const Polygon*> pointers;
    for (const Polygon& polygon : polygons) pointers.push_back(&polygon);
    return pointers;
}

/// Closed convex sets of bodies; tells each body which it is of.
std::vector<Solid> find_solids(std::vector<Body>& bodies) {
    std::vector<const Polygon*> polygons;
    for (const Body& body : bodies) polygons.push_back(&body.polygon);
    const std::vector<std::vector<std::uint32_t>> sets = joined_by_edges(polygons);
    std::vector<Solid> candidates(sets.size());
    parallel_for(sets.size(), 1, [&](std::size_t s) {
        if (sets[s].size() < kFewestFaces) return;
        std::vector<const Polygon*> faces;
        for (const std::uint32_t body : sets[s]) faces.push_back(polygons[body]);
        if (are_convex(faces)) candidates[s] = make_solid(faces);
    });
    std::vector<Solid> solids;
    for (std::size_t s = 0; s < sets.size(); ++s) {
        if (candidates[s].empty()) continue;
        for (const std::uint32_t body : sets[s]) bodies[body].solid = static_cast<std::uint32_t>(solids.size());
        solids.push_back(std::move(candidates[s]));
    }
    return solids;
}

}  // namespace

Surfaces gather_surfaces(const Scene& scene, const SurfaceGroups& groups, Sides sides) {
    std::vector<Bucket> buckets = make_buckets(scene, groups);
    parallel_for(buckets.size(), 1, [&](std::size_t b) { fill(scene, buckets[b]); });
    Surfaces surfaces;
    const std::size_t count = groups.names.size();
    surfaces.faces.resize(count);
    surfaces.triangles.resize(count);
    surfaces.area.assign(count, 0);
    std::vector<Body> bodies;
    for (Bucket& bucket : buckets) {
        const bool front = bucket.front, back = bucket.back && sides == Sides::Both;
        if (bucket.group != kNoGroup) surfaces.area[bucket.group] += bucket.area * (int{front} + int{back});
        if (bucket.group != kNoGroup)
            for (const std::uint32_t t : bucket.triangles) {
                auto& list = surfaces.triangles[bucket.group];
                if (front) list.push_back({bucket.instance, Face::make(t, Side::Front)});
                if (back) list.push_back({bucket.instance, Face::make(t, Side::Back)});
            }
        for (Polygon& polygon : bucket.polygons) {
            if (bucket.group != kNoGroup && front) surfaces.faces[bucket.group].push_back(polygon);
            if (bucket.group != kNoGroup && back) {
                surfaces.faces[bucket.group].push_back(reversed(polygon));
                add_rules(surfaces.faces[bucket.group].back());
            }
            polygon.coarse = polygon.fine = polygon.finest = {};
            bodies.push_back({std::move(polygon), bucket.group});
        }
    }
    surfaces.bodies = joined_bodies(bodies);
    surfaces.solids = find_solids(surfaces.bodies);
    surfaces.convex.assign(count, 0);
    parallel_for(count, 1, [&](std::size_t g) { surfaces.convex[g] = are_convex(pointers_to(surfaces.faces[g])); });
    return surfaces;
}

}  // namespace rro
