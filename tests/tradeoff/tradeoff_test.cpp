#include "solver/tradeoff/tradeoff.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "format/tool/json_document.h"
#include "schemas/tradeoff_schema.h"
#include "tests/scene/scene_files.h"

using namespace rro;
using namespace rro::test;
using Catch::Matchers::Contains;

namespace {

/// A solver that is off by the accuracy asked, 1 W/m^2 being right, and takes (1 / accuracy)^3 ms; the hierarchical method
/// fails. Notes what it was asked.
struct Pretended {
    std::vector<std::string> calls;

    Result<SolvedScene> operator()(const Manifest& manifest, const SolveOptions& options, const Progress&) {
        const double accuracy = options.accuracy.value_or(1);
        calls.push_back(options.samples > 0 ? "truth" : name_of(options.method) + nlohmann::json(accuracy).dump());
        if (options.method == Method::Hierarchical) return failed("", "too <large>");
        auto scene = open_scene(manifest);
        if (!scene) return scene.error();
        SolvedScene out{std::move(*scene), {}, 0};
        for (const Instance& instance : out.scene.instances) {
            InstanceSolution& s = out.solution.instances.emplace_back();
            for (std::size_t f = 0; f < instance.data().faces.size(); ++f) {
                const Vec3 m = to_double(instance.exitance[instance.object->patch_of_face[f]]);
                s.radiosity.push_back(to_float(m + Vec3{1, 1, 1} * (options.samples > 0 ? 1 : 1 + accuracy)));
                s.irradiance.push_back({1, 1, 1});
                s.standard_error.push_back({0, 0, 0});
            }
        }
        out.solution.seconds.total = 0.001 / std::pow(accuracy, 3);
        out.solution.estimated_error = accuracy;
        out.solution.converged = true;
        out.solution.links.near = 7;
        return out;
    }
};

struct Study {
    SceneFiles files;
    Manifest manifest = read();
    TradeoffOptions options = defaults();
    Pretended solver;

    Manifest read(const std::string& more = "") {
        auto manifest_read = read_manifest(files.instances(R"({"name": "a <b>", "archive": "box.rro"})", more));
        REQUIRE(manifest_read);
        return std::move(*manifest_read);
    }
    TradeoffOptions defaults() {
        TradeoffOptions o;
        o.sweep.accuracies = {0.1, 0.4, 0.2};
        o.sweep.knobs = false;
        o.out = files.folder / "out";
        o.repeats = 2;
        o.pictures = false;
        return o;
    }
    Tradeoff measure() {
        solver.calls.clear();
        auto measured = measure_tradeoff(manifest, options, std::ref(solver));
        if (!measured) FAIL(measured.error().where << ": " << measured.error().message);
        return std::move(*measured);
    }
};

}  // namespace

TEST_CASE("tradeoff: rounds go from rough to fine, each over all methods; a method that fails is asked once", "[tradeoff]") {
    Study study;
    const Tradeoff t = study.measure();
    const std::vector<std::string> first = {"reusable0.4", "hierarchical0.4", "reference0.4", "reusable0.2", "hierarchical0.2",
                                            "reference0.2", "reusable0.1", "hierarchical0.1", "reference0.1"};
    std::vector<std::string> all = {"truth"};
    all.insert(all.end(), first.begin(), first.end());
    for (const std::string& call : first)
        if (!call.starts_with("h")) all.push_back(call);
    CHECK(study.solver.calls == all);
    REQUIRE(t.points.size() == 9);
    CHECK(t.points[1].not_run == "too <large>");
    CHECK(t.points[0].runs.size() == 2);
    CHECK(t.points[0].runs[0].measured.error == Approx(0.4).epsilon(1e-5));
    // Seconds x error^2 is 1 / accuracy ms: the roughest is the knee.
    CHECK(t.points[0].knee);
    CHECK(std::count_if(t.points.begin(), t.points.end(), [](const Point& p) { return p.knee; }) == 1);
}

TEST_CASE("tradeoff: finished runs and the truth are found again, as long as nothing they depend on changes", "[tradeoff]") {
    Study study;
    const Tradeoff first = study.measure();
    const Tradeoff again = study.measure();
    CHECK(study.solver.calls.empty());
    CHECK(tradeoff_csv(again) == tradeoff_csv(first));
    study.options.repeats = 3;  // one more of each of the six
    study.measure();
    CHECK(study.solver.calls.size() == 6);
    study.options.sweep.accuracies.push_back(0.05);
    study.measure();
    CHECK(study.solver.calls.size() == 3 + 2 * 2);
    // A run that was cut short while it was written is run again.
    for (const auto& entry : std::filesystem::directory_iterator(study.options.out / "runs")) {
        std::filesystem::resize_file(entry.path(), 10);
        break;
    }
    study.measure();
    CHECK(study.solver.calls.size() == 1);
    study.manifest = study.read(", \"accuracy\": 0.3");  // another scene
    study.measure();
    CHECK(study.solver.calls.size() == 1 + 3 * 4 + 2 * 2 * 4);
}

TEST_CASE("tradeoff: another build of one version measures anew, the truth too", "[tradeoff]") {
    Study study;
    const Tradeoff first = study.measure();
    const std::vector<std::string> all = study.solver.calls;
    study.options.program = "another";
    const Tradeoff other = study.measure();
    CHECK(study.solver.calls == all);
    CHECK(other.truth_from != first.truth_from);
    study.options.program.clear();
    CHECK(study.measure().truth_from == first.truth_from);
    CHECK(study.solver.calls.empty());
}

