#include "solver/transport/solve_plain.h"


#include "format/clock.h"
#include "format/parallel.h"
#include "solver/transport/channels.h"
#include "solver/transport/plain_links.h"

namespace rro {

namespace {

constexpr int kMostRounds = 12;
constexpr int kMostSweeps = 1000;
constexpr int kFirstSweeps = 2;  // of the first round: enough to steer refinement

// A link with less power than this part of `accuracy` times all emitted power is not refined for being near; the part is
// lowered while such links carry too much light together.
constexpr double kFirstShare = 1e-3, kLowered = 0.25;
constexpr double kCoarse = 0.9;  // of `accuracy`: the residual is the other part

/// Radiosity and irradiance of every node, for C channels: gather over links, push down to faces, pull up.
template <int C>
class PlainLight {
  public:
    explicit PlainLight(const Nodes& nodes)
        : nodes_(nodes), radiosity_(nodes.size() * C, 0), irradiance_(nodes.size() * C, 0) {
        for_each_face([&](std::uint32_t id, const Rgb&, const Rgb& exitance) {
            emitted_ += nodes_[id].area * mean_over<C>([&](std::size_t c) { return double(component<C>(exitance, c)); });
        });
        extinguish();
    }

    /// Back to emitted light alone.
    void extinguish() {
        std::fill(irradiance_.begin(), irradiance_.end(), 0.0f);
        reflect();
    }

    void set_links(const std::vector<PlainLink>& links) {
        first_.assign(nodes_.size() + 1, 0);
        const auto carries = [](const PlainLink& l) { return l.exchange > 0; };
        for (const PlainLink& l : links)
            if (carries(l)) ++first_[l.a + 1], ++first_[l.b + 1];
        for (std::size_t n = 0; n < nodes_.size(); ++n) first_[n + 1] += first_[n];
        halves_.resize(first_.back());
        std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
        const auto add = [&](std::uint32_t to, std::uint32_t from, float exchange) {
            halves_[next[to]++] = {from, static_cast<float>(double(exchange) / nodes_[to].area)};
        };
        for (const PlainLink& l : links) {
            if (!carries(l)) continue;
            add(l.a, l.b, l.exchange);
            add(l.b, l.a, l.exchange);
        }
    }

    /// One Jacobi sweep.
    /// returns  area-weighted root mean square of the change of B
    double sweep() {
        parallel_for(nodes_.size(), 1024, [&](std::size_t n) {
            std::array<float, C> sum{};
            for (std::uint32_t k = first_[n]; k < first_[n + 1]; ++k)
                for (std::size_t c = 0; c < C; ++c) sum[c] += halves_[k].gain * radiosity_[halves_[k].from * C + c];
            std::copy(sum.begin(), sum.end(), &irradiance_[n * C]);
        });
        return reflect();
    }

    /// Area-weighted root mean square of R = B - M.
    double reflected_norm() const {
        double sum = 0, area = 0;
        for_each_face([&](std::uint32_t id, const Rgb& reflectance, const Rgb&) {
            area += nodes_[id].area;
            sum += nodes_[id].area * mean_over<C>([&](std::size_t c) {
                return std::pow(double(component<C>(reflectance, c)) * double(irradiance_[id * C + c]), 2);
            });
        });
        return area > 0 ? std::sqrt(sum / area) : 0.0;
    }

    /// Mean over the channels. [nodes]
    std::vector<float> mean() const {
        std::vector<float> mean(nodes_.size(), 0);
        for (std::size_t id = 0; id < mean.size(); ++id)
            mean[id] = mean_over<C>([&](std::size_t c) { return radiosity_[id * C + c]; });
        return mean;
    }

    double emitted() const { return emitted_; }  // W, mean over the channels

    double received() const {  // W, mean over the channels
        double sum = 0;
        for_each_face([&](std::uint32_t id, const Rgb&, const Rgb&) {
            sum += nodes_[id].area * mean_over<C>([&](std::size_t c) { return double(irradiance_[id * C + c]); });
        });
        return sum;
    }

    std::uint64_t bytes() const { return halves_.size() * sizeof(Half); }

