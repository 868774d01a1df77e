#include "solver/explain.h"

#include <cstdio>
#include <nlohmann/json.hpp>

#include "format/parallel.h"
#include "format/tool/names.h"
#include "solver/effects/cost.h"
#include "solver/solve_scene.h"

namespace rro {
namespace {

using nlohmann::json;

/// 12, 3400, 56k, 1.2M: four characters at most but for huge numbers.
std::string short_count(std::uint64_t n) {
    char text[32];
    const auto value = static_cast<double>(n);
    if (n < 10'000)
        std::snprintf(text, sizeof text, "%llu", static_cast<unsigned long long>(n));
    else if (n < 1'000'000)
        std::snprintf(text, sizeof text, "%.0fk", value / 1e3);
    else
        std::snprintf(text, sizeof text, value < 1e7 ? "%.1fM" : "%.0fM", value / 1e6);
    return text;
}

std::string table_row(const std::string& name, const std::string& on, const std::optional<Work>& work,
                      const std::string& reason) {
    char seconds[32] = "-";
    if (work) std::snprintf(seconds, sizeof seconds, "%.2g", work->seconds);
    char text[512];
    std::snprintf(text, sizeof text, "  %-16s %-4s %8s %8s %9s %8s  ", name.c_str(), on.c_str(),
                  work ? short_count(work->links).c_str() : "-", work ? short_count(work->rays).c_str() : "-",
                  work ? size_text(work->bytes).c_str() : "-", seconds);
    return text + reason + "\n";
}

json work_json(const Work& work) {
    return {{"links", work.links}, {"rays", work.rays}, {"memory_bytes", work.bytes}, {"seconds", work.seconds}};
}

}  // namespace

Outlook outlook(const Scene& scene, std::optional<double> accuracy, Plan& plan) {
    Outlook o;
    o.accuracy = accuracy_of(scene, accuracy);
    o.work = predict_work(scene, o.accuracy, thread_count(), plan);
    o.memory = estimated_memory(scene);
    return o;
}

std::string explain_text(const Scene& scene, const Plan& plan, const Outlook& o) {
    char head[256];
    std::snprintf(head, sizeof head,
                  "%zu instances of %zu archives, %zu triangles; %d channel%s; about %s of memory\n"
                  "predicted for --method reusable --accuracy %g on %u thread%s:\n",
                  scene.instances.size(), scene.objects.size(), scene.triangle_count(), plan.channels,
                  plan.channels == 1 ? "" : "s", size_text(o.memory).c_str(), o.accuracy, thread_count(),
                  thread_count() == 1 ? "" : "s");
    char columns[128];
    std::snprintf(columns, sizeof columns, "  %-16s %-4s %8s %8s %9s %8s  %s\n", "effect", "", "links", "rays", "memory",
                  "seconds", "why");
    std::string text = head + std::string(columns);
    for (const EffectPlan& e : plan.effects) text += table_row(e.name, e.on ? "on" : "off", e.predicted, e.reason);
    text += table_row("all", "", o.work, "");
    return text;
}

std::string explain_json(const Scene& scene, const Plan& plan, const Outlook& o) {
    json effects = json::array();
    for (const EffectPlan& e : plan.effects) {
        json line = {{"name", e.name}, {"on", e.on}, {"reason", e.reason}};
        if (e.predicted) line["predicted"] = work_json(*e.predicted);
        effects.push_back(line);
    }
    const json document = {{"instances", scene.instances.size()}, {"archives", scene.objects.size()},
                           {"triangles", scene.triangle_count()}, {"channels", plan.channels},
                           {"memory_bytes", o.memory},            {"accuracy", o.accuracy},
                           {"threads", thread_count()},
                           {"predicted", work_json(o.work)},      {"effects", effects},
                           {"warnings", plan.warnings}};
    return document.dump(2, ' ', false, json::error_handler_t::replace) + "\n";
}

std::string size_text(std::uint64_t bytes) {
    char text[32];
    const double mebibytes = static_cast<double>(bytes) / (1 << 20);
    std::snprintf(text, sizeof text, mebibytes < 1024 ? "%.0f MiB" : "%.2f GiB",
                  mebibytes < 1024 ? mebibytes : mebibytes / 1024);
    return text;
}

}  // namespace rro
