#include "solver/study/hierarchical.h"

#include <algorithm>
#include <cmath>

#include "format/clock.h"
#include "format/parallel.h"
#include "solver/study/quad_links.h"

namespace rro {
namespace {

// What one link is off by, as a share of what it carries: measured on rooms with furniture, where most of it is the noise
// of few rays. Links of power w each leave an error of kLinkError sqrt(w / W) where W arrives: hence the power allowed.
constexpr double kLinkError = 0.3;
constexpr double kUnlinkedShare = 0.5;   // of the error asked: all pairs of faces together that are too dim to be linked
constexpr double kFirstRoundPower = 4;   // the first round knows only the emitters: coarser links, to be refined
constexpr int kMostRounds = 8;
constexpr int kMostIterations = 1000;    // of one round
constexpr double kSettled = 0.05;        // of the error asked: change in one iteration
constexpr std::size_t kGrain = 256;

/// Light of all elements; C channels.
template <int C>
class Light {
  public:
    using Channels = std::array<float, static_cast<std::size_t>(C)>;

    Light(const Scene& scene, const QuadElements& all) : all_(all) {
        for (const QuadFace& face : all.faces) {
            const Instance& instance = scene.instances[face.instance];
            const std::size_t patch = instance.object->patch_of_face[face.face];
            exitance_.push_back(channels(instance.exitance[patch]));
            reflectance_.push_back(channels(instance.reflectance[patch]));
        }
        radiosity_ = exitance_;
        irradiance_.resize(radiosity_.size());
    }

    /// Mean over the channels.
    std::vector<float> brightness() const {
        std::vector<float> mean(radiosity_.size());
        for (std::size_t k = 0; k < mean.size(); ++k) mean[k] = sum(radiosity_[k]) / float(C);
        return mean;
    }

    /// Power that leaves all faces, and that arrives; mean over the channels, W.
    double leaving() const { return power(radiosity_); }
    double arriving() const { return power(irradiance_); }

    /// Takes the links of a round, by receiver; new elements have their parent's light.
    void take(const std::vector<QuadLink>& links) {
        const std::size_t n = all_.elements.size();
        for (std::size_t k = radiosity_.size(); k < n; ++k) {
            radiosity_.push_back(radiosity_[all_.elements[k].parent]);
            irradiance_.push_back(irradiance_[all_.elements[k].parent]);
        }
        first_.assign(n + 1, 0);
        for (const QuadLink& link : links) ++first_[link.a + 1], ++first_[link.b + 1];
        for (std::size_t k = 0; k < n; ++k) first_[k + 1] += first_[k];
        halves_.resize(2 * links.size());
        std::vector<std::uint64_t> next(first_.begin(), first_.end() - 1);
        for (const QuadLink& link : links) {
            halves_[next[link.a]++] = {link.b, link.exchange};
            halves_[next[link.b]++] = {link.a, link.exchange};
        }
    }

    /// One iteration: gather, push, pull.
    /// returns  the change of reflected radiosity of faces, relative, root mean square over area and channels
    double iterate() {
        gathered_.resize(radiosity_.size());
        parallel_for(radiosity_.size(), kGrain, [&](std::size_t k) { gathered_[k] = gather(k); });
        const std::vector<Channels> before(irradiance_.begin(), irradiance_.begin() + std::ptrdiff_t(all_.faces.size()));
        push();
        pull();
        double change = 0, all = 0;
        for (std::size_t f = 0; f < before.size(); ++f)
            for (std::size_t c = 0; c < std::size_t(C); ++c) {
                const double now = double(reflectance_[f][c]) * double(irradiance_[f][c]);
                const double was = double(reflectance_[f][c]) * double(before[f][c]);
                change += all_.elements[f].area * (now - was) * (now - was);
                all += all_.elements[f].area * now * now;
            }
        return all > 0 ? std::sqrt(change / all) : 0.0;
    }