    void store(Solution& solution) const {
        const auto rgb = [](const std::vector<float>& v, std::size_t id) {
            return Rgb{v[id * C], v[id * C + 1 % C], v[id * C + 2 % C]};
        };
        solution.instances.resize(nodes_.scene().instances.size());
        for_each_face([&](std::uint32_t id, const Rgb& reflectance, const Rgb& exitance) {
            InstanceSolution& out = solution.instances[nodes_[id].instance];
            const Rgb e = rgb(irradiance_, id);
            out.radiosity.push_back(rgb(radiosity_, id));
            out.irradiance.push_back(e);
            ++solution.elements;
            solution.energy.emitted += to_double(exitance) * nodes_[id].area;
            solution.energy.absorbed += hadamard(Vec3{1, 1, 1} - to_double(reflectance), to_double(e)) * nodes_[id].area;
        });
        solution.energy.escaped = solution.energy.emitted - solution.energy.absorbed;
    }

  private:
    struct Half {
        std::uint32_t from;
        float gain;
    };

    template <class F>
    void for_each_face(const F& f) const {
        for (std::uint32_t i = 0; i < nodes_.scene().instances.size(); ++i) for_each_face_of(i, f);
    }

    // f(node, reflectance, exitance)
    template <class F>
    void for_each_face_of(std::uint32_t i, const F& f) const {
        const Instance& instance = nodes_.scene().instances[i];
        const std::uint32_t first = nodes_.instance(i).first_face;
        for (std::uint32_t k = 0; k < instance.data().faces.size(); ++k) {
            const std::uint32_t patch = instance.object->patch_of_face[k];
            f(first + k, instance.reflectance[patch], instance.exitance[patch]);
        }
    }

    /// Irradiance down to the faces, each as its cluster; then B = M + rho E there, and means up to the roots.
    double reflect() {
        const std::size_t count = nodes_.scene().instances.size();
        std::vector<double> change(count, 0);
        parallel_for(count, 1, [&](std::size_t k) { change[k] = reflect_instance(static_cast<std::uint32_t>(k)); });
        double sum = 0, area = 0;
        for (std::uint32_t i = 0; i < count; ++i) {
            sum += change[i];
            area += nodes_[nodes_.root(i)].area;
        }
        for (std::uint32_t g = nodes_.group_count(); g-- > 0;) average(g);
        return area > 0 ? std::sqrt(sum / area) : 0.0;
    }

    double reflect_instance(std::uint32_t i) {
        const std::uint32_t root = nodes_.root(i), first_face = nodes_.instance(i).first_face;
        const auto end = first_face + static_cast<std::uint32_t>(nodes_.scene().instances[i].data().faces.size());
        for (std::uint32_t id = root + 1; id < end; ++id)
            for (std::size_t c = 0; c < C; ++c) irradiance_[id * C + c] += irradiance_[nodes_[id].parent * C + c];
        double change = 0;
        for_each_face_of(i, [&](std::uint32_t id, const Rgb& reflectance, const Rgb& exitance) {
            std::array<double, C> square;
            for (std::size_t c = 0; c < C; ++c) {
                const float b = component<C>(exitance, c) + component<C>(reflectance, c) * irradiance_[id * C + c];
                const double d = double(b) - double(radiosity_[id * C + c]);
                square[c] = d * d;
                radiosity_[id * C + c] = b;
            }
            change += nodes_[id].area * mean_of(square);
        });
        for (std::uint32_t id = first_face; id-- > root;) average(id);
        return change;
    }

    /// The mean of a cluster's or group's children.
    void average(std::uint32_t id) {
        const Node& n = nodes_[id];
        std::array<double, C> sum{};
        const auto add = [&](std::uint32_t child) {
            for (std::size_t c = 0; c < C; ++c) sum[c] += nodes_[child].area * double(radiosity_[child * C + c]);
        };
        if (n.second_child != 0)
            add(n.first_child), add(n.second_child);
        else
            for (std::uint32_t k = 0; k < n.child_count; ++k) add(n.first_child + k);
        for (std::size_t c = 0; c < C; ++c)
            radiosity_[id * C + c] = n.area > 0 ? static_cast<float>(sum[c] / n.area) : 0.0f;
    }

