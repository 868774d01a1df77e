#include "solver/tradeoff/sweep.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <set>
#include <system_error>

#include "format/archive_reader.h"
#include "solver/study/compare.h"

namespace rro {
namespace {

namespace fs = std::filesystem;

// The truth is made by `run` or here with seed 1; a reference that is judged by it must not share its random numbers.
constexpr std::uint64_t kSweepSeed = 1001;

std::string text_of(double value) {
    std::array<char, 32> text;
    std::snprintf(text.data(), text.size(), "%g", value);
    return text.data();
}

Trial trial_at(Method method, double accuracy) {
    Trial trial;
    trial.method = method;
    trial.solve.method = method;
    trial.solve.accuracy = accuracy;
    trial.solve.seed = kSweepSeed;
    return trial;
}

/// How a library's tables were made; where archives differ from one another it says so.
struct TableSettings {
    std::set<std::uint32_t> grids;
    std::set<GridMap> maps;
    std::set<std::string> sections;  // of any archive
    std::set<std::string> contents;  // of the files

    bool operator==(const TableSettings&) const = default;
};

Result<TableSettings> settings_of(const Manifest& manifest) {
    TableSettings settings;
    std::set<fs::path> files;
    for (const InstanceEntry& entry : manifest.instances) files.insert(entry.archive);
    for (const fs::path& file : files) {
        const auto archive = Archive::open(file, kGeometry);
        if (!archive) return archive.error();
        settings.grids.insert(archive->data().meta.grid_size);
        settings.maps.insert(archive->data().meta.grid_map);
        for (const SectionInfo& section : archive->sections()) settings.sections.insert(section.name);
        settings.contents.insert(archive->content_sha256());
    }
    return settings;
}

const char* name_of(GridMap map) {
    return map == GridMap::Octahedral ? "octahedral" : "latlong";
}

/// By what a variant differs from the scene's own archives: a knob and its value.
std::array<std::string, 2> difference(const TableSettings& own, const TableSettings& other, const fs::path& folder) {
    const bool grid = own.grids != other.grids && other.grids.size() == 1;
    const bool map = own.maps != other.maps && other.maps.size() == 1;
    if (grid && own.maps == other.maps) return {"grid", std::to_string(*other.grids.begin())};
    if (map && own.grids == other.grids) return {"map", name_of(*other.maps.begin())};
    return {own.grids == other.grids && own.maps == other.maps ? "tables" : "library", folder.filename().string()};
}

bool has_archives(const fs::path& folder) {
    std::error_code unreadable;
    for (const auto& entry : fs::directory_iterator(folder, unreadable))
        if (entry.path().extension() == ".rro") return true;
    return false;
}

/// The folders of archives that are meant, in the order of their names.
Result<std::vector<fs::path>> libraries_in(const std::vector<fs::path>& variants) {
    std::vector<fs::path> libraries;
    for (const fs::path& given : variants) {
        std::error_code none;
        const fs::path folder = given.has_filename() ? given : given.parent_path();
        if (!fs::is_directory(folder, none)) return bad_input(folder.string(), "is no folder, expected one of archives");
        if (has_archives(folder)) {
            libraries.push_back(folder);
            continue;
        }
        const std::size_t before = libraries.size();
        for (const auto& entry : fs::directory_iterator(folder, none))
            if (entry.is_directory(none) && has_archives(entry.path())) libraries.push_back(entry.path());
        if (libraries.size() == before) return bad_input(folder.string(), "holds no archives, and no folders of archives");
        std::sort(libraries.begin() + static_cast<std::ptrdiff_t>(before), libraries.end());
    }
    return libraries;
}

void add_variants(const Manifest& manifest, const std::vector<fs::path>& libraries, const TableSettings& own, Sweep& sweep) {
    for (const fs::path& library : libraries) {
        const auto there = with_archives_in(manifest, library);
        const auto settings = there ? settings_of(*there) : Result<TableSettings>(there.error());
        if (!settings) {
            sweep.not_swept.push_back({"library " + library.string(), settings.error().message});
            continue;
        }
        if (own == *settings) {
            sweep.not_swept.push_back({"library " + library.string(), "its archives are the scene's own"});
            continue;
        }
        Trial trial = trial_at(Method::Reusable, sweep.knobs_at);
        const auto [knob, value] = difference(own, *settings, library);
        trial.knob = knob, trial.value = value;
        trial.library = library;
        sweep.trials.push_back(std::move(trial));
    }
}

void add_solver_knobs(const TableSettings& own, Sweep& sweep) {
    const auto add = [&](const char* knob, std::string value, const auto& set) {
        Trial trial = trial_at(Method::Reusable, sweep.knobs_at);
        trial.knob = knob, trial.value = std::move(value);
        set(trial.solve);
        sweep.trials.push_back(std::move(trial));
    };
    for (const double factor : {2.5, 3.5, 7.0, 10.0})  // 5 is the rule
        add("far factor", text_of(factor), [&](SolveOptions& o) { o.far_factor = factor; });
    for (const char* method : {"rays", "atlas", "tables", "none"}) {
        const std::string section = method == std::string("tables") ? "hit" : method;
        if ((section == "hit" || section == "atlas") && !own.sections.contains(section))
            sweep.not_swept.push_back({std::string("visibility ") + method, "archives without the section " + section});
        else
            add("visibility", method, [&](SolveOptions& o) { o.visibility = *parse_visibility(method); });
    }
    add("transport", "plain", [](SolveOptions& o) { o.transport = Transport::Plain; });
    for (const std::uint64_t seed : {kSweepSeed + 1, kSweepSeed + 2})
        add("sampling", "seed " + std::to_string(seed), [&](SolveOptions& o) { o.seed = seed; });
}

/// Values of knobs that only a library compiled for them can show.
void list_missing(const TableSettings& own, Sweep& sweep) {
    const auto has = [&](const std::string& knob, const std::string& value) {
        return std::any_of(sweep.trials.begin(), sweep.trials.end(),
                           [&](const Trial& t) { return t.knob == knob && (value.empty() || t.value == value); });
    };
    const char* hint = "no folder of --variants holds the scene's archives compiled so";
    for (const std::uint32_t n : {6u, 12u, 16u, 24u})
        if (!own.grids.contains(n) && !has("grid", std::to_string(n)))
            sweep.not_swept.push_back({"grid " + std::to_string(n), hint});
    for (const GridMap map : {GridMap::Octahedral, GridMap::LatLong})
        if (!own.maps.contains(map) && !has("map", name_of(map)))
            sweep.not_swept.push_back({std::string("map ") + name_of(map), hint});
    if (!has("tables", "") && !has("library", "")) sweep.not_swept.push_back({"tables", hint});
    sweep.not_swept.push_back({"rays of a link", "the solver takes as many as the accuracy needs; the seeds of \"sampling\" show "
                                                 "what their places change"});
}

Status check(const SweepOptions& options) {
    const auto bad = [](double a) { return !(a > 0 && a <= 1); };
    if (options.accuracies.empty() || std::any_of(options.accuracies.begin(), options.accuracies.end(), bad) ||
        (options.knobs_at && bad(*options.knobs_at)))
        return Error{ErrorKind::Usage, "", "expected relative errors above 0 and at most 1 for --accuracy and --knobs-at", ""};
    return Done{};
}

}  // namespace

std::string name_of(Method method) {
    switch (method) {
        case Method::Reusable: return "reusable";
        case Method::Hierarchical: return "hierarchical";
        case Method::Reference: return "reference";
    }
    return "";
}

std::string name_of(const Trial& trial) {
    const std::string name = name_of(trial.method) + " at " + text_of(trial.solve.accuracy.value_or(0));
    return trial.knob.empty() ? name : name + ", " + trial.knob + " " + trial.value;
}

Result<Sweep> plan_sweep(const Manifest& manifest, const SweepOptions& options) {
    if (auto good = check(options); !good) return good.error();
    std::vector<double> accuracies = options.accuracies;
    std::sort(accuracies.rbegin(), accuracies.rend());
    accuracies.erase(std::unique(accuracies.begin(), accuracies.end()), accuracies.end());
    Sweep sweep;
    for (const double accuracy : accuracies)
        for (const Method method : options.methods) sweep.trials.push_back(trial_at(method, accuracy));
    sweep.knobs_at = options.knobs_at.value_or(accuracies[accuracies.size() / 2]);
    const auto libraries = libraries_in(options.variants);
    if (!libraries) return libraries.error();
    if (!options.knobs) return sweep;
    const auto own = settings_of(manifest);
    if (!own) return own.error();
    // Knobs are compared with the method as it is, at the same accuracy.
    if (std::none_of(sweep.trials.begin(), sweep.trials.end(), [&](const Trial& t) {
            return t.method == Method::Reusable && *t.solve.accuracy == sweep.knobs_at;
        }))
        sweep.trials.push_back(trial_at(Method::Reusable, sweep.knobs_at));
    add_variants(manifest, *libraries, *own, sweep);
    add_solver_knobs(*own, sweep);
    list_missing(*own, sweep);
    return sweep;
}

}  // namespace rro
