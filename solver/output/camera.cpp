#include "solver/output/camera.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "format/parallel.h"
#include "solver/output/exposure.h"
#include "solver/output/seen_face.h"

namespace rro {
namespace {

constexpr double kOutsideFov = 36, kInsideFov = 62;  // degrees: a portrait lens, a wide one
constexpr double kMargin = 1.04;                     // air about the scene, seen from outside
constexpr int kScoreColumns = 32, kScoreRows = 20;   // the small pictures
constexpr int kExposureColumns = 240, kExposureRows = 135;

/// An inside view is for rooms: walls nearly all round. They cover more of the picture than anything seen from outside,
/// so it has to be this much better.
constexpr double kInsideWorth = 0.2, kInsideEmpty = 0.15;

/// Surfaces nearer than this share of the scene's diagonal fill the picture with nothing.
constexpr double kTooNear = 0.08;

struct Candidate {
    CameraEntry camera;
    double worth = 1;
    double may_be_empty = 1;  // share of the picture
};

Vec3 towards(double azimuth_degrees, double elevation_degrees) {
    constexpr double radians = std::numbers::pi / 180;
    const double a = azimuth_degrees * radians, e = elevation_degrees * radians;
    return {std::sin(a) * std::cos(e), std::sin(e), std::cos(a) * std::cos(e)};
}

/// The nearest place on a line through the box's centre from which the whole box is in the picture.
CameraEntry outside_view(const Box3& box, const Vec3& back, double aspect) {
    CameraEntry entry{box.centre() + back, box.centre(), {0, 1, 0}, kOutsideFov, {}};
    const Camera probe = make_camera(entry, aspect);
    double distance = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const Vec3 p{corner & 1 ? box.hi.x : box.lo.x, corner & 2 ? box.hi.y : box.lo.y,
                     corner & 4 ? box.hi.z : box.lo.z};
        const Vec3 d = p - box.centre();
        const double sideways = std::max(std::abs(dot(d, probe.right)) / probe.half_width,
                                         std::abs(dot(d, probe.up)) / probe.half_height);
        distance = std::max(distance, sideways - dot(d, probe.forward));
    }
    entry.position = entry.target + back * (kMargin * distance);
    return entry;
}

CameraEntry inside_view(const Box3& box, double x, double z) {
    const Vec3 half = 0.5 * box.extent();
    const Vec3 c = box.centre();
    return {c + Vec3{x * half.x, 0.2 * half.y, z * half.z}, c - Vec3{0.3 * x * half.x, 0.15 * half.y, 0.3 * z * half.z},
            {0, 1, 0}, kInsideFov, {}};
}

std::vector<Candidate> candidates(const Box3& box, double aspect) {
    std::vector<Candidate> out;
    // Seen at an angle shapes read better than straight on, so a straight view must show a little more.
    for (const double azimuth : {35.0, -35.0, 145.0, -145.0})
        for (const double elevation : {22.0, 50.0})
            out.push_back({outside_view(box, towards(azimuth, elevation), aspect), elevation < 30 ? 1.0 : 0.8, 1.0});
    for (const double azimuth : {0.0, 180.0, 90.0, -90.0})
        out.push_back({outside_view(box, towards(azimuth, 2), aspect), 0.85, 1.0});
    for (const double x : {0.86, -0.86})
        for (const double z : {0.86, -0.86}) out.push_back({inside_view(box, x, z), kInsideWorth, kInsideEmpty});
    for (const double z : {0.9, -0.9}) out.push_back({inside_view(box, 0, z), kInsideWorth, kInsideEmpty});
    for (const double x : {0.9, -0.9}) out.push_back({inside_view(box, x, 0), kInsideWorth, kInsideEmpty});
    return out;
}

/// Visits the rays of a small picture: visit(what is seen).
template <class Visit>
void look(const Scene& scene, const SceneRays& rays, const Camera& camera, int columns, int rows, const Visit& visit) {
    for (int row = 0; row < rows; ++row)
        for (int column = 0; column < columns; ++column) {
            const Vec3 d = normalised(camera.direction((column + 0.5) / columns, (row + 0.5) / rows));
            visit(seen_face(scene, rays, camera.position, d));
        }
}

double luminance_of(const Solution& solution, const SeenFace& seen) {
    return luminance(to_double(solution.instances[seen.instance].radiosity[seen.face]));
}

/// How lit the surfaces of a view are, by its mean, nothing above typical counting for more; 0 where more of it is
/// empty than may be.
double score(const Scene& scene, const Solution& solution, const SceneRays& rays, const Candidate& candidate,
             double aspect, double typical) {
    const double near = kTooNear * length(scene.bounds.extent());
    double sum = 0;
    int empty = 0;
    look(scene, rays, make_camera(candidate.camera, aspect), kScoreColumns, kScoreRows, [&](const SeenFace& seen) {
        if (seen.instance == kNoInstance) ++empty;
        if (seen.face == kNoFace) return;
        sum += std::min(1.0, luminance_of(solution, seen) / typical) * std::min(1.0, seen.t / near);
    });
    constexpr double rays_in_all = kScoreRows * kScoreColumns;
    return empty > candidate.may_be_empty * rays_in_all ? 0.0 : candidate.worth * sum / rays_in_all;
}

}  // namespace

Camera make_camera(const CameraEntry& entry, double aspect) {
    Camera camera;
    camera.position = entry.position;
    camera.forward = normalised(entry.target - entry.position);
    if (length2(camera.forward) == 0) camera.forward = {0, 0, -1};
    camera.right = cross(camera.forward, normalised(entry.up));
    constexpr double parallel = 1e-6;  // sine of the angle below which up says nothing
    if (length(camera.right) < parallel)
        camera.right = cross(camera.forward, std::abs(camera.forward.z) < 0.9 ? Vec3{0, 0, -1} : Vec3{0, 1, 0});
    camera.right = normalised(camera.right);
    camera.up = cross(camera.right, camera.forward);
    camera.half_height = std::tan(0.5 * entry.vertical_fov * std::numbers::pi / 180);
    camera.half_width = camera.half_height * aspect;
    return camera;
}

CameraEntry choose_camera(const Scene& scene, const Solution& solution, const SceneRays& rays, double aspect) {
    if (scene.bounds.empty()) return {};
    const std::vector<Candidate> views = candidates(scene.bounds, aspect);
    const double typical = kMiddleGrey / surface_exposure(scene, solution);
    std::vector<double> worth(views.size());
    parallel_for(views.size(), 1,
                 [&](std::size_t i) { worth[i] = score(scene, solution, rays, views[i], aspect, typical); });
    return views[static_cast<std::size_t>(std::max_element(worth.begin(), worth.end()) - worth.begin())].camera;
}

double view_exposure(const Scene& scene, const Solution& solution, const SceneRays& rays, const Camera& camera) {
    std::vector<WeightedLuminance> samples;
    look(scene, rays, camera, kExposureColumns, kExposureRows, [&](const SeenFace& seen) {
        if (seen.face != kNoFace) samples.push_back({luminance_of(solution, seen), 1.0});
    });
    return automatic_exposure(samples);
}

}  // namespace rro
