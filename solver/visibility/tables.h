// The chance that a line passes an object, from its hierarchy of bounding volumes with hit probabilities (paper, sections
// 3 and 5; feature-based error metric of [SILL 95]).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "format/archive_reader.h"
#include "format/object_data.h"

namespace rro {

/// How tables answer.
struct TableOptions {
    // A volume's probability answers for it where the area that may be missed, its projected area times (1 - hit
    // probability), is at most this share of the shaft's cross-section.
    double tolerance = 0.01;
    // Throw a dice with the probability instead of returning it: lines pass or do not, as rays.
    bool dice = false;
    // Probability that a volume's own triangles are hit, where archives hold it (compile --tables all); else, and with
    // false, that any of the object's are, which is the paper's.
    bool intrinsic = true;
};

/// One archive's volumes and tables. Refers to the archive; safe to share between threads.
class HitTables {
  public:
    /// With the sections hbv and hit (asserted).
    explicit HitTables(const Archive& archive);

    /// The chance that the segment from p to q passes the object: probabilities of the volumes that answer multiply, as
    /// the paper throws one dice after the other. A volume answers only for segments that go all the way through it;
    /// where none does, triangles decide.
    ///
    /// p, q      archive frame
    /// missing   largest area that may be missed, m^2
    /// key       of the dice
    double passes(const Vec3& p, const Vec3& q, double missing, const TableOptions& options, std::uint64_t key) const;

  private:
    /// Both kinds of probability are the same along a line and against it.
    double probability(std::uint32_t row, bool intrinsic, const DirectionTaps& taps) const;
    bool hits_triangle(const Volume& leaf, const Vec3& p, const Vec3& d) const;

    const ObjectData& object_;
    const DirectionGrid& grid_;
    std::vector<std::uint32_t> row_;   // [volumes] into the tables, kNoRow where there is none
    std::vector<std::uint32_t> line_;  // [directions] of the grid's nodes
};

}  // namespace rro
