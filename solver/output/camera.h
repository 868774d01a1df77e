// The camera of a picture: the manifest's, or one chosen to see the scene.
#pragma once

#include "solver/scene/scene.h"
#include "solver/solution.h"
#include "solver/visibility/scene_rays.h"

namespace rro {

/// A pinhole: the picture's plane lies at distance 1.
struct Camera {
    Vec3 position;
    Vec3 forward, right, up;           // orthonormal
    double half_width = 1, half_height = 1;  // of the picture's plane

    /// Direction through a point of the picture, x from left, y from top, both in [0, 1]. Not unit.
    Vec3 direction(double x, double y) const {
        return forward + right * ((2 * x - 1) * half_width) + up * ((1 - 2 * y) * half_height);
    }
};

/// aspect   width / height. An up vector along the view is replaced by one that is not; a target at the position is
///          taken to lie along -z.
Camera make_camera(const CameraEntry& entry, double aspect);

/// A view that shows lit surfaces: from outside at an angle where that shows them, from a corner inside for closed rooms.
/// Candidates are compared by small pictures, the first best wins.
CameraEntry choose_camera(const Scene& scene, const Solution& solution, const SceneRays& rays, double aspect);

/// The factor for radiosity, W/m^2, that brings the log-average of a view to middle grey: that of a picture over pi, but
/// for the smaller number of rays and the faces' means taken as they are.
double view_exposure(const Scene& scene, const Solution& solution, const SceneRays& rays, const Camera& camera);

}  // namespace rro
