#include "solver/edit/live.h"

#include <algorithm>
#include <deque>
#include <istream>
#include <nlohmann/json.hpp>
#include <ostream>

#include "format/atomic_file.h"
#include "format/clock.h"
#include "format/source_order.h"
#include "format/tool/interrupt.h"
#include "format/tool/json_document.h"
#include "format/tool/names.h"
#include "format/tool/program.h"
#include "schemas/live_schema.h"
#include "solver/arguments.h"
#include "solver/edit/json_text.h"
#include "solver/edit/light_groups.h"
#include "solver/edit/manifest_edit.h"
#include "solver/effects/effect.h"
#include "solver/explain.h"
#include "solver/output/output.h"
#include "solver/scene/file_bytes.h"

namespace rro {
namespace {

using nlohmann::json;
constexpr std::uint64_t kLargestManifest = std::uint64_t{1} << 30;  // bytes
constexpr std::size_t kLongestLine = std::size_t{64} << 20;         // bytes; a request for a million materials

std::string line_of(const json& reply) {
    return reply.dump(-1, ' ', false, json::error_handler_t::replace);
}

json refusal(const Error& error) {
    const char* kind = error.kind == ErrorKind::Failed  ? "failed"
                       : error.kind == ErrorKind::Usage ? "usage"
                       : error.kind == ErrorKind::BadInput ? "bad_input"
                                                           : "internal";
    return {{"ok", false},
            {"error", {{"kind", kind}, {"where", error.where}, {"message", error.message}, {"hint", error.hint}}}};
}

/// The schema of each request, by its op.
std::map<std::string, JsonSchema> request_schemas() {
    const json all = json::parse(live_schema);
    std::map<std::string, JsonSchema> schemas;
    for (const json& alternative : all["oneOf"]) {
        std::string op = alternative["$ref"].get<std::string>();
        op.erase(0, op.rfind('/') + 1);
        json schema = all["definitions"][op];
        schema["definitions"] = all["definitions"];
        schemas.emplace(op, schema.dump());
    }
    return schemas;
}

/// A request as JSON whose op is known and whose keys fit it.
Status check_request(const json& request) {
    static const std::map<std::string, JsonSchema> schemas = request_schemas();
    if (!request.is_object() || !request.contains("op") || !request["op"].is_string())
        return bad_input("request", "found " + described(request) + ", expected an object with \"op\", a string");
    const std::string op = request["op"].get<std::string>();
    const auto schema = schemas.find(op);
    if (schema != schemas.end()) return schema->second.check(request, "request");
    std::vector<std::string> names;
    for (const auto& [name, unused] : schemas) names.push_back(name);
    return bad_input("request: /op", "found " + described(op) + ", expected one of: " + listed(names),
                     nearest_hint(op, names));
}

/// JSON text of a request's member, or nothing.
std::string text_of(const json& request, const char* key) {
    return request.contains(key) ? respaced(request[key].dump()) : "";
}

/// What undo and redo go between.
struct State {
    std::string text;     // of the manifest, before light groups are scaled
    GroupScales scales;
    std::shared_ptr<const Solution> solution;  // none while edits wait for a solve

    std::size_t bytes() const {
        std::size_t sum = text.size() + sizeof *this;
        if (solution)
            for (const InstanceSolution& s : solution->instances)
                sum += (s.radiosity.size() + s.irradiance.size()) * sizeof(Rgb) + s.elements.size() * sizeof(Element);
        return sum;
    }
};

struct Built {
    std::shared_ptr<const Scene> scene;
    std::string text;  // with light groups scaled: what `save` writes
};

json radiosity_rows(const Instance& instance, const InstanceSolution& solution) {
    const ObjectData& data = instance.data();
    json rows = json::array();
    for (const std::uint32_t triangle : by_source_number(data)) {
        json row{data.source_triangle[triangle]};
        for (const std::uint32_t face : {instance.object->front_face[triangle], instance.object->back_face[triangle]})
            if (face != kNoFace)
                for (const float channel : {solution.radiosity[face].x, solution.radiosity[face].y, solution.radiosity[face].z})
                    row.push_back(channel);
        rows.push_back(std::move(row));
    }
    return rows;
}

Result<PictureOptions> picture_options(const json& request) {
    PictureOptions options;
    if (!request.contains("size")) return options;
    const json& asked = request["size"];
    if (asked.is_array()) {
        options.width = asked[0].get<int>();
        options.height = asked[1].get<int>();
        return options;
    }
    const auto size = parse_size(asked.get<std::string>());
    if (!size) return bad_input("request: /size", size.error().message);
    options.width = (*size)[0];
    options.height = (*size)[1];
    return options;
}

/// The camera of a request, by the manifest's rules.
Result<std::optional<CameraEntry>> camera_of(const json& request) {
    if (!request.contains("camera")) return std::optional<CameraEntry>();
    const json scene{{"format", "rro-scene/1"}, {"instances", json::array()}, {"camera", request["camera"]}};
    const auto manifest = parse_manifest(scene.dump(), "request");
    if (!manifest) return manifest.error();
    return manifest->camera;
}

}  // namespace

struct LiveSession::Parts {
    std::filesystem::path path;
    LiveOptions options;
    SectionSet wanted;
    std::vector<std::shared_ptr<const Object>> opened;  // every archive met so far
    State now;
    Built built;
    std::deque<State> undone_to, redone_to;  // the latest at the back
    bool forgot = false;                     // states to undo have gone for want of memory
    bool ended = false;
    SceneSolver solver = {};
    json changed_links = none_changed();     // by the request at hand
    double open_ms = 0;

