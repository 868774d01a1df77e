#include "compiler/hit_probability.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numeric>

#include "compiler/direction_images.h"
#include "compiler/scan_conversion.h"
#include "format/direction_grid.h"
#include "format/parallel.h"

namespace rro {
namespace {

constexpr std::size_t kLargestVolumes = 1024;
constexpr std::uint32_t kNone = 0xffffffffu;

Box3 box_of(const Volume& volume) {
    return {to_double(volume.lo), to_double(volume.hi)};
}

/// The largest by surface area, in preorder. A box holds those below it and comes before them, so with a volume all
/// above it are chosen.
std::vector<std::uint32_t> largest_volumes(std::span<const Volume> volumes, std::size_t count) {
    std::vector<double> area;
    area.reserve(volumes.size());
    for (const Volume& v : volumes) area.push_back(box_of(v).surface_area());
    std::vector<std::uint32_t> chosen(volumes.size());
    std::iota(chosen.begin(), chosen.end(), 0u);
    std::stable_sort(chosen.begin(), chosen.end(), [&](std::uint32_t a, std::uint32_t b) { return area[a] > area[b]; });
    chosen.resize(std::min(chosen.size(), count));
    std::sort(chosen.begin(), chosen.end());
    return chosen;
}

/// The K chosen volumes as a tree of their own.
struct HitTree {
    std::vector<std::uint32_t> parent;       // [K] in [0, K), kNone at the root
    std::vector<std::uint32_t> first;        // [K] of the triangles in the HBV's order
    std::vector<std::uint32_t> of_position;  // [T] the smallest of the K that holds the triangle at this place
};

HitTree make_tree(const ObjectData& object, std::span<const std::uint32_t> chosen) {
    HitTree tree;
    tree.of_position.resize(object.volume_triangles.size());
    std::vector<std::uint32_t> open;  // from the root to the last volume
    for (std::uint32_t k = 0; k < chosen.size(); ++k) {
        const Volume& v = object.volumes[chosen[k]];
        const auto ends_before = [&](std::uint32_t other) {
            const Volume& o = object.volumes[chosen[other]];
            return o.first + o.count <= v.first;
        };
        while (!open.empty() && ends_before(open.back())) open.pop_back();
        tree.parent.push_back(open.empty() ? kNone : open.back());
        tree.first.push_back(v.first);
        open.push_back(k);
        // Preorder: deeper volumes come later and overwrite.
        std::fill_n(tree.of_position.begin() + v.first, v.count, k);
    }
    return tree;
}

/// The image that the outermost box fills, slightly turned where that would be a line.
DirectionImage image_of(const Box3& box, const Vec3& direction, std::uint32_t resolution) {
    constexpr double kTurn = 1e-3;  // radians; well above the thinnest image
    std::array<Vec3f, 8> corners;
    for (std::size_t i = 0; i < 8; ++i)
        corners[i] = to_float({i & 1 ? box.hi.x : box.lo.x, i & 2 ? box.hi.y : box.lo.y, i & 4 ? box.hi.z : box.lo.z});
    DirectionImage image = fit_image(corners, direction, resolution);
    for (int axis = 0; axis < 3 && image.empty(); ++axis) {
        Vec3 turned = direction;
        turned[axis] += kTurn;
        image = fit_image(corners, normalised(turned), resolution);
    }
    assert(image.pixel_width > 0 && image.pixel_height > 0);  // a triangle with an area has a box of two extents
    return image;
}

/// The outlines of boxes in an image: hexagons whose sides run along the box's axes.
class BoxOutlines {
  public:
    explicit BoxOutlines(const DirectionImage& image) : image_(image) {
        for (int axis = 0; axis < 3; ++axis) {
            ImagePoint step{image.right[axis] / image.pixel_width, image.up[axis] / image.pixel_height};
            if (step.y < 0 || (step.y == 0 && step.x < 0)) step = {-step.x, -step.y};
            steps_[static_cast<std::size_t>(axis)] = {axis, step};
        }
        // From the one that leads to the right most to the one that leads to the left most.
        std::sort(steps_.begin(), steps_.end(), [](const Step& a, const Step& b) {
            const double turn = a.along.x * b.along.y - a.along.y * b.along.x;
            return turn != 0 ? turn > 0 : a.axis < b.axis;
        });
    }

    /// Calls emit(row, begin, end) for each run of samples in the box's outline.
    template <class Emit>
    void for_each_span(const Box3& box, const Emit& emit) const {
        const Vec3 extent = box.extent();
        ImagePoint low = image_.frame().place(box.centre()), high = low;
        for (const Step& s : steps_) {
            const double half = 0.5 * extent[s.axis];
            low = {low.x - half * s.along.x, low.y - half * s.along.y};
            high = {high.x + half * s.along.x, high.y + half * s.along.y};
        }
        Chain right(low), left(low);
        const double last = std::min(first_row(high.y), static_cast<double>(image_.resolution));
        for (double row = std::max(0.0, first_row(low.y)); row < last; ++row) {
            const double y = row + kSampleHeight;
            const auto number = static_cast<std::uint32_t>(row);
            const double shift = sample_shift(number);
            const double from = left.at(y, [&](std::size_t i) { return side(steps_[2 - i], extent); }) - shift;
            const double to = right.at(y, [&](std::size_t i) { return side(steps_[i], extent); }) - shift;
            const double begin = std::max(0.0, std::ceil(from));
            const double end = std::min(static_cast<double>(image_.resolution), std::ceil(to));
            if (end > begin) emit(number, static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(end));
        }
    }

