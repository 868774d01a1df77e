#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <utility>
#include <vector>

#include "format/parallel.h"
#include "format/self_links.h"
#include "format/verifier.h"

namespace rro {
namespace {

std::string number(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.9g", value);
    return text;
}
std::string number(std::uint64_t value) { return std::to_string(value); }
std::string number(std::uint32_t value) { return std::to_string(value); }

bool finite(const Vec3f& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }
bool finite_box(const Vec3f& lo, const Vec3f& hi) {
    return finite(lo) && finite(hi) && lo.x <= hi.x && lo.y <= hi.y && lo.z <= hi.z;
}
// The long arrays are first judged as a whole, in loops without branches; only where something is wrong it is looked for.

/// A float is not finite where all bits of its exponent are set.
bool all_finite(std::span<const Vec3f> positions) {
    constexpr std::uint32_t kExponent = 0x7f800000;
    const auto* floats = reinterpret_cast<const float*>(positions.data());
    std::uint32_t wrong = 0;
    for (std::size_t i = 0; i < 3 * positions.size(); ++i)
        wrong |= (std::bit_cast<std::uint32_t>(floats[i]) & kExponent) == kExponent ? 1u : 0u;
    return wrong == 0;
}

bool all_below(std::span<const std::uint32_t> values, std::uint64_t limit) {
    std::uint32_t largest = 0;
    for (const std::uint32_t value : values) largest = std::max(largest, value);
    return values.empty() || largest < limit;
}

/// The numbers 0 .. limit - 1, none of them twice.
bool all_different(std::span<const std::uint32_t> values, std::uint64_t limit) {
    if (!all_below(values, limit)) return false;
    std::vector<std::uint8_t> seen(limit, 0);
    std::uint8_t twice = 0;
    for (const std::uint32_t value : values) {
        twice |= seen[value];
        seen[value] = 1;
    }
    return twice == 0;
}

/// The words of an array of structures that hold nothing else.
template <class T>
std::span<const std::uint32_t> words_of(std::span<const T> values) {
    return {reinterpret_cast<const std::uint32_t*>(values.data()), values.size_bytes() / 4};
}

bool not_negative(double value) { return std::isfinite(value) && value >= 0; }

/// Light that is reflected for ever has no solution, so 1 is excluded.
bool is_reflectance(const Vec3& v) {
    const auto share = [](double c) { return c >= 0 && c < 1; };
    return share(v.x) && share(v.y) && share(v.z);
}

std::string triple(const Vec3& v) { return "(" + number(v.x) + ", " + number(v.y) + ", " + number(v.z) + ")"; }
std::string triple(const Vec3f& v) { return triple(to_double(v)); }

/// The checks of one section each; a failed one is an error with section and field.
class ContentVerifier {
  public:
    ContentVerifier(const ObjectData& object, const std::string& name) : o_(object), name_(name) {}

    Status meta() const;
    Status mesh() const;
    Status materials() const;
    Status patches() const;
    Status clusters() const;
    Status hbv() const;
    Status area() const;
    Status visibility() const;
    Status errors() const;
    Status source() const;
    Status self_links() const;
    Status hit() const;
    Status atlas() const;

    Status section(Section section) const {
        switch (section) {
            case Section::Meta: return meta();
            case Section::Mesh: return mesh();
            case Section::Materials: return materials();
            case Section::Patches: return patches();
            case Section::Clusters: return clusters();
            case Section::Area: return area();
            case Section::Visibility: return visibility();
            case Section::Errors: return errors();
            case Section::Hbv: return hbv();
            case Section::Source: return source();
            case Section::SelfLinks: return self_links();
            case Section::Hit: return hit();
            case Section::Atlas: return atlas();
        }
        return Done{};
    }

  private:
    Error wrong(const char* section, const std::string& field, const std::string& found,
                const std::string& expected) const {
        return bad_input(name_ + ": section " + section + ": field " + field, "found " + found + ", expected " + expected);
    }
    /// For `array[index].member`.
    Error wrong(const char* section, const char* array, std::size_t index, const char* member, const std::string& found,
                const std::string& expected) const {
        return wrong(section, std::string(array) + "[" + std::to_string(index) + "]" + (*member ? "." : "") + member,
                     found, expected);
    }

