#include "compiler/build_command.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <system_error>

#include "compiler/archive_facts.h"
#include "compiler/cluster_tree.h"
#include "compiler/import_process.h"
#include "compiler/input_record.h"
#include "format/archive_reader.h"
#include "format/archive_writer.h"
#include "format/clock.h"
#include "format/layout.h"
#include "format/tool/interrupt.h"
#include "format/tool/program.h"
#include "format/version.h"

namespace rro {
namespace fs = std::filesystem;
namespace {

// Part of the options' text: raise it when the same mesh and options give other tables, so that --if-changed notices.
constexpr int kTableVersion = 8;

Error usage(std::string message, std::string hint = {}) {
    return {ErrorKind::Usage, "", std::move(message), std::move(hint)};
}

/// N numbers with commas between them, in [0, below).
template <std::size_t N>
Result<std::array<double, N>> parse_numbers(const std::string& option, const std::string& text, double below,
                                            const std::string& expected) {
    const Error wrong = usage(option + " " + text + ": expected " + expected);
    std::array<double, N> values{};
    const char *at = text.data(), *end = text.data() + text.size();
    for (std::size_t k = 0; k < N; ++k) {
        if (k > 0 && (at == end || *at++ != ',')) return wrong;
        const auto [next, code] = std::from_chars(at, end, values[k]);
        if (code != std::errc{} || !(values[k] >= 0 && values[k] < below)) return wrong;
        at = next;
    }
    if (at != end) return wrong;
    return values;
}

/// The value that belongs to a word, or what the words are.
template <class T>
Result<T> choice(const std::string& option, const std::string& word, const std::map<std::string, T>& values) {
    if (const auto found = values.find(word); found != values.end()) return found->second;
    std::string names;
    for (const auto& entry : values) names += (names.empty() ? "" : ", ") + entry.first;
    return usage(option + " " + word + ": expected one of " + names);
}

Status set_options(const BuildRequest& request, BuildPlan& plan) {
    const auto map =
        choice<GridMap>("--map", request.map, {{"octahedral", GridMap::Octahedral}, {"latlong", GridMap::LatLong}});
    if (!map) return map.error();
    const auto two_sided = choice<TwoSided>("--two-sided", request.two_sided,
                                            {{"auto", TwoSided::Auto}, {"yes", TwoSided::Yes}, {"no", TwoSided::No}});
    if (!two_sided) return two_sided.error();
    const auto unit = choice<double>("--unit", request.unit, {{"m", 1}, {"cm", 0.01}, {"mm", 0.001}, {"in", 0.0254}});
    if (!unit) return unit.error();
    const auto z_up = choice<bool>("--up", request.up, {{"y", false}, {"z", true}});
    if (!z_up) return z_up.error();
    if (request.grid < 2 || request.grid > layout::kMaxGridSize)
        return usage("--grid " + std::to_string(request.grid) + ": expected 2 to " +
                     std::to_string(layout::kMaxGridSize));
    const auto tables = parse_tables(request.tables);
    if (!tables) return tables.error();
    if (!request.reflectance.empty()) {
        const auto rgb = parse_numbers<3>("--reflectance", request.reflectance, 1, "r,g,b, each at least 0 and below 1");
        if (!rgb) return rgb.error();
        plan.import.reflectance = Vec3{(*rgb)[0], (*rgb)[1], (*rgb)[2]};
    }
    if (!request.cluster_weights.empty()) {
        const auto w = parse_numbers<5>("--cluster-weights", request.cluster_weights, 1e6,
                                        "proximity,orientation,reflectivity,aspect,size, each from 0 to below 1e6");
        if (!w) return w.error();
        plan.compile.cluster_weights = {(*w)[0], (*w)[1], (*w)[2], (*w)[3], (*w)[4]};
    }
    plan.materials = request.materials;
    plan.materials_place = request.materials_place;
    plan.import.unit = *unit;
    plan.import.z_up = *z_up;
    plan.two_sided = *two_sided;
    plan.fix_winding = request.fix_winding;
    plan.if_changed = request.if_changed;
    plan.compile.grid_map = *map;
    plan.compile.grid_size = request.grid;
    plan.compile.tables = *tables;
    return Done{};
}

std::string canonical_options(const BuildRequest& request, const BuildPlan& plan) {
    const ClusterWeights& weights = plan.compile.cluster_weights;
    std::string reflectance = "none";
    if (const auto& r = plan.import.reflectance)
        reflectance = shortest(r->x) + "," + shortest(r->y) + "," + shortest(r->z);
    return "grid=" + std::to_string(request.grid) + " map=" + request.map + " two_sided=" + request.two_sided +
           " fix_winding=" + (request.fix_winding ? "yes" : "no") + " unit=" + request.unit + " up=" + request.up +
           " reflectance=" + reflectance + " tables=" + tables_text(plan.compile.tables) +
           " table_version=" + std::to_string(kTableVersion) +
           " image=" + std::to_string(plan.compile.image_resolution) + " patch_area=1/" +
           shortest(plan.compile.patch_area_divisor) + " patch_cone=" + shortest(plan.compile.patch_cone_cosine) +
           " weights=proximity:" + shortest(weights.proximity) + ",orientation:" + shortest(weights.orientation) + ",reflectivity:" + shortest(weights.reflectivity) +
           ",aspect:" + shortest(weights.aspect) + ",size:" + shortest(weights.size) +
           (plan.materials.empty() ? "" : " materials=" + canonical_text(plan.materials));
}

bool names_a_folder(const fs::path& out) {
    std::error_code code;
    return !out.has_filename() || fs::is_directory(out, code);
}

Result<std::vector<BuildTarget>> targets_of(const BuildRequest& request) {
    std::error_code code;
    if (request.meshes.size() == 1 && !names_a_folder(request.out))
        return std::vector<BuildTarget>{{request.meshes.front(), request.out}};
    if (fs::exists(request.out, code) && !fs::is_directory(request.out, code))
        return usage("--out " + request.out.string() + " is a file, but several meshes need a folder");
    std::map<fs::path, fs::path> mesh_of_stem;
    std::vector<BuildTarget> targets;
    for (const fs::path& mesh : request.meshes) {
        const auto [at, is_new] = mesh_of_stem.try_emplace(mesh.stem(), mesh);
        if (!is_new)
            return usage(at->second.string() + " and " + mesh.string() + " would both become " +
                             (request.out / mesh.stem()).string() + ".rro",
                         "build them into different folders");
        targets.push_back({mesh, request.out / (mesh.stem().string() + ".rro")});
    }
    return targets;
}

Status check_targets(const BuildRequest& request, const std::vector<BuildTarget>& targets) {
    std::error_code code;
    std::set<fs::path> meshes;
    for (const fs::path& mesh : request.meshes) meshes.insert(fs::weakly_canonical(mesh, code));
    for (const BuildTarget& target : targets)
        if (meshes.contains(fs::weakly_canonical(target.archive, code)))
            return usage("--out " + target.archive.string() + " would be written over the mesh");
    const bool to_folder = targets.size() > 1 || targets.front().archive != request.out;
    if (to_folder && !fs::create_directories(request.out, code) && code)
        return failed(request.out.string(), "the folder cannot be made: " + code.message());
    // Found out now rather than after minutes of work.
    for (const fs::path& output : {targets.front().archive, request.depfile, request.report}) {
        const fs::path folder = output.parent_path();
        if (!folder.empty() && !fs::is_directory(folder, code))
            return failed(output.string(), "cannot be written: there is no folder " + folder.string());
    }
    return Done{};
}

/// Whether the archive is there, made by this compiler with these options from a source of this hash.
bool is_current(const BuildTarget& target, const BuildPlan& plan, const std::string& sha256, BuildOutcome& outcome) {
    std::error_code code;
    if (!fs::exists(target.archive, code)) return false;
    const auto archive = Archive::open(target.archive, Section::Meta);
    if (!archive) return false;
    outcome.meta = archive->data().meta;
    outcome.bytes = archive->file_bytes();
    return outcome.meta.source_sha256 == sha256 && outcome.meta.options == plan.options &&
           outcome.meta.tool_version == kToolVersion && outcome.meta.source_name == target.mesh.filename().string();
}

/// The same without an import, where the record beside the archive allows that.
bool is_current_by_record(const BuildTarget& target, const BuildPlan& plan, BuildOutcome& outcome) {
    auto inputs = read_recorded_inputs(target.archive, target.mesh);
    if (!inputs || !is_current(target, plan, inputs->sha256, outcome)) return false;
    outcome.inputs = std::move(inputs->read);
    return true;
}

void warn_of_import(BuildOutcome& outcome, const BuildPlan& plan, std::uint32_t dropped_by_rounding) {
    const auto warn = [&](std::uint32_t count, const std::string& what) {
        if (count > 0)
            outcome.warnings.push_back(std::to_string(count) + (count == 1 ? " triangle " : " triangles ") + what);
    };
    constexpr double kUnlikelySmall = 1e-3, kUnlikelyLarge = 1e3;  // metres: more likely another unit
    const ImportReport& r = outcome.import;
    warn(r.dropped_not_finite, "dropped: a corner is not a finite number");
    warn(r.dropped_degenerate, "dropped: no area");
    warn(dropped_by_rounding, "dropped: no area in single precision");
    warn(r.duplicate_triangles, r.duplicate_triangles == 1 ? "dropped: lies exactly on another" : "dropped: lie exactly on others");
    if (r.ignored_faces > 0)
        outcome.warnings.push_back(std::to_string(r.ignored_faces) + " faces ignored: fewer than three corners");
    if (r.reflectance_clamped > 0)
        outcome.warnings.push_back(std::to_string(r.reflectance_clamped) +
                                   " materials reflected more than 0.95, now 0.95");
    if (r.reflectance_assumed > 0 && !plan.import.reflectance)
        outcome.warnings.push_back(std::to_string(r.reflectance_assumed) +
                                   (r.reflectance_assumed == 1 ? " material" : " materials") +
                                   " without a colour: reflectance 0.5 assumed (--reflectance, or the manifest)");
    const double size = max_component(r.extent);
    if (size < kUnlikelySmall || size > kUnlikelyLarge)
        outcome.warnings.push_back("the object extends over " + shortest(size) + " m: check --unit");
}

void count_contents(const ObjectData& data, BuildOutcome& outcome) {
    outcome.meta = data.meta;
    outcome.triangles = data.triangles.size();
    outcome.faces = data.faces.size();
    outcome.patches = data.patches.size();
    outcome.clusters = data.clusters.size();
    outcome.volumes = data.volumes.size();
}

/// The steps of build_target; the outcome's error and seconds are the caller's.
Status build_into(BuildOutcome& outcome, const BuildPlan& plan, const CompileProgress& progress) {
    const BuildTarget& target = outcome.target;
    outcome.unchanged = plan.if_changed && is_current_by_record(target, plan, outcome);
    if (outcome.unchanged) return Done{};
    auto imported = import_mesh_contained(target.mesh, plan.import, plan.two_sided, plan.fix_winding);
    if (!imported) return imported.error();
    outcome.inputs = imported->files;
    const InputFiles inputs{imported->files, imported->report.absent};
    outcome.unchanged = plan.if_changed && is_current(target, plan, imported->sha256, outcome);
    if (outcome.unchanged) {
        const DeferInterrupts until_written;
        write_input_record(target.archive, inputs);
        return Done{};
    }
    if (auto changed = change_materials(imported->mesh, plan.materials, plan.materials_place); !changed)
        return changed.error();
    outcome.import = imported->report;
    outcome.warnings = imported->report.warnings;
    auto object = compile_object(imported->mesh, plan.compile, progress);
    if (!object) {
        Error error = object.error();
        error.where = target.mesh.string();
        return error;
    }
    warn_of_import(outcome, plan, object->dropped_by_rounding);
    object->data.meta.source_name = target.mesh.filename().string();
    object->data.meta.source_sha256 = imported->sha256;
    object->data.meta.options = plan.options;
    count_contents(object->data, outcome);
    const DeferInterrupts until_written;
    if (const auto written = write_archive(object->data, target.archive); !written) return written.error();
    std::error_code code;
    outcome.bytes = fs::file_size(target.archive, code);
    if (plan.if_changed) write_input_record(target.archive, inputs);
    return Done{};
}

std::string escaped_for_make(const fs::path& path) {
    std::string text;
    for (const char c : path.string()) {
        if (c == ' ' || c == '#' || c == '\\') text += '\\';
        if (c == '$') text += '$';
        text += c;
    }
    return text;
}

nlohmann::ordered_json report_of(const BuildOutcome& o) {
    nlohmann::ordered_json entry{{"mesh", o.target.mesh.string()}, {"archive", o.target.archive.string()}};
    if (o.error) {
        entry["state"] = "failed";
        entry["error"] = {{"where", o.error->where}, {"message", o.error->message}, {"hint", o.error->hint}};
        return entry;
    }
    const ImportReport& r = o.import;
    entry["state"] = o.unchanged ? "unchanged" : "written";
    entry["source_sha256"] = o.meta.source_sha256;
    entry["options"] = o.meta.options;
    entry["seconds"] = o.seconds;
    entry["object"] = {{"area", o.meta.area}, {"closed", o.meta.closed}, {"convex", o.meta.convex}, {"bytes", o.bytes}};
    if (o.unchanged) return entry;
    entry["import"] = {{"source_triangles", r.source_triangles},
                       {"dropped_not_finite", r.dropped_not_finite},
                       {"dropped_degenerate", r.dropped_degenerate},
                       {"ignored_faces", r.ignored_faces},
                       {"duplicate_triangles", r.duplicate_triangles},
                       {"welded_vertices", r.welded_vertices},
                       {"polygons_triangulated", r.polygons_triangulated},
                       {"polygons_ear_clipped", r.polygons_ear_clipped},
                       {"reflectance_clamped", r.reflectance_clamped},
                       {"reflectance_assumed", r.reflectance_assumed},
                       {"textures_not_read", r.textures_not_read},
                       {"components", r.components},
                       {"closed_components", r.closed_components},
                       {"open_edges", r.open_edges},
                       {"non_manifold_edges", r.non_manifold_edges},
                       {"one_sided_triangles", r.one_sided_triangles},
                       {"two_sided_triangles", r.two_sided_triangles},
                       {"winding_fixed", r.winding_fixed},
                       {"extent", {r.extent.x, r.extent.y, r.extent.z}}};
    entry["object"].update({{"triangles", o.triangles},
                            {"faces", o.faces},
                            {"patches", o.patches},
                            {"clusters", o.clusters},
                            {"volumes", o.volumes}});
    entry["warnings"] = o.warnings;
    return entry;
}

}  // namespace

Result<BuildPlan> plan_build(const BuildRequest& request) {
    BuildPlan plan;
    if (const auto set = set_options(request, plan); !set) return set.error();
    auto targets = targets_of(request);
    if (!targets) return targets.error();
    if (const auto good = check_targets(request, *targets); !good) return good.error();
    plan.targets = std::move(*targets);
    plan.options = canonical_options(request, plan);
    return plan;
}

BuildOutcome build_target(const BuildTarget& target, const BuildPlan& plan, const CompileProgress& progress) {
    const auto start = Clock::now();
    BuildOutcome outcome;
    outcome.target = target;
    try {
        if (const auto built = build_into(outcome, plan, progress); !built) outcome.error = built.error();
    } catch (const std::exception& exception) {  // out of memory: the other objects may be smaller
        outcome.error = error_from_exception(exception);
        if (outcome.error->where.empty()) outcome.error->where = target.mesh.string();
    }
    outcome.seconds = seconds_since(start);
    return outcome;
}

std::string summary_line(const BuildOutcome& o) {
    std::array<char, 256> text;
    if (o.unchanged)
        std::snprintf(text.data(), text.size(), ": unchanged, %.1f kB", static_cast<double>(o.bytes) / 1000);
    else
        std::snprintf(text.data(), text.size(), ": %zu triangles, %zu faces, %zu patches, %s%s%.1f kB, %.2f s",
                      o.triangles, o.faces, o.patches, o.meta.closed ? "closed, " : "open, ",
                      o.meta.convex ? "convex, " : "", static_cast<double>(o.bytes) / 1000, o.seconds);
    return o.target.archive.string() + text.data();
}

std::string depfile_text(const std::vector<BuildOutcome>& outcomes, const fs::path& also) {
    std::string text;
    for (const BuildOutcome& o : outcomes) {
        if (o.error) continue;
        text += escaped_for_make(o.target.archive) + ":";
        for (const fs::path& input : o.inputs) text += " \\\n  " + escaped_for_make(input);
        if (!also.empty()) text += " \\\n  " + escaped_for_make(also);
        text += "\n";
    }
    return text;
}

std::string build_report(const std::vector<BuildOutcome>& outcomes) {
    nlohmann::ordered_json report{{"tool", "rro-compile"}, {"version", kToolVersion}};
    report["archives"] = nlohmann::ordered_json::array();
    for (const BuildOutcome& o : outcomes) report["archives"].push_back(report_of(o));
    return report.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace rro
