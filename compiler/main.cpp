// rro-compile: arguments, exit code, printing; no logic.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <string>

#include "compiler/archive_diff.h"
#include "compiler/build_command.h"
#include "compiler/inspect.h"
#include "compiler/library_build.h"
#include "format/archive_reader.h"
#include "format/atomic_file.h"
#include "format/parallel.h"
#include "format/tool/interrupt.h"
#include "format/tool/program.h"
#include "format/version.h"

namespace rro {
namespace {

constexpr const char* kProgram = "rro-compile";
constexpr const char* kExamples =
    "Examples:\n"
    "  rro-compile build chair.obj --out chair.rro\n"
    "  rro-compile build meshes/*.glb --out library/ --unit cm --if-changed\n"
    "  rro-compile library furniture.json --out library/\n"
    "  rro-compile inspect chair.rro --json\n"
    "  rro-compile inspect chair.rro --triangles chair.csv\n"
    "  rro-compile verify library/*.rro\n"
    "  rro-compile diff old/chair.rro new/chair.rro\n"
    "  rro-compile extract chair.rro --section patches --out patches.bin\n"
    "Exit codes: 0 done, 1 the work failed or archives differ, 2 wrong usage, 3 bad input, 4 internal error, "
    "130 interrupted.";

struct Arguments {
    BuildRequest build;
    LibraryRequest library;
    std::vector<std::filesystem::path> archives;
    std::filesystem::path archive, other, triangles, extracted;
    std::string section;
    unsigned threads = 0;
    bool json = false, quiet = false, verbose = false;
};

void declare_common(CLI::App& command, Arguments& a) {
    command.add_flag("-q,--quiet", a.quiet, "Print errors only");
    command.add_flag("-v,--verbose", a.verbose, "Print settings and counts to stderr");
    command.footer(kExamples);
}

void declare_outputs(CLI::App& command, Arguments& a, std::filesystem::path& depfile, std::filesystem::path& report) {
    command.add_option("--threads", a.threads, "Threads to use; 0: all cores")->type_name("N");
    command.add_option("--depfile", depfile, "Makefile rules of all files read")->type_name("FILE");
    command.add_option("--report", report, "What was imported and built, as JSON")->type_name("FILE.json");
}

void declare_build(CLI::App& build, Arguments& a) {
    BuildRequest& r = a.build;
    build
        .add_option("meshes", r.meshes,
                    "Meshes: OBJ, PLY, OFF, STL, glTF or GLB; textures: PNG, JPEG or TGA. Each mesh is read in a "
                    "process of its own, with at most 4 GiB and 300 s")
        ->required()
        ->type_name("MESH");
    build.add_option("-o,--out", r.out, "The archive; a folder for several meshes")
        ->required()
        ->type_name("FILE.rro|DIR");
    build.add_option("--grid", r.grid, "Directions of the tables: N x N")->type_name("N")->capture_default_str();
    build.add_option("--map", r.map, "How they cover the sphere: octahedral or latlong")
        ->type_name("MAP")
        ->capture_default_str();
    build
        .add_option("--two-sided", r.two_sided,
                    "Triangles that reflect on both sides: auto, yes or no; auto: all but "
                    "closed, consistently wound components")
        ->type_name("WHICH")
        ->capture_default_str();
    build.add_flag("--fix-winding", r.fix_winding,
                   "Turn triangles so that components agree and closed ones face outward");
    build.add_option("--unit", r.unit, "Unit of the source: m, cm, mm or in")->type_name("UNIT")->capture_default_str();
    build.add_option("--up", r.up, "Up axis of the source: y or z")->type_name("AXIS")->capture_default_str();
    build.add_option("--reflectance", r.reflectance, "Where the source gives none")->type_name("R,G,B");
    build.add_option("--cluster-weights", r.cluster_weights,
                     "What makes clusters alike: proximity, orientation, reflectivity, aspect, size")
        ->type_name("P,O,R,A,S");
    build.add_option("--tables", r.tables, "Tables to store: default, all (for every node), or some of area,visibility,errors,hit,atlas,selflinks")->type_name("LIST")->capture_default_str();
    declare_outputs(build, a, r.depfile, r.report);
    build.add_flag("--if-changed", r.if_changed,
                   "Leave archives alone that were made from the same source and options");
    declare_common(build, a);
}

void declare_library(CLI::App& library, Arguments& a) {
    LibraryRequest& r = a.library;
    library.add_option("library", r.library, "The list of objects, \"rro-library/1\"")
        ->required()
        ->type_name("LIBRARY.json");
    library.add_option("-o,--out", r.out, "The folder of the archives")->required()->type_name("DIR");
    declare_outputs(library, a, r.depfile, r.report);
    declare_common(library, a);
}

void print_outcome(const BuildOutcome& outcome, bool quiet) {
    if (quiet) return;
    for (const std::string& warning : outcome.warnings)
        report_warning(kProgram, outcome.target.mesh.string() + ": " + warning);
    if (outcome.error) return;
    std::puts(summary_line(outcome).c_str());
    std::fflush(stdout);  // an interrupt ends the program at once
}

/// Builds, prints, and writes depfile and report. A library's file is among the inputs of its archives.
int run_plans(const Arguments& a, const std::vector<BuildPlan>& plans, const std::filesystem::path& depfile,
              const std::filesystem::path& report, const std::filesystem::path& library = {}) {
    int code = 0;
    TerminalProgress progress(a.quiet);
    const auto done = [&](const BuildOutcome& outcome) {
        progress.clear();
        print_outcome(outcome, a.quiet);
        if (const auto& error = outcome.error)
            code = std::max(code, report_error(kProgram, library.empty() ? *error : library_error(*error)));
    };
    const std::vector<BuildOutcome> outcomes = build_all(plans, {done, progress.callback()});
    progress.clear();
    const auto write = [&](const std::filesystem::path& path, const std::string& text) {
        if (path.empty()) return;
        const DeferInterrupts until_written;
        if (const auto written = write_file_atomically(path, text); !written)
            code = std::max(code, report_error(kProgram, written.error()));
    };
    write(depfile, depfile_text(outcomes, library));
    write(report, build_report(outcomes));
    return code;
}

int run_build(const Arguments& a) {
    auto plan = plan_build(a.build);
    if (!plan) return report_error(kProgram, plan.error());
    if (a.verbose) std::fprintf(stderr, "options: %s\n", plan->options.c_str());
    return run_plans(a, {*std::move(plan)}, a.build.depfile, a.build.report);
}

int run_library(const Arguments& a) {
    const auto plans = plan_library(a.library);
    if (!plans) return report_error(kProgram, plans.error());
    if (a.verbose)
        for (const BuildPlan& plan : *plans)
            std::fprintf(stderr, "%s: options: %s\n", plan.targets.front().archive.c_str(), plan.options.c_str());
    return run_plans(a, *plans, a.library.depfile, a.library.report, a.library.library);
}

int run_inspect(const Arguments& a) {
    const auto archive = Archive::open(a.archive);
    if (!archive) return report_error(kProgram, archive.error());
    if (!a.triangles.empty())
        if (const auto written = write_file_atomically(a.triangles, triangles_csv(archive->data())); !written)
            return report_error(kProgram, written.error());
    const std::string name = a.archive.string();
    if (a.json || !a.quiet)
        std::fputs((a.json ? inspection_json(*archive, name) : inspection_text(*archive, name)).c_str(), stdout);
    return 0;
}

int run_verify(const Arguments& a) {
    int code = 0;
    for (const std::filesystem::path& path : a.archives) {
        const auto archive = Archive::open(path);
        if (!archive)
            code = std::max(code, report_error(kProgram, archive.error()));
        else if (!a.quiet)
            std::printf("%s: good\n", path.c_str());
    }
    return code;
}

int run_diff(const Arguments& a) {
    const auto before = Archive::open(a.archive);
    const auto after = Archive::open(a.other);
    int refused = 0;
    for (const auto* archive : {&before, &after})
        if (!*archive) refused = std::max(refused, report_error(kProgram, archive->error()));
    if (refused) return refused;
    const ArchiveDiff diff = diff_archives(*before, *after);
    const std::string name_a = a.archive.string(), name_b = a.other.string();
    if (a.json || !a.quiet)
        std::fputs((a.json ? diff_json(diff, name_a, name_b) : diff_text(diff, name_a, name_b)).c_str(), stdout);
    return diff.same ? 0 : 1;
}

int run_extract(const Arguments& a) {
    const auto archive = Archive::open(a.archive);
    if (!archive) return report_error(kProgram, archive.error());
    const auto section = archive->section(a.section);
    if (!section) return report_error(kProgram, section.error());
    const auto written = write_file_atomically(a.extracted, *section);
    return written ? 0 : report_error(kProgram, written.error());
}

int main_with(int argc, char** argv) {
    Arguments a;
    CLI::App app("Compiles meshes into reusable radiosity objects.", kProgram);
    app.set_version_flag("--version", std::string(kProgram) + " " + std::string(kToolVersion));
    app.require_subcommand(1);
    app.footer(kExamples);
    CLI::App* build = app.add_subcommand("build", "Compile meshes into archives");
    declare_build(*build, a);
    CLI::App* library = app.add_subcommand("library", "Compile what has changed of a list of objects");
    declare_library(*library, a);
    CLI::App* inspect = app.add_subcommand("inspect", "Show what an archive holds");
    inspect->add_option("archive", a.archive, "The archive")->required()->type_name("FILE.rro");
    inspect->add_flag("--json", a.json, "As JSON");
    inspect->add_option("--triangles", a.triangles, "Triangles by source number, as CSV")->type_name("OUT.csv");
    declare_common(*inspect, a);
    CLI::App* verify = app.add_subcommand("verify", "Check archives completely");
    verify->add_option("archives", a.archives, "The archives")->required()->type_name("FILE.rro");
    declare_common(*verify, a);
    CLI::App* diff =
        app.add_subcommand("diff", "Show what changed from one archive to another; exit code 1 if they differ");
    diff->add_option("before", a.archive, "The archive before")->required()->type_name("A.rro");
    diff->add_option("after", a.other, "The archive after")->required()->type_name("B.rro");
    diff->add_flag("--json", a.json, "As JSON");
    declare_common(*diff, a);
    CLI::App* extract = app.add_subcommand("extract", "Write one section as a plain FlatBuffers buffer");
    extract->add_option("archive", a.archive, "The archive")->required()->type_name("FILE.rro");
    extract->add_option("--section", a.section, "Its name, as inspect shows it")->required()->type_name("NAME");
    extract->add_option("-o,--out", a.extracted, "The buffer")->required()->type_name("FILE.bin");
    declare_common(*extract, a);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
        return report_error(kProgram, {ErrorKind::Usage, "", error.what(), "rro-compile --help shows the options"});
    }
    set_thread_count(a.threads);
    if (build->parsed()) return run_build(a);
    if (library->parsed()) return run_library(a);
    if (inspect->parsed()) return run_inspect(a);
    if (diff->parsed()) return run_diff(a);
    return verify->parsed() ? run_verify(a) : run_extract(a);
}

}  // namespace
}  // namespace rro

int main(int argc, char** argv) {
    return rro::run_program(rro::kProgram, rro::main_with, argc, argv);
}
