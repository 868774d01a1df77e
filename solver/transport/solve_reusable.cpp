// The solve, in order: nodes, then rounds of refining links under the light known so far and iterating that light.
#include <chrono>

#include "solver/transport/gather.h"
#include "solver/transport/outside_light.h"
#include "solver/transport/refine.h"
#include "solver/transport/transport.h"

namespace rro {

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

constexpr int kMostRounds = 9;
constexpr int kMostSweeps = 1000;
// Divisions of one face at the edges of shadows from sky, sun and lamps, before any link is made.
constexpr int kShadowLevels = 6;
// Light that only steers refinement may be this part of the accuracy away from converged.
constexpr double kSteering = 0.3;
// Light of the first rounds only steers refinement: direct light, one bounce, then converged.
constexpr int kDirectRounds = 1;
// How much of the squared error one link may bring at first; later rounds learn it from the estimate.
constexpr double kFirstShare = 1.0 / 1000;
constexpr double kCoarseAccuracy = 0.3;
// An instance by itself may be this many times worse than the scene.
constexpr double kWorstInstance = 2;
constexpr int kInstanceRounds = 1;  // for them alone
// Instances below this share of the reflected power do not count by themselves (contract: accuracy).
constexpr double kCountingShare = 1e-3;
// Where a round of refinement shows that errors were larger than estimated, later estimates are raised by up to this.
constexpr double kMostDoubt = 4;

struct Residual {
    int sweeps = 0;
    double relative = 0;  // ||r|| / ((1 - q) ||R||), q the ratio of the last two sweeps' ||r||
};

// Where light returns so nearly whole, and the share q of the last change that each sweep brings has settled to this part of
// 1 - q, all changes still to come are added at once: q / (1 - q) times the last one.
constexpr double kSlow = 0.9, kSettled = 0.1;

// Sweeps until the remaining error is below `goal` of R.
template <int C>
Residual iterate(LightField<C>& field, double goal, double largest_reflectance, int most) {
    Residual out;
    double last = 0, q = largest_reflectance, slowest = 0;
    const double most_q = std::clamp(largest_reflectance, 0.9999, 1 - 1e-7);  // single precision tells no more from 1
    int plain = 0;  // sweeps that followed one another
    for (out.sweeps = 1; out.sweeps <= most; ++out.sweeps) {
        const double r = field.sweep();
        const double norm = field.reflected_norm(), before = q;
        if (++plain >= 3 && last > 0) q = std::clamp(r / last, slowest, most_q);
        last = r;
        out.relative = norm > 0 ? r / ((1 - q) * norm) : 0;
        if (out.relative <= goal) break;
        if (plain < 4 || q < kSlow || std::abs(q - before) > kSettled * (1 - q)) continue;
        field.advance(q / (1 - q));
        slowest = q;
        plain = 0;
    }
    out.sweeps = std::min(out.sweeps, most);
    return out;
}

// What later bounces make of an error in the light of one, where errors agree in sign: they grow like the light itself.
/// Sum of A R^2 (channels' mean) of the light from outside that leaves reflect, W^2/m^2.
double reflected_once(const Nodes& nodes, const Scene& scene, const std::vector<Rgb>& irradiance) {
    double sum = 0;
    for (std::uint32_t id = 0; id < irradiance.size(); ++id) {
        const Node& n = nodes[id];
        if (n.kind != NodeKind::Surface || n.child_count > 0) continue;
        const Vec3 rho = to_double(scene.instances[n.instance].reflectance[nodes.patch_of(n)]);
        sum += n.area * length2(hadamard(rho, to_double(irradiance[id]))) / 3;
    }
    return sum;
}

template <int C>
double amplification(const Scene& scene, const Nodes& nodes, const LightField<C>& field, const OutsideLight& outside) {
    double all = 0, emitted = 0;
    if (outside.any())
        for (std::uint32_t id = 0; id < nodes.size(); ++id) {
            if (nodes[id].kind != NodeKind::Surface || nodes[id].child_count > 0) continue;
            const Vec3 e = to_double(outside.irradiance()[id]);
            for (std::size_t c = 0; c < C; ++c)
                emitted += nodes[id].area * double(field.reflectance(id, c)) * (c == 0 ? e.x : c == 1 ? e.y : e.z);
        }
    for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
        const InstanceNodes& in = nodes.instance(i);
        for (std::uint32_t f = 0; f < scene.instances[i].data().faces.size(); ++f)
            for (std::size_t c = 0; c < C; ++c) {
                const std::uint32_t id = in.first_face + f;
                all += nodes[id].area * double(field.radiosity()[id * C + c]);
                emitted += nodes[id].area * double(field.exitance(id, c));
            }
    }
    return emitted > 0 ? std::max(1.0, all / emitted) : 1.0;
}

