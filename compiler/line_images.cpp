#include "compiler/line_images.h"

#include <limits>

namespace rro {
namespace {

/// What one viewer sees on each line.
class FirstFaces {
  public:
    explicit FirstFaces(const DirectionImage& image)
        : first_(std::size_t{image.resolution} * image.resolution), same_(static_cast<float>(same_height(image))) {}

    /// A triangle that turns a face to the viewer, or a black side (kBlackSide). The greatest height is seen; of two at one
    /// height a face before a black side, then what came first.
    void offer(std::size_t sample, std::uint32_t face, float height) {
        First& first = first_[sample];
        const bool higher = height > first.height + same_;
        const bool beside = height > first.height - same_ && face != kBlackSide && first.face == kBlackSide;
        if (higher || beside) first = {height, face};
    }

    void count(std::span<std::uint32_t> seen) const {
        for (const First& first : first_)
            if (first.face != kBlackSide) ++seen[first.face];
    }

  private:
    struct First {
        float height = -std::numeric_limits<float>::infinity();
        std::uint32_t face = kBlackSide;
    };
    std::vector<First> first_;
    float same_;
};

}  // namespace

double same_height(const DirectionImage& image) {
    constexpr double kShare = 1e-6;  // of the object's size; ten times what single precision tells apart
    return kShare * std::max(image.depth, image.resolution * std::max(image.pixel_width, image.pixel_height));
}

RunFaces faces_of(const TriangleRun& run, std::span<const std::uint32_t> face_by_side) {
    const std::uint32_t front = face_by_side[Face::make(run.triangle, Side::Front).packed];
    const std::uint32_t back = face_by_side[Face::make(run.triangle, Side::Back).packed];
    return run.front ? RunFaces{front, back} : RunFaces{back, front};
}

void add_covered(const TriangleRun& run, const RunFaces& faces, LineCounts& counts) {
    if (faces.toward != kBlackSide) counts.toward[faces.toward] += run.end - run.begin;
    if (faces.opposite != kBlackSide) counts.opposite[faces.opposite] += run.end - run.begin;
}

SeenAndCovered count_samples(const ObjectData& object, std::span<const std::uint32_t> face_by_side,
                             const DirectionImage& image) {
    SeenAndCovered counts{LineCounts(object.faces.size()), LineCounts(object.faces.size())};
    if (image.empty()) return counts;
    FirstFaces near(image), far(image);
    for_each_run(object, image, [&](const TriangleRun& run) {
        const RunFaces faces = faces_of(run, face_by_side);
        add_covered(run, faces, counts.covered);
        for (std::uint32_t column = run.begin; column < run.end; ++column) {
            const std::size_t sample = std::size_t{run.row} * image.resolution + column;
            const auto height = static_cast<float>(run.height_at(column));
            near.offer(sample, faces.toward, height);
            far.offer(sample, faces.opposite, -height);
        }
    });
    near.count(counts.seen.toward);
    far.count(counts.seen.opposite);
    return counts;
}

std::vector<std::uint32_t> opposite_directions(std::span<const Vec3> directions) {
    constexpr double kSame = 1e-18;  // squared distance of unit vectors; grids compute theirs to 1e-15
    std::vector<std::uint32_t> result(directions.size(), kNoDirection);
    for (std::uint32_t a = 0; a < directions.size(); ++a)
        for (std::uint32_t b = 0; b < directions.size(); ++b)
            if (length2(directions[a] + directions[b]) < kSame) result[a] = b;
    return result;
}

}  // namespace rro
