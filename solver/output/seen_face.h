// What a camera's ray meets.
#pragma once

#include "solver/scene/scene.h"
#include "solver/visibility/scene_rays.h"

namespace rro {

/// The face that a ray meets first, and where. instance is kNoInstance where there is nothing; face is kNoFace on the
/// black back of a one-sided surface.
struct SeenFace {
    std::uint32_t instance = kNoInstance;
    std::uint32_t face = kNoFace;
    double b1 = 0, b2 = 0;  // barycentric, in the face's own winding
    double t = 0;           // along the ray's direction
};

/// origin in metres, direction of any length; both in the world.
inline SeenFace seen_face(const Scene& scene, const SceneRays& rays, const Vec3& origin, const Vec3& direction) {
    const SceneHit hit = rays.first_hit(origin, direction);
    if (hit.instance == kNoInstance) return {};
    const Object& object = *scene.instances[hit.instance].object;
    if (hit.side == Side::Front) return {hit.instance, object.front_face[hit.triangle], hit.b1, hit.b2, hit.t};
    return {hit.instance, object.back_face[hit.triangle], hit.b2, hit.b1, hit.t};  // a back runs the other way round
}

}  // namespace rro