/// What rounds of refinement tell about the estimate: the light changes by about what it was wrong by before.
class HindSight {
  public:
    /// Raises the estimate of every instance whose last one was too low, by as much.
    template <int C>
    void correct(ErrorEstimate& estimate, const Scene& scene, const Nodes& nodes, const LightField<C>& field) {
        std::vector<float> reflected;
        std::vector<double> change, square;
        std::size_t k = 0;
        for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
            const InstanceNodes& in = nodes.instance(i);
            double moved = 0, all = 0;
            for (std::uint32_t f = 0; f < scene.instances[i].data().faces.size(); ++f)
                for (std::size_t c = 0; c < C; ++c, ++k) {
                    const std::uint32_t id = in.first_face + f;
                    const double r = double(field.reflectance(id, c)) * double(field.irradiance()[id * C + c]);
                    reflected.push_back(static_cast<float>(r));
                    if (!reflected_.empty()) moved += nodes[id].area * std::pow(r - double(reflected_[k]), 2);
                    all += nodes[id].area * r * r;
                }
            change.push_back(all > 0 ? std::sqrt(moved / all) : 0);
        }
        reflected_ = std::move(reflected);
        const std::vector<double> before = std::exchange(estimate_, estimate.of_instance);
        if (before.empty()) return;
        double sum = 0;
        for (std::size_t i = 0; i < change.size(); ++i) {
            if (before[i] > 0) estimate.of_instance[i] *= std::clamp(change[i] / before[i], 1.0, kMostDoubt);
            sum += estimate.weight[i] * std::pow(estimate.of_instance[i], 2);
        }
        estimate.whole = std::sqrt(sum);
    }

  private:
    std::vector<float> reflected_;  // [faces * C] of all instances, as the last round left it
    std::vector<double> estimate_;  // [instances] of the last round, as the links gave it
};

template <int C>
void store(const Scene& scene, const Nodes& nodes, const LightField<C>& field, const std::vector<Rgb>& outside,
           Solution& solution) {
    const auto rgb = [](const std::vector<float>& v, std::size_t id) {
        return C == 1 ? Rgb{v[id], v[id], v[id]} : Rgb{v[id * C], v[id * C + 1 % C], v[id * C + 2 % C]};
    };
    for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
        const InstanceNodes& in = nodes.instance(i);
        const auto faces = static_cast<std::uint32_t>(scene.instances[i].data().faces.size());
        InstanceSolution& out = solution.instances.emplace_back();
        for (std::uint32_t f = 0; f < faces; ++f) {
            const std::uint32_t id = in.first_face + f;
            out.radiosity.push_back(rgb(field.radiosity(), id));
            out.irradiance.push_back(rgb(field.irradiance(), id));
            if (nodes[id].child_count == 0) ++solution.elements;
            for (std::size_t c = 0; c < 3; ++c) {
                const std::size_t k = C == 1 ? 0 : c;
                const auto ch = static_cast<int>(c);
                const double e = double(field.irradiance()[id * C + k]) * nodes[id].area;
                solution.energy.emitted[ch] += double(field.exitance(id, k)) * nodes[id].area;
                solution.energy.absorbed[ch] += (1 - double(field.reflectance(id, k)) - double(field.transmittance(id, k))) * e;
            }
        }
        for (const std::uint32_t id : in.elements)
            if (nodes[id].child_count == 0)
                out.elements.push_back({nodes.face_of(nodes[id]), nodes.element_corners(id), rgb(field.radiosity(), id),
                                        rgb(field.irradiance(), id)});
        solution.elements += out.elements.size();
        std::stable_sort(out.elements.begin(), out.elements.end(),
                         [](const Element& x, const Element& y) { return x.face < y.face; });
    }
    for (std::uint32_t id = 0; id < outside.size(); ++id)
        if (nodes[id].kind == NodeKind::Surface && nodes[id].child_count == 0)
            solution.energy.emitted += to_double(outside[id]) * nodes[id].area;
    solution.energy.escaped = solution.energy.emitted - solution.energy.absorbed;
}