    static json none_changed() { return {{"removed", 0}, {"retested", 0}, {"added", 0}}; }

    Result<Scene> open(const std::string& text) {
        auto manifest = parse_manifest(text, path);
        if (!manifest) return manifest.error();
        auto scene = open_scene(std::move(*manifest), wanted, opened);
        if (!scene) return scene.error();
        for (const auto& object : scene->objects)
            if (std::find(opened.begin(), opened.end(), object) == opened.end()) opened.push_back(object);
        return scene;
    }

    Result<Built> build(const State& state) {
        auto scene = open(state.text);
        if (!scene) return scene.error();
        std::string text = state.text;
        if (std::any_of(state.scales.begin(), state.scales.end(), [](const auto& s) { return s.second != 1; })) {
            auto scaled = with_group_scales({path, state.text}, *scene, state.scales);
            if (!scaled) return scaled.error();
            auto dimmed = open(*scaled);
            if (!dimmed) return dimmed.error();
            scene = std::move(dimmed);
            text = std::move(*scaled);
        }
        leave_out(options.solve.overrides, *scene);
        if (const std::uint64_t needed = estimated_memory(*scene); needed > options.memory)
            return failed(path.string(), "needs about " + size_text(needed) + " of memory, " +
                                             size_text(options.memory) + " are allowed", "allow more with --memory");
        return Built{std::make_shared<const Scene>(std::move(*scene)), std::move(text)};
    }

    Status solve_state(State& state, const std::shared_ptr<const Scene>& scene, const SolveOptions& how) {
        auto solution = solver.solve(scene, how);
        if (!solution) return solution.error();
        state.solution = std::make_shared<const Solution>(std::move(*solution));
        const LinkChange& change = solver.change();
        changed_links = {{"removed", change.removed}, {"retested", change.retested}, {"added", change.added}};
        return Done{};
    }

    /// Makes `next` the state, solved if asked; the state before goes to the back of `before`. All or nothing.
    Status adopt(State next, bool solve, std::deque<State>& before) {
        auto rebuilt = build(next);
        if (!rebuilt) return rebuilt.error();
        if (solve && !next.solution)
            if (auto solved = solve_state(next, rebuilt->scene, options.solve); !solved) return solved.error();
        before.push_back(std::move(now));
        now = std::move(next);
        built = std::move(*rebuilt);
        return Done{};
    }

    void forget_the_oldest() {
        std::size_t bytes = now.bytes();
        for (const auto* states : {&undone_to, &redone_to})
            for (const State& state : *states) bytes += state.bytes();
        while (bytes > options.history_bytes && !(undone_to.empty() && redone_to.empty())) {
            auto& states = undone_to.empty() ? redone_to : undone_to;
            forgot = forgot || &states == &undone_to;
            bytes -= states.front().bytes();
            states.pop_front();
        }
    }

    /// A new edit: nothing can be redone after it.
    Status edit(const json& request, Result<std::string> text, GroupScales scales) {
        if (!text) return text.error();
        if (auto done = adopt({std::move(*text), std::move(scales), nullptr}, request.value("solve", true), undone_to); !done)
            return done.error();
        redone_to.clear();
        forget_the_oldest();
        return Done{};
    }