  private:
    struct Step {
        int axis = 0;
        ImagePoint along{};  // in the image, of 1 m along the axis, upwards
    };
    static ImagePoint side(const Step& step, const Vec3& extent) {
        return {extent[step.axis] * step.along.x, extent[step.axis] * step.along.y};
    }

    /// Three sides of the hexagon, from its lowest corner upwards.
    struct Chain {
        ImagePoint begin, along{};
        std::size_t next = 0;  // side

        explicit Chain(const ImagePoint& lowest) : begin(lowest) {}
        template <class Side>
        double at(double y, const Side& side_of) {
            while (next < 3 && begin.y + along.y < y) {
                begin = {begin.x + along.x, begin.y + along.y};
                along = side_of(next++);
            }
            return along.y > 0 ? begin.x + std::min(1.0, (y - begin.y) / along.y) * along.x : begin.x + along.x;
        }
    };

    DirectionImage image_;
    std::array<Step, 3> steps_;
};

/// Samples on which a volume's own triangles lie, for all volumes at once: triangles are drawn in the order of the tree,
/// each counts for its volume, and where another was drawn before it, what holds both counted it already.
///
/// returns  [K]
std::vector<std::uint32_t> count_own(const ObjectData& object, const HitTree& tree, const DirectionImage& image) {
    const std::uint32_t size = image.resolution;
    std::vector<ImagePoint> at;
    at.reserve(object.positions.size());
    for (const Vec3f& p : object.positions) at.push_back(image.frame().place(to_double(p)));
    std::vector<std::uint32_t> drawn(std::size_t{size} * size, kNone);  // place of the last triangle
    std::vector<std::uint32_t> counts(tree.parent.size());              // differences wrap, sums do not
    for (std::uint32_t place = 0; place < object.volume_triangles.size(); ++place) {
        const auto& [a, b, c] = object.triangles[object.volume_triangles[place]];
        for_each_span(std::array{at[a], at[b], at[c]}, size, size,
                      [&](std::uint32_t row, std::uint32_t begin, std::uint32_t end) {
                          for (std::size_t s = std::size_t{row} * size + begin; s < std::size_t{row} * size + end; ++s) {
                              std::uint32_t k = tree.of_position[place];
                              ++counts[k];
                              if (drawn[s] != kNone) {
                                  while (tree.first[k] > drawn[s]) k = tree.parent[k];
                                  --counts[k];
                              }
                              drawn[s] = place;
                          }
                      });
    }
    for (std::size_t k = counts.size() - 1; k > 0; --k) counts[tree.parent[k]] += counts[k];
    return counts;
}

std::uint8_t probability_byte(double probability) {
    constexpr double kSteps = 31;  // 0 and 1 among them; interpolation between directions errs by several times a step
    return static_cast<std::uint8_t>(std::lround(255 * std::round(kSteps * probability) / kSteps));
}

/// Adds one direction's probabilities to a table: of K volumes, from the root down.
///
/// hits, met   samples, of those on the box
void store(std::span<const std::uint32_t> hits, std::span<const std::uint32_t> met, const HitTree& tree,
           std::size_t lines, std::size_t line, std::vector<std::uint8_t>& table) {
    constexpr double kPrior = 1;  // samples that what is known of the volume above weighs
    std::vector<double> probability(hits.size());
    for (std::size_t k = 0; k < hits.size(); ++k) {
        // The root fills its image, so that it has samples.
        const bool root = tree.parent[k] == kNone;
        const double prior = root ? 0 : kPrior, above = root ? 0 : probability[tree.parent[k]];
        probability[k] = std::min(1.0, (hits[k] + prior * above) / (met[k] + prior));
        table[k * lines + line] = probability_byte(probability[k]);
    }
}

}  // namespace

HitProbabilities measure_hits(const ObjectData& object, const TableChoice& tables) {
    assert(!object.volumes.empty() && object.meta.image_resolution > 0);
    const DirectionGrid grid(object.meta.grid_map, object.meta.grid_size);
    const std::size_t lines = grid.lines();
    HitProbabilities result;
    result.volumes = largest_volumes(object.volumes, tables.every_node ? object.volumes.size() : kLargestVolumes);
    const std::size_t count = result.volumes.size();
    const HitTree tree = make_tree(object, result.volumes);
    result.whole.resize(count * lines);
    result.intrinsic.resize(tables.every_node ? count * lines : 0);
    parallel_for(lines, 1, [&](std::size_t line) {
        const DirectionImage image = image_of(box_of(object.volumes[0]), grid.direction(static_cast<std::uint32_t>(line)),
                                              2 * object.meta.image_resolution);
        const CoverageMask mask =
            silhouette(object.positions, object.triangles, image.frame(), image.resolution, image.resolution);
        const BoxOutlines outlines(image);
        std::vector<std::uint32_t> hits(count), met(count);
        for (std::size_t k = 0; k < count; ++k)
            outlines.for_each_span(box_of(object.volumes[result.volumes[k]]),
                                   [&](std::uint32_t row, std::uint32_t begin, std::uint32_t end) {
                                       met[k] += end - begin;
                                       hits[k] += mask.count(row, begin, end);
                                   });
        store(hits, met, tree, lines, line, result.whole);
        if (tables.every_node) store(count_own(object, tree, image), met, tree, lines, line, result.intrinsic);
    });
    return result;
}

}  // namespace rro
