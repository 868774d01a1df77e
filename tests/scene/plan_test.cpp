#include "solver/effects/effect.h"
#include "solver/effects/shape.h"
#include "tests/scene/scene_files.h"

using namespace rro;
using namespace rro::test;
using Catch::Matchers::Contains;

namespace {

constexpr const char* kGreyWalls = R"("*": {"reflectance": [0.5, 0.5, 0.5], "exitance": [0, 0, 0]})";
constexpr const char* kGreyLamp = R"("*": {"reflectance": [0.5, 0.5, 0.5]}, "lamp": {"exitance": [20, 20, 20]})";

std::string instance(const std::string& name, const std::string& materials, const std::string& archive = "box.rro") {
    return "{\"name\": \"" + name + "\", \"archive\": \"" + archive + "\", \"materials\": {" + materials + "}}";
}

Plan plan_of(SceneFiles& files, const std::string& instances, const EffectOverrides& overrides = {}) {
    auto plan = plan_effects(files.open(files.instances(instances)), overrides);
    if (!plan) FAIL(plan.error().message);
    return std::move(*plan);
}

/// The box, said not to be convex: its shape is not looked at again.
void add_not_convex(SceneFiles& files) {
    TinyObject object = tiny_object();
    object.meta.convex = false;
    files.add_archive("cave.rro", object);
}

/// The box pressed flat onto z = 0, turned about x so that its coordinates round.
void add_flat(SceneFiles& files) {
    TinyObject object = tiny_object();
    object.meta.convex = false;
    for (Vec3f& p : object.positions) p = {p.x, p.y * 0.36f, p.y * 0.93f};
    files.add_archive("flat.rro", object);
}

std::string reason(Plan& plan, const std::string& effect, bool on) {
    CHECK(plan[effect].on == on);
    CHECK(plan.on(effect) == on);
    return plan[effect].reason;
}

}  // namespace

TEST_CASE("the plan lists all effects in their order, each with a reason", "[effects]") {
    SceneFiles files;
    const Plan plan = plan_of(files, instance("a", ""));
    std::string names;
    for (const EffectPlan& effect : plan.effects) {
        names += effect.name + " ";
        CHECK_FALSE(effect.reason.empty());
    }
    CHECK(names ==
          "emitters interreflection occlusion self colour sky sun lights transmission textures groups medium ");
    CHECK(plan.warnings.empty());
    for (const char* absent : {"sky", "sun", "lights", "transmission", "groups", "medium"})
        CHECK_FALSE(plan.on(absent));
}

TEST_CASE("a dark scene needs no transport", "[effects]") {
    SceneFiles files;
    add_not_convex(files);
    Plan plan = plan_of(files, instance("a", kGreyWalls) + "," + instance("b", kGreyWalls, "cave.rro"));
    CHECK(reason(plan, "emitters", false) == "no surface emits");
    for (const char* effect : {"interreflection", "occlusion", "self"})
        CHECK(reason(plan, effect, false) == "nothing gives light");
    CHECK(reason(plan, "colour", false) == "every reflectance and every light is grey");
    CHECK(plan.channels == 1);
}

TEST_CASE("one convex object sees nothing", "[effects]") {
    SceneFiles files;
    Plan plan = plan_of(files, instance("bulb", kGreyLamp));
    CHECK(reason(plan, "emitters", true) == "bulb: exitance 20 W/m^2 at material lamp");
    CHECK(reason(plan, "interreflection", false) == "one object, convex or flat: nothing sees anything");
    CHECK(reason(plan, "occlusion", false) == "one object, convex or flat");
    CHECK(reason(plan, "self", false) == "every object is convex or flat");
    CHECK(plan.channels == 1);
}

TEST_CASE("two convex or flat objects cannot be blocked, three can", "[effects]") {
    SceneFiles files;
    add_flat(files);
    const std::string two = instance("bulb", kGreyLamp) + "," + instance("floor", kGreyWalls, "flat.rro");
    Plan plan = plan_of(files, two);
    CHECK(reason(plan, "interreflection", true) == "bulb: reflectance 0.5 at material walls");
    CHECK(reason(plan, "occlusion", false) == "two objects, each convex or flat");
    CHECK(reason(plan, "self", false) == "every object is convex or flat");
    Plan three = plan_of(files, two + "," + instance("wall", kGreyWalls));
    CHECK(reason(three, "occlusion", true) == "3 objects");
}

