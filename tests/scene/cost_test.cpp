#include "solver/effects/cost.h"

#include "solver/explain.h"
#include "tests/scene/scene_files.h"

using namespace rro;
using namespace rro::test;
using Catch::Matchers::Contains;

namespace {

constexpr const char* kGrey = R"("*": {"reflectance": [0.5, 0.5, 0.5], "exitance": [1, 1, 1]})";
constexpr const char* kColoured = R"("*": {"reflectance": [0.5, 0.4, 0.5], "exitance": [1, 1, 1]})";
constexpr const char* kBlack = R"("*": {"reflectance": [0, 0, 0], "exitance": [1, 1, 1]})";
constexpr const char* kDark = R"("*": {"exitance": [0, 0, 0]})";

std::string boxes(int count, const std::string& materials) {
    std::string list;
    for (int i = 0; i < count; ++i)
        list += (i > 0 ? "," : "") + std::string("{\"name\": \"") + std::to_string(i) +
                R"(", "archive": "box.rro", "materials": {)" + materials + "}}";
    return list;
}

struct Prediction {
    Plan plan;
    Work all;
};

Prediction predicted(SceneFiles& files, const std::string& instances, double accuracy = 0.1, unsigned threads = 1) {
    const Scene scene = files.open(files.instances(instances));
    auto plan = plan_effects(scene, {});
    if (!plan) FAIL(plan.error().message);
    const Work all = predict_work(scene, accuracy, threads, *plan);
    return {std::move(*plan), all};
}

}  // namespace

TEST_CASE("work is predicted for what is on only, and adds up", "[effects][cost]") {
    SceneFiles files;
    Prediction grey = predicted(files, boxes(3, kGrey));
    CHECK(grey.plan["interreflection"].predicted->links > 0);
    CHECK(grey.plan["occlusion"].predicted->rays > 0);
    CHECK_FALSE(grey.plan["self"].predicted);    // convex
    CHECK_FALSE(grey.plan["colour"].predicted);  // one channel
    CHECK_FALSE(grey.plan["sky"].predicted);
    CHECK(grey.all.links == grey.plan["interreflection"].predicted->links);
    CHECK(grey.all.seconds ==
          Approx(grey.plan["interreflection"].predicted->seconds + grey.plan["occlusion"].predicted->seconds));

    Prediction colour = predicted(files, boxes(3, kColoured));
    CHECK(colour.all.seconds > grey.all.seconds);
    CHECK(colour.all.links == grey.all.links);
    CHECK(colour.plan["colour"].predicted->bytes > 0);

    Prediction black = predicted(files, boxes(3, kBlack));
    CHECK(black.plan["emitters"].predicted->links == grey.all.links);
    CHECK(black.all.seconds < grey.all.seconds);
}

TEST_CASE("no light is no work, one convex object has no links, two meet without rays", "[effects][cost]") {
    SceneFiles files;
    const Work dark = predicted(files, boxes(3, kDark)).all;
    CHECK(dark.links == 0);
    CHECK(dark.seconds == 0);
    CHECK(predicted(files, boxes(1, kGrey)).all.links == 0);
    const Work two = predicted(files, boxes(2, kGrey)).all;
    CHECK(two.links > 0);
    CHECK(two.rays == 0);
}

TEST_CASE("accuracy costs, threads share", "[effects][cost]") {
    SceneFiles files;
    const Work coarse = predicted(files, boxes(3, kGrey), 0.2).all, fine = predicted(files, boxes(3, kGrey), 0.02).all;
    CHECK(fine.links > 5 * coarse.links);
    CHECK(fine.rays > 5 * coarse.rays);
    CHECK(predicted(files, boxes(3, kGrey), 0.02, 4).all.seconds == Approx(fine.seconds / 4));
}

TEST_CASE("explain tells of every effect, its work and why, as a table and as JSON", "[effects][cost]") {
    SceneFiles files;
    const Scene scene = files.open(files.instances(boxes(3, kGrey), R"(, "sky": {"radiance": [1, 1, 1]}, "accuracy": 0.25)"));
    auto plan = plan_effects(scene, {});
    REQUIRE(plan);
    const Outlook expected = outlook(scene, {}, *plan);
    CHECK(expected.accuracy == 0.25);
    CHECK(outlook(scene, 0.5, *plan).accuracy == 0.5);
    const std::string table = explain_text(scene, *plan, expected), json = explain_json(scene, *plan, expected);
    for (const EffectPlan& effect : plan->effects) {
        CHECK_THAT(table, Contains("  " + effect.name + " ") && Contains(effect.reason));
        CHECK_THAT(json, Contains("\"name\": \"" + effect.name + "\""));
    }
    CHECK_THAT(table, Contains("--accuracy 0.25"));
    CHECK(plan->effects[5].name == "sky");
    CHECK(plan->effects[5].predicted.value_or(Work{}).rays > 0);
    CHECK_THAT(json, Contains("\"predicted\"") && Contains("\"rays\""));
}

TEST_CASE("seconds of a solve are divided among the effects that took them", "[effects][cost]") {
    Solution solution;
    solution.effects = {{"emitters", true, "x"}, {"interreflection", true, "x"}, {"occlusion", true, "x"}, {"self", true, "x"}};
    solution.seconds.links = 8, solution.seconds.iterate = 2, solution.seconds.visibility = 3;
    solution.links.far = 60, solution.links.near = 15, solution.links.self = 25;
    account_seconds(solution);
    CHECK(solution.effects[0].seconds == 0);
    CHECK(solution.effects[1].seconds == 8);
    CHECK(solution.effects[2].seconds == 3);
    CHECK(solution.effects[3].seconds == 2);
}
