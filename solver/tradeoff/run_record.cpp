#include "solver/tradeoff/run_record.h"

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <system_error>

#include "format/atomic_file.h"
#include "format/tool/interrupt.h"
#include "format/tool/json_document.h"

namespace rro {
namespace {

using nlohmann::json;

/// JSON has no infinity: an error that is not finite becomes the largest double.
double finite(double value) {
    return std::isfinite(value) ? value : std::numeric_limits<double>::max();
}

}  // namespace

Status write_run(const RunRecord& run, const std::filesystem::path& path) {
    const PhaseSeconds& s = run.seconds;
    const MeasuredError& m = run.measured;
    const json document = {{"failed", run.failed},
                           {"load", s.load},
                           {"plan", s.plan},
                           {"links_seconds", s.links},
                           {"visibility", s.visibility},
                           {"iterate", s.iterate},
                           {"total", s.total},
                           {"error", finite(m.error)},
                           {"error_low", finite(m.low)},
                           {"error_high", finite(m.high)},
                           {"bias", m.bias},
                           {"worst_instance", m.worst_instance},
                           {"worst_error", finite(m.worst_error)},
                           {"estimated_error", finite(run.estimated_error)},
                           {"converged", run.converged},
                           {"far", run.links.far},
                           {"near", run.links.near},
                           {"self", run.links.self},
                           {"bytes", run.links.bytes},
                           {"rays", run.rays}};
    const DeferInterrupts until_written;
    return write_file_atomically(path, document.dump(2, ' ', false, json::error_handler_t::replace) + "\n");
}

std::optional<RunRecord> read_run(const std::filesystem::path& path) {
    std::error_code unreadable;
    if (!std::filesystem::is_regular_file(path, unreadable)) return std::nullopt;
    const auto document = read_json(path);
    if (!document) return std::nullopt;
    const json& j = *document;
    try {
        RunRecord run;
        run.failed = j.at("failed");
        run.seconds = {j.at("load"), j.at("plan"), j.at("links_seconds"), j.at("visibility"), j.at("iterate"), 0, j.at("total")};
        run.measured = {j.at("error"), j.at("error_low"), j.at("error_high"), j.at("bias"), j.at("worst_instance"),
                        j.at("worst_error")};
        run.estimated_error = j.at("estimated_error");
        run.converged = j.at("converged");
        run.links = {j.at("far"), j.at("near"), j.at("self"), j.at("bytes")};
        run.rays = j.at("rays");
        return run;
    } catch (const json::exception&) {
        return std::nullopt;
    }
}

}  // namespace rro
