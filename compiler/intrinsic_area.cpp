#include "compiler/intrinsic_area.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "compiler/line_images.h"
#include "format/parallel.h"

namespace rro {
namespace {

constexpr std::uint32_t kNone = 0xffffffffu;

/// The K clusters as a tree of their own.
struct AreaTree {
    std::vector<std::uint32_t> parent;      // [K] in [0, K), kNone at the root
    std::vector<std::uint32_t> of_patch;    // [P] the smallest of the K that holds the patch
    std::vector<std::uint32_t> of_face;     // [F]
    std::vector<std::uint32_t> begin, end;  // [K] faces
};

AreaTree make_area_tree(const ObjectData& object, std::span<const std::uint32_t> clusters) {
    AreaTree tree;
    tree.of_patch.assign(object.patches.size(), kNone);
    std::vector<std::uint32_t> open;  // from the root to the last cluster
    for (std::uint32_t k = 0; k < clusters.size(); ++k) {
        const Cluster& c = object.clusters[clusters[k]];
        const auto holds = [&](std::uint32_t other) {
            const Cluster& o = object.clusters[clusters[other]];
            return c.first_patch < o.first_patch + o.patch_count;
        };
        while (!open.empty() && !holds(open.back())) open.pop_back();
        tree.parent.push_back(open.empty() ? kNone : open.back());
        open.push_back(k);
        const std::uint32_t last_patch = c.first_patch + c.patch_count - 1;
        // Preorder: deeper clusters come later and overwrite.
        for (std::uint32_t p = c.first_patch; p <= last_patch; ++p) tree.of_patch[p] = k;
        tree.begin.push_back(object.patches[c.first_patch].first_face);
        tree.end.push_back(object.patches[last_patch].first_face + object.patches[last_patch].face_count);
    }
    tree.of_face.resize(object.faces.size());
    for (std::size_t p = 0; p < object.patches.size(); ++p)
        std::fill_n(tree.of_face.begin() + object.patches[p].first_face, object.patches[p].face_count,
                    tree.of_patch[p]);
    return tree;
}

/// One side of a triangle on a line of sight.
struct LineHit {
    double height;       // along the image's `toward`, in steps of same_height
    bool turned_toward;  // to the viewer that the image has, not to the opposite one
    std::uint32_t node;  // of the area tree
};

/// Counts per node for one viewer.
class ViewerCounts {
  public:
    explicit ViewerCounts(std::size_t nodes) : seen(nodes), decided_(nodes) {}

    /// hits in any order; reorders them.
    void add_line(std::span<LineHit> hits, bool opposite, const AreaTree& tree) {
        ++line_;
        // At one height (both sides of a triangle) the side that faces the viewer comes first.
        std::sort(hits.begin(), hits.end(), [&](const LineHit& a, const LineHit& b) {
            if (a.height != b.height) return opposite ? a.height < b.height : a.height > b.height;
            if (a.turned_toward != b.turned_toward) return a.turned_toward != opposite;
            return a.node < b.node;
        });
        for (const LineHit& hit : hits)
            for (std::uint32_t k = hit.node; k != kNone && decided_[k] != line_; k = tree.parent[k]) {
                decided_[k] = line_;
                if (hit.turned_toward != opposite) ++seen[k];
            }
    }

    std::vector<std::uint32_t> seen;  // [K]

  private:
    std::vector<std::uint32_t> decided_;  // [K] the last line on which the node met a triangle
    std::uint32_t line_ = 0;
};

/// All that lies on the lines of one image, line by line.
struct LineHits {
    std::vector<std::uint32_t> begin;  // [lines + 1]
    std::vector<LineHit> hits;

    std::span<LineHit> line(std::size_t l) { return {hits.data() + begin[l], hits.data() + begin[l + 1]}; }
};

/// Both sides of a triangle hit; black sides are left out.
LineHits collect_hits(const ObjectData& object, const DirectionImage& image, std::span<const std::uint32_t> face_by_side,
                      const AreaTree& tree, LineCounts& covered) {
    const std::size_t size = image.resolution;
    struct Found {
        std::uint32_t line;
        LineHit hit;
    };
    std::vector<Found> found;
    LineHits lines;
    lines.begin.resize(size * size + 1);
    for_each_run(object, image, [&](const TriangleRun& run) {
        const RunFaces faces = faces_of(run, face_by_side);
        add_covered(run, faces, covered);
        for (std::uint32_t column = run.begin; column < run.end; ++column) {
            const auto line = static_cast<std::uint32_t>(run.row * size + column);
            const double height = std::round(run.height_at(column) / same_height(image));
            if (faces.toward != kBlackSide) found.push_back({line, {height, true, tree.of_face[faces.toward]}});
            if (faces.opposite != kBlackSide) found.push_back({line, {height, false, tree.of_face[faces.opposite]}});
        }
    });
    for (const Found& f : found) ++lines.begin[f.line + 1];
    for (std::size_t l = 0; l < size * size; ++l) lines.begin[l + 1] += lines.begin[l];
    std::vector<std::uint32_t> next(lines.begin.begin(), lines.begin.end() - 1);
    lines.hits.resize(found.size());
    for (const Found& f : found) lines.hits[next[f.line]++] = f.hit;
    return lines;
}

}  // namespace

SampleCounts count_intrinsic(const ObjectData& object, std::span<const Vec3> directions,
                             std::span<const std::uint32_t> clusters, std::uint32_t resolution) {
    const AreaTree tree = make_area_tree(object, clusters);
    // Half of the whole object's: the stored clusters are large, and every hit of a line costs.
    const std::uint32_t half = (resolution + 1) / 2;
    const std::vector<std::uint32_t> opposite_of = opposite_directions(directions), face_by_side = faces_by_side(object);
    SampleCounts counts(clusters.size() * directions.size());

    const auto store = [&](std::size_t direction, const ViewerCounts& viewer, std::span<const std::uint32_t> covered) {
        std::vector<std::uint32_t> before(covered.size() + 1);
        for (std::size_t f = 0; f < covered.size(); ++f) before[f + 1] = before[f] + covered[f];
        for (std::size_t k = 0; k < clusters.size(); ++k) {
            counts.seen[k * directions.size() + direction] = viewer.seen[k];
            counts.covered[k * directions.size() + direction] = before[tree.end[k]] - before[tree.begin[k]];
        }
    };
    parallel_for(directions.size(), 1, [&](std::size_t d) {
        const std::uint32_t opposite = opposite_of[d];
        if (opposite < d) return;  // done with its partner, on the same lines
        const DirectionImage image = fit_image(object.positions, directions[d], half);
        ViewerCounts toward(clusters.size()), behind(clusters.size());
        LineCounts covered(object.faces.size());
        if (!image.empty()) {
            LineHits lines = collect_hits(object, image, face_by_side, tree, covered);
            for (std::size_t l = 0; l + 1 < lines.begin.size(); ++l) {
                toward.add_line(lines.line(l), false, tree);
                if (opposite != kNoDirection) behind.add_line(lines.line(l), true, tree);
            }
        }
        store(d, toward, covered.toward);
        if (opposite != kNoDirection) store(opposite, behind, covered.opposite);
    });
    return counts;
}

}  // namespace rro
