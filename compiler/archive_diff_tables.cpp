#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

#include "compiler/archive_diff_parts.h"
#include "compiler/archive_facts.h"
#include "compiler/diff_words.h"

namespace rro {
namespace {

constexpr double kSphere = 4 * std::numbers::pi;

std::string directions_text(const ObjectMeta& meta) {
    return std::to_string(meta.grid_size) + " x " + std::to_string(meta.grid_size) + " " + map_name(meta.grid_map);
}

bool same_grid(const ObjectMeta& a, const ObjectMeta& b) {
    return a.grid_map == b.grid_map && a.grid_size == b.grid_size;
}

void compare_settings(const ObjectData& a, const ObjectData& b, Changes& out) {
    if (!same_grid(a.meta, b.meta))
        out.push_back({"tables",
                       "grid",
                       "directions",
                       directions_text(a.meta),
                       directions_text(b.meta),
                       {},
                       "directions: " + directions_text(a.meta) + " -> " + directions_text(b.meta) +
                           "; tables are compared by their means"});
    compare_count("tables", "image_resolution", "pixels along an image", a.meta.image_resolution, b.meta.image_resolution, out);
    compare_count("tables", "area_clusters", "clusters with areas", a.area_clusters.size(), b.area_clusters.size(), out);
}

/// One of the two kinds of effective area of an archive.
struct AreaTables {
    std::span<const std::uint8_t> values;  // [K * D]
    std::span<const float> scale;          // [K]
    std::size_t directions;

