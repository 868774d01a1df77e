#include "solver/tradeoff/tradeoff.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <set>
#include <span>
#include <system_error>
#include <utility>

#include "format/atomic_file.h"
#include "format/sha256.h"
#include "format/tool/interrupt.h"
#include "solver/scene/file_bytes.h"
#include "solver/tradeoff/error_picture.h"

namespace rro {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 33;  // of any one file of a scene
constexpr std::size_t kKeyDigits = 20;  // 80 bits of a digest: no two runs of one folder share them by chance
constexpr double kGrowth = 2;           // guess: time grows with accuracy^-2, as long as a finer run has not shown it

std::string digest(const std::string& text) {
    return sha256_hex(std::as_bytes(std::span(text)));
}

/// What the results of a manifest depend on, options aside: its own bytes and those of every file it names.
Result<std::string> scene_digest(const Manifest& manifest) {
    std::set<fs::path> files{manifest.path};
    for (const InstanceEntry& entry : manifest.instances) files.insert(entry.archive);
    if (manifest.sky && !manifest.sky->image.empty()) files.insert(manifest.sky->image);
    for (const LightEntry& light : manifest.lights)
        if (!light.file.empty()) files.insert(light.file);
    std::string all;
    for (const fs::path& file : files) {
        const auto bytes = read_bytes(file, kMostBytes);
        if (!bytes) return bytes.error();
        all += file.filename().string() + " " + digest(*bytes) + "\n";
    }
    return digest(all);
}

std::string options_text(const SolveOptions& o) {
    std::array<char, 256> numbers;
    std::snprintf(numbers.data(), numbers.size(), "%d %.17g %d %u %llu %d %.17g", static_cast<int>(o.method),
                  o.accuracy.value_or(0), static_cast<int>(o.visibility), o.samples,
                  static_cast<unsigned long long>(o.seed), o.transport ? static_cast<int>(*o.transport) : -1, o.far_factor);
    return numbers.data();
}

/// A sweep under way.
class Measuring {
  public:
    Measuring(const Manifest& manifest, const TradeoffOptions& options, const SolveTrial& solve, const Progress& progress)
        : manifest_(manifest), solve_(solve), progress_(progress),
          program_(options.program.empty() ? program_digest() : options.program) {
        result_.options = options;
        result_.scene = manifest.path.string();
    }

    Result<Tradeoff> run() {
        std::error_code code;
        fs::create_directories(runs_folder(), code);
        if (code) return failed(runs_folder().string(), "cannot be made: " + code.message());
        auto sweep = plan_sweep(manifest_, options().sweep);
        if (!sweep) return sweep.error();
        result_.not_swept = std::move(sweep->not_swept);
        result_.knobs_at = sweep->knobs_at;
        for (Trial& trial : sweep->trials) result_.points.emplace_back().trial = std::move(trial);
        result_.machine = machine_facts();
        if (auto made = find_truth(); !made) return made.error();
        if (auto named = name_runs(); !named) return named.error();
        for (int repeat = 0; repeat < options().repeats; ++repeat)
            for (std::size_t p = 0; p < result_.points.size(); ++p)
                if (auto done = run_once(p, repeat); !done) return done.error();
        mark_knees();
        return std::move(result_);
    }

  private:
    const TradeoffOptions& options() const { return result_.options; }
    fs::path runs_folder() const { return options().out / "runs"; }

    Status find_truth() {
        auto scene = open_scene(manifest_, kGeometry | Section::Source);
        if (!scene) return scene.error();
        result_.triangles = scene->triangle_count();
        result_.instances = scene->instances.size();
        auto truth = options().reference_file.empty() ? kept_truth(*scene) : given_truth(*scene);
        if (!truth) return truth.error();
        truth_ = std::move(*truth);
        result_.truth_error = standard_error(*scene, truth_);
        return Done{};
    }

    Result<Truth> given_truth(const Scene& scene) {
        result_.truth_from = options().reference_file.string();
        result_.truth_note = "a file that was given";
        return read_truth(options().reference_file, scene);
    }

