#include "compiler/object_bvh.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <numeric>

namespace rro {
namespace {

constexpr std::uint32_t kLeafTriangles = 8;  // half the volumes of 4, for a quarter of the bytes per triangle
constexpr int kBins = 16;
constexpr int kSahDepth = 40;  // splits below halve by count, so that nested geometry cannot make the tree a list

struct Bin {
    Box3 box;
    std::uint32_t count = 0;

    void add(const Bin& other) {
        box.add(other.box);
        count += other.count;
    }
    double cost() const { return count == 0 ? 0 : box.surface_area() * count; }
};

struct Split {
    int axis = 0;
    int first_right_bin = 0;  // 0: no split found
    double cost = 0;
};

class Builder {
  public:
    Builder(std::span<const Vec3f> positions, std::span<const TriangleIndices> triangles) {
        boxes_.reserve(triangles.size());
        for (const TriangleIndices& t : triangles) {
            Box3 box;
            for (const std::uint32_t v : t) box.add(to_double(positions[v]));
            boxes_.push_back(box);
        }
        bvh_.triangles.resize(triangles.size());
        std::iota(bvh_.triangles.begin(), bvh_.triangles.end(), 0u);
        bvh_.volumes.reserve(triangles.size());
    }

    ObjectBvh run() {
        build(0, static_cast<std::uint32_t>(bvh_.triangles.size()), 0);
        return std::move(bvh_);
    }

  private:
    static int bin_of(const Box3& centres, int axis, const Vec3& centre) {
        const double share = (centre[axis] - centres.lo[axis]) / (centres.hi[axis] - centres.lo[axis]);
        return std::min(kBins - 1, static_cast<int>(share * kBins));
    }

    void build(std::uint32_t begin, std::uint32_t end, int depth) {
        Box3 box, centres;
        for (std::uint32_t i = begin; i < end; ++i) {
            box.add(boxes_[bvh_.triangles[i]]);
            centres.add(boxes_[bvh_.triangles[i]].centre());
        }
        const std::size_t own = bvh_.volumes.size();
        bvh_.volumes.push_back({to_float(box.lo), to_float(box.hi), begin, end - begin, 0});
        if (end - begin <= kLeafTriangles) return;
        const std::uint32_t middle = divide(begin, end, centres, depth);
        build(begin, middle, depth + 1);
        bvh_.volumes[own].right_child = static_cast<std::uint32_t>(bvh_.volumes.size());
        build(middle, end, depth + 1);
    }

    /// Reorders [begin, end) and returns where the right part starts; neither part is empty.
    std::uint32_t divide(std::uint32_t begin, std::uint32_t end, const Box3& centres, int depth) {
        const Split split = depth < kSahDepth ? best_split(begin, end, centres) : Split{};
        const auto first = bvh_.triangles.begin() + begin, last = bvh_.triangles.begin() + end;
        if (split.first_right_bin > 0) {
            const auto middle = std::stable_partition(first, last, [&](std::uint32_t t) {
                return bin_of(centres, split.axis, boxes_[t].centre()) < split.first_right_bin;
            });
            return static_cast<std::uint32_t>(middle - bvh_.triangles.begin());
        }
        const Vec3 extent = centres.extent();
        const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
        const auto half = first + (end - begin) / 2;
        std::nth_element(first, half, last, [&](std::uint32_t a, std::uint32_t b) {
            const double ca = boxes_[a].centre()[axis], cb = boxes_[b].centre()[axis];
            return ca < cb || (ca == cb && a < b);
        });
        // nth_element leaves each half in an order of its own making; ours is by number.
        std::sort(first, half);
        std::sort(half, last);
        return static_cast<std::uint32_t>(half - bvh_.triangles.begin());
    }

    Split best_split(std::uint32_t begin, std::uint32_t end, const Box3& centres) const {
        Split best;
        for (int axis = 0; axis < 3; ++axis) {
            if (!(centres.hi[axis] > centres.lo[axis])) continue;
            std::array<Bin, kBins> bins;
            for (std::uint32_t i = begin; i < end; ++i) {
                const Box3& box = boxes_[bvh_.triangles[i]];
                bins[static_cast<std::size_t>(bin_of(centres, axis, box.centre()))].add({box, 1});
            }
            std::array<double, kBins> right_cost{};
            Bin sum;
            for (std::size_t b = kBins - 1; b > 0; --b) {
                sum.add(bins[b]);
                right_cost[b] = sum.cost();
            }
            sum = {};
            for (std::size_t b = 1; b < kBins; ++b) {
                sum.add(bins[b - 1]);
                if (sum.count == 0 || sum.count == end - begin) continue;
                const double cost = sum.cost() + right_cost[b];
                if (best.first_right_bin == 0 || cost < best.cost) best = {axis, static_cast<int>(b), cost};
            }
        }
        return best;
    }

    std::vector<Box3> boxes_;  // [T]
    ObjectBvh bvh_;
};

}  // namespace

ObjectBvh build_object_bvh(std::span<const Vec3f> positions, std::span<const TriangleIndices> triangles) {
    assert(!triangles.empty());
    return Builder(positions, triangles).run();
}

}  // namespace rro
