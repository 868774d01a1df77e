#include "solver/factors/surfaces.h"

#include <map>

#include "format/parallel.h"

namespace rro {
namespace {

constexpr std::size_t kLargestConvexTest = 20'000;  // faces: each is compared with each

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

bool is_convex(const std::vector<Polygon>& faces) {
    if (faces.size() > kLargestConvexTest) return false;
    for (const Polygon& a : faces)
        for (const Polygon& b : faces) {
            const double rounding = std::max(a.rounding, b.rounding);
            if (a.height(b.centre) > rounding) return false;
            for (const Vec3& corner : b.corners)
                if (a.height(corner) > rounding) return false;
        }
    return true;
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
    surfaces.convex.assign(count, 0);
    surfaces.solids.resize(count);
    parallel_for(count, 1, [&](std::size_t g) {
        surfaces.convex[g] = is_convex(surfaces.faces[g]);
        if (surfaces.convex[g]) surfaces.solids[g] = make_solid(surfaces.faces[g]);
    });
    return surfaces;
}

}  // namespace rro
