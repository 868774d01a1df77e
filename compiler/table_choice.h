// Which tables an archive gets: `--tables`.
#pragma once

#include <string>

#include "format/result.h"

namespace rro {

/// Nothing is computed that is not asked for.
struct TableChoice {
    bool area = true;        // effective areas, whole-object and intrinsic
    bool visibility = true;  // of patches
    bool errors = true;      // measured errors of the areas and the visibility; needs both
    bool hit = true;         // hit probabilities
    bool atlas = true;       // silhouettes
    bool selflinks = true;
    bool every_node = false;  // areas of all clusters and hit probabilities of all volumes, these also intrinsic;
                              // else of the largest thousand

    bool operator==(const TableChoice&) const = default;
};

/// "default" (what a solver asks most), "all" (the same for every node), or names with commas between them: area,
/// visibility, errors, hit, atlas, selflinks.
///
/// errors   Usage: an unknown name, none at all, or errors without area and visibility
Result<TableChoice> parse_tables(const std::string& text);

/// The text of a choice, one for each; parse_tables reads it.
std::string tables_text(const TableChoice& tables);

}  // namespace rro