template <int C>
Result<Solution> solve(const Scene& scene, const Plan& plan, const TransportOptions& options, const Progress& progress) {
    Solution solution;
    solution.accuracy = options.accuracy;
    const auto tell = [&](std::string_view phase, double done) {
        if (progress) progress(phase, done);
    };

    auto start = Clock::now();
    Nodes nodes(scene);
    const EndAreas areas(nodes);
    const SceneRays rays(scene);
    const LinkBuilder builder(nodes, areas, rays, options);
    OutsideLight outside(scene, plan, builder, rays, options);
    LightField<C> field(nodes, areas);
    LinkSet set(nodes, plan.on("self"));
    const bool bounces = plan.on("interreflection");
    const bool closed = plan.on("self") && is_closed_shell(scene) && !scene.medium;  // a medium takes from every row
    Guide guide;
    guide.share.assign(scene.instances.size(), std::pow(std::max(kCoarseAccuracy, options.accuracy), 2) * kFirstShare);
    guide.scene_share = guide.share.empty() ? 0 : guide.share[0];
    solution.seconds.links += seconds_since(start);

    double largest_reflectance = 0, emitted = 0, area = 0;
    for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
        const InstanceNodes& in = nodes.instance(i);
        for (std::uint32_t f = 0; f < scene.instances[i].data().faces.size(); ++f)
            for (std::size_t c = 0; c < C; ++c) {
                const double sent_on = double(field.reflectance(in.first_face + f, c)) + double(field.transmittance(in.first_face + f, c));
                largest_reflectance = std::max(largest_reflectance, sent_on);
                emitted += double(field.exitance(in.first_face + f, c)) * nodes[in.first_face + f].area / C;
            }
        area += nodes[nodes.root(i)].area;
    }

    // Light from outside first: it is a source like emitters, and its shadows divide faces.
    start = Clock::now();
    double entering = 0;
    if (outside.any()) {
        tell("sky, sun and lamps", 0);
        outside.find(nodes);
        for (int level = 0; level < kShadowLevels; ++level) {
            guide.reflected = reflected_once(nodes, scene, outside.irradiance());
            const std::vector<std::uint32_t> edges = outside.shadow_edges(nodes, guide);
            if (edges.empty()) break;
            for (const std::uint32_t id : edges) nodes.subdivide(id);
            outside.find(nodes);
        }
        entering = reflected_once(nodes, scene, outside.irradiance());
        field.grow();
        field.set_outside(outside.irradiance());
        field.begin();
    }
    guide.error.assign(nodes.size(), 0.0f);
    solution.seconds.outside = seconds_since(start);

    const double allowed = 0.99 * options.accuracy;  // a tenth is left to the iteration, added by squares
    double error = 0;
    int settled = 0;
    Residual residual;
    HindSight hind_sight;
    for (int round = 0; round < kMostRounds; ++round) {
        tell("links", double(round) / kMostRounds);
        start = Clock::now();
        if (round == 0) {
            field.fill(guide);
            // Before any light has been gathered: all emitted power spread evenly and reflected once.
            if (area > 0) guide.reflected = emitted * emitted / area * 0.25 + entering;
        }
        const std::size_t before = nodes.size(), links_before = set.links.size();
        const std::uint64_t rays_before = set.rays;
        refine(set, nodes, guide, builder);
        field.grow();
        if (outside.any()) {
            outside.find(nodes);
            field.set_outside(outside.irradiance());
        }
        field.set_links(set.links);
        field.bound_rows();
        if (closed) field.close_rows();
        solution.seconds.links += seconds_since(start);

        tell("iterate", double(round) / kMostRounds);
        start = Clock::now();
        const bool changed = nodes.size() != before || set.links.size() != links_before || set.rays != rays_before;
        if (!bounces) field.extinguish();
        const int most = !bounces ? 1 : round < kDirectRounds ? 2 : kMostSweeps;
        residual = iterate(field, kSteering * options.accuracy, largest_reflectance, most);
        if (!bounces) residual.relative = 0;  // one sweep is all there is
        solution.iterations += residual.sweeps;
        solution.seconds.iterate += seconds_since(start);

        field.fill(guide);
        ErrorEstimate estimate = estimate_error(set, nodes, closed ? 1.0 : amplification(scene, nodes, field, outside), outside.error(), guide);
        hind_sight.correct(estimate, scene, nodes, field);
        error = estimate.whole;
        if (round < kDirectRounds) continue;
        bool good = true;
        for (std::size_t i = 0; i < guide.share.size(); ++i) {
            // Errors add up by their squares, to which a few bright spots may bring nearly everything; but what most of the
            // light comes from is what is looked at, and so is held to the accuracy asked, too.
            const bool counts = estimate.power_share[i] > kCountingShare;
            const double worse = std::min(kWorstInstance, 1 / std::sqrt(std::max(estimate.power_share[i], 1e-300)));
            const double over = std::min(allowed / std::max(error, 1e-300),
                                         counts ? worse * allowed / std::max(estimate.of_instance[i], 1e-300) : 1.0);
            if (over >= 1) continue;
            good = false;
            guide.share[i] *= std::clamp(0.7 * over * over * over, 1.0 / 30, 0.7);
            guide.scene_share = std::min(guide.scene_share, guide.share[i]);
        }
        if (error <= allowed) ++settled;
        if ((good || settled > kInstanceRounds) && !(changed && round < kDirectRounds + 1)) break;
    }

    if (bounces && residual.relative > options.accuracy / 10) {
        start = Clock::now();
        residual = iterate(field, options.accuracy / 10, largest_reflectance, kMostSweeps);
        solution.iterations += residual.sweeps;
        solution.seconds.iterate += seconds_since(start);
    }
    solution.residual = residual.relative;
    solution.estimated_error = std::hypot(error, residual.relative);
    solution.converged = solution.estimated_error <= options.accuracy;
    solution.rays = set.rays + outside.rays();
    solution.seconds.visibility = set.visibility_seconds + solution.seconds.outside;
    solution.seconds.links -= set.visibility_seconds;
    for (const Link& l : set.links) {
        if (!nodes[l.a].group() && nodes[l.a].instance == nodes[l.b].instance) ++solution.links.self;
        else ++(l.mean() ? solution.links.near : solution.links.far);
    }
    solution.links.bytes = set.links.size() * sizeof(Link) + field.bytes();
    store(scene, nodes, field, outside.irradiance(), solution);
    return solution;
}

}  // namespace

Result<Solution> solve_reusable(const Scene& scene, const Plan& plan, const TransportOptions& options,
                                const Progress& progress) {
    TransportOptions asked = options;
    if (!plan.on("occlusion")) asked.visibility = VisibilityMethod::None;
    return plan.channels == 1 ? solve<1>(scene, plan, asked, progress) : solve<3>(scene, plan, asked, progress);
}

}  // namespace rro
