// What patches and clusters show along given directions, from images of the whole object.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "compiler/visible_share.h"
#include "format/object_data.h"

namespace rro {

/// Half-open range of faces.
struct FaceRange {
    std::uint32_t begin, end;
};
/// The faces of each patch. [P]
std::vector<FaceRange> patch_ranges(const ObjectData& object);
/// The faces of each of these clusters. [K]
std::vector<FaceRange> cluster_ranges(const ObjectData& object, std::span<const std::uint32_t> clusters);

/// Counts of P patches, of K clusters and of the whole object over D directions.
struct SeenCounts {
    SampleCounts patches, clusters, whole;  // [P * D], [K * D], [D]
};

/// From one image of resolution^2 samples per direction, or per two opposite ones.
///
/// directions   [D] unit, from the object to its viewer
/// clusters     [K] their faces
SeenCounts count_seen_areas(const ObjectData& object, std::span<const Vec3> directions,
                            std::span<const FaceRange> clusters, std::uint32_t resolution);

/// Sum of A max(0, n . w) over the faces of each patch. [P * D], m^2
std::vector<double> patch_cosines(const ObjectData& object, std::span<const Vec3> directions);

/// The same for clusters, from the sums of their patches. [K * D], m^2
std::vector<double> cluster_cosines(const ObjectData& object, std::span<const double> of_patches, std::size_t directions,
                                    std::span<const std::uint32_t> clusters);

}  // namespace rro
