#include "solver/transport/groups.h"

#include <algorithm>
#include <numeric>

namespace rro {

namespace {

// With fewer instances, all pairs of them cost less than groups do.
constexpr std::size_t kFewestInstances = 32;

// An instance whose diagonal is this part of its group's or more parts from smaller ones.
constexpr double kLarge = 0.5;

class Builder {
  public:
    Builder(const Scene& scene, GroupTree& tree) : scene_(scene), tree_(tree) {}

    /// returns  the child number of the members [first, first + count)
    std::uint32_t build(std::uint32_t first, std::uint32_t count) {
        const auto instances = static_cast<std::uint32_t>(scene_.instances.size());
        if (count == 1) return instances - 1 + tree_.members[first];  // a tree over n leaves has n - 1 inner nodes
        const auto self = static_cast<std::uint32_t>(tree_.groups.size());
        tree_.groups.push_back({{}, first, count});
        const std::uint32_t left = part(first, count);
        const std::uint32_t a = build(first, left), b = build(first + left, count - left);
        tree_.groups[self].child = {a, b};
        return self;
    }

  private:
    const Box3& box(std::uint32_t instance) const { return scene_.instances[instance].bounds; }

    bool shines(std::uint32_t instance) const {
        const std::vector<Rgb>& exitance = scene_.instances[instance].exitance;
        return std::any_of(exitance.begin(), exitance.end(), [](const Rgb& m) { return m.x > 0 || m.y > 0 || m.z > 0; });
    }

    /// Orders the members so that the first ones, as many as returned, are one part of two.
    std::uint32_t part(std::uint32_t first, std::uint32_t count) {
        const auto begin = tree_.members.begin() + first, end = begin + count;
        Box3 all, centres;
        for (auto m = begin; m != end; ++m) {
            all.add(box(*m));
            centres.add(box(*m).centre());
        }
        if (first == 0 && count == tree_.members.size()) {
            const auto dark = std::stable_partition(begin, end, [&](std::uint32_t i) { return shines(i); });
            if (dark != begin && dark != end) return static_cast<std::uint32_t>(dark - begin);
        }
        const auto large = [&](std::uint32_t i) { return length(box(i).extent()) >= kLarge * length(all.extent()); };
        const auto middle = std::stable_partition(begin, end, large);
        if (middle != begin && middle != end) return static_cast<std::uint32_t>(middle - begin);

        const Vec3 extent = centres.extent();
        const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
        std::sort(begin, end, [&](std::uint32_t a, std::uint32_t b) {
            const double ca = box(a).centre()[axis], cb = box(b).centre()[axis];
            return ca != cb ? ca < cb : scene_.instances[a].name < scene_.instances[b].name;
        });
        return count / 2;
    }

    const Scene& scene_;
    GroupTree& tree_;
};

}  // namespace

GroupTree group_instances(const Scene& scene) {
    GroupTree tree;
    if (scene.instances.size() < kFewestInstances) return tree;
    tree.members.resize(scene.instances.size());
    std::iota(tree.members.begin(), tree.members.end(), 0u);
    // By name first: partitions keep the order they find.
    std::sort(tree.members.begin(), tree.members.end(), [&](std::uint32_t a, std::uint32_t b) {
        return scene.instances[a].name < scene.instances[b].name;
    });
    Builder(scene, tree).build(0, static_cast<std::uint32_t>(scene.instances.size()));
    return tree;
}

}  // namespace rro
