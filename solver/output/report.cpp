#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "format/atomic_file.h"
#include "solver/output/output.h"

namespace rro {
namespace {

using nlohmann::json;

/// JSON has no infinity: what is not finite becomes the largest double.
double finite(double value) {
    return std::isfinite(value) ? value : std::numeric_limits<double>::max();
}

json channels(const Vec3& v) {
    return {finite(v.x), finite(v.y), finite(v.z)};
}

std::uint64_t memory_peak_bytes() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;  // Linux counts kibibytes
}

json effects(const Solution& solution) {
    json list = json::array();
    for (const EffectPlan& e : solution.effects)
        list.push_back({{"name", e.name}, {"on", e.on}, {"reason", e.reason}, {"seconds", finite(e.seconds)}});
    return list;
}

}  // namespace

Status write_report(const Scene& scene, const Solution& solution, const std::filesystem::path& path) {
    const PhaseSeconds& s = solution.seconds;
    const LinkCounts& l = solution.links;
    json report = {
        {"accuracy", solution.accuracy},
        {"estimated_error", finite(solution.estimated_error)},
        {"converged", solution.converged},
        {"iterations", solution.iterations},
        {"residual", finite(solution.residual)},
        {"seconds",
         {{"load", s.load},
          {"plan", s.plan},
          {"links", s.links},
          {"visibility", s.visibility},
          {"iterate", s.iterate},
          {"output", s.output},
          {"total", s.total}}},
        {"links", {{"far", l.far}, {"near", l.near}, {"self", l.self}, {"total", l.total()}, {"bytes", l.bytes}}},
        {"rays", solution.rays},
        {"triangles", scene.triangle_count()},
        {"elements", solution.elements},
        {"memory_peak_bytes", memory_peak_bytes()},
        {"energy",
         {{"emitted", channels(solution.energy.emitted)},
          {"absorbed", channels(solution.energy.absorbed)},
          {"escaped", channels(solution.energy.escaped)}}},
        {"effects", effects(solution)},
        {"warnings", solution.warnings}};
    if (solution.worst_instance >= 0)
        report["worst_instance"] = {{"name", scene.instances[static_cast<std::size_t>(solution.worst_instance)].name},
                                    {"estimated_error", finite(solution.worst_estimate)}};
    return write_file_atomically(path, report.dump(2, ' ', false, json::error_handler_t::replace) + "\n");
}

}  // namespace rro
