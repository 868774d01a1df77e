#include "compiler/archive_diff.h"

#include <algorithm>
#include <map>
#include <set>

#include "compiler/archive_diff_parts.h"
#include "compiler/archive_facts.h"
#include "compiler/diff_words.h"

namespace rro {
namespace {

constexpr std::size_t kHexShown = 12;                   // enough to find a commit or an archive by
constexpr const char* kTableVersion = "table_version";  // an option that the compiler sets, not its user

/// The options' text, "key=value key=value ...", by key.
std::map<std::string, std::string> options_of(const std::string& text) {
    std::map<std::string, std::string> options;
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t end = std::min(text.find(' ', at), text.size());
        const std::string word = text.substr(at, end - at);
        const std::size_t sign = std::min(word.find('='), word.size());
        if (!word.empty()) options[word.substr(0, sign)] = word.substr(std::min(sign + 1, word.size()));
        at = end + 1;
    }
    return options;
}

void compare_text(const std::string& kind, const std::string& what, const std::string& before, const std::string& after,
                  Changes& out) {
    if (before == after) return;
    out.push_back({"provenance", kind, what, before, after, {}, what + ": " + before + " -> " + after});
}

void compare_options(const std::string& before, const std::string& after, Changes& out) {
    const auto a = options_of(before), b = options_of(after);
    const std::string kAbsent = "(absent)";
    std::set<std::string> keys;
    for (const auto* options : {&a, &b})
        for (const auto& option : *options) keys.insert(option.first);
    for (const std::string& key : keys) {
        const auto in_a = a.find(key), in_b = b.find(key);
        const bool was = in_a != a.end(), is = in_b != b.end();
        if (was && is && in_a->second == in_b->second) continue;
        Change& change = out.emplace_back(Change{"provenance", "option", key, {}, {}, {}, ""});
        if (was) change.before = in_a->second;
        if (is) change.after = in_b->second;
        change.text = "option " + key + ": " + (was ? in_a->second : kAbsent) + " -> " + (is ? in_b->second : kAbsent);
    }
}

void compare_provenance(const Archive& a, const Archive& b, Changes& out) {
    const ObjectMeta &ma = a.data().meta, &mb = b.data().meta;
    compare_text("tool_version", "compiler", ma.tool_version, mb.tool_version, out);
    compare_text("format_version", "format", format_version(a), format_version(b), out);
    compare_text("source_name", "source", ma.source_name, mb.source_name, out);
    if (ma.source_sha256 != mb.source_sha256)
        out.push_back({"provenance",
                       "source_sha256",
                       "SHA-256 of the source and the files it names",
                       ma.source_sha256,
                       mb.source_sha256,
                       {},
                       "content of the source and the files it names: SHA-256 " +
                           ma.source_sha256.substr(0, kHexShown) + "... -> " + mb.source_sha256.substr(0, kHexShown) +
                           "..."});
    compare_options(ma.options, mb.options, out);
}

SectionInfo* find(std::vector<SectionInfo>& sections, const std::string& name) {
    const auto found = std::find_if(sections.begin(), sections.end(), [&](const auto& s) { return s.name == name; });
    return found == sections.end() ? nullptr : &*found;
}

/// Whether a section holds the same payload in both. One that this version cannot unpack, being unknown to it, is
/// judged by the checksum of what is stored.
bool same_payload(const Archive& a, const Archive& b, const SectionInfo& in_a, const SectionInfo& in_b) {
    if (in_a.raw_bytes != in_b.raw_bytes) return false;
    const auto raw_a = a.section(in_a.name), raw_b = b.section(in_b.name);
    if (raw_a && raw_b) return *raw_a == *raw_b;
    return in_a.codec == in_b.codec && in_a.stored_bytes == in_b.stored_bytes && in_a.crc32 == in_b.crc32;
}

std::string size_text(const SectionInfo& s) {
    return std::to_string(s.stored_bytes) + " bytes" +
           (s.codec == "raw" ? "" : ", " + s.codec + " of " + std::to_string(s.raw_bytes));
}

std::string size_text(const SectionInfo& before, const SectionInfo& after) {
    const std::string percent =
        in_percent(static_cast<double>(before.stored_bytes), static_cast<double>(after.stored_bytes));
    if (before.codec != after.codec) return size_text(before) + " -> " + size_text(after) + percent;
    if (size_text(before) == size_text(after)) return "other content, " + size_text(before) + " as before";
    return from_to(before.stored_bytes, after.stored_bytes) + " bytes" + percent +
           (before.codec == "raw"
                ? ""
                : ", " + before.codec + " of " +
                      (before.raw_bytes == after.raw_bytes ? std::to_string(before.raw_bytes)
                                                           : from_to(before.raw_bytes, after.raw_bytes)));
}

Change section_change(const std::string& kind, const SectionInfo& before, const SectionInfo& after) {
    return {"sections",
            kind,
            before.name,
            before.stored_bytes,
            after.stored_bytes,
            {{"codec_before", before.codec},
             {"codec_after", after.codec},
             {"raw_before", before.raw_bytes},
             {"raw_after", after.raw_bytes}},
            before.name + ": " + size_text(before, after) + (kind == "codec" ? "; the same when unpacked" : "")};
}

Change lone_section(const std::string& kind, const SectionInfo& section, bool added) {
    Change change{"sections",
                  kind,
                  section.name,
                  {},
                  {},
                  {{"codec", section.codec}, {"raw", section.raw_bytes}},
                  section.name + (added ? " added: " : " removed: ") + size_text(section)};
    (added ? change.after : change.before) = section.stored_bytes;
    return change;
}

/// Fills `unchanged_sections` too.
Changes compare_sections(const Archive& a, const Archive& b, ArchiveDiff& diff) {
    Changes out;
    std::vector<SectionInfo> rest = b.sections();
    for (const SectionInfo& before : a.sections()) {
        const SectionInfo* after = find(rest, before.name);
        if (!after) {
            out.push_back(lone_section("section_removed", before, false));
            continue;
        }
        const bool same = same_payload(a, b, before, *after);
        if (same) diff.unchanged_sections.push_back(before.name);
        if (!same)
            out.push_back(section_change("section_changed", before, *after));
        else if (before.codec != after->codec || before.stored_bytes != after->stored_bytes)
            out.push_back(section_change("codec", before, *after));
        rest.erase(rest.begin() + (after - rest.data()));
    }
    for (const SectionInfo& after : rest) out.push_back(lone_section("section_added", after, true));
    return out;
}

void compare_files(const ArchiveIdentity& a, const ArchiveIdentity& b, Changes& out) {
    if (a.bytes == b.bytes) return;
    const auto before = static_cast<double>(a.bytes), after = static_cast<double>(b.bytes);
    out.push_back({"file",
                   "file_bytes",
                   "file",
                   a.bytes,
                   b.bytes,
                   {{"relative", relative_change(before, after)}},
                   from_to(a.bytes, b.bytes) + " bytes" + in_percent(before, after)});
}

std::string summary_of_same(const ArchiveDiff& diff, const std::set<std::string>& kinds) {
    if (diff.a.content == diff.b.content) return "the same, byte for byte";
    std::string where = kinds.contains("format_version") ? "format version" : "";
    if (kinds.contains("codec")) where += (where.empty() ? "" : " and ") + std::string("compression");
    return "same content; the files differ in " + (where.empty() ? "the layout of their sections" : where);
}

std::string summary_of(const ArchiveDiff& diff) {
    std::set<std::string> kinds;
    bool options = false;
    for (const Change& change : diff.changes) {
        kinds.insert(change.kind);
        options = options || (change.kind == "option" && change.what != kTableVersion);
    }
    if (diff.same) return summary_of_same(diff, kinds);
    if (kinds.contains("source_sha256")) return options ? "the source and the options changed" : "the source changed";
    if (options) return "same source, compiled with other options";
    if (kinds.contains("tool_version") || kinds.contains("option"))
        return "same source and options, other compiler version";
    return kinds.contains("source_name") ? "same source under another name, same options and compiler version"
                                         : "same source, options and compiler version";
}

}  // namespace