    double value(std::size_t row, std::size_t direction) const {
        return values[row * directions + direction] * static_cast<double>(scale[row]) / 255;
    }
    bool same_row(const AreaTables& other, std::size_t row) const {
        return scale[row] == other.scale[row] &&
               std::memcmp(values.data() + row * directions, other.values.data() + row * directions, directions) == 0;
    }
};

AreaTables tables_of(const ObjectData& data, bool whole) {
    return whole ? AreaTables{data.whole_area, data.whole_area_scale, data.directions()}
                 : AreaTables{data.intrinsic_area, data.intrinsic_area_scale, data.directions()};
}

/// Over the sphere, each node by its solid angle.
double mean_over(const DirectionGrid& grid, const AreaTables& tables, std::size_t row) {
    const std::vector<double> angles = grid.solid_angles();
    double mean = 0;
    for (std::uint32_t d = 0; d < grid.size(); ++d) mean += tables.value(row, d) * angles[d] / kSphere;
    return mean;
}

/// angles   solid angles of the nodes
double rms_over(std::span<const double> angles, const AreaTables& a, const AreaTables& b, std::size_t row) {
    double square = 0;
    for (std::uint32_t d = 0; d < angles.size(); ++d) {
        const double change = b.value(row, d) - a.value(row, d);
        square += change * change * angles[d] / kSphere;
    }
    return std::sqrt(square);
}

bool has_root(const ObjectData& data) {
    return !data.area_clusters.empty() && data.area_clusters.front() == 0;
}

/// RMS and largest change over one grid.
void add_spread(const DirectionGrid& grid, const AreaTables& a, const AreaTables& b, double mean, Change& change) {
    std::uint32_t where = 0;
    const auto change_at = [&](std::uint32_t d) { return b.value(0, d) - a.value(0, d); };
    for (std::uint32_t d = 1; d < grid.size(); ++d)
        if (std::abs(change_at(d)) > std::abs(change_at(where))) where = d;
    const double rms = rms_over(grid.solid_angles(), a, b, 0), largest = change_at(where);
    const Vec3& w = grid.direction(where);
    change.more.insert(change.more.end(), {{"rms", rms},
                                           {"rms_relative", mean > 0 ? DiffValue(rms / mean) : DiffValue()},
                                           {"largest", largest},
                                           {"largest_direction", w}});
    change.text +=
        "; RMS change " + (mean > 0 ? number(100 * rms / mean, 3) + " % of the mean" : number(rms, 2) + " m^2");
    change.text += ", largest " + std::string(largest > 0 ? "+" : "") + number(largest, 2) + " m^2 seen from (" +
                   number(w.x, 2) + ", " + number(w.y, 2) + ", " + number(w.z, 2) + ")";
}

/// The areas of the whole object: those of the root cluster.
void compare_root(const Archive& a, const Archive& b, bool whole, Changes& out) {
    const ObjectData &da = a.data(), &db = b.data();
    if (!has_root(da) || !has_root(db)) return;
    const AreaTables before = tables_of(da, whole), after = tables_of(db, whole);
    if (before.values.empty() || after.values.empty()) return;
    const bool comparable = same_grid(da.meta, db.meta);
    if (comparable && before.same_row(after, 0)) return;
    const double mean_a = mean_over(a.grid(), before, 0), mean_b = mean_over(b.grid(), after, 0);
    const std::string what = whole ? "effective area of the object" : "intrinsic area of the object";
    Change change{"tables",
                  whole ? "whole_area" : "intrinsic_area",
                  what,
                  mean_a,
                  mean_b,
                  {{"relative", relative_change(mean_a, mean_b)}},
                  ", mean: " + from_to(mean_a, mean_b) + " m^2" + in_percent(mean_a, mean_b)};
    if (comparable) add_spread(a.grid(), before, after, mean_a, change);
    const bool likewise = !out.empty() && out.back().kind == "whole_area" && out.back().text.ends_with(change.text);
    change.text = what + (likewise ? ": likewise" : change.text);
    out.push_back(std::move(change));
}

/// The areas of all clusters but the root.
void compare_clusters(const Archive& a, const Archive& b, bool whole, Changes& out) {
    const ObjectData& da = a.data();
    const AreaTables before = tables_of(da, whole), after = tables_of(b.data(), whole);
    if (before.values.empty() || after.values.empty()) return;
    const std::vector<double> angles = a.grid().solid_angles();
    std::uint64_t count = 0;
    double largest = 0;
    std::uint32_t where = 0;
    for (std::size_t row = 0; row < da.area_clusters.size(); ++row) {
        const Cluster& cluster = da.clusters[da.area_clusters[row]];
        if (da.area_clusters[row] == 0 || before.same_row(after, row)) continue;
        ++count;
        const double rms = rms_over(angles, before, after, row);
        if (const double relative = cluster.area > 0 ? rms / static_cast<double>(cluster.area) : 0;
            relative > largest) {
            largest = relative;
            where = da.area_clusters[row];
        }
    }
    if (count == 0) return;
    const std::string what = whole ? "effective areas of clusters" : "intrinsic areas of clusters";
    out.push_back({"tables",
                   whole ? "whole_area_of_clusters" : "intrinsic_area_of_clusters",
                   what,
                   {},
                   {},
                   {{"count", count},
                    {"of", std::uint64_t{da.area_clusters.size()}},
                    {"largest_rms_relative", largest},
                    {"largest_cluster", std::uint64_t{where}}},
                   what + ": " + std::to_string(count) + " of " + std::to_string(da.area_clusters.size()) +
                       " changed; the most: cluster " + std::to_string(where) + ", RMS change " +
                       number(100 * largest, 2) + " % of its surface"});
}

/// Shares of patches that are seen, for the patches that both have; each by its area and the direction's solid angle.
void compare_visibility(const Archive& a, const Archive& b, const TreeMatch& trees, Changes& out) {
    const ObjectData &da = a.data(), &db = b.data();
    if (da.visibility.empty() || db.visibility.empty()) return;
    const std::size_t directions = da.directions();
    const std::vector<double> angles = a.grid().solid_angles();
    double square = 0, area = 0;
    std::uint64_t count = 0;
    for (std::size_t p = 0; p < da.patches.size(); ++p) {
        if (trees.patch_in_b[p] == kNoPatch) continue;
        const auto before = da.visibility.subspan(p * directions, directions);
        const auto after = db.visibility.subspan(trees.patch_in_b[p] * directions, directions);
        const auto weight = static_cast<double>(da.patches[p].area);
        area += weight;
        if (std::ranges::equal(before, after)) continue;
        ++count;
        for (std::uint32_t d = 0; d < directions; ++d) {
            const double change = (after[d] - before[d]) / 255.0;
            square += change * change * weight * angles[d] / kSphere;
        }
    }
    if (count == 0) return;
    const double rms = area > 0 ? std::sqrt(square / area) : 0;
    out.push_back({"tables",
                   "visibility",
                   "visibility of patches",
                   {},
                   {},
                   {{"count", count}, {"of", std::uint64_t{trees.matched}}, {"rms", rms}},
                   "visibility: " + std::to_string(count) + " of " + std::to_string(trees.matched) +
                       " patches changed, by an RMS of " + number(rms, 2) +
                       " over surface and directions (0: hidden, 1: seen)"});
}

/// The measured error of one kind of table for the object as a whole.
void compare_error(const char* kind, const std::string& what, std::span<const float> before,
                   std::span<const float> after, Changes& out) {
    if (before.empty() || after.empty() || before[0] == after[0]) return;
    const auto from = static_cast<double>(before[0]), to = static_cast<double>(after[0]);
    out.push_back({"tables", kind, what, from, to, {},
                   what + " between the grid's directions: " + number(100 * from, 3) + " -> " + number(100 * to, 3) + " %"});
}

}  // namespace

void compare_tables(const Archive& a, const Archive& b, const TreeMatch& trees, Changes& out) {
    const ObjectData &da = a.data(), &db = b.data();
    compare_settings(da, db, out);
    for (const bool whole : {true, false}) compare_root(a, b, whole, out);
    compare_error("whole_area_error", "error of the effective area", da.whole_area_error, db.whole_area_error, out);
    compare_error("intrinsic_area_error", "error of the intrinsic area", da.intrinsic_area_error, db.intrinsic_area_error,
                  out);
    compare_error("visibility_error", "error of the patches' seen areas", da.visibility_error, db.visibility_error, out);
    if (!same_grid(da.meta, db.meta)) return;
    if (trees.same_clusters && std::ranges::equal(da.area_clusters, db.area_clusters))
        for (const bool whole : {true, false}) compare_clusters(a, b, whole, out);
    compare_visibility(a, b, trees, out);
}

}  // namespace rro
