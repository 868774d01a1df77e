#include "compiler/intrinsic_area.h"

#include <algorithm>
#include <vector>

#include "compiler/direction_images.h"
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
    double height;       // along the image's `toward`
    bool turned_toward;  // to the viewer that the image has, not to the opposite one
    std::uint32_t node;  // of the area tree
};

/// Counts per node for one viewer.
class ViewerCounts {
  public:
    explicit ViewerCounts(std::size_t nodes) : seen(nodes), decided_(nodes) {}

    /// hits in any order; reorders them.
    void add_line(std::vector<LineHit>& hits, bool opposite, const AreaTree& tree) {
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

/// Everything one image needs; safe to share between threads.
class LineTracer {
  public:
    LineTracer(const ObjectData& object, const ObjectRays& rays, const AreaTree& tree)
        : object_(object), rays_(rays), tree_(tree), face_by_side_(faces_by_side(object)) {}

    void trace(const DirectionImage& image, ViewerCounts& toward, ViewerCounts* opposite) const {
        if (image.empty()) return;
        std::vector<std::uint32_t> triangles;
        std::vector<LineHit> hits;
        for (std::uint32_t row = 0; row < image.resolution; ++row)
            for (std::uint32_t column = 0; column < image.resolution; ++column) {
                rays_.all_hits(image.ray(column, row), triangles);
                if (triangles.empty()) continue;
                hits.clear();
                for (const std::uint32_t t : triangles) add_sides(t, image, image.sample(column, row), hits);
                toward.add_line(hits, false, tree_);
                if (opposite) opposite->add_line(hits, true, tree_);
            }
    }

    std::span<const std::uint32_t> face_by_side() const { return face_by_side_; }

  private:
    void add_sides(std::uint32_t triangle, const DirectionImage& image, const Vec3& sample,
                   std::vector<LineHit>& hits) const {
        const TriangleIndices& t = object_.triangles[triangle];
        const Vec3 a = to_double(object_.positions[t[0]]);
        const Vec3 normal = area_vector(a, to_double(object_.positions[t[1]]), to_double(object_.positions[t[2]]));
        const double slope = dot(normal, image.toward);
        if (slope == 0) return;
        const double height = dot(a - sample, normal) / slope;
        for (const Side side : {Side::Front, Side::Back}) {
            const std::uint32_t face = face_by_side_[Face::make(triangle, side).packed];
            if (face != kNoFace) hits.push_back({height, (slope > 0) == (side == Side::Front), tree_.of_face[face]});
        }
    }

    const ObjectData& object_;
    const ObjectRays& rays_;
    const AreaTree& tree_;
    std::vector<std::uint32_t> face_by_side_;
};

/// The direction opposite to each, or kNone. Grids of even size are symmetric.
std::vector<std::uint32_t> opposite_directions(std::span<const Vec3> directions) {
    constexpr double kSame = 1e-18;  // squared distance of unit vectors; grids compute theirs to 1e-15
    std::vector<std::uint32_t> result(directions.size(), kNone);
    for (std::uint32_t a = 0; a < directions.size(); ++a)
        for (std::uint32_t b = 0; b < directions.size(); ++b)
            if (length2(directions[a] + directions[b]) < kSame) result[a] = b;
    return result;
}

}  // namespace

SampleCounts count_intrinsic(const ObjectData& object, const ObjectRays& rays, std::span<const Vec3> directions,
                             std::span<const std::uint32_t> clusters) {
    const AreaTree tree = make_area_tree(object, clusters);
    const LineTracer tracer(object, rays, tree);
    // Half of the whole object's: the stored clusters are large, and every hit of a line costs.
    const std::uint32_t resolution = (object.meta.image_resolution + 1) / 2;
    const std::vector<std::uint32_t> opposite_of = opposite_directions(directions);
    SampleCounts counts(clusters.size() * directions.size());

    const auto store = [&](std::uint32_t direction, const ViewerCounts& viewer,
                           std::span<const std::uint32_t> covered) {
        std::vector<std::uint32_t> before(covered.size() + 1);
        for (std::size_t f = 0; f < covered.size(); ++f) before[f + 1] = before[f] + covered[f];
        for (std::size_t k = 0; k < clusters.size(); ++k) {
            counts.seen[k * directions.size() + direction] = viewer.seen[k];
            counts.covered[k * directions.size() + direction] = before[tree.end[k]] - before[tree.begin[k]];
        }
    };
    parallel_for(directions.size(), 1, [&](std::size_t d) {
        const auto direction = static_cast<std::uint32_t>(d);
        const std::uint32_t opposite = opposite_of[d];
        if (opposite < direction) return;  // done with its partner, on the same lines
        const bool both = opposite != kNone;
        const DirectionImage image = fit_image(object.positions, directions[d], resolution);
        ViewerCounts front(clusters.size()), behind(clusters.size());
        std::vector<std::uint32_t> covered_front(object.faces.size()), covered_behind(both ? object.faces.size() : 0);
        tracer.trace(image, front, both ? &behind : nullptr);
        count_covered(object, tracer.face_by_side(), image, covered_front, covered_behind);
        store(direction, front, covered_front);
        if (both) store(opposite, behind, covered_behind);
    });
    return counts;
}

}  // namespace rro
