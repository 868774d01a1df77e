// Mean transmittance of a shaft through one object without rays: the archive's silhouettes under the shaft's
// cross-section.
#pragma once

#include <cstdint>
#include <vector>

#include "format/direction_grid.h"
#include "format/object_data.h"
#include "solver/visibility/shaft.h"

namespace rro {

/// What an object does to a shaft.
struct Cover {
    enum class Kind : std::uint8_t {
        Unknown,  // the shaft is too narrow for the stored images, or an end reaches into the object's sphere
        Clear,    // nothing of the silhouette is near it
        Dark,     // the silhouette covers all of it and more
        Partial,
    };
    Kind kind = Kind::Unknown;
    double share = 0;  // of the shaft that is covered
    double error = 0;  // of it, root mean square
};

/// The silhouettes of one archive as summed-area tables. Safe to share between threads.
class SilhouetteSums {
  public:
    explicit SilhouetteSums(const ObjectData& object);

    /// shaft   in the archive's frame
    Cover cover(const LocalShaft& shaft) const;

  private:
    struct Frame {
        Vec3 right, up, line;
    };
    /// A rectangle in units of pixels of one line's image.
    struct Footprint {
        double left = 0, right = 0, bottom = 0, top = 0;
    };
    double sum_below(std::uint32_t line, double column, double row) const;
    double covered_share(std::uint32_t line, const Footprint& f) const;
    double blended_share(const CrossSection& section, const LocalShaft& shaft) const;
    bool passes_by(const LocalShaft& shaft, const CrossSection& section) const;
    Cover::Kind proof(const LocalShaft& shaft, std::uint32_t line) const;

    DirectionGrid grid_;
    std::uint32_t size_;              // pixels along each side
    Vec3 centre_;                     // archive frame
    double radius_;                   // m
    std::vector<Frame> frames_;       // [lines]
    std::vector<std::uint32_t> sums_; // [lines * (size + 1)^2] of coverage below and left of each pixel corner
};

}  // namespace rro
