#include "compiler/patches.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <queue>
#include <utility>

#include "compiler/morton_order.h"

namespace rro {
namespace {

constexpr std::uint32_t kNone = 0xffffffffu;
constexpr double kCrumbShare = 0.25;  // of the largest area: smaller patches look for a neighbour to join

// Dust, likewise: below 1 / 32,000 of the object with the default limit. One plant has three quarters of its patches, but
// less than a fiftieth of its area in such scraps.
constexpr double kDustShare = 1.0 / 16;
constexpr double kDustSpread = 3;         // widest heap of dust, in edges of a square of the largest area
constexpr std::size_t kOpenHeaps = 32;    // along the Morton curve; at least one per direction a surface can look in

/// Sums over the faces of a patch.
struct Sums {
    Vec3 area_vector, reflectance;  // reflectance times area
    double area = 0;
};

/// What the limits say of faces and patches. Areas are looked at over and over, so they are computed once.
class Judge {
  public:
    Judge(const Surface& surface, const PatchLimits& limits) : surface_(surface), limits_(limits) {
        area_.reserve(surface.faces.size());
        for (const Vec3& a : surface.area_vector) area_.push_back(length(a));
    }

    double area(std::uint32_t face) const { return area_[face]; }

    void add(Sums& sums, std::uint32_t face) const {
        sums.area_vector += surface_.area_vector[face];
        sums.reflectance += surface_.reflectance[face] * area_[face];
        sums.area += area_[face];
    }

    Sums sums_of(std::span<const std::uint32_t> faces) const {
        Sums sums;
        for (const std::uint32_t f : faces) add(sums, f);
        return sums;
    }

    bool fits(const Sums& sums, std::uint32_t face) const {
        return fits(sums.area_vector, limits_.cone_cosine * length(sums.area_vector), sums.reflectance / sums.area, face);
    }

    bool all_fit(std::span<const std::uint32_t> faces) const {
        const Sums sums = sums_of(faces);
        // Within a cone, areas add up to this at least; faces that look opposite ways add up to nothing at all.
        constexpr double kRounding = 1e-9;
        if (length(sums.area_vector) < (limits_.cone_cosine - kRounding) * sums.area) return false;
        const double least = limits_.cone_cosine * length(sums.area_vector);
        const Vec3 reflectance = sums.reflectance / sums.area;
        return std::all_of(faces.begin(), faces.end(),
                           [&](std::uint32_t f) { return fits(sums.area_vector, least, reflectance, f); });
    }

  private:
    bool fits(const Vec3& area_vector, double least, const Vec3& reflectance, std::uint32_t face) const {
        if (dot(surface_.area_vector[face], area_vector) < least * area_[face]) return false;
        const Vec3 off = surface_.reflectance[face] - reflectance;
        return std::max({std::abs(off.x), std::abs(off.y), std::abs(off.z)}) <= limits_.reflectance_spread;
    }

    const Surface& surface_;
    const PatchLimits& limits_;
    std::vector<double> area_;  // [F] m^2
};

/// Grows one patch after the other and remembers who owns which face.
class Growth {
  public:
    Growth(const Surface& surface, const PatchLimits& limits, const FaceAdjacency& adjacency)
        : surface_(surface), limits_(limits), adjacency_(adjacency), judge_(surface, limits) {
        owner_.assign(surface.faces.size(), kNone);
        queued_for_.assign(surface.faces.size(), kNone);
        centre_.reserve(surface.faces.size());
        for (const Face f : surface.faces) {
            const TriangleCorners c = surface.corners(f.triangle());
            centre_.push_back((c[0] + c[1] + c[2]) / 3);
        }
    }

    std::vector<std::vector<std::uint32_t>> run() {
        for (std::uint32_t first = 0; first < owner_.size(); ++first) {
            rim_.push_back(first);
            while (!rim_.empty()) {
                const std::uint32_t seed = rim_.front();
                rim_.pop_front();
                if (owner_[seed] == kNone) grow(seed);
            }
        }
        join_crumbs();
        std::erase_if(patches_, [](const auto& p) { return p.empty(); });
        join_dust();
        std::erase_if(patches_, [](const auto& p) { return p.empty(); });
        for (auto& patch : patches_) sort_along_curve(patch);
        return std::move(patches_);
    }