TEST_CASE("an object that is neither convex nor flat lights and blocks itself", "[effects]") {
    SceneFiles files;
    add_not_convex(files);
    Plan plan = plan_of(files, instance("cave", kGreyLamp, "cave.rro"));
    for (const char* effect : {"occlusion", "self"})
        CHECK(reason(plan, effect, true) == "cave: neither convex nor flat");
    CHECK(plan.on("interreflection"));
}

TEST_CASE("black surfaces do not interreflect but block", "[effects]") {
    SceneFiles files;
    add_not_convex(files);
    Plan plan = plan_of(files, instance("cave", R"("*": {"reflectance": [0, 0, 0]})", "cave.rro"));
    CHECK(reason(plan, "interreflection", false) == "all reflectances are 0");
    CHECK(plan.on("occlusion"));
    CHECK(plan.on("emitters"));
}

TEST_CASE("colour anywhere takes three channels", "[effects]") {
    SceneFiles files;
    Plan plan = plan_of(files, instance("a", kGreyWalls) + "," + instance("b", ""));
    CHECK(reason(plan, "colour", true) == "b: reflectance (0.5, 0.25, 0.125) at material walls");
    CHECK(plan.channels == 3);
    Plan lamp = plan_of(files, instance("a", R"("*": {"reflectance": [0, 0, 0]})"));
    CHECK(reason(lamp, "colour", true) == "a: exitance (20, 18, 15.5) W/m^2 at material lamp");
}

TEST_CASE("textures are called for unless the manifest replaces them", "[effects]") {
    SceneFiles files;
    Plan plan = plan_of(files, instance("a", ""));
    CHECK(reason(plan, "textures", true) == "a: material lamp has a texture");
    CHECK_FALSE(plan_of(files, instance("a", kGreyLamp)).on("textures"));
}

TEST_CASE("effects are switched by hand with a warning", "[effects]") {
    SceneFiles files;
    Plan plan = plan_of(files, instance("a", kGreyLamp), {{"self"}, {"emitters", "sky"}});
    CHECK(reason(plan, "self", true) == "asked for by --with");
    CHECK(reason(plan, "emitters", false) == "left out by --without");
    REQUIRE(plan.warnings.size() == 3);
    CHECK_THAT(plan.warnings[0], Contains("--without emitters"));
    CHECK(plan.warnings[1] == "--with self: not called for (every object is convex or flat)");
    CHECK_THAT(plan.warnings[2], Contains("--without sky"));
    CHECK(plan_of(files, instance("a", kGreyLamp), {{"colour"}, {}}).channels == 3);
}

TEST_CASE("overrides that make no sense are wrong usage", "[effects]") {
    SceneFiles files;
    const Scene scene = files.open(files.instances(instance("a", "")));
    const auto error = [&](const EffectOverrides& overrides) {
        const auto plan = plan_effects(scene, overrides);
        REQUIRE_FALSE(plan);
        CHECK(plan.error().kind == ErrorKind::Usage);
        return plan.error();
    };
    const Error unknown = error({{}, {"color"}});
    CHECK_THAT(unknown.message,
               Contains("--without color: no such effect, expected one of: emitters, interreflection, occlusion, self, "
                        "colour, sky, sun, lights, transmission, textures, groups, medium"));
    CHECK(unknown.hint == "did you mean \"colour\"?");
    CHECK_THAT(error({{"self"}, {"self"}}).message, Contains("contradict"));
}

TEST_CASE("what is left out by hand leaves the radiometry", "[effects]") {
    SceneFiles files;
    TinyObject object = tiny_object();
    object.patches[1].reflectance = {0.75f, 0.5f, 0.25f};  // a texture over a black material
    files.add_archive("box.rro", object);
    const auto left = [&](const std::string& effect) {
        Scene scene = files.open(files.instances(instance("a", "")));
        leave_out({{}, {effect}}, scene);
        return scene;
    };
    CHECK(left("emitters").instances[0].exitance[1] == Rgb{});
    CHECK(left("textures").instances[0].reflectance[1] == Rgb{});
    CHECK(left("textures").instances[0].reflectance[0] == Rgb{0.5f, 0.25f, 0.125f});
    CHECK(left("colour").instances[0].reflectance[1] == Rgb{0.5f, 0.5f, 0.5f});
    CHECK(left("self").instances[0].exitance[1] == Rgb{20, 18, 15.5f});
    auto plan = plan_effects(left("colour"), {{}, {"colour"}});
    REQUIRE(plan);
    CHECK(plan->channels == 1);
}

