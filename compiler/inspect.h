// What is in an archive, for people and for scripts.
#pragma once

#include <string>

#include "format/archive_reader.h"

namespace rro {

/// Sections, sizes, counts, settings, source: as text for a terminal.
std::string inspection_text(const Archive& archive, const std::string& name);

/// The same as one JSON object.
std::string inspection_json(const Archive& archive, const std::string& name);

/// `triangle,material,ax,ay,az,bx,by,bz,cx,cy,cz`, in the archive's frame; rows by source number, coordinates as the
/// shortest text that reads back as the same double, fields as RFC 4180.
std::string triangles_csv(const ObjectData& data);

}  // namespace rro