ArchiveDiff diff_archives(const Archive& a, const Archive& b) {
    ArchiveDiff diff;
    diff.a = {a.file_bytes(), format_version(a), a.content_sha256()};
    diff.b = {b.file_bytes(), format_version(b), b.content_sha256()};
    Changes sections = compare_sections(a, b, diff);
    diff.same =
        diff.unchanged_sections.size() == a.sections().size() && diff.unchanged_sections.size() == b.sections().size();
    compare_provenance(a, b, diff.changes);
    if (!diff.same) {
        const ObjectData &da = a.data(), &db = b.data();
        const TrianglePairs triangles = pair_triangles(da, db);
        const bool mesh_differs = std::find(diff.unchanged_sections.begin(), diff.unchanged_sections.end(), "mesh") ==
                                  diff.unchanged_sections.end();
        compare_geometry(da, db, triangles, mesh_differs, diff.changes);
        compare_materials(da, db, triangles, diff.changes);
        const TreeMatch trees = match_trees(da, db, triangles);
        compare_textures(da, db, trees, diff.changes);
        compare_structure(da, db, trees, diff.changes);
        compare_tables(a, b, trees, diff.changes);
        compare_hits(a, b, diff.changes);
        compare_atlases(da, db, diff.changes);
        compare_self_links(da, db, diff.changes);
    }
    std::move(sections.begin(), sections.end(), std::back_inserter(diff.changes));
    compare_files(diff.a, diff.b, diff.changes);
    diff.summary = summary_of(diff);
    return diff;
}

}  // namespace rro
