#include "solver/edit/live.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>

#include "compiler/compile_object.h"
#include "format/tool/json_document.h"
#include "schemas/live_schema.h"
#include "tests/scene/scene_files.h"
#include "tests/support/meshes.h"

using namespace rro;
using namespace rro::test;
using nlohmann::json;

namespace {

/// box.rro, and a scene of a lit one above another.
class LiveFiles : public SceneFiles {
  public:
    LiveFiles() {
        const auto compiled = compile_object(make_box(1, 1, 1), {});
        REQUIRE(compiled);
        REQUIRE(write_archive(compiled->data, folder / "box.rro"));
    }

    LiveSession open_live(LiveOptions options = {}) {
        options.solve.accuracy = 0.2;
        auto session = LiveSession::open(
            instances(R"({"name": "low", "archive": "box.rro"},
                         {"name": "lamp", "archive": "box.rro", "transform": {"translate": [0, 2, 0]},
                          "materials": {"*": {"exitance": [10, 10, 10], "group": "evening"}}})"),
            options);
        if (!session) FAIL(session.error().where << ": " << session.error().message);
        return std::move(*session);
    }
};

/// One of the schema's definitions, as a schema.
std::string definition(const char* name) {
    const json all = json::parse(live_schema);
    json schema = all["definitions"][name];
    schema["definitions"] = all["definitions"];
    return schema.dump();
}

json ask(LiveSession& session, const json& request) {
    static const JsonSchema reply_schema(definition("reply")), refusal_schema(definition("refusal"));
    const json reply = json::parse(session.answer(request.dump()));
    INFO(request.dump() << " -> " << reply.dump());
    CHECK((reply["ok"] == true ? reply_schema : refusal_schema).check(reply, "reply"));
    return reply;
}

json done(LiveSession& session, const json& request) {
    const json reply = ask(session, request);
    INFO(request.dump() << " -> " << reply.dump());
    REQUIRE(reply["ok"] == true);
    return reply;
}

/// All radiosities, to be compared bit for bit.
std::vector<Rgb> light_of(const Solution& solution) {
    std::vector<Rgb> out;
    for (const InstanceSolution& s : solution.instances) out.insert(out.end(), s.radiosity.begin(), s.radiosity.end());
    return out;
}

bool same_bits(const std::vector<Rgb>& a, const std::vector<Rgb>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(Rgb)) == 0;
}

// Target A6 is a tenth of the accuracy, 0.2, of what is reflected; here exitance counts, too.
constexpr double kAgreement = 0.15 * 0.2;

/// Root mean square of the difference, relative to the second.
double difference(const std::vector<Rgb>& a, const std::vector<Rgb>& b) {
    REQUIRE(a.size() == b.size());
    double sum = 0, all = 0;
    for (std::size_t k = 0; k < a.size(); ++k) {
        sum += length2(to_double(a[k]) - to_double(b[k]));
        all += length2(to_double(b[k]));
    }
    return all > 0 ? std::sqrt(sum / all) : std::sqrt(sum);
}

/// The manifest as the session saves it, solved by itself.
std::vector<Rgb> from_scratch(LiveFiles& files, LiveSession& session) {
    const std::string file = (files.folder / "saved.json").string();
    done(session, {{"op", "save"}, {"file", file}});
    SolveOptions options;
    options.accuracy = 0.2;
    const auto solution = solve_scene(files.open(file), options);
    REQUIRE(solution);
    return light_of(*solution);
}

json random_edit(std::mt19937& random, const Scene& scene) {
    const auto number = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); };
    const json transform{{"translate", {number(-3, 3), number(-3, 3), number(-3, 3)}}};
    const std::string name = scene.instances.empty() ? "none" : scene.instances[random() % scene.instances.size()].name;
    switch (random() % 6) {
        case 0: return {{"op", "place"}, {"name", "n" + std::to_string(random() % 4)}, {"archive", "box.rro"}, {"transform", transform}};
        case 1: return {{"op", "delete"}, {"name", name}};
        case 2: return {{"op", "material"}, {"name", name}, {"materials", {{"*", {{"reflectance", {number(0, 0.9), 0.5, 0}}}}}}};
        case 3: return {{"op", "light"}, {"group", "evening"}, {"scale", number(0, 2)}};
        case 4: return {{"op", "light"}, {"instance", name}, {"material", "*"}, {"exitance", {number(0, 20), 1, 0}}};
        default: return {{"op", "move"}, {"name", name}, {"transform", transform}};
    }
}

}  // namespace