    /// Root mean square over area of the error of faces, relative, where links err independently.
    double estimated_error() const {
        std::vector<double> variance(all_.faces.size(), 0);  // of the reflected power of a face, W^2
        for (std::size_t k = 0; k < radiosity_.size(); ++k) {
            const std::size_t f = all_.elements[k].face;
            double squares = 0;
            for (std::size_t c = 0; c < std::size_t(C); ++c) {
                double carried = 0;
                for (std::uint64_t h = first_[k]; h < first_[k + 1]; ++h) {
                    const double power = double(halves_[h].exchange) * double(radiosity_[halves_[h].from][c]);
                    carried += power * power;
                }
                squares += carried * double(reflectance_[f][c]) * double(reflectance_[f][c]);
            }
            variance[f] += squares;
        }
        double error = 0, all = 0;
        for (std::size_t f = 0; f < variance.size(); ++f) {
            const double area = all_.elements[f].area;
            error += area > 0 ? variance[f] / area : 0.0;
            for (std::size_t c = 0; c < std::size_t(C); ++c) {
                const double reflected = double(reflectance_[f][c]) * double(irradiance_[f][c]);
                all += area * reflected * reflected;
            }
        }
        return all > 0 ? kLinkError * std::sqrt(error / all) : 0.0;
    }

    Rgb radiosity(std::size_t element) const { return rgb(radiosity_[element]); }
    Rgb irradiance(std::size_t element) const { return rgb(irradiance_[element]); }
    Rgb exitance(std::size_t face) const { return rgb(exitance_[face]); }
    Rgb reflectance(std::size_t face) const { return rgb(reflectance_[face]); }

  private:
    struct Half {
        std::uint32_t from;
        float exchange;
    };

    static Channels channels(const Rgb& v) {
        if constexpr (C == 1)
            return {v.x};
        else
            return {v.x, v.y, v.z};
    }
    static Rgb rgb(const Channels& v) {
        if constexpr (C == 1)
            return {v[0], v[0], v[0]};
        else
            return {v[0], v[1], v[2]};
    }
    static float sum(const Channels& v) {
        float all = 0;
        for (const float x : v) all += x;
        return all;
    }
    double power(const std::vector<Channels>& of) const {
        double all = 0;
        for (std::size_t f = 0; f < all_.faces.size(); ++f) all += all_.elements[f].area * double(sum(of[f])) / C;
        return all;
    }

    Channels gather(std::size_t k) const {
        std::array<double, static_cast<std::size_t>(C)> arriving{};
        for (std::uint64_t h = first_[k]; h < first_[k + 1]; ++h) {
            const Channels& from = radiosity_[halves_[h].from];
            for (std::size_t c = 0; c < std::size_t(C); ++c) arriving[c] += double(halves_[h].exchange) * double(from[c]);
        }
        Channels mean{};
        if (const double area = all_.elements[k].area; area > 0)
            for (std::size_t c = 0; c < std::size_t(C); ++c) mean[c] = static_cast<float>(arriving[c] / area);
        return mean;
    }

    /// Irradiance of an element: what it and all above it gathered.
    void push() {
        for (std::size_t k = 0; k < radiosity_.size(); ++k) {
            irradiance_[k] = gathered_[k];
            if (k < all_.faces.size()) continue;
            for (std::size_t c = 0; c < std::size_t(C); ++c) irradiance_[k][c] += irradiance_[all_.elements[k].parent][c];
        }
    }

    /// Leaves reflect; the others have the mean of their four parts, which are of equal area.
    void pull() {
        for (std::size_t k = radiosity_.size(); k-- > 0;) {
            const QuadElement& e = all_.elements[k];
            for (std::size_t c = 0; c < std::size_t(C); ++c) {
                if (e.children == 0) {
                    radiosity_[k][c] = exitance_[e.face][c] + reflectance_[e.face][c] * irradiance_[k][c];
                    continue;
                }
                const std::size_t p = e.children;
                irradiance_[k][c] =
                    0.25f * (irradiance_[p][c] + irradiance_[p + 1][c] + irradiance_[p + 2][c] + irradiance_[p + 3][c]);
                radiosity_[k][c] =
                    0.25f * (radiosity_[p][c] + radiosity_[p + 1][c] + radiosity_[p + 2][c] + radiosity_[p + 3][c]);
            }
        }
    }

