#include "solver/edit/manifest_edit.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "format/archive_reader.h"
#include "format/atomic_file.h"
#include "format/tool/json_document.h"
#include "format/tool/names.h"
#include "solver/edit/json_text.h"
#include "solver/scene/file_bytes.h"
#include "solver/scene/manifest.h"

namespace rro {
namespace {

constexpr std::uint64_t kLargestManifest = std::uint64_t{1} << 30;  // bytes; a million instances have a fifth of it

std::string text_value(std::string_view text, const JsonSpan& string) {
    return nlohmann::json::parse(string.of(text)).get<std::string>();
}

std::vector<std::string> instance_names(std::string_view text, const JsonSpan& instances) {
    std::vector<std::string> names;
    for (const JsonSpan& instance : instances.values) names.push_back(text_value(text, *instance.find("name")));
    return names;
}

/// The spans of one instance, in a text that has been looked through.
struct Found {
    JsonSpan instance;
    std::size_t index;
};

Result<Found> find_spans(const ManifestText& manifest, std::string_view name) {
    const JsonSpan document = json_spans(manifest.text);
    const JsonSpan& instances = *document.find("instances");
    const std::vector<std::string> names = instance_names(manifest.text, instances);
    const auto at = std::find(names.begin(), names.end(), name);
    if (at == names.end()) {
        const std::string nearest = nearest_hint(name, names);
        constexpr std::size_t most = 20;  // a longer list is no help
        const std::string expected = names.empty() ? "it has none"
                                     : names.size() > most ? "it has " + std::to_string(names.size()) + " others"
                                                           : "expected one of: " + listed(names);
        return bad_input(json_place(manifest.path.string(), "/instances"),
                         "no instance has the name " + described(std::string(name)) + "; " + expected, nearest);
    }
    const auto index = static_cast<std::size_t>(at - names.begin());
    return Found{instances.values[index], index};
}

/// Members as an object: on one line, or laid out as `model` is in `text`.
std::string object_json(const std::vector<std::string>& members, std::string_view text, const JsonSpan* model,
                        const std::string& closing_line) {
    const std::string line = model ? line_start(text, *model) : "";
    std::string out = "{";
    for (const std::string& member : members) {
        out += (out.size() > 1 ? "," : "") + (line.empty() ? std::string(" ") : line) + member;
    }
    return out + (line.empty() || closing_line.empty() ? " " : closing_line) + "}";
}

std::vector<std::string> transform_members(const TransformChange& change) {
    std::vector<std::string> members;
    if (!change.matrix.empty()) members.push_back("\"matrix\": " + json_numbers(change.matrix));
    if (!change.translate.empty()) members.push_back("\"translate\": " + json_numbers(change.translate));
    if (const auto& r = change.rotate; !r.empty())
        members.push_back("\"rotate\": { \"axis\": " + json_numbers({r[0], r[1], r[2]}) +
                          ", \"degrees\": " + json_number(r[3]) + " }");
    if (const auto& s = change.scale; !s.empty())
        members.push_back("\"scale\": " + (s.size() == 1 ? json_number(s[0]) : json_numbers(s)));
    return members;
}

/// The path that leads from a folder to a file; links in folders are followed, as the system does with "..".
Result<std::string> relative_path(const std::filesystem::path& file, const std::filesystem::path& folder) {
    std::error_code code;
    const auto from = std::filesystem::weakly_canonical(std::filesystem::absolute(folder), code);
    const auto parent = std::filesystem::weakly_canonical(std::filesystem::absolute(file).parent_path(), code);
    const std::string path = (parent / file.filename()).lexically_relative(from).generic_string();
    if (!is_utf8(path)) return bad_input(file.string(), "the path is not UTF-8, a manifest cannot hold it");
    return path;
}

void add_path_changes(std::string_view text, const JsonSpan* path, std::vector<JsonSpan>& paths) {
    if (path && std::filesystem::path(text_value(text, *path)).is_relative()) paths.push_back(*path);
}

}  // namespace

Result<std::size_t> find_instance(const ManifestText& manifest, std::string_view name) {
    const auto found = find_spans(manifest, name);
    if (!found) return found.error();
    return found->index;
}

std::string transform_json(const TransformChange& change) {
    return change.empty() ? "" : object_json(transform_members(change), "", nullptr, "");
}

Result<std::string> with_instance(const ManifestText& manifest, const NewInstance& instance) {
    const std::string& text = manifest.text;
    const JsonSpan document = json_spans(text);
    const JsonSpan& instances = *document.find("instances");
    const std::vector<std::string> names = instance_names(text, instances);
    if (!is_utf8(instance.name)) return bad_input(manifest.path.string(), "the name is not UTF-8");
    if (const auto taken = std::find(names.begin(), names.end(), instance.name); taken != names.end())
        return bad_input(json_place(manifest.path.string(), "/instances/" + std::to_string(taken - names.begin()) + "/name"),
                         "the name " + described(instance.name) + " is taken, expected another",
                         "move it, or delete it first");
    std::vector<std::string> members{"\"name\": " + json_string(instance.name), "\"archive\": " + instance.archive};
    if (!instance.transform.empty()) members.push_back("\"transform\": " + instance.transform);
    if (!instance.materials.empty()) members.push_back("\"materials\": " + instance.materials);
    const JsonSpan* last = instances.values.empty() ? nullptr : &instances.values.back();
    return with_value(text, instances, object_json(members, text, last, line_start(text, instances)));
}

Result<std::string> without_instance(const ManifestText& manifest, std::string_view name) {
    const auto found = find_spans(manifest, name);
    if (!found) return found.error();
    const JsonSpan document = json_spans(manifest.text);
    return without_value(manifest.text, *document.find("instances"), found->index);
}

Result<std::string> with_transform(const ManifestText& manifest, std::string_view name, std::string_view transform) {
    const auto found = find_spans(manifest, name);
    if (!found) return found.error();
    return with_member(manifest.text, found->instance, "transform", transform);
}

Result<std::string> with_transform_parts(const ManifestText& manifest, std::string_view name,
                                         const TransformChange& change) {
    const auto found = find_spans(manifest, name);
    if (!found) return found.error();
    const JsonSpan* transform = found->instance.find("transform");
    if (!transform || transform->values.empty() || !change.matrix.empty()) {
        std::vector<std::string> members = transform_members(change);
        if (const JsonSpan* extras = transform ? transform->find("extras") : nullptr)
            members.push_back("\"extras\": " + std::string(extras->of(manifest.text)));
        return with_member(manifest.text, found->instance, "transform", object_json(members, "", nullptr, ""));
    }
    if (transform->find("matrix"))
        return bad_input(json_place(manifest.path.string(),
                                    "/instances/" + std::to_string(found->index) + "/transform/matrix"),
                         "the instance is placed by a matrix, which has no parts to replace", "move it with --matrix");
    ManifestText edited = manifest;
    for (const std::string& member : transform_members(change)) {
        const JsonSpan read = json_spans("{" + member + "}");
        const auto now = find_spans(edited, name);
        edited.text = with_member(edited.text, *now->instance.find("transform"), read.keys[0],
                                  read.values[0].of("{" + member + "}"));
    }
    return std::move(edited.text);
}

Result<std::string> with_material_field(const ManifestText& manifest, std::string_view name, std::string_view material,
                                        std::string_view field, std::string_view value) {
    const auto found = find_spans(manifest, name);
    if (!found) return found.error();
    const std::string fields = "{ " + json_string(field) + ": " + std::string(value) + " }";
    const JsonSpan* materials = found->instance.find("materials");
    if (!materials)
        return with_member(manifest.text, found->instance, "materials", "{ " + json_string(material) + ": " + fields + " }");
    const JsonSpan* own = materials->find(material);
    return own ? with_member(manifest.text, *own, field, value)
               : with_member(manifest.text, *materials, material, fields);
}

std::string moved_to_folder(const ManifestText& manifest, const std::filesystem::path& folder) {
    const JsonSpan document = json_spans(manifest.text);
    std::vector<JsonSpan> paths;
    for (const JsonSpan& instance : document.find("instances")->values) {
        const JsonSpan* archive = instance.find("archive");
        add_path_changes(manifest.text, archive->keys.empty() ? archive : archive->find("path"), paths);
    }
    if (const JsonSpan* sky = document.find("sky")) add_path_changes(manifest.text, sky->find("image"), paths);
    if (const JsonSpan* lights = document.find("lights"))
        for (const JsonSpan& light : lights->values) add_path_changes(manifest.text, light.find("file"), paths);
    // From the end, so that the places before stay true.
    std::sort(paths.begin(), paths.end(), [](const auto& a, const auto& b) { return a.begin > b.begin; });
    std::string text = manifest.text;
    const std::filesystem::path here = manifest.path.parent_path();
    for (const JsonSpan& path : paths) {
        const auto moved = relative_path(here / text_value(manifest.text, path), folder.empty() ? "." : folder);
        if (moved) text = replaced(text, path, json_string(*moved));
    }
    return text;
}

Status edit_manifest_file(const std::filesystem::path& path,
                          const std::function<Result<std::string>(const ManifestText&)>& edit) {
    auto text = read_bytes(path, kLargestManifest);
    if (!text) return text.error();
    if (auto before = parse_manifest(*text, path); !before) return before.error();
    const auto edited = edit({path, std::move(*text)});
    if (!edited) return edited.error();
    if (auto after = parse_manifest(*edited, path); !after) return after.error();
    return write_file_atomically(path, *edited);
}

Status place_in_file(const std::filesystem::path& manifest, const std::string& name,
                     const std::filesystem::path& archive, const TransformChange& transform) {
    return edit_manifest_file(manifest, [&](const ManifestText& text) -> Result<std::string> {
        const auto parent = manifest.parent_path();
        const auto path = relative_path(archive, parent.empty() ? "." : parent);
        if (!path) return path.error();
        auto edited = with_instance(text, {name, json_string(*path), transform_json(transform), ""});
        if (!edited) return edited.error();
        if (auto opened = Archive::open(archive); !opened) return opened.error();
        return edited;
    });
}

Status move_in_file(const std::filesystem::path& manifest, const std::string& name, const TransformChange& transform) {
    return edit_manifest_file(manifest,
                              [&](const ManifestText& text) { return with_transform_parts(text, name, transform); });
}

Status delete_in_file(const std::filesystem::path& manifest, const std::string& name) {
    return edit_manifest_file(manifest, [&](const ManifestText& text) { return without_instance(text, name); });
}

}  // namespace rro
