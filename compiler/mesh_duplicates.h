// Triangles that are in a mesh more than once.
#pragma once

#include <cstdint>

#include "compiler/mesh.h"

namespace rro {

/// Takes out every triangle that lies exactly on an earlier one (equal corners) and looks the same way, or, where both are
/// two-sided, either way: neither would hide the other, and all around would see their light twice. Two one-sided triangles
/// back to back stay: they are the two sides of one sheet. The earlier one's material stands.
///
/// mesh      two_sided may be empty still: then those are taken out that look the same way
/// returns   how many
std::uint32_t drop_duplicates(Mesh& mesh);

}  // namespace rro
