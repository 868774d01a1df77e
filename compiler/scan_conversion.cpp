#include "compiler/scan_conversion.h"

#include <bit>
#include <cassert>

namespace rro {
namespace {

constexpr double kGoldenShare = 0.6180339887498949;
constexpr std::uint32_t kWordBits = 64;
constexpr std::int32_t kMostRows = 4;  // a larger triangle is rarely behind what is there; it is drawn

/// Calls visit(word, bits) for the words of a row that [begin, end) touches, with its bits of them.
template <class Visit>
void for_each_word(std::uint32_t begin, std::uint32_t end, const Visit& visit) {
    const std::uint32_t first = begin / kWordBits, last = (end - 1) / kWordBits;
    for (std::uint32_t word = first; word <= last; ++word) {
        std::uint64_t bits = ~std::uint64_t{0};
        if (word == first) bits &= ~std::uint64_t{0} << begin % kWordBits;
        if (word == last) bits &= ~std::uint64_t{0} >> (kWordBits - 1 - (end - 1) % kWordBits);
        visit(word, bits);
    }
}

/// Whether a triangle within these rows and between these x adds nothing: no sample, or samples that are covered.
bool adds_nothing(const CoverageMask& mask, std::span<const double> shifts, std::int32_t begin_row,
                  std::int32_t end_row, double left, double right) {
    if (end_row - begin_row > kMostRows) return false;
    for (auto row = static_cast<std::uint32_t>(begin_row); row < static_cast<std::uint32_t>(end_row); ++row) {
        const double begin = std::max(0.0, std::ceil(left - shifts[row]));
        const double end = std::min(static_cast<double>(mask.columns()), std::ceil(right - shifts[row]));
        if (end > begin && !mask.covers(row, static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(end)))
            return false;
    }
    return true;
}

}  // namespace

double sample_shift(std::uint32_t row) {
    const double x = row * kGoldenShare;
    return x - std::floor(x);
}

PlacedVertices place(std::span<const Vec3f> positions, const ImageFrame& frame, std::uint32_t rows) {
    PlacedVertices vertices;
    vertices.at.reserve(positions.size());
    vertices.row.reserve(positions.size());
    for (const Vec3f& p : positions) {
        const ImagePoint& at = vertices.at.emplace_back(frame.place(to_double(p)));
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

bool CoverageMask::covers(std::uint32_t row, std::uint32_t begin, std::uint32_t end) const {
    assert(row < rows_ && begin < end && end <= columns_);
    const std::uint64_t* const words = bits_.data() + std::size_t{row} * words_;
    std::uint64_t missing = 0;
    for_each_word(begin, end, [&](std::uint32_t word, std::uint64_t bits) { missing |= bits & ~words[word]; });
    return missing == 0;
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
        if (adds_nothing(mask, shifts, begin, end, left, right)) continue;
        for_each_span(corners, columns, rows,
                      [&](std::uint32_t row, std::uint32_t from, std::uint32_t to) { mask.cover(row, from, to); });
    }
    return mask;
}

}  // namespace rro