    Result<Truth> kept_truth(const Scene& scene) {
        const auto of_scene = scene_digest(manifest_);
        if (!of_scene) return of_scene.error();
        SolveOptions reference;
        reference.method = Method::Reference;
        reference.samples = options().samples;
        const std::string name = "truth-" + digest(program_ + *of_scene + options_text(reference)).substr(0, kKeyDigits) + ".csv";
        const fs::path file = options().out / name;
        result_.truth_from = name;
        result_.truth_note = "the reference, " + std::to_string(options().samples) + " paths per face";
        if (std::error_code none; fs::is_regular_file(file, none))
            if (auto truth = read_truth(file, scene)) return truth;
        const auto solved = solve_(manifest_, reference, progress_);
        if (!solved) return solved.error();
        Truth truth = truth_of(solved->scene, solved->solution);
        const DeferInterrupts until_written;
        if (auto written = write_truth(truth, file); !written) return written.error();
        return truth;
    }

    /// Every point's key: of all that its runs depend on.
    Status name_runs() {
        const fs::path truth_file = options().reference_file.empty() ? options().out / result_.truth_from : options().reference_file;
        const auto truth = read_bytes(truth_file, kMostBytes);
        if (!truth) return truth.error();
        const MachineFacts& m = result_.machine;
        const std::string common = program_ + m.processor + std::to_string(m.threads) + digest(*truth);
        std::map<fs::path, std::string> scenes;
        for (const Point& point : result_.points) {
            const auto there = manifest_of(point.trial);
            if (!there) return there.error();
            std::string& of_scene = scenes[point.trial.library];
            if (of_scene.empty()) {
                auto found = scene_digest(*there);
                if (!found) return found.error();
                of_scene = std::move(*found);
            }
            keys_.push_back(digest(common + of_scene + options_text(point.trial.solve)).substr(0, kKeyDigits));
        }
        return Done{};
    }

    Result<Manifest> manifest_of(const Trial& trial) const {
        return trial.library.empty() ? Result<Manifest>(manifest_) : with_archives_in(manifest_, trial.library);
    }

    /// What a run of a point will take: as its runs before, or as the next rougher one of its curve foretells.
    std::optional<double> expected_seconds(const Point& point) const {
        if (!point.runs.empty()) return point.seconds().median;
        std::optional<double> guess;
        double nearest = std::numeric_limits<double>::infinity();
        for (const Point& other : result_.points) {
            if (other.trial.method != point.trial.method || !other.trial.knob.empty() || other.runs.empty()) continue;
            const double ratio = *other.trial.solve.accuracy / *point.trial.solve.accuracy;
            if (ratio < 1 || ratio > nearest) continue;
            nearest = ratio;
            guess = other.seconds().median * std::pow(ratio, kGrowth);
        }
        return guess;
    }

    Status run_once(std::size_t p, int repeat) {
        Point& point = result_.points[p];
        if (!point.not_run.empty()) return Done{};
        const fs::path record = runs_folder() / (keys_[p] + "." + std::to_string(repeat) + ".json");
        const fs::path picture = runs_folder() / (keys_[p] + ".png");
        const bool wants_picture = options().pictures && point.trial.knob.empty() && repeat == 0;
        std::error_code none;
        auto run = read_run(record);
        if (!run || (run->failed.empty() && wants_picture && !fs::is_regular_file(picture, none))) {
            const double expected = expected_seconds(point).value_or(0);
            if (options().budget && spent_ + expected > *options().budget) {
                leave_out(point, expected);
                return Done{};
            }
            tell(point, repeat);
            auto fresh = measure(point, wants_picture ? picture : fs::path());
            if (!fresh) return fresh.error();
            run = std::move(*fresh);
            spent_ += run->seconds.total;
            if (auto written = write_run(*run, record); !written) return written.error();
        }
        if (run->failed.empty()) point.runs.push_back(std::move(*run));
        else point.not_run = run->failed;
        if (wants_picture && fs::is_regular_file(picture, none)) point.picture = picture;
        return Done{};
    }

