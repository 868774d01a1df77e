#include "solver/command_line.h"

#include <CLI/CLI.hpp>

#include "format/version.h"
#include "solver/arguments.h"

namespace rro {
namespace {

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

}  // namespace

Result<std::optional<Arguments>> parse_command_line(int argc, char** argv) {
    Arguments a;
    CLI::App app("Solves scenes of reusable radiosity objects.", "rro-solve");
    app.set_version_flag("--version", "rro-solve " + std::string(kToolVersion));
    app.require_subcommand(1);
    app.footer(kExamples);
    declare_run(*app.add_subcommand("run", "Solve a scene and write the solution"), a);
    CLI::App* explain = app.add_subcommand("explain", "Tell which effects a scene calls for, why, and what they will cost");
    declare_shared(*explain, a);
    explain->add_flag("--json", a.json, "As JSON");
    declare_factors(*app.add_subcommand("factors", "View factors between instances, materials or groups"), a);
    declare_compare(*app.add_subcommand("compare", "Compare two versions of a scene's archives: time and result"), a);
    declare_tradeoff(*app.add_subcommand("tradeoff", "What accuracy costs in time: error over time of all methods and knobs"), a);
    declare_edits(app, a);
    declare_live(*app.add_subcommand("live", "Keep a scene in memory and answer edits, one JSON object per line"), a);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        if (error.get_exit_code() != 0)
            return Error{ErrorKind::Usage, "", error.what(), "rro-solve --help shows the options"};
        app.exit(error);  // prints --help or --version
        return std::optional<Arguments>();
    }
    a.command = app.get_subcommands().front()->get_name();
    return std::optional(std::move(a));
}

Status check_accuracy(const Arguments& a) {
    if (a.accuracy && !(*a.accuracy > 0 && *a.accuracy <= 1))
        return Error{ErrorKind::Usage, "", "--accuracy: expected a relative error above 0 and at most 1", ""};
    return Done{};
}

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

Result<TradeoffOptions> tradeoff_options_of(const Arguments& a) {
    TradeoffOptions options = a.tradeoff;
    options.sweep.knobs = !a.no_knobs;
    options.pictures = !a.no_pictures;
    options.sweep.methods.clear();
    for (const std::string& name : a.methods) {
        const auto method = parse_method(name);
        if (!method) return method.error();
        options.sweep.methods.push_back(*method);
    }
    return options;
}

}  // namespace rro
