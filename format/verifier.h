// Untrusted bytes -> Result. Nothing of an archive is used before these have passed, in this order: the container, the
// wire format of each known section, the meaning of what they hold.
//
// Every refusal is BadInput and names file, section and field, what was found and what was expected.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "format/layout.h"
#include "format/object_data.h"
#include "format/result.h"

namespace rro {

/// What the header and the directory say.
struct Container {
    std::uint16_t version_major = 0, version_minor = 0;
    std::vector<layout::SectionEntry> entries;  // in the directory's order; names are unique
};

/// Checks header, directory, bounds, alignment, overlaps, padding and every checksum, so that no byte of the file may
/// differ from what was written.
///
/// name     of the file, for messages
/// errors   BadInput; another major version has a hint
Result<Container> verify_container(std::span<const std::byte> bytes, const std::string& name);

/// A section's name without its padding.
std::string section_name(const layout::SectionEntry& entry);

/// Checks that a buffer is a table of this kind in the FlatBuffers wire format, whatever a TableView asks of it: vtables,
/// offsets, alignment, sizes, ends of strings; and that nothing is referred to twice (a small file must not unfold to a
/// large one).
///
/// where    for messages: file and section
Status verify_table(std::span<const std::byte> buffer, std::span<const layout::FieldSpec> table, const std::string& where);

/// Checks that the parts of an object fit one another: sizes, indices, ranges, trees, finite numbers.
///
/// present  the sections that have been read, with those they need; others are not looked at
/// name     of the file, for messages
Status verify_content(const ObjectData& object, SectionSet present, const std::string& name);

}  // namespace rro
