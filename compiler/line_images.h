// All triangles along the lines of an image, with their heights: what a viewer sees first on each line, and what one on
// the opposite side sees.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "compiler/direction_images.h"
#include "compiler/scan_conversion.h"

namespace rro {

/// Neighbouring samples of a row that a triangle covers.
struct TriangleRun {
    std::uint32_t triangle;
    bool front;  // it turns its front to the image's viewer
    std::uint32_t row, begin, end;
    double height, slope;    // of the first sample along `toward`, in metres, and from sample to sample
    double lowest, highest;  // of the corners: a triangle seen edge-on has no slope worth its name

    double height_at(std::uint32_t column) const {
        // In this order also something where the slope is not finite.
        return std::min(std::max(lowest, height + slope * (column - begin)), highest);
    }
};

/// Calls visit(TriangleRun) for all runs of all triangles, triangle by triangle.
template <class Visit>
void for_each_run(const ObjectData& object, const DirectionImage& image, const Visit& visit) {
    const ImageFrame frame = image.frame();
    const PlacedVertices vertices = place(object.positions, frame, image.resolution);
    for (const std::uint32_t t : across_rows(object.triangles, vertices.row)) {
        const TriangleIndices& corners = object.triangles[t];
        const std::uint32_t a = corners[0], b = corners[1], c = corners[2];
        const std::array at{vertices.at[a], vertices.at[b], vertices.at[c]};
        const ImagePoint ab{at[1].x - at[0].x, at[1].y - at[0].y}, ac{at[2].x - at[0].x, at[2].y - at[0].y};
        const double turn = ab.x * ac.y - ab.y * ac.x;  // positive where the corners run counter-clockwise
        if (turn == 0) continue;
        const auto height_of = [&](std::uint32_t v) { return dot(to_double(object.positions[v]), image.toward); };
        TriangleRun run{t, turn > 0, 0, 0, 0, 0, 0, 0, 0};
        double height_a = 0, along_x = 0, along_y = 0;
        bool known = false;  // most triangles of a fine mesh cover no sample
        for_each_span(at, image.resolution, image.resolution,
                      [&](std::uint32_t row, std::uint32_t begin, std::uint32_t end) {
                          if (!known) {
                              height_a = height_of(a);
                              const double height_b = height_of(b), height_c = height_of(c);
                              const double to_b = height_b - height_a, to_c = height_c - height_a;
                              along_x = (to_b * ac.y - to_c * ab.y) / turn;
                              along_y = (to_c * ab.x - to_b * ac.x) / turn;
                              run.lowest = least(height_a, height_b, height_c);
                              run.highest = greatest(height_a, height_b, height_c);
                              known = true;
                          }
                          run.row = row, run.begin = begin, run.end = end;
                          run.height = height_a + along_x * (begin + sample_shift(row) - at[0].x) +
                                       along_y * (row + kSampleHeight - at[0].y);
                          run.slope = along_x;
                          visit(run);
                      });
    }
}

/// The faces that a run's triangle turns to the image's viewer and to one who looks along the same lines from the other
/// side; kBlackSide for a black side.
struct RunFaces {
    std::uint32_t toward, opposite;
};
RunFaces faces_of(const TriangleRun& run, std::span<const std::uint32_t> face_by_side);

/// Triangles that lie closer along a line are at one height, m: some modellers make a leaf of two, one for each side.
double same_height(const DirectionImage& image);

/// Samples per face for both viewers. [F]
struct LineCounts {
    std::vector<std::uint32_t> toward, opposite;

    explicit LineCounts(std::size_t faces) : toward(faces), opposite(faces) {}
};
void add_covered(const TriangleRun& run, const RunFaces& faces, LineCounts& counts);

/// `seen`: the face is the first thing on the line, seen from its own side; `covered`: it would be if nothing hid
/// anything. seen <= covered.
struct SeenAndCovered {
    LineCounts seen, covered;
};

/// face_by_side   see faces_by_side
SeenAndCovered count_samples(const ObjectData& object, std::span<const std::uint32_t> face_by_side,
                             const DirectionImage& image);

/// The direction opposite to each, or kNoDirection.
inline constexpr std::uint32_t kNoDirection = 0xffffffffu;
std::vector<std::uint32_t> opposite_directions(std::span<const Vec3> directions);

}  // namespace rro
