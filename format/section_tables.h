// What each section's fields are in memory: ObjectData -> table, and back.
#pragma once

#include "format/object_data.h"
#include "format/section.h"
#include "format/table_builder.h"
#include "format/table_view.h"

namespace rro {

/// The section's table. Refers to the object's arrays until TableBuilder::finish().
TableBuilder section_table(const ObjectData& object, Section section);

/// Whether there is anything to write; required sections are always written.
bool has_content(const ObjectData& object, Section section);

/// Fills in what the section holds: copies what is small, points to the rest. The table's buffer has passed
/// verify_table and must outlive `object`.
void read_section(const TableView& table, Section section, ObjectData& object);

}  // namespace rro
