#include <map>
#include <nlohmann/json.hpp>

#include "compiler/archive_diff.h"

namespace rro {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kLabelWidth = 12;    // the longest group and two blanks
constexpr std::size_t kLinesPerKind = 12;  // of a hundred materials or options, the first tell enough

std::string label(const std::string& text) {
    return text + std::string(kLabelWidth - std::min(kLabelWidth - 1, text.size()), ' ');
}

struct JsonWriter {
    Json operator()(std::monostate) const { return nullptr; }
    Json operator()(const Vec3& v) const { return {v.x, v.y, v.z}; }
    template <class Value>
    Json operator()(const Value& v) const {
        return v;
    }
};

Json json_of(const DiffValue& value) {
    return std::visit(JsonWriter{}, value);
}

Json json_of(const Change& change) {
    Json entry{{"group", change.group},
               {"kind", change.kind},
               {"what", change.what},
               {"before", json_of(change.before)},
               {"after", json_of(change.after)}};
    for (const auto& [name, value] : change.more) entry[name] = json_of(value);
    return entry;
}

Json json_of(const ArchiveIdentity& archive, const std::string& name) {
    return {{"file", name}, {"bytes", archive.bytes}, {"version", archive.version}, {"content", archive.content}};
}

}  // namespace

std::string diff_text(const ArchiveDiff& diff, const std::string& name_a, const std::string& name_b) {
    std::string out = name_a + " -> " + name_b + ": " + diff.summary + "\n";
    std::string group;
    std::map<std::string, std::size_t> lines;  // by kind
    for (std::size_t i = 0; i < diff.changes.size(); ++i) {
        const Change& change = diff.changes[i];
        const std::size_t line = ++lines[change.kind];
        if (line <= kLinesPerKind) out += label(change.group == group ? "" : change.group) + change.text + "\n";
        group = change.group;
        const bool last = i + 1 == diff.changes.size() || diff.changes[i + 1].kind != change.kind;
        if (last && line > kLinesPerKind)
            out += label("") + "and " + std::to_string(line - kLinesPerKind) + " more (--json has all)\n";
    }
    if (diff.changes.empty()) return out;
    std::string unchanged;
    for (const std::string& name : diff.unchanged_sections) unchanged += (unchanged.empty() ? "" : ", ") + name;
    return unchanged.empty() ? out : out + label("unchanged") + unchanged + "\n";
}

std::string diff_json(const ArchiveDiff& diff, const std::string& name_a, const std::string& name_b) {
    Json out{
        {"same", diff.same}, {"summary", diff.summary}, {"a", json_of(diff.a, name_a)}, {"b", json_of(diff.b, name_b)}};
    out["changes"] = Json::array();
    for (const Change& change : diff.changes) out["changes"].push_back(json_of(change));
    out["unchanged_sections"] = diff.unchanged_sections;
    return out.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace rro