TEST_CASE("light from outside is called for where the manifest has some that is not 0", "[effects]") {
    SceneFiles files;
    const auto plan_with = [&](const std::string& more, const EffectOverrides& overrides = {}) {
        Scene scene = files.open(files.instances(instance("a", kGreyWalls), more));
        leave_out(overrides, scene);
        auto plan = plan_effects(scene, overrides);
        if (!plan) FAIL(plan.error().message);
        return std::move(*plan);
    };
    const std::string lit = R"(, "sky": {"radiance": [1, 1, 1], "ground": true},
        "sun": {"direction": [0, -1, 0], "irradiance": [800, 800, 700]},
        "lights": [{"name": "bulb", "type": "point", "position": [0, 3, 0], "intensity": [5, 5, 5], "group": "night"},
                   {"name": "off", "type": "point", "position": [0, 3, 0], "intensity": [0, 0, 0]}],
        "medium": {"absorption": [0.1, 0.1, 0.1]})";
    Plan plan = plan_with(lit);
    CHECK(reason(plan, "emitters", false) == "no surface emits");
    CHECK(reason(plan, "interreflection", false) == "one object, convex or flat: nothing sees anything");
    CHECK(reason(plan, "sky", true) == "light from above the horizon");
    CHECK(reason(plan, "sun", true) == "irradiance (800, 800, 700) W/m^2");
    CHECK(reason(plan, "lights", true) == "bulb: intensity 5 W/sr");
    CHECK(reason(plan, "groups", true) == "light bulb is in light group night");
    CHECK(reason(plan, "medium", true) == "absorption 0.1 1/m");
    CHECK(reason(plan, "colour", true) == "sun: irradiance (800, 800, 700) W/m^2");
    Plan without = plan_with(lit, {{}, {"sky", "sun", "lights", "medium", "groups"}});
    for (const char* effect : {"sky", "sun", "lights", "groups", "medium"}) CHECK_FALSE(without.on(effect));
    CHECK(reason(without, "interreflection", false) == "nothing gives light");
    Plan dark = plan_with(R"(, "sky": {"radiance": [0, 0, 0]}, "medium": {"absorption": [0, 0, 0]})");
    CHECK(reason(dark, "sky", false) == "its radiance is 0");
    CHECK(reason(dark, "medium", false) == "its absorption is 0");
}

TEST_CASE("flatness survives the rounding of coordinates, and a dent is seen", "[effects][shape]") {
    TinyObject object = tiny_object();
    CHECK_FALSE(is_flat(object.data()));
    for (Vec3f& p : object.positions) {
        const Vec3 q = 50.0 * Vec3{1, 1, 1} + Vec3{0.6, 0.8, 0.1} * double(p.x) + Vec3{-0.3, 0.2, 0.7} * double(p.y);
        p = to_float(q);
    }
    CHECK(is_flat(object.data()));
    object.positions[0].z += 1e-3f;  // of coordinates near 50, where float32 steps are 4e-6
    CHECK_FALSE(is_flat(object.data()));
}

TEST_CASE("a build without an effect refuses scenes that call for it", "[effects]") {
    SceneFiles files;
    const Plan plan = plan_of(files, instance("bulb", kGreyLamp));
    CHECK(all_built(plan, kEffects, "room.json"));
    CHECK(all_built(plan, std::array<std::string_view, 1>{"emitters"}, "room.json"));  // all that a single bulb calls for
    const Status refused = all_built(plan, std::array<std::string_view, 2>{"sky", "sun"}, "room.json");
    REQUIRE_FALSE(refused);
    CHECK(refused.error().kind == ErrorKind::BadInput);
    CHECK(refused.error().where == "room.json");
    CHECK(refused.error().message ==
          "calls for emitters (bulb: exitance 20 W/m^2 at material lamp), which this build leaves out");
    CHECK_THAT(refused.error().hint, Contains("RRO_EFFECTS") && Contains("--without emitters"));
}
