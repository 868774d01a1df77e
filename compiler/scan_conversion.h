// Which samples of an image triangles cover: row by row, without a ray.
//
// An image has rows x columns samples; sample (column, row) lies at (column + sample_shift(row), row + 1/2). A sample on
// a triangle's left border is inside, on the right one outside, so triangles that share an edge cover each sample once.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "format/object_data.h"

namespace rro {

inline constexpr double kSampleHeight = 0.5;  // of a sample within its row

/// In [0, 1). It differs from row to row (golden ratio), so that edges parallel to the columns do not alias.
inline double sample_shift(std::uint32_t row) {
    constexpr double kGoldenShare = 0.6180339887498949;
    const double x = row * kGoldenShare;
    return x - std::floor(x);
}

/// A place in an image: x in columns, y in rows.
struct ImagePoint {
    double x, y;
};

/// Of three, without a branch, unlike std::minmax.
template <class T>
T least(T a, T b, T c) {
    return std::min(std::min(a, b), c);
}
template <class T>
T greatest(T a, T b, T c) {
    return std::max(std::max(a, b), c);
}

/// The first sample row that does not lie below y.
inline double first_row(double y) { return std::ceil(y - kSampleHeight); }

/// Calls emit(row, begin, end) for each run of samples that lie in the triangle; rows ascend.
template <class Emit>
void for_each_span(const std::array<ImagePoint, 3>& t, std::uint32_t columns, std::uint32_t rows, const Emit& emit) {
    ImagePoint low = t[0], middle = t[1], high = t[2];
    if (low.y > middle.y) std::swap(low, middle);
    if (middle.y > high.y) std::swap(middle, high);
    if (low.y > middle.y) std::swap(low, middle);
    // Always from the lower end of an edge, so that both triangles at it compute the same crossings. No row meets a level edge.
    const auto slope = [](const ImagePoint& a, const ImagePoint& b) { return b.y > a.y ? (b.x - a.x) / (b.y - a.y) : 0.0; };
    const double to_high = slope(low, high), to_middle = slope(low, middle), from_middle = slope(middle, high);
    const double last = std::min(first_row(high.y), static_cast<double>(rows));
    for (double row = std::max(0.0, first_row(low.y)); row < last; ++row) {
        const double y = row + kSampleHeight;
        const double one = low.x + (y - low.y) * to_high;
        const double other = y < middle.y ? low.x + (y - low.y) * to_middle : middle.x + (y - middle.y) * from_middle;
        const auto number = static_cast<std::uint32_t>(row);
        const double shift = sample_shift(number);
        const double begin = std::max(0.0, std::ceil(std::min(one, other) - shift));
        const double end = std::min(static_cast<double>(columns), std::ceil(std::max(one, other) - shift));
        if (end > begin) emit(number, static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(end));
    }
}

/// Takes positions to places in an image.
struct ImageFrame {
    Vec3 right, up;    // orthonormal
    Vec3 corner;       // the image's, relative to the object's origin
    double pixel_width = 0, pixel_height = 0;  // m, > 0

    ImagePoint place(const Vec3& p) const {
        const Vec3 from_corner = p - corner;
        return {dot(from_corner, right) / pixel_width, dot(from_corner, up) / pixel_height};
    }
};

/// Vertices in an image, with the first sample row at or above each.
struct PlacedVertices {
    std::vector<ImagePoint> at;     // [V]
    std::vector<std::int32_t> row;  // [V] 0 to rows
};
PlacedVertices place(std::span<const Vec3f> positions, const ImageFrame& frame, std::uint32_t rows);

/// The triangles that lie across some sample row, ascending; others cover no sample.
std::vector<std::uint32_t> across_rows(std::span<const TriangleIndices> triangles, std::span<const std::int32_t> row);

/// Samples of an image, one bit each.
class CoverageMask {
  public:
    CoverageMask(std::uint32_t columns, std::uint32_t rows)
        : columns_(columns), rows_(rows), words_((columns + 63) / 64), bits_(std::size_t{words_} * rows + 1) {}

    std::uint32_t columns() const { return columns_; }
    std::uint32_t rows() const { return rows_; }

    /// Samples [begin, end) of a row, begin < end <= columns().
    void cover(std::uint32_t row, std::uint32_t begin, std::uint32_t end);
    std::uint32_t count(std::uint32_t row, std::uint32_t begin, std::uint32_t end) const;

    /// Which of so many samples (0 to kMostMissing) from `begin` on are not covered, one bit each.
    static constexpr std::uint32_t kMostMissing = 56;
    std::uint64_t missing(std::uint32_t row, std::uint32_t begin, std::uint32_t samples) const {
        const std::uint64_t wanted = (std::uint64_t{1} << samples) - 1;
        std::uint64_t bits;  // from the byte of `begin` on; numbers are little-endian, as in archives
        std::memcpy(&bits, reinterpret_cast<const std::byte*>(bits_.data() + std::size_t{row} * words_) + begin / 8,
                    sizeof bits);
        return wanted & ~(bits >> begin % 8);
    }

  private:
    std::uint32_t columns_, rows_;
    std::uint32_t words_;              // of a row
    std::vector<std::uint64_t> bits_;  // [rows * words], and one more to read over
};

/// The samples that an object covers: its silhouette. Both sides of a triangle block.
CoverageMask silhouette(std::span<const Vec3f> positions, std::span<const TriangleIndices> triangles,
                        const ImageFrame& frame, std::uint32_t columns, std::uint32_t rows);

}  // namespace rro
