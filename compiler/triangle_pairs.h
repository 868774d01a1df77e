// Which triangle of one version of an object is which of the other.
#pragma once

#include <cstdint>
#include <vector>

#include "format/object_data.h"

namespace rro {

/// Indices (not source numbers) of a triangle in either version.
struct TrianglePair {
    std::uint32_t a, b;
};

/// Every triangle of both versions is in exactly one list; lists run by source number (of `a`, but for `added`).
/// Corners are the same if they are equal as doubles, whichever comes first.
struct TrianglePairs {
    std::vector<TrianglePair> kept;        // same number, same corners
    std::vector<TrianglePair> turned;      // same number, same corners the other way round
    std::vector<TrianglePair> renumbered;  // same corners, other number
    std::vector<TrianglePair> moved;       // same number, other corners
    std::vector<std::uint32_t> removed;    // in a only
    std::vector<std::uint32_t> added;      // in b only

    /// All pairs.
    std::vector<TrianglePair> all() const;
};

/// O(n log n). A number that occurs twice in a version is paired in the order of storage.
TrianglePairs pair_triangles(const ObjectData& a, const ObjectData& b);

/// How far the corners of two triangles are apart, of the assignments that keep the winding under the best one.
struct CornerShift {
    double distance = 0;  // of the corner that moved the most
    Vec3 from, to;
};
CornerShift corner_shift(const TriangleCorners& a, const TriangleCorners& b);

}  // namespace rro
