// rro-solve: arguments, exit code, printing; no logic.
#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <iostream>
#include <optional>

#include "format/atomic_file.h"
#include "format/parallel.h"
#include "format/tool/interrupt.h"
#include "format/tool/program.h"
#include "format/version.h"
#include "solver/arguments.h"
#include "solver/edit/edit_arguments.h"
#include "solver/edit/live.h"
#include "solver/edit/manifest_edit.h"
#include "solver/explain.h"
#include "solver/factors/factors_output.h"
#include "solver/factors/previous_factors.h"
#include "solver/output/output.h"
#include "solver/solve_scene.h"
#include "solver/study/compare.h"
#include "solver/tradeoff/tradeoff.h"

namespace rro {
namespace {

constexpr const char* kProgram = "rro-solve";
constexpr const char* kExamples =
    "Examples:\n"
    "  rro-solve run room.json --out room.glb --picture room.png\n"
    "  rro-solve run room.json --radiosity room.csv --report room.report.json --accuracy 0.05\n"
    "  rro-solve run room.json --method reference --radiosity truth.csv\n"
    "  rro-solve run room.json --method hierarchical --accuracy 0.1 --report classic.json\n"
    "  rro-solve explain room.json\n"
    "  rro-solve place room.json chair library/chair.rro --translate 2.7,0,3 --rotate 0,1,0,186\n"
    "  rro-solve move room.json chair --translate 2.2,0,3\n"
    "  rro-solve delete room.json chair\n"
    "  echo '{\"op\":\"move\",\"name\":\"chair\",\"transform\":{\"translate\":[2,0,3]}}' | rro-solve live room.json\n"
    "  rro-solve factors room.json --out factors.csv\n"
    "  rro-solve factors room.json --out factors.json --by material --accuracy 1e-4 --report factors.report.json\n"
    "  rro-solve factors room.json --reuse factors.json --out factors.json --by material --accuracy 1e-4\n"
    "  rro-solve compare room.json --base library-1.0 --head library-1.1 --fail-if-slower 1.1 --markdown change.md\n"
    "  rro-solve tradeoff room.json --out tradeoff --accuracy 0.3,0.2,0.1 --variants library-variants\n"
    "Exit codes: 0 done, 1 the work failed or the accuracy was not met, 2 wrong usage, 3 bad input, 4 internal error,\n"
    "130 interrupted.";

struct Arguments {
    std::filesystem::path scene, out, picture, radiosity, report;
    std::string size = "960x540", method = "reusable", transport, visibility = "auto", memory;
    std::optional<double> accuracy;
    std::uint32_t samples = 0;
    std::uint64_t seed = 1;
    unsigned threads = 0;
    EffectOverrides overrides;
    bool quiet = false, verbose = false, json = false;
    std::string by, sides = "front";
    std::string name;
    std::filesystem::path archive;
    TransformOptions transform;
    std::optional<double> threshold;
    bool close = false;
    std::filesystem::path reuse;
    CompareOptions compare;
    TradeoffOptions tradeoff;
    std::vector<std::string> methods = {"reusable", "hierarchical", "reference"};
    bool no_knobs = false, no_pictures = false;
    std::filesystem::path json_file, markdown_file;
};

void declare_common(CLI::App& command, Arguments& a) {
    command.add_option("scene", a.scene, "Scene manifest")->required()->type_name("SCENE.json");
    command.add_option("--threads", a.threads, "Threads to use; 0: all cores")->type_name("N");
    command.add_flag("--quiet,-q", a.quiet, "Print errors only");
    command.footer(kExamples);
}

void declare_shared(CLI::App& command, Arguments& a) {
    declare_common(command, a);
    command.add_option("--with", a.overrides.with, "Effect to switch on although the scene does not call for it")
        ->type_name("EFFECT")
        ->allow_extra_args(false)
        ->delimiter(',');
    command.add_option("--without", a.overrides.without, "Effect to leave out although the scene calls for it")
        ->type_name("EFFECT")
        ->allow_extra_args(false)
        ->delimiter(',');
    command.add_option("--accuracy", a.accuracy, "Relative error aimed at (default: the manifest's, or 0.02)")
        ->type_name("E");
    command.add_flag("--verbose,-v", a.verbose, "Print the effect plan and all warnings to stderr");
}

void declare_run(CLI::App& run, Arguments& a) {
    declare_shared(run, a);
    run.add_option("--out", a.out, "Solution as binary glTF")->type_name("SCENE.glb");
    run.add_option("--picture", a.picture, "Picture from the manifest's camera, .png or .exr")->type_name("VIEW.png");
    run.add_option("--size", a.size, "Pixels of the picture")->type_name("WxH")->capture_default_str();
    run.add_option("--radiosity", a.radiosity, "Radiosity per source triangle, W/m^2")->type_name("FILE.csv");
    run.add_option("--report", a.report, "What the solve did, as JSON")->type_name("FILE.json");
    run.add_option("--method", a.method, "reusable, hierarchical or reference")->type_name("METHOD")->capture_default_str();
    run.add_option("--transport", a.transport,
                   "directional, or plain: alike in all directions, as in the paper (default: directional)")
        ->type_name("HOW");
    run.add_option("--visibility", a.visibility, "auto, atlas, tables, rays or none")->type_name("HOW")->capture_default_str();
    run.add_option("--samples", a.samples, "Paths per triangle (reference); 0: as --accuracy needs")->type_name("N");
    run.add_option("--seed", a.seed, "Seed of all random choices")->type_name("N")->capture_default_str();
    run.add_option("--memory", a.memory, "Most memory to use (default: 8G or ulimit -v)")->type_name("8G");
}

void declare_transform(CLI::App& command, Arguments& a) {
    command.add_option("--translate", a.transform.translate, "Where to, in metres")->type_name("x,y,z");
    command.add_option("--rotate", a.transform.rotate, "Axis and degrees, right-handed")->type_name("ax,ay,az,deg");
    command.add_option("--scale", a.transform.scale, "One factor, or one per axis; before the rotation")->type_name("s|x,y,z");
    command.add_option("--matrix", a.transform.matrix, "The whole transform: 16 numbers, row by row")
        ->expected(1, 16)
        ->type_name("m");
}

/// place, move and delete.
void declare_edits(CLI::App& app, Arguments& a) {
    const auto declare = [&](const char* name, const char* help) {
        CLI::App* command = app.add_subcommand(name, help);
        declare_common(*command, a);
        command->add_option("name", a.name, "Name of the instance")->required()->type_name("NAME");
        return command;
    };
    CLI::App* place = declare("place", "Place an archive in a manifest");
    place->add_option("archive", a.archive, "Relative to the working folder")->required()->type_name("ARCHIVE");
    declare_transform(*place, a);
    declare_transform(*declare("move", "Replace parts of an instance's transform; the others stay"), a);
    declare("delete", "Take an instance out of a manifest");
}

void declare_live(CLI::App& live, Arguments& a) {
    declare_shared(live, a);
    live.add_option("--visibility", a.visibility, "auto, atlas, tables, rays or none")->type_name("HOW")->capture_default_str();
    live.add_option("--seed", a.seed, "Seed of all random choices")->type_name("N")->capture_default_str();
    live.add_option("--memory", a.memory, "Most memory to use (default: 8G or ulimit -v)")->type_name("8G");
}

Status check_accuracy(const Arguments& a) {
    if (a.accuracy && !(*a.accuracy > 0 && *a.accuracy <= 1))
        return Error{ErrorKind::Usage, "", "--accuracy: expected a relative error above 0 and at most 1", ""};
    return Done{};
}

void declare_factors(CLI::App& factors, Arguments& a) {
    declare_common(factors, a);
    factors.add_option("--out", a.out, "View factors, .csv or .json")->required()->type_name("F.csv|F.json");
    factors.add_option("--by", a.by, "instance, material or group (default: group if the manifest has any, else instance)")
        ->type_name("WHAT");
    factors.add_option("--sides", a.sides, "front, or both sides of two-sided surfaces")
        ->type_name("SIDES")
        ->capture_default_str();
    factors.add_option("--accuracy", a.accuracy,
                       "Error aimed at: relative above F = 0.01, a hundredth of it absolute below (default: 1e-3)")
        ->type_name("E");
    factors.add_option("--threshold", a.threshold, "Write only factors of at least this (default: all, zeros included)")
        ->type_name("F");
    factors.add_option("--reuse", a.reuse,
                       "Factors written before to a .json: only what has changed since is computed again")
        ->type_name("F.json");
    factors.add_flag("--close", a.close, "Correct the factors so that rows sum to 1, as little as can be");
    factors.add_option("--report", a.report, "What was done, as JSON: closure, reciprocity, time")->type_name("FILE.json");
    factors.add_option("--memory", a.memory, "Most memory to use (default: 8G or ulimit -v)")->type_name("8G");
    factors.add_flag("--verbose,-v", a.verbose, "Print every row's sum to stderr");
}

/// The options of `run` as the pipeline takes them.
struct Job {
    SolveOptions solve;
    PictureOptions picture;
    std::uint64_t memory = 0;
};

Result<Job> job_of(const Arguments& a) {
    Job job;
    const auto method = parse_method(a.method);
    if (!method) return method.error();
    const auto transport = parse_transport(a.transport.empty() ? "directional" : a.transport);
    if (!transport) return transport.error();
    const auto visibility = parse_visibility(a.visibility);
    if (!visibility) return visibility.error();
    const auto size = parse_size(a.size);
    if (!size) return size.error();
    const auto memory = a.memory.empty() ? Result<std::uint64_t>(default_memory()) : parse_bytes(a.memory);
    if (!memory) return memory.error();
    if (auto good = check_accuracy(a); !good) return good.error();
    const std::string ending = a.picture.extension().string();
    if (!a.picture.empty() && ending != ".png" && ending != ".exr")
        return Error{ErrorKind::Usage, "",
                     "--picture " + a.picture.string() + ": expected a name ending in .png or .exr", ""};
    job.solve = {*method, a.accuracy, *visibility, a.samples, a.seed, a.overrides};
    job.solve.memory = *memory;
    if (!a.transport.empty()) job.solve.transport = *transport;
    job.picture.width = (*size)[0];
    job.picture.height = (*size)[1];
    job.memory = *memory;
    return job;
}

double seconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// What a run uses of the archives.
SectionSet sections_for(const Arguments& a, const Job& job) {
    SectionSet wanted = kGeometry;
    if (job.solve.method == Method::Reusable) wanted = wanted | kTables | sections_of(job.solve.visibility);
    if (!a.radiosity.empty()) wanted = wanted | Section::Source;
    return wanted;
}

Result<Scene> load(const Arguments& a, SectionSet wanted) {
    auto manifest = read_manifest(a.scene);
    if (!manifest) return manifest.error();
    auto scene = open_scene(std::move(*manifest), wanted);
    if (scene) leave_out(a.overrides, *scene);
    return scene;
}

void print_plan(std::FILE* to, const std::vector<EffectPlan>& effects) {
    for (const EffectPlan& e : effects)
        std::fprintf(to, "  %-16s %-4s %s\n", e.name.c_str(), e.on ? "on" : "off", e.reason.c_str());
}

void print_summary(const Scene& scene, const Solution& s, std::optional<double> exposure) {
    const auto count = [](auto n) { return static_cast<unsigned long long>(n); };
    const PhaseSeconds& t = s.seconds;
    std::printf("%llu instances, %llu triangles, %llu elements\n", count(scene.instances.size()),
                count(scene.triangle_count()), count(s.elements));
    std::printf(
        "seconds          %.2f (load %.2f, plan %.2f, links %.2f, visibility %.2f, iterate %.2f, output %.2f)\n",
        t.total, t.load, t.plan, t.links, t.visibility, t.iterate, t.output);
    std::printf("links            %llu (far %llu, near %llu, self %llu); rays %llu; iterations %d\n",
                count(s.links.total()), count(s.links.far), count(s.links.near), count(s.links.self), count(s.rays),
                s.iterations);
    std::printf("estimated error  %.3g, asked for %.3g%s\n", s.estimated_error, s.accuracy,
                s.converged ? "" : " (not met)");
    const auto power = [](const char* what, const Vec3& v) {
        std::printf("%-16s %.6g %.6g %.6g W\n", what, v.x, v.y, v.z);
    };
    power("emitted", s.energy.emitted);
    power("absorbed", s.energy.absorbed);
    power("escaped", s.energy.escaped);
    if (exposure) std::printf("exposure         %.4g stops\n", *exposure);
}

/// Writes what was asked for, the report last: it holds the seconds of the others.
/// returns  the exposure of the picture, where there is one to choose
Result<std::optional<double>> write_outputs(const Arguments& a, const Job& job, const Scene& scene, Solution& solution,
                                            std::chrono::steady_clock::time_point begun) {
    const auto start = std::chrono::steady_clock::now();
    const DeferInterrupts until_written;
    std::optional<double> exposure;
    if (!a.radiosity.empty())
        if (auto written = write_radiosity_csv(scene, solution, a.radiosity); !written) return written.error();
    if (!a.out.empty())
        if (auto written = write_glb(scene, solution, a.out); !written) return written.error();
    if (!a.picture.empty()) {
        auto used = write_picture(scene, solution, SceneRays(scene), job.picture, a.picture);
        if (!used) return used.error();
        if (a.picture.extension() == ".png") exposure = *used;
    }
    solution.seconds.output = seconds_since(start);
    solution.seconds.total = seconds_since(begun);
    if (!a.report.empty())
        if (auto written = write_report(scene, solution, a.report); !written) return written.error();
    return exposure;
}

int run(const Arguments& a) {
    const auto begun = std::chrono::steady_clock::now();
    const auto job = job_of(a);
    if (!job) return report_error(kProgram, job.error());
    const std::array<std::filesystem::path, 4> outputs{a.out, a.picture, a.radiosity, a.report};
    if (auto writable = check_outputs(outputs, a.scene); !writable) return report_error(kProgram, writable.error());
    const auto scene = load(a, sections_for(a, *job));
    if (!scene) return report_error(kProgram, scene.error());
    const double load_seconds = seconds_since(begun);
    if (const std::uint64_t needed = estimated_memory(*scene); needed > job->memory)
        return report_error(kProgram, failed(a.scene.string(),
                                             "needs about " + size_text(needed) + " of memory, " +
                                                 size_text(job->memory) + " are allowed",
                                             "allow more with --memory"));
    TerminalProgress progress(a.quiet);
    auto solution = solve_scene(*scene, job->solve, progress.callback());
    progress.clear();
    if (!solution) return report_error(kProgram, solution.error());
    solution->seconds.load = load_seconds;
    if (a.verbose) print_plan(stderr, solution->effects);
    if (!a.quiet)
        for (const std::string& warning : solution->warnings) report_warning(kProgram, warning);
    const auto exposure = write_outputs(a, *job, *scene, *solution, begun);
    if (!exposure) return report_error(kProgram, exposure.error());
    if (!a.quiet) print_summary(*scene, *solution, *exposure);
    if (work_done(*solution, job->solve)) return 0;
    char text[160];
    std::snprintf(text, sizeof text,
                  "the estimated error is %.3g, asked for %.3g; the outputs are written all the same",
                  solution->estimated_error, solution->accuracy);
    return report_error(kProgram, failed(a.scene.string(), text, "ask for less with --accuracy"));
}

int explain(const Arguments& a) {
    if (auto good = check_accuracy(a); !good) return report_error(kProgram, good.error());
    const auto scene = load(a, kGeometry);
    if (!scene) return report_error(kProgram, scene.error());
    auto plan = plan_effects(*scene, a.overrides);
    if (!plan) return report_error(kProgram, plan.error());
    if (!a.quiet)
        for (const std::string& warning : plan->warnings) report_warning(kProgram, warning);
    const Outlook expected = outlook(*scene, a.accuracy, *plan);
    std::fputs((a.json ? explain_json : explain_text)(*scene, *plan, expected).c_str(), stdout);
    return 0;
}

struct FactorsJob {
    FactorOptions options;
    std::uint64_t memory = 0;
};

Result<FactorsJob> factors_job_of(const Arguments& a) {
    FactorsJob job;
    const auto by = a.by.empty() ? Result<GroupBy>(GroupBy::Auto) : parse_group_by(a.by);
    if (!by) return by.error();
    const auto sides = parse_sides(a.sides);
    if (!sides) return sides.error();
    const auto memory = a.memory.empty() ? Result<std::uint64_t>(default_memory()) : parse_bytes(a.memory);
    if (!memory) return memory.error();
    const auto refuse = [](const std::string& message) { return Error{ErrorKind::Usage, "", message, ""}; };
    if (a.accuracy && !(*a.accuracy > 0 && *a.accuracy <= 1))
        return refuse("--accuracy: expected a relative error above 0 and at most 1");
    if (a.threshold && !(*a.threshold >= 0 && *a.threshold <= 1)) return refuse("--threshold: expected a factor, 0 to 1");
    const std::string ending = a.out.extension().string();
    if (ending != ".csv" && ending != ".json" && !a.out.string().starts_with("/dev/"))
        return refuse("--out " + a.out.string() + ": expected a name ending in .csv or .json");
    job.options.by = *by;
    job.options.sides = *sides;
    if (a.accuracy) job.options.accuracy = *a.accuracy;
    job.memory = *memory;
    return job;
}

/// Passes progress on with the time that is left, as the time so far foretells it.
Progress with_time_left(Progress draw) {
    if (!draw) return {};
    struct Phase {
        std::string name;
        std::chrono::steady_clock::time_point begun;
    };
    return [draw = std::move(draw), at = std::make_shared<Phase>()](std::string_view phase, double done) {
        if (at->name != phase) *at = {std::string(phase), std::chrono::steady_clock::now()};
        const double spent = seconds_since(at->begun);
        if (done < 0.01 || spent < 1) return draw(phase, done);
        char text[64];
        std::snprintf(text, sizeof text, ", about %.0f s left,", spent * (1 - done) / done);
        draw(at->name + text, done);
    };
}

void print_closure(std::FILE* to, const FactorTable& f) {
    const ClosureReport& closure = f.closure;
    std::fprintf(to, "closure          rows differ from 1 by %.3g at most (%s), %.3g on the average\n",
                 closure.largest_defect, f.names[closure.worst_row].c_str(), closure.mean_defect);
    std::fprintf(to, "reciprocity      A_i F_ij and A_j F_ji differ by %.3g at most", closure.largest_asymmetry);
    if (closure.largest_asymmetry > 0)
        std::fprintf(to, " of the smaller area (%s, %s), %.3g relative where F is above 0.01",
                     f.names[closure.asymmetric_from].c_str(), f.names[closure.asymmetric_to].c_str(),
                     closure.largest_relative_asymmetry);
    std::fputc('\n', to);
}

void print_counts(const FactorTable& f, const FactorSeconds& seconds) {
    const auto count = [](std::uint64_t n) { return static_cast<unsigned long long>(n); };
    std::printf("%zu groups by %s, %s; %llu polygons, of which %llu can stand between others\n", f.names.size(),
                std::string(name_of(f.options.by)).c_str(),
                f.options.sides == Sides::Front ? "fronts" : "both sides", count(f.polygons), count(f.blockers));
    std::printf("pairs            %llu exact, %llu with shadows cut out, %llu by %llu rays", count(f.counts.exact),
                count(f.counts.cut), count(f.counts.sampled), count(f.counts.rays));
    if (f.options.previous) std::printf(", %llu reused", count(f.counts.reused));
    std::printf("\nseconds          %.2f (load %.2f, factors %.2f)\n", seconds.total, seconds.load, seconds.factors);
}

/// Computes all rows, closes them and writes them.
Result<FactorTable> closed_factors(const Arguments& a, const FactorsJob& job, const Scene& scene, const Progress& progress,
                                   std::optional<Closing>& closing) {
    auto found = view_factors(scene, job.options, progress);
    if (!found) return found.error();
    auto closed = close_rows(*found);
    if (!closed) {
        print_closure(stdout, *found);
        return closed.error();
    }
    closing = *std::move(closed);
    const DeferInterrupts until_written;
    if (auto written = write_factors(*found, a.threshold, true, a.out); !written) return written.error();
    return static_cast<FactorTable&&>(*std::move(found));
}

/// Writes rows as they are computed.
Result<FactorTable> streamed_factors(const Arguments& a, const FactorsJob& job, const Scene& scene, const Progress& progress) {
    auto file = FactorsFile::open(a.out, a.threshold, false);
    if (!file) return file.error();
    auto table = view_factors(
        scene, job.options,
        [&](const FactorTable& t, std::uint32_t first, std::span<const FactorRow> rows) { return file->add(t, first, rows); },
        progress);
    if (!table) return table.error();
    const DeferInterrupts until_written;
    if (auto written = file->finish(*table); !written) return written.error();
    return table;
}

void print_factors(const Arguments& a, const FactorTable& f, const std::optional<Closing>& closing, const FactorSeconds& seconds) {
    if (!a.quiet) {
        print_closure(stdout, f);
        if (closing)
            std::printf("closed           factors moved by %.3g at most (row of %s)\n", closing->largest_move,
                        f.names[closing->worst_row].c_str());
        print_counts(f, seconds);
    }
    if (a.verbose)
        for (std::size_t g = 0; g < f.names.size(); ++g)
            std::fprintf(stderr, "  %.9f %s%s\n", f.closure.row_sum[g], f.names[g].c_str(),
                         closing ? (", moved by " + std::to_string(closing->moved[g])).c_str() : "");
    if (f.counts.missed > 0)
        report_warning(kProgram, std::to_string(f.counts.missed) + " of the sampled factors have a standard error above "
                                 "half the error asked for; the file says which");
}

int factors(const Arguments& a) {
    const auto begun = std::chrono::steady_clock::now();
    auto job = factors_job_of(a);
    if (!job) return report_error(kProgram, job.error());
    const std::array<std::filesystem::path, 2> outputs{a.out, a.report};
    if (auto writable = check_outputs(outputs, a.scene); !writable) return report_error(kProgram, writable.error());
    const auto scene = load(a, kGeometry);
    if (!scene) return report_error(kProgram, scene.error());
    if (const std::uint64_t needed = factors_memory(*scene, job->options, a.close); needed > job->memory)
        return report_error(kProgram, failed(a.scene.string(),
                                             "needs up to " + size_text(needed) + " of memory, " +
                                                 size_text(job->memory) + " are allowed",
                                             "allow more with --memory, or join surfaces in groups"));
    std::optional<PreviousFactors> previous;
    if (!a.reuse.empty()) {
        auto read = read_previous_factors(a.reuse);
        if (!read) return report_error(kProgram, read.error());
        job->options.previous = &previous.emplace(*std::move(read));
    }
    FactorSeconds seconds;
    seconds.load = seconds_since(begun);
    TerminalProgress progress(a.quiet);
    const Progress tell = with_time_left(progress.callback());
    std::optional<Closing> closing;
    const auto found = a.close ? closed_factors(a, *job, *scene, tell, closing) : streamed_factors(a, *job, *scene, tell);
    progress.clear();
    if (!found) return report_error(kProgram, found.error());
    seconds.total = seconds_since(begun);
    seconds.factors = seconds.total - seconds.load;
    if (!a.report.empty())
        if (auto written = write_factors_report(*found, closing, seconds, a.report); !written)
            return report_error(kProgram, written.error());
    print_factors(a, *found, closing, seconds);
    return 0;
}

void declare_compare(CLI::App& command, Arguments& a) {
    declare_common(command, a);
    command.add_option("--base", a.compare.base, "Folder of archives, found by their file names")->required()->type_name("DIR");
    command.add_option("--head", a.compare.head, "The other version of them")->required()->type_name("DIR");
    command.add_option("--runs", a.compare.runs, "Measured runs of each, interleaved, after one that is not measured")
        ->type_name("N")
        ->check(CLI::Range(1, 1000))
        ->capture_default_str();
    command.add_option("--fail-if-slower", a.compare.fail_if_slower,
                       "Exit 1 if the total time of head is above this times base's, beyond the noise")
        ->type_name("RATIO")
        ->check(CLI::PositiveNumber);
    command.add_option("--fail-if-differs", a.compare.fail_if_differs,
                       "Exit 1 if reflected radiosity differs by more (relative, root mean square by area)")
        ->type_name("E")
        ->check(CLI::NonNegativeNumber);
    command.add_option("--json", a.json_file, "The comparison for programs")->type_name("FILE.json");
    command.add_option("--markdown", a.markdown_file, "The comparison for a merge request")->type_name("FILE.md");
    command.add_option("--accuracy", a.accuracy, "Relative error aimed at (default: the manifest's, or 0.02)")->type_name("E");
    command.add_option("--method", a.method, "reusable, hierarchical or reference")->type_name("METHOD")->capture_default_str();
    command.add_option("--memory", a.memory, "Most memory to use (default: 8G or ulimit -v)")->type_name("8G");
}

/// One measured solve of `compare` or `tradeoff`, as `run` would do it.
Result<SolvedScene> solve_once(const Manifest& manifest, const Job& job, const Progress& progress = {}) {
    const auto begun = std::chrono::steady_clock::now();
    SectionSet wanted = kGeometry | Section::Source;
    if (job.solve.method == Method::Reusable) wanted = wanted | kTables | sections_of(job.solve.visibility);
    auto scene = open_scene(manifest, wanted);
    if (!scene) return scene.error();
    const double load_seconds = seconds_since(begun);
    const std::uint64_t needed = estimated_memory(*scene);
    if (needed > job.memory)
        return failed(manifest.path.string(), "needs about " + size_text(needed) + " of memory", "allow more with --memory");
    auto solution = solve_scene(*scene, job.solve, progress);
    if (!solution) return solution.error();
    solution->seconds.load = load_seconds;
    return SolvedScene{std::move(*scene), std::move(*solution), needed};
}

int compare(const Arguments& a) {
    const auto job = job_of(a);
    if (!job) return report_error(kProgram, job.error());
    const std::array<std::filesystem::path, 2> outputs{a.json_file, a.markdown_file};
    if (auto writable = check_outputs(outputs, a.scene); !writable) return report_error(kProgram, writable.error());
    const auto manifest = read_manifest(a.scene);
    if (!manifest) return report_error(kProgram, manifest.error());
    TerminalProgress progress(a.quiet);
    const auto compared = compare_archives(
        *manifest, a.compare, [&](const Manifest& m) { return solve_once(m, *job); }, with_time_left(progress.callback()));
    progress.clear();
    if (!compared) return report_error(kProgram, compared.error());
    const DeferInterrupts until_written;
    if (!a.json_file.empty())
        if (auto written = write_file_atomically(a.json_file, comparison_json(*compared)); !written)
            return report_error(kProgram, written.error());
    if (!a.markdown_file.empty())
        if (auto written = write_file_atomically(a.markdown_file, comparison_markdown(*compared)); !written)
            return report_error(kProgram, written.error());
    if (!a.quiet) std::fputs(comparison_text(*compared).c_str(), stdout);
    if (compared->passed()) return 0;
    return report_error(kProgram, failed(a.scene.string(),
                                         std::string(compared->too_slow ? "head is slower" : "head differs more") +
                                             " than the threshold allows"));
}

void declare_tradeoff(CLI::App& command, Arguments& a) {
    declare_common(command, a);
    SweepOptions& sweep = a.tradeoff.sweep;
    command.add_option("--out", a.tradeoff.out, "Folder for the results; run again, it goes on where it was")->required()->type_name("DIR");
    command.add_option("--accuracy", sweep.accuracies, "Relative errors to ask for (default: 0.3,0.2,0.1,0.05)")
        ->type_name("LIST")
        ->allow_extra_args(false)
        ->delimiter(',');
    command.add_option("--methods", a.methods, "Methods to run (default: reusable,hierarchical,reference)")
        ->type_name("LIST")
        ->allow_extra_args(false)
        ->delimiter(',');
    command.add_option("--variants", sweep.variants, "Folders of the scene's archives compiled otherwise, or folders of such folders")
        ->type_name("DIR");
    command.add_option("--knobs-at", sweep.knobs_at, "Accuracy at which knobs are swept (default: the middle of the list)")->type_name("E");
    command.add_flag("--no-knobs", a.no_knobs, "The methods' curves only");
    command.add_flag("--no-pictures", a.no_pictures, "No pictures of where the error sits");
    command.add_option("--repeats", a.tradeoff.repeats, "Runs of each point, interleaved")
        ->type_name("N")
        ->check(CLI::Range(1, 1000))
        ->capture_default_str();
    command.add_option("--samples", a.tradeoff.samples, "Paths per triangle of the reference that judges")
        ->type_name("N")
        ->check(CLI::Range(16, 1 << 24))
        ->capture_default_str();
    command.add_option("--reference-file", a.tradeoff.reference_file, "A reference at hand, as run --method reference --radiosity writes it")
        ->type_name("FILE.csv");
    command.add_option("--budget", a.tradeoff.budget, "Begin no run that would probably end after so many seconds of runs")
        ->type_name("SECONDS")
        ->check(CLI::PositiveNumber);
    command.add_option("--memory", a.memory, "Most memory to use (default: 8G or ulimit -v)")->type_name("8G");
}

int tradeoff(const Arguments& a) {
    const auto job = job_of(a);
    if (!job) return report_error(kProgram, job.error());
    TradeoffOptions options = a.tradeoff;
    options.sweep.knobs = !a.no_knobs;
    options.pictures = !a.no_pictures;
    options.sweep.methods.clear();
    for (const std::string& name : a.methods) {
        const auto method = parse_method(name);
        if (!method) return report_error(kProgram, method.error());
        options.sweep.methods.push_back(*method);
    }
    const auto manifest = read_manifest(a.scene);
    if (!manifest) return report_error(kProgram, manifest.error());
    TerminalProgress progress(a.quiet);
    const auto solve = [&](const Manifest& m, const SolveOptions& solve_options, const Progress& of_solve) {
        Job one = *job;
        one.solve = solve_options;
        one.solve.memory = job->memory;
        return solve_once(m, one, with_time_left(of_solve));
    };
    const auto measured = measure_tradeoff(*manifest, options, solve, progress.callback());
    progress.clear();
    if (!measured) return report_error(kProgram, measured.error());
    if (auto written = write_tradeoff(*measured); !written) return report_error(kProgram, written.error());
    if (!a.quiet) std::fputs(tradeoff_text(*measured).c_str(), stdout);
    return 0;
}

Status edit_manifest(const Arguments& a, const std::string& command) {
    const auto transform = parse_transform(a.transform);
    if (!transform) return transform.error();
    if (command == "move" && transform->empty())
        return Error{ErrorKind::Usage, "", "move: expected --translate, --rotate, --scale or --matrix", ""};
    const DeferInterrupts until_written;
    if (command == "place") return place_in_file(a.scene, a.name, a.archive, *transform);
    return command == "move" ? move_in_file(a.scene, a.name, *transform) : delete_in_file(a.scene, a.name);
}

int edit(const Arguments& a, const std::string& command) {
    const auto edited = edit_manifest(a, command);
    return edited ? 0 : report_error(kProgram, edited.error());
}

int live(const Arguments& a) {
    const auto job = job_of(a);
    if (!job) return report_error(kProgram, job.error());
    auto session = LiveSession::open(a.scene, {job->solve, job->memory});
    if (!session) return report_error(kProgram, session.error());
    if (!a.quiet)
        for (const std::string& warning : session->solution()->warnings) report_warning(kProgram, warning);
    serve(*session, std::cin, std::cout);
    return 0;
}

int main_with(int argc, char** argv) {
    Arguments arguments;
    CLI::App app("Solves scenes of reusable radiosity objects.", kProgram);
    app.set_version_flag("--version", std::string(kProgram) + " " + std::string(kToolVersion));
    app.require_subcommand(1);
    app.footer(kExamples);
    CLI::App* run_command = app.add_subcommand("run", "Solve a scene and write the solution");
    declare_run(*run_command, arguments);
    CLI::App* explain_command =
        app.add_subcommand("explain", "Tell which effects a scene calls for, why, and what they will cost");
    declare_shared(*explain_command, arguments);
    explain_command->add_flag("--json", arguments.json, "As JSON");
    CLI::App* factors_command = app.add_subcommand("factors", "View factors between instances, materials or groups");
    declare_factors(*factors_command, arguments);
    CLI::App* compare_command = app.add_subcommand("compare", "Compare two versions of a scene's archives: time and result");
    declare_compare(*compare_command, arguments);
    CLI::App* tradeoff_command = app.add_subcommand("tradeoff", "What accuracy costs in time: error over time of all methods and knobs");
    declare_tradeoff(*tradeoff_command, arguments);
    declare_edits(app, arguments);
    declare_live(*app.add_subcommand("live", "Keep a scene in memory and answer edits, one JSON object per line"), arguments);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
        return report_error(kProgram, {ErrorKind::Usage, "", error.what(), "rro-solve --help shows the options"});
    }
    set_thread_count(arguments.threads);
    if (factors_command->parsed()) return factors(arguments);
    if (compare_command->parsed()) return compare(arguments);
    if (tradeoff_command->parsed()) return tradeoff(arguments);
    if (app.got_subcommand("live")) return live(arguments);
    for (const char* command : {"place", "move", "delete"})
        if (app.got_subcommand(command)) return edit(arguments, command);
    return run_command->parsed() ? run(arguments) : explain(arguments);
}

}  // namespace
}  // namespace rro

int main(int argc, char** argv) {
    rro::end_on_interrupt();
    try {
        return rro::main_with(argc, argv);
    } catch (const std::exception& exception) {
        return rro::report_error(rro::kProgram, rro::error_from_exception(exception));
    }
}