TEST_CASE("a dialogue as the protocol says", "[live]") {
    LiveFiles files;
    LiveSession session = files.open_live();
    const json ready = json::parse(session.ready());
    CHECK(ready["event"] == "ready");
    CHECK(ready["protocol"] == 1);
    const json before = done(session, {{"op", "radiosity"}, {"name", "low"}});
    CHECK(before["radiosity"].size() == 12);
    CHECK(before["radiosity"][3][0] == 3);

    const json moved = done(session, {{"op", "move"}, {"id", "a7"}, {"name", "low"}, {"transform", {{"translate", {0, -1, 0}}}}});
    CHECK(moved["id"] == "a7");
    CHECK(moved["links"]["removed"] > 0);
    CHECK(moved["links"]["added"] > 0);
    CHECK(moved["estimated_error"].is_number());
    CHECK(done(session, {{"op", "radiosity"}, {"name", "low"}})["radiosity"] != before["radiosity"]);
    const json undone = done(session, {{"op", "undo"}});
    CHECK(undone["links"] == json{{"removed", 0}, {"retested", 0}, {"added", 0}});
    CHECK(done(session, {{"op", "radiosity"}, {"name", "low"}})["radiosity"] == before["radiosity"]);

    const json later = done(session, {{"op", "delete"}, {"name", "low"}, {"solve", false}});
    CHECK(later["estimated_error"].is_null());
    CHECK(session.solution() == nullptr);
    CHECK(done(session, {{"op", "solve"}, {"accuracy", 0.3}})["estimated_error"].is_number());
    const std::string file = (files.folder / "lamp.csv").string();
    done(session, {{"op", "radiosity"}, {"name", "lamp"}, {"file", file}});
    CHECK_THAT(file_text(file), Catch::Contains("\nlamp,0,"));
    const std::string picture = (files.folder / "view.png").string();
    done(session, {{"op", "picture"}, {"file", picture}, {"size", {16, 9}},
                   {"camera", {{"position", {0, 0, 9}}, {"target", {0, 0, 0}}}}});
    CHECK(file_text(picture).starts_with("\x89PNG"));
    done(session, {{"op", "quit"}});
    CHECK(session.ended());
}

TEST_CASE("what cannot be done is answered and changes nothing", "[live]") {
    LiveFiles files;
    LiveSession session = files.open_live();
    const auto before = light_of(*session.solution());
    const auto refused = [&](const std::string& line, const std::string& what) {
        const json reply = json::parse(session.answer(line));
        INFO(line.substr(0, 200) << " -> " << reply.dump().substr(0, 400));
        CHECK(reply["ok"] == false);
        for (const char* key : {"kind", "where", "message", "hint"}) CHECK(reply["error"][key].is_string());
        CHECK_THAT(reply["error"].dump(), Catch::Contains(what));
        REQUIRE(session.solution());
        CHECK(same_bits(light_of(*session.solution()), before));
        CHECK(session.scene().instances.size() == 2);
    };
    refused("{\"op\":", "line 1");
    refused("[]", "an array");
    refused("{\"op\":\"undo\",\"op\":\"redo\"}", "twice");
    refused("{\"op\":7}", "op");
    refused("\xff\xfe", "request");
    refused(std::string(200, '['), "request");
    refused(std::string(100000, '['), "nested");
    refused("{\"op\":\"mvoe\"}", "did you mean \\\"move\\\"?");
    refused("{\"op\":\"undo\"}", "nothing to undo");
    refused("{\"op\":\"redo\"}", "nothing to redo");
    refused("{\"op\":\"move\",\"name\":\"low\"}", "transform");
    refused("{\"op\":\"move\",\"name\":\"low\",\"transform\":{\"translate\":[NaN,0,0]}}", "line 1");
    refused("{\"op\":\"move\",\"name\":\"low\",\"transform\":{\"translate\":[1e999,0,0]}}", "request");
    refused(R"({"op":"move","name":"low","transform":{"translate":["1",0,0]}})", "/transform/translate/0");
    refused(R"({"op":"move","name":"low","transform":{"scale":0}})", "singular");
    refused(R"({"op":"move","name":"lwo","transform":{}})", "did you mean \\\"low\\\"?");
    refused(R"({"op":"place","name":"low","archive":"box.rro"})", "taken");
    refused(R"({"op":"place","name":"x","archive":"none.rro"})", "none.rro");
    refused(R"({"op":"place","name":"x","archive":[]})", "/archive");
    refused(R"({"op":"material","name":"low","materials":{"brass":{"reflectance":[0,0,0]}}})", "brass");
    refused(R"({"op":"material","name":"low","materials":{"*":{"reflectance":[0,0,1]}}})", "below 1");
    refused(R"({"op":"light","group":"evning","scale":1})", "evening");
    refused(R"({"op":"light","group":"evening","scale":-1})", "scale");
    refused(R"({"op":"light","group":"evening","scale":1e300})", "exitance");
    refused(R"({"op":"light","group":"evening","exitance":[1,1,1]})", "expected");
    refused(R"({"op":"solve","accuracy":0})", "accuracy");
    refused(R"({"op":"radiosity","name":"x"})", "no instance");
    refused(R"({"op":"picture","file":"x.png","size":"0x5"})", "size");
    refused(R"({"op":"picture","file":"/none/x.png"})", "/none");
    refused(R"({"op":"picture","file":"x.png","camera":{"position":[0,0,0],"target":[0,0,0]}})", "target");
    refused(R"({"op":"save","file":"/none/x.json"})", "/none");
    refused(R"({"op":"save","file":"x\u0000y"})", "NUL");
    refused("{\"op\":\"move\",\"name\":\"" + std::string(1 << 20, 'x') + "\",\"transform\":{}}", "no instance");
    std::string singular = R"({"op":"move","name":"low","transform":{"matrix":[0,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]}})";
    refused(singular, "singular");
}