  private:
    /// So that a part of a patch is a row of its faces.
    void sort_along_curve(std::vector<std::uint32_t>& patch) const {
        std::sort(patch.begin(), patch.end());
        std::vector<Vec3> centres;
        for (const std::uint32_t f : patch) centres.push_back(centre_[f]);
        std::vector<std::uint32_t> sorted;
        for (const std::uint32_t i : morton_order(centres)) sorted.push_back(patch[i]);
        patch = std::move(sorted);
    }

    std::span<const std::uint32_t> neighbours(std::uint32_t face) const {
        return std::span(adjacency_.neighbour)
            .subspan(adjacency_.first[face], adjacency_.first[face + 1] - adjacency_.first[face]);
    }

    void grow(std::uint32_t seed) {
        const auto id = static_cast<std::uint32_t>(patches_.size());
        std::priority_queue<std::pair<double, std::uint32_t>, std::vector<std::pair<double, std::uint32_t>>,
                            std::greater<>>
            nearest;
        std::vector<std::uint32_t> taken;
        Sums sums;
        nearest.emplace(0, seed);
        queued_for_[seed] = id;
        while (!nearest.empty()) {
            const std::uint32_t face = nearest.top().second;
            if (face != seed) {
                if (sums.area + judge_.area(face) > limits_.largest_area) break;
                if (!judge_.fits(sums, face)) {
                    rim_.push_back(face);
                    nearest.pop();
                    continue;
                }
            }
            nearest.pop();
            taken.push_back(face);
            judge_.add(sums, face);
            for (const std::uint32_t next : neighbours(face)) {
                if (owner_[next] != kNone || queued_for_[next] == id) continue;
                if (surface_.material[next] != surface_.material[seed]) continue;
                queued_for_[next] = id;
                nearest.emplace(length2(centre_[next] - centre_[seed]), next);
            }
        }
        for (; !nearest.empty(); nearest.pop()) rim_.push_back(nearest.top().second);
        release_misfits(taken);
        for (const std::uint32_t f : taken) owner_[f] = id;
        patches_.push_back(std::move(taken));
    }

    /// The mean moved while the patch grew; faces that no longer fit go back. At least the seed stays.
    void release_misfits(std::vector<std::uint32_t>& taken) {
        const std::uint32_t seed = taken.front();
        constexpr int kRounds = 4;  // each round moves the mean less; nearly all patches need none or one
        for (int round = 0; round < kRounds && !judge_.all_fit(taken); ++round) {
            const Sums sums = judge_.sums_of(taken);
            std::erase_if(taken, [&](std::uint32_t f) {
                const bool out = f != seed && !judge_.fits(sums, f);
                if (out) rim_.push_back(f);
                return out;
            });
        }
        // Else the nearer half, and so on.
        while (taken.size() > 1 && !judge_.all_fit(taken)) {
            const std::size_t kept = taken.size() / 2;
            rim_.insert(rim_.end(), taken.begin() + static_cast<std::ptrdiff_t>(kept), taken.end());
            taken.resize(kept);
        }
    }

    /// Small leftovers between patches join the nearest neighbour that stays within the limits.
    void join_crumbs() {
        constexpr std::size_t kTries = 8;
        for (std::uint32_t p = 0; p < patches_.size(); ++p) {
            const double area = judge_.sums_of(patches_[p]).area;
            if (area >= kCrumbShare * limits_.largest_area) continue;
            std::vector<std::uint32_t> near = patches_beside(p);
            for (std::size_t k = 0; k < std::min(near.size(), kTries); ++k) {
                if (judge_.sums_of(patches_[near[k]]).area + area > limits_.largest_area) continue;
                std::vector<std::uint32_t> both = patches_[near[k]];
                both.insert(both.end(), patches_[p].begin(), patches_[p].end());
                if (!judge_.all_fit(both)) continue;
                for (const std::uint32_t f : patches_[p]) owner_[f] = near[k];
                patches_[near[k]] = std::move(both);
                patches_[p].clear();
                break;
            }
        }
    }

