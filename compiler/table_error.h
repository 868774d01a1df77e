// How far the tables are off between their nodes: the error bars that an archive carries.
#pragma once

#include <cstdint>
#include <vector>

#include "format/object_data.h"

namespace rro {

/// As ObjectData stores them, for the K clusters with areas.
struct TableErrors {
    std::uint32_t directions = 0;
    std::vector<float> whole, intrinsic, visibility;  // [K], relative
};

/// Measures the object anew along directions between the nodes and compares with what its tables, as they are stored,
/// interpolate to there. Root mean square of the difference over that of the measured value; the noise of the measuring
/// images, known from their counts, is taken out of it.
///
/// object   with its tables filled in
TableErrors measure_table_errors(const ObjectData& object);

}  // namespace rro
