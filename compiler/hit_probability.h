// The chance that a line which meets a bounding volume hits the object, per volume and direction (paper, section 5).
#pragma once

#include <cstdint>
#include <vector>

#include "compiler/table_choice.h"
#include "format/object_data.h"

namespace rro {

/// As ObjectData stores it: K volumes, H lines of the grid.
struct HitProbabilities {
    std::vector<std::uint32_t> volumes;          // [K] ascending; with a volume all above it
    std::vector<std::uint8_t> whole, intrinsic;  // [K * H]; intrinsic is empty unless every node was asked for
};

/// Of the lines along a direction that meet the volume's box, the share that hits the object, anywhere before, in or
/// behind the box; `intrinsic`: the share that hits one of the volume's own triangles.
///
/// Counted at samples of twice meta.image_resolution along each side of the image that the outermost box fills, by scan
/// conversion. A box of few samples leans on the volume above it, by the weight of one sample. Where all boxes are seen
/// edge-on, the direction is turned a little: a flat object's share is the same from everywhere else. Rounded to 32
/// steps (by at most 0.016), which leaves 0 and 1 and halves the archive's bytes.
///
/// object   with mesh, volumes and grid filled in
/// tables   every_node: all volumes and both kinds; else the 1024 largest by surface area, without the intrinsic kind
/// source   paper section 5, figure 9
HitProbabilities measure_hits(const ObjectData& object, const TableChoice& tables);

}  // namespace rro