TEST_CASE("tradeoff: a budget leaves out what would probably take too long", "[tradeoff]") {
    Study study;
    study.options.sweep.methods = {Method::Reusable};
    study.options.repeats = 1;
    study.options.budget = 0.2;  // s: 0.016 and 0.125 are spent, and 0.1 may take four times as long again
    const Tradeoff t = study.measure();
    CHECK(study.solver.calls == std::vector<std::string>{"truth", "reusable0.4", "reusable0.2"});
    CHECK_THAT(t.points[2].not_run, Contains("budget"));
}

TEST_CASE("tradeoff: the knee is where seconds x error^2 is least", "[tradeoff]") {
    CHECK(knee_of({{0.4, 1}, {0.2, 2}, {0.1, 20}}) == 1u);
    CHECK(knee_of({{0.4, 1}, {0.2, 4}, {0.1, 16}}) == 0u);  // what sampling pays: no point beats another
    CHECK(knee_of({{0.4, 1}, {0.2, 2}, {0, 3}}) == 1u);
    CHECK_FALSE(knee_of({{0.4, 1}}));
    CHECK_FALSE(knee_of({}));
}

TEST_CASE("tradeoff: JSON fits its schema, every row of the CSV has all columns", "[tradeoff]") {
    Study study;
    study.options.sweep.knobs = true;
    const Tradeoff t = study.measure();
    const auto json = parse_json(tradeoff_json(t), "tradeoff.json");
    REQUIRE(json);
    const auto fits = check_schema(*json, tradeoff_schema, "tradeoff.json");
    if (!fits) FAIL(fits.error().where << ": " << fits.error().message);
    CHECK((*json)["points"].size() == t.points.size());
    CHECK((*json)["points"][0]["error"]["value"].get<double>() == Approx(0.4).epsilon(1e-5));
    const std::string csv = tradeoff_csv(t);
    const auto columns = std::count(csv.begin(), csv.begin() + static_cast<std::ptrdiff_t>(csv.find('\n')), ',');
    std::size_t rows = 0;
    for (std::size_t at = 0; at < csv.size(); at = csv.find('\n', at) + 1, ++rows) {
        const auto from = csv.begin() + static_cast<std::ptrdiff_t>(at);
        CHECK(std::count(from, std::find(from, csv.end(), '\n'), ',') == columns);
    }
    CHECK(rows == t.points.size() + 1);
}

TEST_CASE("tradeoff: the page needs nothing from elsewhere, and names stay text", "[tradeoff]") {
    Study study;
    study.options.pictures = true;
    study.options.sweep.knobs = true;
    const Tradeoff t = study.measure();
    const std::string page = tradeoff_html(t);
    for (const char* outside : {"http:", "https:", "//cdn", "<link", "@import", "url("}) CHECK(page.find(outside) == std::string::npos);
    CHECK(page.find("{{") == std::string::npos);  // every part of the frame is filled in
    CHECK_THAT(page, Contains("too &lt;large&gt;") && !Contains("too <large>"));
    CHECK_THAT(page, Contains("a &lt;b&gt;") && !Contains("a <b>"));
    CHECK_THAT(page, Contains("src=\"data:image/png;base64,iVBORw0KGgo"));  // PNG's first bytes
    CHECK_THAT(page, Contains("class=\"ring\"") && Contains("prefers-color-scheme: dark"));
    REQUIRE(write_tradeoff(t));
    CHECK(file_text(study.options.out / "tradeoff.html") == page);
}

TEST_CASE("tradeoff: knobs are swept alone, those that need archives are listed where there are none", "[tradeoff]") {
    Study study;
    study.options.sweep.knobs = true;
    const auto sweep = plan_sweep(study.manifest, study.options.sweep);
    REQUIRE(sweep);
    CHECK(sweep->knobs_at == 0.2);
    std::vector<std::string> knobs;
    for (const Trial& trial : sweep->trials) {
        if (trial.knob.empty()) continue;
        CHECK(*trial.solve.accuracy == 0.2);
        CHECK(trial.method == Method::Reusable);
        if (knobs.empty() || knobs.back() != trial.knob) knobs.push_back(trial.knob);
    }
    CHECK(knobs == std::vector<std::string>{"far factor", "visibility", "transport", "sampling"});
    const auto lists = [&](const std::string& what) {
        return std::any_of(sweep->not_swept.begin(), sweep->not_swept.end(), [&](const NotSwept& n) { return n.what == what; });
    };
    CHECK(lists("grid 24"));
    CHECK(lists("map latlong"));
    // A variant is named by how its tables differ.
    TinyObject other = tiny_object();
    std::filesystem::create_directories(study.files.folder / "variants" / "fine");
    study.files.add_archive("variants/fine/box.rro", other);
    study.options.sweep.variants = {study.files.folder / "variants"};
    const auto same = plan_sweep(study.manifest, study.options.sweep);
    REQUIRE(same);
    CHECK(std::any_of(same->not_swept.begin(), same->not_swept.end(),
                      [](const NotSwept& n) { return n.what.ends_with("variants/fine"); }));
    study.options.sweep.variants = {study.files.folder / "none"};
    CHECK(!plan_sweep(study.manifest, study.options.sweep));
    study.options.sweep.accuracies = {2};
    CHECK(!plan_sweep(study.manifest, study.options.sweep));
}