    const Nodes& nodes_;
    std::vector<float> radiosity_, irradiance_;  // [nodes * C]
    std::vector<std::uint32_t> first_;           // [nodes + 1]
    std::vector<Half> halves_;
    double emitted_ = 0;
};

/// Sweeps until the remaining error is below `goal` of R: ||r|| / ((1 - q) ||R||), q the ratio of the last two ||r||, or
/// the largest reflectance where there are no three yet.
template <int C>
double iterate(PlainLight<C>& light, double goal, double largest_reflectance, int most, int& sweeps) {
    constexpr double kSlowest = 0.9999;
    double relative = 0, last = 0;
    for (int k = 0; k < most; ++k) {
        const double r = light.sweep(), norm = light.reflected_norm();
        const double q = k >= 2 && last > 0 ? r / last : largest_reflectance;
        last = r;
        ++sweeps;
        relative = norm > 0 ? r / ((1 - std::min(q, kSlowest)) * norm) : 0;
        if (relative <= goal) break;
    }
    return relative;
}

double largest_reflectance(const Scene& scene) {
    double most = 0;
    for (const Instance& i : scene.instances)
        for (const Rgb& r : i.reflectance) most = std::max(most, max_component(to_double(r)));
    return most;
}

/// The share of `received` that coarse links carry.
double coarse_share(const PlainLinks& set, const std::vector<float>& light, double received) {
    double coarse = 0;
    for (const PlainLink& l : set.links)
        if (l.kind == PlainKind::Coarse) coarse += double(l.exchange) * (double(light[l.a]) + double(light[l.b]));
    return received > 0 ? coarse / received : 0.0;
}

LinkCounts count_links(const Nodes& nodes, const PlainLinks& set) {
    LinkCounts counts;
    for (const PlainLink& l : set.links)
        if (l.exchange > 0)
            ++(nodes[l.a].instance == nodes[l.b].instance ? counts.self : l.kind == PlainKind::Near ? counts.near : counts.far);
    return counts;
}

template <int C>
Result<Solution> solve(const Scene& scene, const Plan& plan, const TransportOptions& options, const Progress& progress) {
    const auto tell = [&](std::string_view phase, double done) {
        if (progress) progress(phase, done);
    };
    auto start = Clock::now();
    const Nodes nodes(scene);
    const EndAreas areas(nodes);
    const SceneRays rays(scene);
    const PlainLinker linker(nodes, areas, rays, options, plan.on("self"));
    PlainLinks set(nodes);
    PlainLight<C> light(nodes);
    const bool bounces = plan.on("interreflection");
    const double most_reflected = largest_reflectance(scene);
    const std::vector<float> emission = light.mean();
    const auto sent = [&] { return bounces ? light.mean() : emission; };
    bool fine = true;
    double threshold = kFirstShare * options.accuracy * light.emitted(), coarse = 0;
    Solution solution;
    solution.accuracy = options.accuracy;
    for (int round = 0; round < kMostRounds; ++round) {
        tell("links", double(round) / kMostRounds);
        const bool changed = refine(set, linker, sent(), threshold);
        light.set_links(set.links);
        solution.seconds.links += seconds_since(start);
        if (round > 1 && !changed && fine) break;

        tell("iterate", double(round) / kMostRounds);
        start = Clock::now();
        if (!bounces) light.extinguish();
        const int most = !bounces ? 1 : round == 0 ? kFirstSweeps : kMostSweeps;
        solution.residual = iterate(light, options.accuracy / 10, most_reflected, most, solution.iterations);
        solution.seconds.iterate += seconds_since(start);
        start = Clock::now();
        coarse = coarse_share(set, sent(), light.received());
        fine = coarse <= kCoarse * options.accuracy;
        if (!fine) threshold *= kLowered;
    }
    if (!bounces) solution.residual = 0;  // one sweep is all there is
    solution.links = count_links(nodes, set);
    solution.links.bytes = set.links.size() * sizeof(PlainLink) + light.bytes();
    solution.rays = set.rays;
    solution.estimated_error = std::hypot(coarse, solution.residual);
    solution.converged = solution.estimated_error <= options.accuracy;
    light.store(solution);
    return solution;
}

}  // namespace

Result<Solution> solve_plain(const Scene& scene, const Plan& plan, const TransportOptions& options,
                             const Progress& progress) {
    TransportOptions asked = options;
    if (!plan.on("occlusion")) asked.visibility = VisibilityMethod::None;
    return plan.channels == 1 ? solve<1>(scene, plan, asked, progress) : solve<3>(scene, plan, asked, progress);
}

}  // namespace rro