    Status cluster_numbers(std::size_t i) const;
    Status cluster_children(std::size_t i) const;
    Status volume_children(std::size_t i, std::size_t end) const;
    Status all_once(const char* section, const char* array, std::span<const std::uint32_t> values, std::uint64_t limit,
                    const char* rule) const;
    Status depth_within_limit(const char* section, const char* array, std::size_t index, std::uint32_t depth) const;
    Status table(const char* values_name, std::size_t values, const char* scale_name, std::span<const float> scale) const;
    Status hit_table(const char* field, std::size_t values) const;
    Status error_bars(const char* field, std::span<const float> values) const;

    const ObjectData& o_;
    const std::string& name_;
};

Status ContentVerifier::meta() const {
    const ObjectMeta& m = o_.meta;
    if (m.grid_map != GridMap::Octahedral && m.grid_map != GridMap::LatLong)
        return wrong("meta", "grid_map", number(static_cast<std::uint32_t>(m.grid_map)), "0 or 1");
    if (m.grid_size < 2 || m.grid_size > layout::kMaxGridSize)
        return wrong("meta", "grid_size", number(m.grid_size), "2 to " + number(layout::kMaxGridSize));
    if (!is_finite(m.bounds.lo)) return wrong("meta", "bounds_lo", triple(m.bounds.lo), "finite numbers");
    if (!is_finite(m.bounds.hi) || m.bounds.empty())
        return wrong("meta", "bounds_hi", triple(m.bounds.hi), "finite numbers, none below those of bounds_lo");
    if (!not_negative(m.area)) return wrong("meta", "area", number(m.area), "a finite number from 0");
    return Done{};
}

Status ContentVerifier::mesh() const {
    const std::size_t vertices = o_.positions.size();
    if (!is_finite(o_.origin)) return wrong("mesh", "origin", triple(o_.origin), "finite numbers");
    if (!all_finite(o_.positions)) {
        const auto at = std::find_if_not(o_.positions.begin(), o_.positions.end(), finite);
        return wrong("mesh", "positions", static_cast<std::size_t>(at - o_.positions.begin()), "", triple(*at),
                     "finite numbers");
    }
    if (const auto corners = words_of(o_.triangles); !all_below(corners, vertices)) {
        const auto at = std::find_if(corners.begin(), corners.end(), [&](std::uint32_t c) { return c >= vertices; });
        return wrong("mesh", "triangles", static_cast<std::size_t>(at - corners.begin()) / 3, "", "vertex " + number(*at),
                     "one below " + number(vertices));
    }
    return all_once("mesh", "faces", words_of(o_.faces), 2 * std::uint64_t{o_.triangles.size()}, "each side once");
}

Status ContentVerifier::source() const {
    const std::size_t triangles = o_.triangles.size();
    if (o_.source_triangle.size() != triangles)
        return wrong("source", "triangles", number(o_.source_triangle.size()) + " numbers",
                     number(triangles) + ", one per triangle");
    if (triangles > o_.meta.source_triangles)
        return wrong("source", "triangles", number(triangles) + " triangles",
                     "at most meta.source_triangles, " + number(o_.meta.source_triangles));
    if (all_below(o_.source_triangle, o_.meta.source_triangles)) return Done{};
    const auto at = std::max_element(o_.source_triangle.begin(), o_.source_triangle.end());
    return wrong("source", "triangles", static_cast<std::size_t>(at - o_.source_triangle.begin()), "", number(*at),
                 "a number below meta.source_triangles, " + number(o_.meta.source_triangles));
}

Status ContentVerifier::all_once(const char* section, const char* array, std::span<const std::uint32_t> values,
                                 std::uint64_t limit, const char* rule) const {
    if (all_different(values, limit)) return Done{};
    std::vector<bool> seen(limit, false);
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (values[i] >= limit)
            return wrong(section, array, i, "", number(values[i]), "a number below " + number(limit));
        if (seen[values[i]]) return wrong(section, array, i, "", number(values[i]) + " again", rule);
        seen[values[i]] = true;
    }
    return Done{};
}

Status ContentVerifier::materials() const {
    for (std::size_t i = 0; i < o_.materials.size(); ++i) {
        const Material& m = o_.materials[i];
        if (!is_reflectance(m.reflectance))
            return wrong("materials", "materials", i, "reflectance", triple(m.reflectance), "numbers in [0, 1)");
        if (!not_negative(m.exitance.x) || !not_negative(m.exitance.y) || !not_negative(m.exitance.z))
            return wrong("materials", "materials", i, "exitance", triple(m.exitance), "finite numbers from 0");
    }
    return Done{};
}

/// Patches tile the faces in order.
Status ContentVerifier::patches() const {
    if (o_.patches.empty()) return wrong("patches", "patches", "none", "at least one");
    std::uint64_t next_face = 0;
    for (std::size_t i = 0; i < o_.patches.size(); ++i) {
        const Patch& p = o_.patches[i];
        if (p.first_face != next_face)
            return wrong("patches", "patches", i, "first_face", number(p.first_face),
                         number(next_face) + ", where the patch before it ends");
        next_face += p.face_count;
        if (p.face_count == 0 || next_face > o_.faces.size())
            return wrong("patches", "patches", i, "face_count", number(p.face_count),
                         "1 to " + number(o_.faces.size() - p.first_face));
        if (p.material >= o_.materials.size())
            return wrong("patches", "patches", i, "material", number(p.material),
                         "a number below " + number(o_.materials.size()));
        if (!not_negative(p.area)) return wrong("patches", "patches", i, "area", number(p.area), "a finite number from 0");
        if (!is_reflectance(to_double(p.reflectance)))
            return wrong("patches", "patches", i, "reflectance", triple(p.reflectance), "numbers in [0, 1)");
        if (!finite(p.centre)) return wrong("patches", "patches", i, "centre", triple(p.centre), "finite numbers");
        if (!finite(p.normal)) return wrong("patches", "patches", i, "normal", triple(p.normal), "finite numbers");
        if (!std::isfinite(p.cone_cosine))
            return wrong("patches", "patches", i, "cone_cosine", number(p.cone_cosine), "a finite number");
    }
    if (next_face != o_.faces.size())
        return wrong("patches", "patches", "patches of " + number(next_face) + " faces",
                     "all " + number(o_.faces.size()) + " of mesh.faces");
    return Done{};
}

Status ContentVerifier::cluster_numbers(std::size_t i) const {
    const Cluster& c = o_.clusters[i];
    if (!not_negative(c.area)) return wrong("clusters", "clusters", i, "area", number(c.area), "a finite number from 0");
    if (!not_negative(c.radius))
        return wrong("clusters", "clusters", i, "radius", number(c.radius), "a finite number from 0");
    if (!finite_box(c.lo, c.hi))
        return wrong("clusters", "clusters", i, "hi", triple(c.hi), "finite numbers, none below lo, " + triple(c.lo));
    if (!finite(c.normal)) return wrong("clusters", "clusters", i, "normal", triple(c.normal), "finite numbers");
    if (!std::isfinite(c.cone_cosine))
        return wrong("clusters", "clusters", i, "cone_cosine", number(c.cone_cosine), "a finite number");
    return Done{};
}

/// A cluster whose own range has been checked: are its children where preorder puts them, and do they share its patches?
/// A subtree of p patches takes 2p - 1 records, so the left child's count says where the right child is.
Status ContentVerifier::cluster_children(std::size_t i) const {
    const Cluster& c = o_.clusters[i];
    if (c.patch_count == 1) {
        if (c.right_child != 0)
            return wrong("clusters", "clusters", i, "right_child", number(c.right_child), "0, as it is one patch");
        return Done{};
    }
    const Cluster& left = o_.clusters[i + 1];
    if (left.first_patch != c.first_patch)
        return wrong("clusters", "clusters", i + 1, "first_patch", number(left.first_patch),
                     number(c.first_patch) + ", as for the cluster above");
    if (left.patch_count == 0 || left.patch_count >= c.patch_count)
        return wrong("clusters", "clusters", i + 1, "patch_count", number(left.patch_count),
                     "1 to " + number(c.patch_count - 1) + ", a part of the cluster above");
    const std::size_t right = i + 2 * std::size_t{left.patch_count};
    if (c.right_child != right)
        return wrong("clusters", "clusters", i, "right_child", number(c.right_child),
                     number(right) + ", after all clusters of the left child");
    if (o_.clusters[right].first_patch != c.first_patch + left.patch_count)
        return wrong("clusters", "clusters", right, "first_patch", number(o_.clusters[right].first_patch),
                     number(c.first_patch + left.patch_count) + ", where its left sibling ends");
    if (o_.clusters[right].patch_count != c.patch_count - left.patch_count)
        return wrong("clusters", "clusters", right, "patch_count", number(o_.clusters[right].patch_count),
                     number(c.patch_count - left.patch_count) + ", the rest of the cluster above");
    return Done{};
}

Status ContentVerifier::clusters() const {
    const std::uint64_t expected = 2 * std::uint64_t{o_.patches.size()} - 1;
    if (o_.clusters.size() != expected)
        return wrong("clusters", "clusters", number(o_.clusters.size()) + " clusters",
                     number(expected) + ", 2 P - 1 of " + number(o_.patches.size()) + " patches");
    const Cluster& root = o_.clusters[0];
    if (root.first_patch != 0) return wrong("clusters", "clusters", 0, "first_patch", number(root.first_patch), "0");
    if (root.patch_count != o_.patches.size())
        return wrong("clusters", "clusters", 0, "patch_count", number(root.patch_count),
                     "all " + number(o_.patches.size()));
    std::vector<std::uint32_t> depth(o_.clusters.size(), 1);  // parents come before their children
    for (std::size_t i = 0; i < o_.clusters.size(); ++i) {
        if (auto checked = cluster_numbers(i); !checked) return checked;
        if (auto checked = cluster_children(i); !checked) return checked;
        if (auto checked = depth_within_limit("clusters", "clusters", i, depth[i]); !checked) return checked;
        if (o_.clusters[i].right_child != 0) depth[i + 1] = depth[o_.clusters[i].right_child] = depth[i] + 1;
    }
    return Done{};
}

Status ContentVerifier::depth_within_limit(const char* section, const char* array, std::size_t index,
                                           std::uint32_t depth) const {
    if (depth <= layout::kMaxTreeDepth) return Done{};
    return wrong(section, array, index, "", "a tree " + number(depth) + " levels deep",
                 "at most " + number(layout::kMaxTreeDepth));
}

/// As for clusters, but a leaf may hold several triangles, so `end`, where the subtree ends, is carried along.
Status ContentVerifier::volume_children(std::size_t i, std::size_t end) const {
    const Volume& v = o_.volumes[i];
    if (v.right_child <= i + 1 || v.right_child >= end)
        return wrong("hbv", "volumes", i, "right_child", number(v.right_child),
                     number(i + 2) + " to " + number(end - 1) + ", or 0 for a leaf, which is alone in its subtree");
    const Volume& left = o_.volumes[i + 1];
    const Volume& right = o_.volumes[v.right_child];
    if (left.first != v.first)
        return wrong("hbv", "volumes", i + 1, "first", number(left.first), number(v.first) + ", as for the volume above");
    if (left.count == 0 || left.count >= v.count)
        return wrong("hbv", "volumes", i + 1, "count", number(left.count),
                     "1 to " + number(v.count - 1) + ", a part of the volume above");
    if (right.first != v.first + left.count)
        return wrong("hbv", "volumes", v.right_child, "first", number(right.first),
                     number(v.first + left.count) + ", where its left sibling ends");
    if (right.count != v.count - left.count)
        return wrong("hbv", "volumes", v.right_child, "count", number(right.count),
                     number(v.count - left.count) + ", the rest of the volume above");
    return Done{};
}

Status ContentVerifier::hbv() const {
    const std::size_t triangles = o_.triangles.size();
    if (o_.volumes.empty() && o_.volume_triangles.empty()) return Done{};
    if (o_.volumes.empty()) return wrong("hbv", "volumes", "none", "at least one");
    if (o_.volume_triangles.size() != triangles)
        return wrong("hbv", "triangles", number(o_.volume_triangles.size()) + " numbers",
                     number(triangles) + ", one per triangle");
    if (auto checked = all_once("hbv", "triangles", o_.volume_triangles, triangles, "each triangle once"); !checked)
        return checked;
    if (o_.volumes[0].first != 0) return wrong("hbv", "volumes", 0, "first", number(o_.volumes[0].first), "0");
    if (o_.volumes[0].count != triangles)
        return wrong("hbv", "volumes", 0, "count", number(o_.volumes[0].count), "all " + number(triangles));

    std::vector<std::uint32_t> depth(o_.volumes.size(), 1);
    std::vector<std::size_t> ends{o_.volumes.size()};  // of the subtrees that are still to come
    for (std::size_t i = 0; i < o_.volumes.size(); ++i) {
        const Volume& v = o_.volumes[i];
        if (!finite_box(v.lo, v.hi))
            return wrong("hbv", "volumes", i, "hi", triple(v.hi), "finite numbers, none below lo, " + triple(v.lo));
        if (auto checked = depth_within_limit("hbv", "volumes", i, depth[i]); !checked) return checked;
        const std::size_t end = ends.back();
        ends.pop_back();
        if (v.right_child == 0 && end == i + 1) continue;
        if (auto checked = volume_children(i, end); !checked) return checked;
        depth[i + 1] = depth[v.right_child] = depth[i] + 1;
        ends.push_back(end);
        ends.push_back(v.right_child);
    }
    return Done{};
}

/// A table per stored cluster with its scale, or none at all.
Status ContentVerifier::table(const char* values_name, std::size_t values, const char* scale_name,
                              std::span<const float> scale) const {
    if (values == 0 && scale.empty()) return Done{};
    const std::uint64_t stored = o_.area_clusters.size();
    if (scale.size() != stored)
        return wrong("area", scale_name, number(scale.size()) + " numbers", number(stored) + ", one per stored cluster");
    if (values != stored * o_.directions())
        return wrong("area", values_name, number(std::uint64_t{values}) + " bytes",
                     number(stored * o_.directions()) + ", " + number(o_.directions()) + " per stored cluster");
    for (std::size_t k = 0; k < scale.size(); ++k)
        if (!not_negative(scale[k])) return wrong("area", scale_name, k, "", number(scale[k]), "a finite number from 0");
    return Done{};
}

Status ContentVerifier::area() const {
    for (std::size_t k = 0; k < o_.area_clusters.size(); ++k) {
        const std::uint32_t c = o_.area_clusters[k];
        if (c >= o_.clusters.size())
            return wrong("area", "clusters", k, "", number(c), "a number below " + number(o_.clusters.size()));
        if (k > 0 && c <= o_.area_clusters[k - 1])
            return wrong("area", "clusters", k, "", number(c), "more than the one before it, " +
                                                                   number(o_.area_clusters[k - 1]));
    }
    if (auto checked = table("whole", o_.whole_area.size(), "whole_scale", o_.whole_area_scale); !checked) return checked;
    return table("intrinsic", o_.intrinsic_area.size(), "intrinsic_scale", o_.intrinsic_area_scale);
}

Status ContentVerifier::visibility() const {
    const std::uint64_t expected = std::uint64_t{o_.patches.size()} * o_.directions();
    if (o_.visibility.empty() || o_.visibility.size() == expected) return Done{};
    return wrong("visibility", "visibility", number(o_.visibility.size()) + " bytes",
                 number(expected) + ", " + number(o_.directions()) + " per patch");
}

/// One number per stored cluster, or none at all.
Status ContentVerifier::error_bars(const char* field, std::span<const float> values) const {
    if (!values.empty() && values.size() != o_.area_clusters.size())
        return wrong("errors", field, number(std::uint64_t{values.size()}) + " numbers",
                     number(std::uint64_t{o_.area_clusters.size()}) + ", one per cluster with areas");
    for (std::size_t k = 0; k < values.size(); ++k)
        if (!not_negative(values[k]))
            return wrong("errors", field, k, "", number(values[k]), "a finite number from 0");
    return Done{};
}

Status ContentVerifier::errors() const {
    if (auto checked = error_bars("whole", o_.whole_area_error); !checked) return checked;
    if (auto checked = error_bars("intrinsic", o_.intrinsic_area_error); !checked) return checked;
    return error_bars("visibility", o_.visibility_error);
}

Status ContentVerifier::self_links() const {
    const std::size_t links = o_.self_exchange.size();
    for (std::size_t k = 0; k < links; ++k)
        if (!not_negative(o_.self_exchange[k]))
            return wrong("selflinks", "exchange", k, "", number(o_.self_exchange[k]), "a finite number from 0");
    if (o_.self_visibility.size() != links)
        return wrong("selflinks", "visibility", number(std::uint64_t{o_.self_visibility.size()}) + " bytes",
                     number(std::uint64_t{links}) + ", one per link");
    for (const auto& [field, shares] : {std::pair{"escape", o_.self_escape}, std::pair{"received", o_.self_received},
                                        std::pair{"black", o_.self_black}}) {
        if (!shares.empty() && shares.size() != o_.patches.size())
            return wrong("selflinks", field, number(std::uint64_t{shares.size()}) + " numbers",
                         number(std::uint64_t{o_.patches.size()}) + ", one per patch");
        for (std::size_t p = 0; p < shares.size(); ++p)
            if (!not_negative(shares[p]))
                return wrong("selflinks", field, p, "", number(shares[p]), "a finite number from 0");
    }
    if (const auto fault = check_self_pairs(o_))
        return wrong("selflinks", "steps", fault->step, "", fault->found, fault->expected);
    return Done{};
}

/// A table per stored volume.
Status ContentVerifier::hit_table(const char* field, std::size_t values) const {
    const std::uint64_t expected = std::uint64_t{o_.hit_volumes.size()} * o_.lines();
    if (values == expected) return Done{};
    return wrong("hit", field, number(std::uint64_t{values}) + " bytes",
                 number(expected) + ", " + number(o_.lines()) + " per stored volume");
}

/// Runs beside the check of `hbv`, whose numbers may be wrong.
Status ContentVerifier::hit() const {
    std::vector<bool> stored(o_.volumes.size(), false);
    for (std::size_t q = 0; q < o_.hit_volumes.size(); ++q) {
        const std::uint32_t v = o_.hit_volumes[q];
        if (v >= o_.volumes.size())
            return wrong("hit", "volumes", q, "", number(v), "a number below " + number(o_.volumes.size()));
        if (q > 0 && v <= o_.hit_volumes[q - 1])
            return wrong("hit", "volumes", q, "", number(v),
                         "more than the one before it, " + number(o_.hit_volumes[q - 1]));
        stored[v] = true;
    }
    std::vector<std::uint32_t> above(o_.volumes.size(), 0);
    for (std::uint32_t v = 0; v < o_.volumes.size(); ++v) {
        const std::uint32_t right = o_.volumes[v].right_child;
        if (right > v && right < o_.volumes.size()) above[v + 1] = above[right] = v;
    }
    for (std::size_t q = 0; q < o_.hit_volumes.size(); ++q)
        if (const std::uint32_t v = o_.hit_volumes[q]; !stored[above[v]])
            return wrong("hit", "volumes", q, "", number(v) + " without " + number(above[v]),
                         "with a volume the one above it");
    if (auto checked = hit_table("whole", o_.whole_hit.size()); !checked) return checked;
    return o_.intrinsic_hit.empty() ? Status(Done{}) : hit_table("intrinsic", o_.intrinsic_hit.size());
}

Status ContentVerifier::atlas() const {
    const std::uint32_t n = o_.atlas_grid_size, m = o_.atlas_image_size;
    if (n == 0 && m == 0 && o_.atlas_coverage.empty()) return Done{};
    if (!finite(o_.atlas_centre)) return wrong("atlas", "centre", triple(o_.atlas_centre), "finite numbers");
    if (!(not_negative(o_.atlas_radius) && o_.atlas_radius > 0))
        return wrong("atlas", "radius", number(o_.atlas_radius), "a finite number above 0");
    if (n < 2 || n > layout::kMaxGridSize || n % 2 != 0)
        return wrong("atlas", "grid_size", number(n), "an even number from 2 to " + number(layout::kMaxGridSize));
    if (m < 1 || m > layout::kMaxAtlasImageSize)
        return wrong("atlas", "image_size", number(m), "1 to " + number(layout::kMaxAtlasImageSize));
    const std::uint64_t expected = std::uint64_t{n} * n / 2 * m * m;
    if (o_.atlas_coverage.size() != expected)
        return wrong("atlas", "coverage", number(std::uint64_t{o_.atlas_coverage.size()}) + " bytes",
                     number(expected) + ", " + number(m) + " x " + number(m) + " per line");
    return Done{};
}

}  // namespace

Status verify_content(const ObjectData& object, SectionSet present, const std::string& name) {
    const ContentVerifier verifier(object, name);
    std::vector<Status> checked(kSectionKinds, Done{});
    parallel_for(kSectionKinds, 1, [&](std::size_t i) {
        if (present.has(static_cast<Section>(i))) checked[i] = verifier.section(static_cast<Section>(i));
    });
    for (Status& status : checked)
        if (!status) return std::move(status);
    return Done{};
}

}  // namespace rro