    const QuadElements& all_;
    std::vector<Channels> exitance_, reflectance_;            // [faces]
    std::vector<Channels> radiosity_, irradiance_, gathered_;  // [elements] W/m^2
    std::vector<std::uint64_t> first_;                        // [elements + 1] into halves_
    std::vector<Half> halves_;                                // by receiver
};

/// How much power links may carry where `arriving` reaches all faces together.
QuadOracle oracle_for(double accuracy, double arriving, std::size_t faces, std::uint64_t memory) {
    const double n = double(std::max<std::size_t>(faces, 1)), share = accuracy / kLinkError;
    return {share * share * arriving / n, kUnlinkedShare * accuracy * arriving / (n * n), memory};
}

/// Rounds of refinement and iteration, until nothing is left to refine.
template <int C>
Status settle(const HierarchicalOptions& options, QuadLinker& linker, const QuadElements& all, Light<C>& light,
              const Progress& progress, Solution& s) {
    for (int round = 0; round < kMostRounds; ++round) {
        const double arriving = round == 0 ? kFirstRoundPower * light.leaving() : light.arriving();
        std::vector<float> brightness = light.brightness();
        const auto changed =
            linker.refine(oracle_for(options.accuracy, arriving, all.faces.size(), options.memory), brightness, progress);
        if (!changed) return changed.error();
        if (!*changed && round > 0) break;
        const auto start = Clock::now();
        light.take(linker.links());
        for (int k = 0; k < kMostIterations; ++k) {
            ++s.iterations;
            s.residual = light.iterate();
            if (s.residual <= kSettled * options.accuracy) break;
        }
        s.seconds.iterate += seconds_since(start);
    }
    s.converged = s.residual <= kSettled * options.accuracy;
    return Done{};
}

/// The parts of a face that have no parts, in the order of the quadtree.
template <int C>
void add_leaves(const QuadElements& all, const Light<C>& light, std::size_t id, bool mirrored, std::vector<Element>& out) {
    const QuadElement& e = all.elements[id];
    if (e.children != 0) {
        for (std::size_t k = 0; k < 4; ++k) add_leaves(all, light, e.children + k, mirrored, out);
        return;
    }
    Element leaf{all.faces[e.face].face, e.place, light.radiosity(id), light.irradiance(id)};
    if (mirrored) std::swap(leaf.corner[1], leaf.corner[2]);
    out.push_back(leaf);
}

template <int C>
void fill_solution(const Scene& scene, const QuadElements& all, const Light<C>& light, Solution& s) {
    s.instances.resize(scene.instances.size());
    for (std::size_t f = 0; f < all.faces.size(); ++f) {
        InstanceSolution& out = s.instances[all.faces[f].instance];
        out.radiosity.push_back(light.radiosity(f));
        out.irradiance.push_back(light.irradiance(f));
        const std::size_t before = out.elements.size();
        const bool mirrored = scene.instances[all.faces[f].instance].determinant_sign < 0;
        if (all.elements[f].children != 0) add_leaves(all, light, f, mirrored, out.elements);
        s.elements += std::max<std::size_t>(1, out.elements.size() - before);
        const double area = all.elements[f].area;
        const Vec3 arriving = to_double(light.irradiance(f)), leaving = to_double(light.radiosity(f));
        s.energy.emitted += to_double(light.exitance(f)) * area;
        s.energy.absorbed += hadamard(Vec3{1, 1, 1} - to_double(light.reflectance(f)), arriving) * area;
        s.energy.escaped += (leaving - arriving) * area;
    }
}

template <int C>
Result<Solution> solve(const Scene& scene, const HierarchicalOptions& options, const Progress& progress) {
    auto start = Clock::now();
    QuadElements all(scene);
    const SceneRays rays(scene);
    QuadLinker linker(scene, all, rays);
    if (const std::uint64_t bytes = linker.bytes_of_root_links(); bytes > options.memory)
        return failed("", "--method hierarchical links " + std::to_string(all.faces.size()) +
                              " faces with each other, which takes about " + std::to_string(bytes >> 20) +
                              " MB of memory; " + std::to_string(options.memory >> 20) + " MB are allowed",
                      "allow more with --memory, or use --method reusable");
    Light<C> light(scene, all);
    Solution solution;
    solution.seconds.links = seconds_since(start);
    if (auto done = settle(options, linker, all, light, progress, solution); !done) return done.error();
    solution.seconds.links += linker.link_seconds();
    solution.seconds.visibility = linker.visibility_seconds();
    solution.accuracy = options.accuracy;
    solution.estimated_error = light.estimated_error();
    solution.links.near = linker.links().size();
    solution.links.bytes = linker.links().size() * sizeof(QuadLink);
    solution.rays = linker.rays();
    fill_solution(scene, all, light, solution);
    return solution;
}

}  // namespace

Result<Solution> solve_hierarchical(const Scene& scene, const HierarchicalOptions& options, const Progress& progress) {
    if (!(options.accuracy > 0))
        return Error{ErrorKind::Usage, "", "accuracy must be above 0, found " + std::to_string(options.accuracy), ""};
    return options.colour ? solve<3>(scene, options, progress) : solve<1>(scene, options, progress);
}

}  // namespace rro
