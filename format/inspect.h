// What people want to know of an archive, for `rro-compile inspect`.
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "format/archive_reader.h"

namespace rro {

/// One fact, ready for a line of text or a member of a JSON object.
struct Fact {
    std::string name;
    std::variant<std::string, bool, std::uint64_t, double> value;
};

/// Facts of one kind: `source`, `settings`, `object`, `counts`.
struct FactGroup {
    std::string name;
    std::vector<Fact> facts;
};

/// All but the sections, which Archive::sections() lists. Lengths in metres, areas in m^2.
std::vector<FactGroup> archive_facts(const Archive& archive);

/// The facts, materials and sections as text of several lines.
///
/// name     of the file, as the user gave it
std::string inspect_text(const Archive& archive, const std::string& name);

/// The triangles as CSV (RFC 4180, line ends LF), in the order of their source numbers:
/// triangle,material,ax,ay,az,bx,by,bz,cx,cy,cz. `triangle` is the number in the source, `material` a name, corners are in
/// the archive's frame, metres, with as many digits as bring the stored number back.
std::string triangles_csv(const Archive& archive);

}  // namespace rro
