// What changed between two versions of a compiled object, for people and for scripts.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "format/archive_reader.h"

namespace rro {

/// Numbers as closed ranges [first, last], ascending.
using NumberRanges = std::vector<std::array<std::uint32_t, 2>>;

/// One side of a change, or a figure about it; monostate where there is none.
using DiffValue = std::variant<std::monostate, bool, std::uint64_t, double, std::string, Vec3, NumberRanges>;

/// One thing that differs: as values and as a line for people.
struct Change {
    std::string group;  // provenance, geometry, materials, structure, tables, sections, file
    std::string kind;   // what scripts test; schemas/diff.schema.json lists them
    std::string what;   // which one: an option, a material, a section; else the kind in words
    DiffValue before, after;
    std::vector<std::pair<std::string, DiffValue>> more;  // further figures, by name
    std::string text;
};

/// An archive as a whole.
struct ArchiveIdentity {
    std::uint64_t bytes = 0;
    std::string version;  // of the format
    std::string content;  // SHA-256 of the file
};

/// All that differs.
struct ArchiveDiff {
    bool same = false;    // both have the same sections, and each holds the same payload after decompression
    std::string summary;  // why they differ, in a few words
    ArchiveIdentity a, b;
    std::vector<Change> changes;  // by group, in the order above; where `same`, how the files differ all the same
    std::vector<std::string> unchanged_sections;
};

/// From `a` to `b`. Triangles are told apart by their number in the source, and those with another number by their
/// corners. O(n log n) in the triangles; areas in m^2, lengths in metres, "relative" is (after - before) / before.
ArchiveDiff diff_archives(const Archive& a, const Archive& b);

/// For a terminal; ends with the sections that did not change.
std::string diff_text(const ArchiveDiff& diff, const std::string& name_a, const std::string& name_b);

/// One JSON object (schemas/diff.schema.json), with every digit.
std::string diff_json(const ArchiveDiff& diff, const std::string& name_a, const std::string& name_b);

}  // namespace rro
