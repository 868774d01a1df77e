#include "compiler/library_build.h"

#include <algorithm>
#include <map>
#include <mutex>
#include <string>
#include <system_error>

#include "format/parallel.h"
#include "format/tool/json_document.h"
#include "schemas/library_schema.h"

namespace rro {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

Vec3 to_vec3(const json& value) {
    return {value[0].get<double>(), value[1].get<double>(), value[2].get<double>()};
}

/// As --reflectance has it.
std::string to_triple(const json& value) {
    return value[0].dump() + "," + value[1].dump() + "," + value[2].dump();
}

std::string two_sided_word(const json& value) {
    if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
    return value.get<std::string>();
}

MaterialChanges read_materials(const json& value) {
    MaterialChanges changes;
    for (const auto& [name, fields] : value.items()) {
        if (name == "extras") continue;
        MaterialChange& change = changes.emplace_back(name, MaterialChange{}).second;
        if (fields.contains("reflectance")) change.reflectance = to_vec3(fields["reflectance"]);
        if (fields.contains("exitance")) change.exitance = to_vec3(fields["exitance"]);
    }
    std::stable_partition(changes.begin(), changes.end(), [](const auto& change) { return change.first == "*"; });
    return changes;
}

std::string place_of(std::size_t object) {
    return "/objects/" + std::to_string(object);
}

Status check_names(const json& objects, const std::string& library) {
    std::map<std::string, std::size_t> names;
    for (std::size_t i = 0; i < objects.size(); ++i) {
        for (const char* key : {"name", "mesh"})
            if (objects[i][key].get_ref<const std::string&>().find('\0') != std::string::npos)
                return bad_input(json_place(library, place_of(i)) + "/" + key, "a path cannot hold a NUL character");
        const auto [first, is_new] = names.emplace(objects[i]["name"].get<std::string>(), i);
        if (!is_new)
            return bad_input(json_place(library, place_of(i)) + "/name",
                             "found " + described(objects[i]["name"]) + ", the name of " + place_of(first->second) +
                                 " already; expected another");
    }
    return Done{};
}

/// The object's own options over the library's defaults, as a command line of `build`.
BuildRequest request_for(const json& object, const json& defaults, const std::string& where) {
    json options = defaults;
    options.update(object);
    BuildRequest r;
    r.grid = options.value("grid", r.grid);
    r.map = options.value("map", r.map);
    if (options.contains("two_sided")) r.two_sided = two_sided_word(options["two_sided"]);
    r.fix_winding = options.value("fix_winding", r.fix_winding);
    r.unit = options.value("unit", r.unit);
    r.up = options.value("up", r.up);
    if (options.contains("reflectance")) r.reflectance = to_triple(options["reflectance"]);
    r.cluster_weights = options.value("cluster_weights", r.cluster_weights);
    r.tables = options.value("tables", r.tables);
    r.if_changed = true;
    if (object.contains("materials")) r.materials = read_materials(object["materials"]);
    r.materials_place = where + "/materials";
    return r;
}

Result<BuildPlan> plan_object(const json& object, const json& defaults, const LibraryRequest& library,
                              const std::string& where) {
    const std::string name = object["name"].get<std::string>(), mesh = object["mesh"].get<std::string>();
    BuildRequest request = request_for(object, defaults, where);
    const BuildTarget target{(library.library.parent_path() / mesh).lexically_normal(), library.out / (name + ".rro")};
    request.meshes = {target.mesh};
    request.out = target.archive;
    request.depfile = library.depfile;
    request.report = library.report;
    auto plan = plan_build(request);
    if (!plan) {
        Error error = library_error(plan.error());
        if (error.where.empty()) error.where = where;
        return error;
    }
    plan->targets = {target};  // even where a folder of that name is in the way: writing it says so
    return plan;
}

/// Meshes of this many bytes together are compiled at once. A compile takes some twenty times the size of its mesh (16
/// to 28 measured on OBJ files), so this bounds it to little more than 1 GB, or what the largest mesh takes alone.
constexpr std::uint64_t kSourceBytesAtOnce = std::uint64_t{64} << 20;

struct Job {
    const BuildTarget* target;
    const BuildPlan* plan;
};

/// Outcomes as they come in, passed on in order.
class OutcomeLog {
  public:
    OutcomeLog(std::size_t count, const BuildListener& listener)
        : outcomes_(count), ready_(count), listener_(listener) {
        report_progress();
    }

    void add(std::size_t number, BuildOutcome outcome) {
        const std::lock_guard lock(mutex_);
        outcomes_[number] = std::move(outcome);
        ready_[number] = true;
        ++done_;
        for (; told_ < ready_.size() && ready_[told_]; ++told_)
            if (listener_.done) listener_.done(outcomes_[told_]);
        report_progress();
    }

    std::vector<BuildOutcome> take() { return std::move(outcomes_); }

  private:
    void report_progress() const {
        if (!listener_.progress || ready_.size() < 2 || done_ == ready_.size()) return;
        listener_.progress(std::to_string(done_) + " of " + std::to_string(ready_.size()) + " objects",
                           static_cast<double>(done_) / static_cast<double>(ready_.size()));
    }

    std::vector<BuildOutcome> outcomes_;
    std::vector<bool> ready_;
    const BuildListener& listener_;
    std::mutex mutex_;
    std::size_t done_ = 0, told_ = 0;
};

}  // namespace

Error library_error(const Error& error) {
    Error seen = error;
    if (error.kind == ErrorKind::Usage) seen.kind = ErrorKind::BadInput;
    if (error.kind == ErrorKind::BadInput) seen.kind = ErrorKind::Failed;
    return seen;
}

Result<std::vector<BuildPlan>> plan_library(const LibraryRequest& request) {
    const std::string name = request.library.string();
    const auto document = read_json(request.library);
    if (!document) return document.error();
    static const JsonSchema schema(library_schema);
    if (auto fits = schema.check(*document, name); !fits) return fits.error();
    const json& objects = (*document)["objects"];
    if (auto good = check_names(objects, name); !good) return good.error();
    std::error_code code;
    if (!fs::create_directories(request.out, code) && code)
        return failed(request.out.string(), "the folder cannot be made: " + code.message());

    std::vector<BuildPlan> plans;
    const json defaults = document->value("defaults", json::object());
    for (std::size_t i = 0; i < objects.size(); ++i) {
        auto plan = plan_object(objects[i], defaults, request, json_place(name, place_of(i)));
        if (!plan) return plan.error();
        plans.push_back(*std::move(plan));
    }
    return plans;
}

std::vector<BuildOutcome> build_all(std::span<const BuildPlan> plans, const BuildListener& listener) {
    std::vector<Job> jobs;
    std::vector<std::uint64_t> bytes;
    for (const BuildPlan& plan : plans)
        for (const BuildTarget& target : plan.targets) {
            jobs.push_back({&target, &plan});
            std::error_code missing;
            const auto size = fs::file_size(target.mesh, missing);
            bytes.push_back(missing ? 0 : size);
        }
    OutcomeLog log(jobs.size(), listener);
    const CompileProgress phases = jobs.size() == 1 ? listener.progress : CompileProgress{};
    parallel_jobs(bytes, kSourceBytesAtOnce,
                  [&](std::size_t i) { log.add(i, build_target(*jobs[i].target, *jobs[i].plan, phases)); });
    return log.take();
}

}  // namespace rro
