// Which samples of an image triangles cover: row by row, without a ray.
//
// An image has rows x columns samples; sample (column, row) lies at (column + sample_shift(row), row + 1/2). A sample on
// a triangle's left border is inside, on the right one outside, so triangles that share an edge cover each sample once.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "format/object_data.h"

namespace rro {

inline constexpr double kSampleHeight = 0.5;  // of a sample within its row

/// In [0, 1). It differs from row to row (golden ratio), so that edges parallel to the columns do not alias.
double sample_shift(std::uint32_t row);

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
    const double low = least(t[0].y, t[1].y, t[2].y), high = greatest(t[0].y, t[1].y, t[2].y);
    const double leftmost = least(t[0].x, t[1].x, t[2].x), rightmost = greatest(t[0].x, t[1].x, t[2].x);
    const double last = std::min(first_row(high), static_cast<double>(rows));
    for (double row = std::max(0.0, first_row(low)); row < last; ++row) {
        const auto number = static_cast<std::uint32_t>(row);
        const double shift = sample_shift(number);
        if (std::ceil(leftmost - shift) >= std::ceil(rightmost - shift)) continue;  // spares small triangles the rest
        const double y = row + kSampleHeight;
        double left = std::numeric_limits<double>::infinity(), right = -left;
        for (std::size_t k = 0; k < 3; ++k) {
            ImagePoint a = t[k], b = t[(k + 1) % 3];
            if ((a.y <= y) == (b.y <= y)) continue;
            if (a.y > b.y) std::swap(a, b);  // both triangles at an edge compute the same crossing
            const double x = a.x + (y - a.y) * (b.x - a.x) / (b.y - a.y);
            left = std::min(left, x);
            right = std::max(right, x);
        }
        const double begin = std::max(0.0, std::ceil(left - shift));
        const double end = std::min(static_cast<double>(columns), std::ceil(right - shift));
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
        : columns_(columns), rows_(rows), words_((columns + 63) / 64), bits_(std::size_t{words_} * rows) {}

    std::uint32_t columns() const { return columns_; }
    std::uint32_t rows() const { return rows_; }

    /// Samples [begin, end) of a row, begin < end <= columns().
    void cover(std::uint32_t row, std::uint32_t begin, std::uint32_t end);
    bool covers(std::uint32_t row, std::uint32_t begin, std::uint32_t end) const;
    std::uint32_t count(std::uint32_t row, std::uint32_t begin, std::uint32_t end) const;

  private:
    std::uint32_t columns_, rows_;
    std::uint32_t words_;              // of a row
    std::vector<std::uint64_t> bits_;  // [rows * words]
};

/// The samples that an object covers: its silhouette. Both sides of a triangle block.
CoverageMask silhouette(std::span<const Vec3f> positions, std::span<const TriangleIndices> triangles,
                        const ImageFrame& frame, std::uint32_t columns, std::uint32_t rows);

}  // namespace rro
