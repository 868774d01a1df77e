#include "compiler/scan_conversion.h"

#include <bit>
#include <cassert>

namespace rro {
namespace {

constexpr std::uint32_t kWordBits = 64;
// Larger triangles are rarely behind what is there; they are drawn.
constexpr std::int32_t kSmallRows = 2;
constexpr double kSmallColumns = CoverageMask::kMostMissing;

/// Calls visit(word, bits) for the words of a row that [begin, end) touches, with its bits of them.
template <class Visit>
void for_each_word(std::uint32_t begin, std::uint32_t end, const Visit& visit) {
    const std::uint32_t first = begin / kWordBits, last = (end - 1) / kWordBits;
    if (first == last) {  // nearly always
        visit(first, (~std::uint64_t{0} >> (kWordBits - (end - begin))) << begin % kWordBits);
        return;
    }
    for (std::uint32_t word = first; word <= last; ++word) {
        std::uint64_t bits = ~std::uint64_t{0};
        if (word == first) bits &= ~std::uint64_t{0} << begin % kWordBits;
        if (word == last) bits &= ~std::uint64_t{0} >> (kWordBits - 1 - (end - 1) % kWordBits);
        visit(word, bits);
    }
}

/// Whether a small triangle within one or two rows and between these x adds nothing: no sample, or samples that are
/// covered. Without a branch, because it is asked of every small triangle and the answer cannot be guessed.
bool adds_nothing(const CoverageMask& mask, std::span<const double> shifts, std::int32_t begin_row,
                  std::int32_t end_row, double left, double right) {
    std::uint64_t missing = 0;
    for (const std::int32_t row : {begin_row, end_row - 1}) {
        const double shift = shifts[static_cast<std::size_t>(row)], columns = mask.columns();
        const double begin = std::clamp(std::ceil(left - shift), 0.0, columns);
        const double end = std::clamp(std::ceil(right - shift), 0.0, columns);
        missing |= mask.missing(static_cast<std::uint32_t>(row), static_cast<std::uint32_t>(begin),
                                static_cast<std::uint32_t>(end - begin));
    }
    return missing == 0;
}

}  // namespace

PlacedVertices place(std::span<const Vec3f> positions, const ImageFrame& frame, std::uint32_t rows) {
    PlacedVertices vertices;
    vertices.at.reserve(positions.size());
    vertices.row.reserve(positions.size());
    const Vec3 along_x = frame.right / frame.pixel_width, along_y = frame.up / frame.pixel_height;
    for (const Vec3f& p : positions) {
        const Vec3 from_corner = to_double(p) - frame.corner;
        const ImagePoint& at = vertices.at.emplace_back(ImagePoint{dot(from_corner, along_x), dot(from_corner, along_y)});
        vertices.row.push_back(static_cast<std::int32_t>(std::clamp(first_row(at.y), 0.0, static_cast<double>(rows))));
    }
    return vertices;
}

// Without a branch per triangle: most triangles of a fine mesh fall between two rows, and which ones cannot be guessed.
std::vector<std::uint32_t> across_rows(std::span<const TriangleIndices> triangles, std::span<const std::int32_t> row) {
    std::vector<std::uint32_t> across(triangles.size() + 1);
    std::size_t count = 0;
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
        const auto& [a, b, c] = triangles[t];
        across[count] = t;
        count += ((row[a] ^ row[b]) | (row[a] ^ row[c])) != 0 ? 1 : 0;
    }
    across.resize(count);
    return across;
}

void CoverageMask::cover(std::uint32_t row, std::uint32_t begin, std::uint32_t end) {
    assert(row < rows_ && begin < end && end <= columns_);
    std::uint64_t* const words = bits_.data() + std::size_t{row} * words_;
    for_each_word(begin, end, [&](std::uint32_t word, std::uint64_t bits) { words[word] |= bits; });
}

std::uint32_t CoverageMask::count(std::uint32_t row, std::uint32_t begin, std::uint32_t end) const {
    assert(row < rows_ && begin < end && end <= columns_);
    const std::uint64_t* const words = bits_.data() + std::size_t{row} * words_;
    int samples = 0;
    for_each_word(begin, end, [&](std::uint32_t word, std::uint64_t bits) { samples += std::popcount(bits & words[word]); });
    return static_cast<std::uint32_t>(samples);
}

CoverageMask silhouette(std::span<const Vec3f> positions, std::span<const TriangleIndices> triangles,
                        const ImageFrame& frame, std::uint32_t columns, std::uint32_t rows) {
    CoverageMask mask(columns, rows);
    const PlacedVertices vertices = place(positions, frame, rows);
    std::vector<double> shifts;
    for (std::uint32_t row = 0; row < rows; ++row) shifts.push_back(sample_shift(row));
    for (const std::uint32_t t : across_rows(triangles, vertices.row)) {
        const auto& [a, b, c] = triangles[t];
        const std::array corners{vertices.at[a], vertices.at[b], vertices.at[c]};
        const double left = least(corners[0].x, corners[1].x, corners[2].x);
        const double right = greatest(corners[0].x, corners[1].x, corners[2].x);
        const std::int32_t begin = least(vertices.row[a], vertices.row[b], vertices.row[c]);
        const std::int32_t end = greatest(vertices.row[a], vertices.row[b], vertices.row[c]);
        const bool small = end - begin <= kSmallRows && right - left < kSmallColumns;
        if (small && adds_nothing(mask, shifts, begin, end, left, right)) continue;
        for_each_span(corners, columns, rows,
                      [&](std::uint32_t row, std::uint32_t from, std::uint32_t to) { mask.cover(row, from, to); });
    }
    return mask;
}

}  // namespace rro