    /// What is left of loose scraps (stamens, threads, broken scans) is too small for tables of its own: patches of dust
    /// join others nearby that look the same way, touching or not.
    void join_dust() {
        struct Heap {
            std::uint32_t patch;
            double area;
            Box3 box;
        };
        std::vector<std::uint32_t> dust;
        std::vector<Vec3> centres;
        for (std::uint32_t p = 0; p < patches_.size(); ++p) {
            if (judge_.sums_of(patches_[p]).area >= kDustShare * limits_.largest_area) continue;
            dust.push_back(p);
            centres.push_back(centre_[patches_[p].front()]);
        }
        const double widest = kDustSpread * std::sqrt(limits_.largest_area);
        std::deque<Heap> open;  // the most recent first
        for (const std::uint32_t i : morton_order(centres)) {
            const std::uint32_t p = dust[i];
            Heap own{p, judge_.sums_of(patches_[p]).area, box_of(patches_[p])};
            const auto takes = [&](const Heap& heap) {
                Box3 box = heap.box;
                box.add(own.box);
                if (max_component(box.extent()) > widest) return false;
                if (heap.area + own.area > kCrumbShare * limits_.largest_area) return false;
                if (surface_.material[patches_[heap.patch].front()] != surface_.material[patches_[p].front()]) return false;
                std::vector<std::uint32_t> both = patches_[heap.patch];
                both.insert(both.end(), patches_[p].begin(), patches_[p].end());
                return judge_.all_fit(both);
            };
            const auto found = std::find_if(open.begin(), open.end(), takes);
            if (found == open.end()) {
                open.push_front(own);
                if (open.size() > kOpenHeaps) open.pop_back();
                continue;
            }
            std::vector<std::uint32_t>& faces = patches_[found->patch];
            faces.insert(faces.end(), patches_[p].begin(), patches_[p].end());
            patches_[p].clear();
            found->area += own.area;
            found->box.add(own.box);
        }
    }

    Box3 box_of(std::span<const std::uint32_t> faces) const {
        Box3 box;
        for (const std::uint32_t f : faces)
            for (const Vec3& corner : surface_.corners(surface_.faces[f].triangle())) box.add(corner);
        return box;
    }

    /// Patches of the same material that share an edge with p, the one whose seed is nearest first.
    std::vector<std::uint32_t> patches_beside(std::uint32_t p) const {
        std::vector<std::pair<double, std::uint32_t>> found;
        const std::uint32_t seed = patches_[p].front();
        for (const std::uint32_t f : patches_[p])
            for (const std::uint32_t next : neighbours(f))
                if (owner_[next] != p && surface_.material[next] == surface_.material[seed])
                    found.emplace_back(length2(centre_[patches_[owner_[next]].front()] - centre_[seed]), owner_[next]);
        std::sort(found.begin(), found.end());
        std::vector<std::uint32_t> result;
        for (const auto& entry : found)
            if (result.empty() || result.back() != entry.second) result.push_back(entry.second);
        return result;
    }

    const Surface& surface_;
    const PatchLimits& limits_;
    const FaceAdjacency& adjacency_;
    Judge judge_;
    std::vector<std::uint32_t> owner_;       // [F] patch, or kNone
    std::vector<std::uint32_t> queued_for_;  // [F] the last patch that looked at the face
    std::vector<Vec3> centre_;               // [F]
    std::deque<std::uint32_t> rim_;          // faces beside finished patches: the next seeds
    std::vector<std::vector<std::uint32_t>> patches_;
};

}  // namespace

PatchGroups make_patches(const Surface& surface, const PatchLimits& limits) {
    const FaceAdjacency adjacency = face_adjacency(surface, limits.cone_cosine);
    const std::vector<std::vector<std::uint32_t>> patches = Growth(surface, limits, adjacency).run();
    PatchGroups groups;
    groups.faces.reserve(surface.faces.size());
    groups.first.push_back(0);
    for (const auto& patch : patches) {
        groups.faces.insert(groups.faces.end(), patch.begin(), patch.end());
        groups.first.push_back(static_cast<std::uint32_t>(groups.faces.size()));
    }
    return groups;
}

}  // namespace rro
