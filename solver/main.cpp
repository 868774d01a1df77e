// rro-solve: what each command calls, in order, what it prints, its exit code; no logic.
#include <cstdio>
#include <iostream>
#include <optional>

#include "format/atomic_file.h"
#include "format/clock.h"
#include "format/parallel.h"
#include "format/tool/interrupt.h"
#include "format/tool/program.h"
#include "solver/arguments.h"
#include "solver/command_line.h"
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
    if (s.worst_instance >= 0)
        std::printf("worst instance   %s, %.3g\n", scene.instances[static_cast<std::size_t>(s.worst_instance)].name.c_str(), s.worst_estimate);
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
                                            Clock::time_point begun) {
    const auto start = Clock::now();
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
    const auto begun = Clock::now();
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

/// Passes progress on with the time that is left, as the time so far foretells it.
Progress with_time_left(Progress draw) {
    if (!draw) return {};
    struct Phase {
        std::string name;
        Clock::time_point begun;
    };
    return [draw = std::move(draw), at = std::make_shared<Phase>()](std::string_view phase, double done) {
        if (at->name != phase) *at = {std::string(phase), Clock::now()};
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
    const auto begun = Clock::now();
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

/// One measured solve of `compare` or `tradeoff`, as `run` would do it.
Result<SolvedScene> solve_once(const Manifest& manifest, const Job& job, const Progress& progress = {}) {
    const auto begun = Clock::now();
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

int tradeoff(const Arguments& a) {
    const auto job = job_of(a);
    if (!job) return report_error(kProgram, job.error());
    const auto options = tradeoff_options_of(a);
    if (!options) return report_error(kProgram, options.error());
    const auto manifest = read_manifest(a.scene);
    if (!manifest) return report_error(kProgram, manifest.error());
    TerminalProgress progress(a.quiet);
    const auto solve = [&](const Manifest& m, const SolveOptions& solve_options, const Progress& of_solve) {
        Job one = *job;
        one.solve = solve_options;
        one.solve.memory = job->memory;
        return solve_once(m, one, with_time_left(of_solve));
    };
    const auto measured = measure_tradeoff(*manifest, *options, solve, progress.callback());
    progress.clear();
    if (!measured) return report_error(kProgram, measured.error());
    if (auto written = write_tradeoff(*measured); !written) return report_error(kProgram, written.error());
    if (!a.quiet) std::fputs(tradeoff_text(*measured).c_str(), stdout);
    return 0;
}

Status edit_manifest(const Arguments& a) {
    const auto transform = parse_transform(a.transform);
    if (!transform) return transform.error();
    if (a.command == "move" && transform->empty())
        return Error{ErrorKind::Usage, "", "move: expected --translate, --rotate, --scale or --matrix", ""};
    const DeferInterrupts until_written;
    if (a.command == "place") return place_in_file(a.scene, a.name, a.archive, *transform);
    return a.command == "move" ? move_in_file(a.scene, a.name, *transform) : delete_in_file(a.scene, a.name);
}

int edit(const Arguments& a) {
    const auto edited = edit_manifest(a);
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
    const auto arguments = parse_command_line(argc, argv);
    if (!arguments) return report_error(kProgram, arguments.error());
    if (!*arguments) return 0;
    const Arguments& a = **arguments;
    set_thread_count(a.threads);
    if (a.command == "run") return run(a);
    if (a.command == "explain") return explain(a);
    if (a.command == "factors") return factors(a);
    if (a.command == "compare") return compare(a);
    if (a.command == "tradeoff") return tradeoff(a);
    if (a.command == "live") return live(a);
    return edit(a);  // place, move, delete
}

}  // namespace
}  // namespace rro

int main(int argc, char** argv) {
    return rro::run_program(rro::kProgram, rro::main_with, argc, argv);
}