    /// Goes to the last state of `from`.
    Status go_back(const json& request, std::deque<State>& from, std::deque<State>& to) {
        const std::string op = request["op"].get<std::string>();
        if (from.empty())
            return bad_input("request: /op", "nothing to " + op,
                             op == "undo" && forgot ? "older edits were forgotten to keep within " +
                                                          size_text(options.history_bytes) + " of memory" : "");
        State next = from.back();
        if (auto done = adopt(std::move(next), request.value("solve", true), to); !done) return done.error();
        from.pop_back();
        forget_the_oldest();
        return Done{};
    }

    Status light(const json& request) {
        const bool surface = request.contains("instance") && request.contains("material") && request.contains("exitance");
        const bool group = request.contains("group") && request.contains("scale");
        const std::size_t keys = request.size() - request.count("id") - request.count("solve") - 1;  // without op
        if (!(surface && keys == 3) && !(group && keys == 2))
            return bad_input("request", "expected \"instance\", \"material\" and \"exitance\", or \"group\" and \"scale\"");
        if (surface)
            return edit(request,
                        with_material_field({path, now.text}, request["instance"].get<std::string>(),
                                            request["material"].get<std::string>(), "exitance", text_of(request, "exitance")),
                        now.scales);
        const std::string name = request["group"].get<std::string>();
        const std::vector<std::string> names(built.scene->light_groups.begin() + 1, built.scene->light_groups.end());
        if (std::find(names.begin(), names.end(), name) == names.end())
            return bad_input("request: /group", "found " + described(name) + ", expected a light group" +
                                                    (names.empty() ? "; the scene has none" : ": " + listed(names)),
                             nearest_hint(name, names));
        GroupScales scales = now.scales;
        scales[name] = request["scale"].get<double>();
        return edit(request, now.text, std::move(scales));
    }

    Status material(const json& request) {
        ManifestText text{path, now.text};
        const std::string name = request["name"].get<std::string>();
        if (const auto found = find_instance(text, name); !found) return found.error();
        for (const auto& [material_name, fields] : request["materials"].items())
            for (const auto& [field, value] : fields.items()) {
                auto changed = with_material_field(text, name, material_name, field, respaced(value.dump()));
                if (!changed) return changed.error();
                text.text = std::move(*changed);
            }
        return edit(request, std::move(text.text), now.scales);
    }

    Status solve(const json& request) {
        SolveOptions how = options.solve;
        if (request.contains("accuracy")) how.accuracy = request["accuracy"].get<double>();
        if (!now.solution || now.solution->accuracy != accuracy_of(*built.scene, how.accuracy))
            if (auto solved = solve_state(now, built.scene, how); !solved) return solved.error();
        options.solve = how;
        return Done{};
    }

    /// What is read out is never out of date.
    Status solve_what_waits() { return now.solution ? Status(Done{}) : solve(json::object()); }

    Status check_file(const std::string& file) const {
        const std::filesystem::path output = file;
        return check_outputs(std::span(&output, 1), path);
    }

    Status radiosity(const json& request, json& reply) {
        const auto index = find_instance({path, now.text}, request["name"].get<std::string>());
        if (!index) return index.error();
        if (auto solved = solve_what_waits(); !solved) return solved.error();
        const Instance& instance = built.scene->instances[*index];
        const InstanceSolution& solution = now.solution->instances[*index];
        if (!request.contains("file")) {
            reply["radiosity"] = radiosity_rows(instance, solution);
            return Done{};
        }
        const std::string file = request["file"].get<std::string>();
        if (auto fits = check_file(file); !fits) return fits.error();
        Scene one;
        one.instances.push_back(instance);
        Solution part;
        part.instances.push_back(solution);
        const DeferInterrupts until_written;
        return write_radiosity_csv(one, part, file);
    }

    Status picture(const json& request, json& reply) {
        const std::string file = request["file"].get<std::string>();
        const auto size = picture_options(request);
        if (!size) return size.error();
        const auto camera = camera_of(request);
        if (!camera) return camera.error();
        if (auto fits = check_file(file); !fits) return fits.error();
        if (auto solved = solve_what_waits(); !solved) return solved.error();
        Scene seen = *built.scene;
        if (*camera) seen.manifest.camera = *camera;
        const DeferInterrupts until_written;
        const auto exposure = write_picture(seen, *now.solution, SceneRays(seen), *size, file);
        if (!exposure) return exposure.error();
        reply["exposure"] = *exposure;
        return Done{};
    }