TEST_CASE("the end of input is quit, wherever it comes", "[live]") {
    LiveFiles files;
    for (const auto& [input, replies] :
         {std::pair("", 0), std::pair("\n  \r\n", 0), std::pair("{\"op\":\"undo\"}\n{\"op\":", 2), std::pair("{\"op\":\"quit\"}\n{}\n", 1),
          std::pair("{\"op\":\"solve\"}", 1)}) {
        LiveSession session = files.open_live();
        std::istringstream in(input);
        std::ostringstream out;
        serve(session, in, out);
        const std::string text = out.str();
        CHECK(std::count(text.begin(), text.end(), '\n') == 1 + replies);
        CHECK(text.starts_with("{"));
    }
}

TEST_CASE("random edits agree with solving from scratch, and undo restores bit for bit", "[live]") {
    LiveFiles files;
    LiveSession session = files.open_live();
    constexpr unsigned seed = 7;
    std::mt19937 random(seed);
    std::vector<std::vector<Rgb>> history{light_of(*session.solution())};
    std::size_t at = 0;
    for (int step = 0; step < 1000; ++step) {
        if (random() % 3 == 0) {
            const bool back = random() % 3 > 0;
            const bool possible = back ? at > 0 : at + 1 < history.size();
            REQUIRE(ask(session, {{"op", back ? "undo" : "redo"}})["ok"] == possible);
            if (possible) at += back ? std::size_t(-1) : 1;
        } else if (ask(session, random_edit(random, session.scene()))["ok"] == true) {
            history.resize(++at);
            history.push_back(light_of(*session.solution()));
        }
        REQUIRE(same_bits(light_of(*session.solution()), history[at]));
        if (step % 50 == 0) CHECK(difference(from_scratch(files, session), history[at]) < kAgreement);
    }
    CHECK(history.size() > 10);
    CHECK(difference(from_scratch(files, session), history[at]) < kAgreement);
}

TEST_CASE("a dimmed group comes back as it was", "[live]") {
    LiveFiles files;
    LiveSession session = files.open_live();
    const auto before = light_of(*session.solution());
    done(session, {{"op", "light"}, {"group", "evening"}, {"scale", 0}});
    for (const Rgb& dark : light_of(*session.solution())) CHECK((dark.x == 0 && dark.y == 0 && dark.z == 0));
    done(session, {{"op", "light"}, {"group", "evening"}, {"scale", 1}});
    CHECK(difference(light_of(*session.solution()), before) < kAgreement);
}

TEST_CASE("archives are loaded once: an edit needs no file", "[live]") {
    LiveFiles files;
    LiveSession session = files.open_live();
    std::filesystem::remove(files.folder / "box.rro");
    std::filesystem::remove(files.folder / "room.json");
    done(session, {{"op", "place"}, {"name", "more"}, {"archive", "box.rro"}, {"transform", {{"translate", {3, 0, 0}}}}});
    CHECK(session.scene().objects.size() == 1);
}

TEST_CASE("undo keeps within its memory", "[live]") {
    LiveFiles files;
    LiveOptions options;
    options.history_bytes = 20000;  // some states of two boxes
    LiveSession session = files.open_live(options);
    for (int i = 0; i < 60; ++i)
        done(session, {{"op", "move"}, {"name", "low"}, {"transform", {{"translate", {0.1 * i, 0, 0}}}}});
    int undone = 0;
    json reply;
    while ((reply = ask(session, {{"op", "undo"}}))["ok"] == true) ++undone;
    CHECK(undone > 0);
    CHECK(undone < 60);
    CHECK_THAT(reply["error"]["hint"].get<std::string>(), Catch::Contains("forgotten"));
}
