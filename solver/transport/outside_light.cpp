#include "solver/transport/outside_light.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "format/parallel.h"
#include "format/sample_points.h"
#include "solver/visibility/sampling.h"

namespace rro {

namespace {

constexpr std::size_t kGrain = 64;
// Points of a leaf: at first, and at most. Each asks one ray of each light.
constexpr std::uint32_t kFirstPoints = 16, kMostPoints = 1024;
// What they may leave undecided, as a part of the accuracy.
constexpr double kShare = 0.3;

double mean(const Vec3& v) { return (v.x + v.y + v.z) / 3; }

}  // namespace

struct OutsideLight::Estimate {
    Vec3 irradiance;
    double variance = 0;  // of the mean, channels' mean
    double partial = 0;
    std::uint64_t rays = 0;
};

/// Of what points of a surface receive; all but the first are means over channels.
struct OutsideLight::Sums {
    Vec3 light;
    double mean = 0, square = 0;
    double clear = 0, open = 0;  // with nothing in the way, and as it is
};

OutsideLight::OutsideLight(const Scene& scene, const Plan& plan, const LinkBuilder& builder, const SceneRays& rays,
                           const TransportOptions& options)
    : scene_(scene), builder_(builder), rays_of_scene_(rays), sky_(plan.on("sky") && scene.sky), sun_(plan.on("sun") && scene.sun),
      lights_(plan.on("lights") && !scene.lights.empty()), occlusion_(options.visibility != VisibilityMethod::None),
      seed_(options.seed), accuracy_(options.accuracy) {
    // What surrounds a scene shines through its medium from infinitely far.
    if (scene.medium && max_component(scene.medium->transmittance(std::numeric_limits<double>::infinity())) <= 0) sky_ = sun_ = false;
}

// What the points' light adds up to: the mean, its variance, and how much of a shadow's edge lies on the surface.
void OutsideLight::conclude(Estimate& e, double n, const Sums& s) const {
    const double m = s.mean / n;
    // Laplace's rule: points that agree may have missed an edge.
    const double v = s.clear > 0 ? (s.open / s.clear * n + 1) / (n + 2) : 1;
    const bool agree = !occlusion_ || s.open <= 0 || s.open >= s.clear;
    const double full = s.clear / n;
    const double unseen = occlusion_ && s.clear > 0 ? full * full * v * (1 - v) / n : 0.0;
    e.variance = kSobolGain * kSobolGain * (std::max(0.0, s.square / n - m * m) / n + (agree ? unseen : 0.0));
    e.irradiance = s.light / n;
    e.partial = agree ? 0.0 : full * full * v * (1 - v);
}

OutsideLight::Estimate OutsideLight::sample(const Nodes& nodes, std::uint32_t surface, double tolerance) const {
    const Node& node = nodes[surface];
    const TriangleCorners corners = nodes.corners(surface);
    const Vec3 normal = node.normal();
    const auto frame = frame_about(normal);
    const SceneTriangle on{node.instance, nodes.triangle_of(node)};
    // A convex or plane object hides nothing from its own fronts.
    const bool own_clear = scene_.instances[node.instance].data().meta.convex || nodes.instance(node.instance).planar;
    const std::array<std::uint32_t, 2> passed{own_clear ? node.instance : kNoInstance, kNoInstance};
    const double far = 2 * length(scene_.bounds.extent());
    const Vec3 behind_all = scene_.medium ? scene_.medium->transmittance(std::numeric_limits<double>::infinity()) : Vec3{1, 1, 1};
    const std::uint64_t seed = mix64(builder_.sample_key(surface) ^ mix64(seed_));

    Estimate e;
    Sums sums;
    const auto seen = [&](const Vec3& p, const Vec3& q, double light) {
        if (light <= 0) return 0.0;
        sums.clear += light;
        if (occlusion_) {
            ++e.rays;
            if (rays_of_scene_.occluded(p, q, on, {}, passed)) return 0.0;
        }
        sums.open += light;
        return 1.0;
    };
    // Towards what is infinitely far.
    const auto from_far = [&](const Vec3& p, const Vec3& direction, const Vec3& light) {
        const Vec3 arriving = hadamard(light, behind_all);
        return arriving * seen(p, p + direction * far, mean(arriving));
    };
    std::uint32_t count = 0;
    for (std::uint32_t end = kFirstPoints; count < kMostPoints; end *= 2) {
        for (; count < end; ++count) {
            const auto s = sobol4(count, seed);
            const auto b = square_to_triangle(double(s[0]), double(s[1]));
            const Vec3 p = triangle_point(corners, b[0], b[1]);
            Vec3 light;
            if (sky() && scene_.sky->is_peaked()) {  // balance heuristic of choices by brightness and by cosine, one each
                const auto choice = scene_.sky->sample(double(s[2]), double(s[3]));
                const double cosine = dot(normal, choice.from);
                if (cosine > 0)
                    light += from_far(p, choice.from, choice.radiance * (cosine / (choice.density + cosine / std::numbers::pi)));
            }
            if (sky()) {
                const Vec3 local = square_to_cosine_hemisphere(double(s[2]), double(s[3]));
                const Vec3 d = frame[0] * local.x + frame[1] * local.y + normal * local.z;
                const double weight = scene_.sky->is_peaked() ? local.z / (scene_.sky->density(d) + local.z / std::numbers::pi)
                                                              : std::numbers::pi;
                light += from_far(p, d, scene_.sky->radiance(d) * weight);
            }
            if (sun()) {
                const auto part = scene_.sun->sample(double(s[2]), double(s[3]));
                light += from_far(p, part.from, part.irradiance * std::max(0.0, dot(normal, part.from)));
            }
            if (lights())
                for (const PointLight& lamp : scene_.lights) {
                    const Vec3 to = lamp.position - p;
                    const double d2 = length2(to), d = std::sqrt(d2), cosine = d > 0 ? dot(normal, to) / d : 0;
                    if (cosine <= 0) continue;
                    Vec3 arriving = lamp.intensity_towards(to * (-1 / d)) * (cosine / d2);
                    if (scene_.medium) arriving = hadamard(arriving, scene_.medium->transmittance(d));
                    light += arriving * seen(p, lamp.position, mean(arriving));
                }
            sums.light += light;
            sums.mean += mean(light);
            sums.square += mean(light) * mean(light);
        }
        conclude(e, count, sums);
        if (sums.clear <= 0 || std::sqrt(e.variance) <= std::max(tolerance, kShare * accuracy_ * (sums.mean / count))) break;
    }
    return e;
}

void OutsideLight::take_over(const OutsideLight& from, const std::vector<std::uint32_t>& node) {
    irradiance_.resize(from.irradiance_.size());
    error_.resize(from.error_.size(), 0);
    partial_.resize(from.partial_.size(), 0);
    typical_ = from.typical_;
    for (std::size_t n = 0; n < from.irradiance_.size(); ++n) {
        irradiance_[node[n]] = from.irradiance_[n];
        error_[node[n]] = from.error_[n];
        partial_[node[n]] = from.partial_[n];
    }
}

void OutsideLight::find(const Nodes& nodes) {
    if (!any()) return;
    const auto first = static_cast<std::uint32_t>(irradiance_.size());
    irradiance_.resize(nodes.size());
    error_.resize(nodes.size(), 0);
    partial_.resize(nodes.size(), 0);
    std::vector<std::uint32_t> leaves;
    for (std::uint32_t id = first; id < nodes.size(); ++id)
        if (nodes[id].kind == NodeKind::Surface && nodes[id].child_count == 0 && nodes[id].area > 0) leaves.push_back(id);
    std::vector<std::uint64_t> rays(leaves.size(), 0);
    const auto pass = [&](double tolerance) {
        parallel_for(leaves.size(), kGrain, [&](std::size_t k) {
            const std::uint32_t id = leaves[k];
            const Estimate e = sample(nodes, id, tolerance);
            irradiance_[id] = to_float(e.irradiance);
            error_[id] = static_cast<float>(std::sqrt(e.variance));
            partial_[id] = static_cast<float>(e.partial);
            rays[k] += e.rays;
        });
    };
    if (typical_ == 0) {  // a first look
        pass(std::numeric_limits<double>::infinity());
        double square = 0, area = 0;
        for (const std::uint32_t id : leaves) {
            square += nodes[id].area * std::pow(mean(to_double(irradiance_[id])), 2);
            area += nodes[id].area;
        }
        typical_ = area > 0 ? std::sqrt(square / area) : 0;
    }
    if (typical_ > 0) pass(kShare * accuracy_ * typical_);
    for (const std::uint64_t r : rays) rays_ += r;
}

std::vector<std::uint32_t> OutsideLight::shadow_edges(const Nodes& nodes, const Guide& guide) const {
    std::vector<std::uint32_t> out;
    for (std::uint32_t id = 0; id < partial_.size(); ++id) {
        const Node& n = nodes[id];
        if (partial_[id] <= 0 || n.child_count > 0 || !builder_.divisible(n)) continue;
        const double rho = mean(to_double(scene_.instances[n.instance].reflectance[nodes.patch_of(n)]));
        const double harm = n.area * rho * rho * double(partial_[id]) * kShadowWithinFace * kShadowWithinFace;
        if (harm > guide.limit(nodes, id)) out.push_back(id);
    }
    return out;
}

}  // namespace rro