    void leave_out(Point& point, double expected) {
        if (!point.runs.empty()) return;  // fewer runs than asked are told by their number
        std::array<char, 160> text;
        std::snprintf(text.data(), text.size(), "left out: of the budget of %.3g s %.3g s are spent, and it may take %.2g s",
                      *options().budget, spent_, expected);
        point.not_run = text.data();
    }

    /// Solves once. An error of the solve is a result; one of this folder is an error.
    Result<RunRecord> measure(const Point& point, const fs::path& picture) {
        RunRecord run;
        const auto there = manifest_of(point.trial);
        if (!there) return there.error();
        const auto solved = solve_(*there, point.trial.solve, {});
        if (!solved) {
            run.failed = solved.error().message;
            return run;
        }
        const Solution& s = solved->solution;
        run.seconds = s.seconds;
        run.seconds.total += s.seconds.load;
        run.measured = measure_error(solved->scene, s, truth_);
        run.estimated_error = s.estimated_error;
        run.converged = s.converged;
        run.links = s.links;
        run.rays = s.rays;
        if (picture.empty()) return run;
        const DeferInterrupts until_written;
        if (auto written = write_error_picture(solved->scene, s, face_errors(solved->scene, s, truth_), picture); !written)
            return written.error();
        return run;
    }

    void tell(const Point& point, int repeat) const {
        if (!progress_) return;
        double left = 0;
        bool unknown = false;
        for (const Point& other : result_.points) {
            const int missing = options().repeats - static_cast<int>(other.runs.size());
            if (!other.not_run.empty() || missing == 0) continue;
            const auto expected = expected_seconds(other);
            unknown = unknown || !expected;
            left += missing * expected.value_or(0);
        }
        if (options().budget) left = std::min(left, *options().budget - spent_);
        std::array<char, 64> text;
        std::snprintf(text.data(), text.size(), ", run %d of %d, %s %.0f s left,", repeat + 1, options().repeats,
                      unknown ? "more than" : "about", left);
        const double all = spent_ + left;
        progress_(name_of(point.trial) + text.data(), all > 0 ? spent_ / all : 0);
    }

    /// Of the methods' own curves; the reference is the measure of what is dear, and has none.
    void mark_knees() {
        for (const Method method : {Method::Reusable, Method::Hierarchical}) {
            std::vector<std::array<double, 2>> curve;
            std::vector<Point*> points;
            for (Point& point : result_.points) {
                if (point.trial.method != method || !point.trial.knob.empty() || point.runs.empty()) continue;
                curve.push_back({point.runs[0].measured.error, point.seconds().median});
                points.push_back(&point);
            }
            if (const auto knee = knee_of(curve)) points[*knee]->knee = true;
        }
    }

    const Manifest& manifest_;
    const SolveTrial& solve_;
    const Progress& progress_;
    const std::string program_;  // its digest
    Tradeoff result_;
    Truth truth_;
    std::vector<std::string> keys_;  // [points]
    double spent_ = 0;               // s, in runs of this call
};

}  // namespace

Timing Point::seconds() const {
    std::vector<double> all;
    for (const RunRecord& run : runs) all.push_back(run.seconds.total);
    if (all.empty()) return {};
    std::sort(all.begin(), all.end());
    const std::size_t n = all.size();
    return {all.front(), n % 2 == 1 ? all[n / 2] : 0.5 * (all[n / 2 - 1] + all[n / 2]), all.back()};
}

std::optional<std::size_t> knee_of(const std::vector<std::array<double, 2>>& points) {
    std::optional<std::size_t> knee;
    double least = std::numeric_limits<double>::infinity();
    std::size_t counted = 0;
    for (std::size_t p = 0; p < points.size(); ++p) {
        const auto [error, seconds] = points[p];
        if (!(error > 0) || !std::isfinite(error)) continue;
        ++counted;
        if (const double price = seconds * error * error; price < least) {
            least = price;
            knee = p;
        }
    }
    return counted >= 2 ? knee : std::nullopt;
}

Result<Tradeoff> measure_tradeoff(const Manifest& manifest, const TradeoffOptions& options, const SolveTrial& solve,
                                  const Progress& progress) {
    return Measuring(manifest, options, solve, progress).run();
}

}  // namespace rro
