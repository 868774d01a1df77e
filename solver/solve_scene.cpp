#include "solver/solve_scene.h"

#include <algorithm>
#include <functional>
#include <string>

#include "format/clock.h"
#include "solver/effects/cost.h"
#include "solver/study/hierarchical.h"
#include "solver/study/reference.h"
#include "solver/transport/solve_plain.h"

namespace rro {
namespace {

constexpr double kDefaultAccuracy = 0.02;
// What the classic method and the paper's plain transport lack: they know surfaces that emit and reflect.
constexpr const char* kNotBetweenSurfaces[] = {"sky", "sun", "lights", "transmission", "medium"};

// For the estimate of memory: the program itself, before any scene. A face has its solution and the solver's state; a
// patch, tables of light per direction and its share of the links (measured: 3500 bytes at accuracy 0.05, patches of
// one triangle).
constexpr std::uint64_t kProgramBytes = std::uint64_t{16} << 20;
constexpr std::uint64_t kBytesPerFace = 200;
constexpr std::uint64_t kBytesPerPatch = 4000;

Error usage(std::string message) {
    return {ErrorKind::Usage, "", std::move(message), ""};
}

/// These two always see the whole of a scene, by rays.
Status check_ray_options(const SolveOptions& options, const std::string& method_name) {
    if (options.transport)
        return usage("--transport is for --method reusable; " + method_name + " has a transport of its own");
    for (const char* method : {"none", "atlas", "tables"})
        if (options.visibility == *parse_visibility(method))
            return usage(std::string("--visibility ") + method + " is for --method reusable; " + method_name +
                         " always traces rays");
    for (const char* effect : {"interreflection", "occlusion", "self"})
        if (std::find(options.overrides.without.begin(), options.overrides.without.end(), effect) !=
            options.overrides.without.end())
            return usage(std::string("--without ") + effect + " is for --method reusable; " + method_name + " has it always");
    return Done{};
}

Status check_deterministic_options(const Plan& plan, const SolveOptions& options) {
    const std::string name = options.method == Method::Reusable ? "reusable" : "hierarchical";
    if (options.samples > 0)
        return usage("--samples is for --method reference; the " + name + " method takes what --accuracy needs");
    if (options.method == Method::Hierarchical)
        for (const std::string effect : kNotBetweenSurfaces)
            if (plan.on(effect))
                return Error{ErrorKind::Usage, "", effect + ": --method hierarchical does not support it in this version",
                             "use --method reference, or leave it out with --without " + effect};
    return Done{};
}

bool is_lit(const Plan& plan) {
    return plan.on("emitters") || plan.on("sky") || plan.on("sun") || plan.on("lights");
}

/// No light: every result is 0, and exactly so.
Solution dark_solution(const Scene& scene, const SolveOptions& options) {
    Solution solution;
    for (const Instance& instance : scene.instances) {
        const std::vector<Rgb> zeros(instance.data().faces.size());
        InstanceSolution& out = solution.instances.emplace_back();
        out.radiosity = out.irradiance = zeros;
        if (options.method == Method::Reference) out.standard_error = zeros;
        solution.elements += zeros.size();
    }
    solution.converged = true;
    solution.warnings.push_back("nothing gives light (no emitter, sky, sun or light): all results are exactly 0");
    return solution;
}

/// Directional transport of the reusable method, by whoever is asked to.
using SolveDirectional = std::function<Result<Solution>(const Plan&, const TransportOptions&)>;

Result<Solution> solve_by_method(const Scene& scene, const Plan& plan, const SolveOptions& options, double accuracy,
                                 const SolveDirectional& directional, const Progress& progress) {
    if (!is_lit(plan)) return dark_solution(scene, options);
    if (options.method == Method::Reference)
        return solve_reference(scene, {accuracy, options.samples, options.seed}, progress);
    if (options.method == Method::Hierarchical)
        return solve_hierarchical(scene, {accuracy, plan.channels > 1, options.memory}, progress);
    TransportOptions transport;
    transport.accuracy = accuracy;
    transport.seed = options.seed;
    transport.visibility = options.visibility;
    transport.far_factor = options.far_factor;
    const bool plain = options.transport == Transport::Plain;
    if (plain && (options.visibility == VisibilityMethod::Atlas || options.visibility == VisibilityMethod::Tables))
        return usage("--visibility atlas and tables are for --transport directional");
    if (plain)
        for (const char* effect : kNotBetweenSurfaces)
            if (plan.on(effect))
                return usage(std::string(effect) + ": --transport plain does not support it; leave it out with --without " + effect);
    return plain ? solve_plain(scene, plan, transport, progress) : directional(plan, transport);
}

Result<Solution> solve_with(const Scene& scene, const SolveOptions& options, const SolveDirectional& directional,
                            const Progress& progress) {
    const auto start = Clock::now();
    auto plan = plan_effects(scene, options.overrides);
    if (!plan) return plan.error();
    if (options.method == Method::Reference)
        if (auto fits = check_ray_options(options, "the reference"); !fits) return fits.error();
    if (options.method == Method::Reusable)
        if (auto fits = check_deterministic_options(*plan, options); !fits) return fits.error();
    if (options.method == Method::Hierarchical) {
        if (auto fits = check_ray_options(options, "the hierarchical method"); !fits) return fits.error();
        if (auto fits = check_deterministic_options(*plan, options); !fits) return fits.error();
    }
    const double plan_seconds = seconds_since(start);

    const double accuracy = accuracy_of(scene, options.accuracy);
    auto solved = solve_by_method(scene, *plan, options, accuracy, directional, progress);
    if (!solved) return solved.error();
    Solution solution = std::move(*solved);
    solution.accuracy = accuracy;
    if (solution.effects.empty()) {
        solution.effects = plan->effects;
        if (options.method == Method::Reusable) account_seconds(solution);
    }
    solution.warnings.insert(solution.warnings.begin(), plan->warnings.begin(), plan->warnings.end());
    solution.seconds.plan = plan_seconds;
    solution.seconds.total = seconds_since(start);
    return solution;
}

}  // namespace

Result<Method> parse_method(std::string_view name) {
    if (name == "reusable") return Method::Reusable;
    if (name == "hierarchical") return Method::Hierarchical;
    if (name == "reference") return Method::Reference;
    return usage("--method " + std::string(name) + ": no such method, expected reusable, hierarchical or reference");
}

Result<Transport> parse_transport(std::string_view name) {
    if (name == "directional") return Transport::Directional;
    if (name == "plain") return Transport::Plain;
    return usage("--transport " + std::string(name) + ": no such transport, expected directional or plain");
}

Result<VisibilityMethod> parse_visibility(std::string_view name) {
    if (name == "auto") return VisibilityMethod::Auto;
    if (name == "atlas") return VisibilityMethod::Atlas;
    if (name == "tables") return VisibilityMethod::Tables;
    if (name == "rays") return VisibilityMethod::Rays;
    if (name == "none") return VisibilityMethod::None;
    return usage("--visibility " + std::string(name) +
                 ": no such visibility, expected auto, atlas, tables, rays or none");
}

Result<Solution> solve_scene(const Scene& scene, const SolveOptions& options, const Progress& progress) {
    return solve_with(scene, options, [&](const Plan& plan, const TransportOptions& transport) {
        return solve_reusable(scene, plan, transport, progress);
    }, progress);
}

Result<Solution> SceneSolver::solve(std::shared_ptr<const Scene> scene, const SolveOptions& options, const Progress& progress) {
    bool reused = false;
    auto solution = solve_with(*scene, options, [&](const Plan& plan, const TransportOptions& transport) {
        reused = true;
        return reusable_.solve(scene, plan, transport, progress);
    }, progress);
    if (!solution) return solution;
    const std::uint64_t before = links_;
    links_ = solution->links.total();
    from_scratch_ = !reused || reusable_.from_scratch();
    change_ = reused ? reusable_.change() : LinkChange{before, 0, links_};
    return solution;
}

double accuracy_of(const Scene& scene, std::optional<double> asked) {
    return asked.value_or(scene.manifest.accuracy.value_or(kDefaultAccuracy));
}

bool work_done(const Solution& solution, const SolveOptions& options) {
    return solution.converged || (options.method == Method::Reference && options.samples > 0);
}

std::uint64_t estimated_memory(const Scene& scene) {
    std::uint64_t bytes = kProgramBytes + ObjectRays::memory_bytes();
    for (const auto& object : scene.objects)
        for (const SectionInfo& section : object->archive.sections()) bytes += section.raw_bytes;
    for (const Instance& instance : scene.instances)
        bytes += kBytesPerFace * instance.data().faces.size() + kBytesPerPatch * instance.data().patches.size();
    return bytes;
}

}  // namespace rro