    Status save(const json& request) {
        const std::filesystem::path file = request["file"].get<std::string>();
        const ManifestText text{path, built.text};
        std::error_code code;
        const auto folder = [](const std::filesystem::path& p) { return p.parent_path().empty() ? "." : p.parent_path(); };
        const bool same = std::filesystem::equivalent(folder(file), folder(path), code);
        const std::string saved = same ? text.text : moved_to_folder(text, folder(file));
        const DeferInterrupts until_written;
        return write_file_atomically(file, saved);
    }

    Status dispatch(const json& request, json& reply) {
        const std::string op = request["op"].get<std::string>();
        const ManifestText text{path, now.text};
        const std::string name = request.value("name", "");
        if (request.value("file", "").find('\0') != std::string::npos)
            return bad_input("request: /file", "a path cannot hold a NUL character");
        if (op == "place")
            return edit(request, with_instance(text, {name, text_of(request, "archive"), text_of(request, "transform"),
                                                      text_of(request, "materials")}), now.scales);
        if (op == "move") return edit(request, with_transform(text, name, text_of(request, "transform")), now.scales);
        if (op == "delete") return edit(request, without_instance(text, name), now.scales);
        if (op == "material") return material(request);
        if (op == "light") return light(request);
        if (op == "undo") return go_back(request, undone_to, redone_to);
        if (op == "redo") return go_back(request, redone_to, undone_to);
        if (op == "solve") return solve(request);
        if (op == "radiosity") return radiosity(request, reply);
        if (op == "picture") return picture(request, reply);
        if (op == "save") return save(request);
        ended = true;  // quit
        return Done{};
    }

    json answer(const json& request) {
        const auto start = Clock::now();
        changed_links = none_changed();
        if (auto fits = check_request(request); !fits) return refusal(fits.error());
        json reply;
        if (auto done = dispatch(request, reply); !done) return refusal(done.error());
        reply["ok"] = true;
        reply["op"] = request["op"];
        reply["links"] = changed_links;
        reply["estimated_error"] = now.solution ? json(now.solution->estimated_error) : json();
        reply["converged"] = now.solution ? json(now.solution->converged) : json();
        reply["ms"] = milliseconds_since(start);
        return reply;
    }
};

LiveSession::LiveSession(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
LiveSession::LiveSession(LiveSession&&) noexcept = default;
LiveSession::~LiveSession() = default;

Result<LiveSession> LiveSession::open(const std::filesystem::path& manifest, const LiveOptions& options) {
    const auto start = Clock::now();
    auto text = read_bytes(manifest, kLargestManifest);
    if (!text) return text.error();
    const SectionSet wanted = kGeometry | kTables | sections_of(options.solve.visibility) | Section::Source;
    auto parts = std::make_unique<Parts>(Parts{manifest, options, wanted, {}, {}, {}, {}, {}});
    std::deque<State> nothing_before;
    if (auto solved = parts->adopt({std::move(*text), {}, nullptr}, true, nothing_before); !solved) return solved.error();
    parts->open_ms = milliseconds_since(start);
    return LiveSession(std::move(parts));
}

std::string LiveSession::ready() const {
    return line_of({{"event", "ready"}, {"protocol", 1}, {"ms", parts_->open_ms},
                    {"estimated_error", parts_->now.solution->estimated_error}});
}

std::string LiveSession::answer(std::string_view line) {
    json id, reply;
    bool has_id = false;
    try {
        const auto request = parse_json(line, "request");
        if (request && request->is_object() && request->contains("id")) {
            has_id = true;
            id = (*request)["id"];
        }
        reply = request ? parts_->answer(*request) : refusal(request.error());
    } catch (const std::exception& exception) {
        reply = refusal(error_from_exception(exception));
    }
    if (has_id) reply["id"] = id;
    return line_of(reply);
}

bool LiveSession::ended() const {
    return parts_->ended;
}

const Scene& LiveSession::scene() const {
    return *parts_->built.scene;
}

const Solution* LiveSession::solution() const {
    return parts_->now.solution.get();
}

void serve(LiveSession& session, std::istream& in, std::ostream& out) {
    out << session.ready() << '\n' << std::flush;
    std::string line;
    while (in && out && !session.ended()) {
        line.clear();
        bool too_long = false;
        int c = in.get();
        for (; in && c != '\n'; c = in.get()) {
            if (line.size() < kLongestLine) line += static_cast<char>(c);
            else too_long = true;
        }
        if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
        out << (too_long ? line_of(refusal(bad_input("request", "the line has more than " + size_text(kLongestLine))))
                         : session.answer(line))
            << '\n'
            << std::flush;
    }
}

}  // namespace rro
