#include <algorithm>
#include <cmath>
#include <numbers>

#include "compiler/archive_diff_parts.h"
#include "compiler/diff_words.h"

namespace rro {
namespace {

/// One of the two kinds of hit probability of an archive.
struct HitTables {
    const Archive* archive;
    std::span<const std::uint8_t> values;  // [Q * H]

    std::size_t lines() const { return archive->data().lines(); }
    std::span<const std::uint8_t> row(std::size_t q) const { return values.subspan(q * lines(), lines()); }
};

HitTables tables_of(const Archive& archive, bool whole) {
    return {&archive, whole ? archive.data().whole_hit : archive.data().intrinsic_hit};
}

/// Of the box of the whole object, over the sphere.
double mean_of_root(const HitTables& tables) {
    const DirectionGrid& grid = tables.archive->grid();
    const std::vector<double> angles = grid.solid_angles();
    double mean = 0;
    for (std::uint32_t node = 0; node < grid.size(); ++node)
        mean += tables.values[grid.line(node)] / 255.0 * angles[node] / (4 * std::numbers::pi);
    return mean;
}

double rms_change(std::span<const std::uint8_t> a, std::span<const std::uint8_t> b) {
    double square = 0;
    for (std::size_t i = 0; i < a.size(); ++i) square += (b[i] - a[i]) / 255.0 * ((b[i] - a[i]) / 255.0);
    return a.empty() ? 0 : std::sqrt(square / static_cast<double>(a.size()));
}

bool same_grid(const ObjectMeta& a, const ObjectMeta& b) {
    return a.grid_map == b.grid_map && a.grid_size == b.grid_size;
}

void compare_root(const HitTables& before, const HitTables& after, const char* kind, const std::string& what,
                  Changes& out) {
    if (same_grid(before.archive->data().meta, after.archive->data().meta) &&
        std::ranges::equal(before.row(0), after.row(0)))
        return;
    const double a = mean_of_root(before), b = mean_of_root(after);
    out.push_back({"tables", kind, what, a, b, {{"relative", relative_change(a, b)}},
                   what + ", mean: " + from_to(a, b) + in_percent(a, b)});
}

/// The volumes below the root, where both store the same ones.
void compare_volumes(const HitTables& before, const HitTables& after, const char* kind, const std::string& what,
                     Changes& out) {
    const auto volumes = before.archive->data().hit_volumes;
    std::uint64_t count = 0;
    double largest = 0;
    std::uint32_t where = 0;
    for (std::size_t q = 1; q < volumes.size(); ++q) {
        const double rms = rms_change(before.row(q), after.row(q));
        if (rms > 0) ++count;
        if (rms > largest) largest = rms, where = volumes[q];
    }
    if (count == 0) return;
    out.push_back({"tables",
                   kind,
                   what,
                   {},
                   {},
                   {{"count", count},
                    {"of", std::uint64_t{volumes.size()}},
                    {"largest_rms", largest},
                    {"largest_volume", std::uint64_t{where}}},
                   what + ": " + std::to_string(count) + " of " + std::to_string(volumes.size()) +
                       " changed; the most: volume " + std::to_string(where) + ", by an RMS of " + number(largest, 2)});
}

void compare_probabilities(const Archive& a, const Archive& b, bool whole, Changes& out) {
    const HitTables before = tables_of(a, whole), after = tables_of(b, whole);
    if (before.values.empty() || after.values.empty()) return;
    compare_root(before, after, whole ? "hit_probability" : "intrinsic_hit_probability",
                 whole ? "hit probability of the object's box" : "intrinsic hit probability of the object's box", out);
    if (same_grid(a.data().meta, b.data().meta) && std::ranges::equal(a.data().hit_volumes, b.data().hit_volumes))
        compare_volumes(before, after, whole ? "hit_probability_of_volumes" : "intrinsic_hit_probability_of_volumes",
                        whole ? "hit probabilities of volumes" : "intrinsic hit probabilities of volumes", out);
}

double mean_coverage(const ObjectData& data) {
    double sum = 0;
    for (const std::uint8_t c : data.atlas_coverage) sum += c / 255.0;
    return sum / static_cast<double>(data.atlas_coverage.size());
}

std::string layout_text(const ObjectData& data) {
    const std::string n = std::to_string(data.atlas_grid_size), m = std::to_string(data.atlas_image_size);
    return n + " x " + n + " directions, " + m + " x " + m + " pixels";
}

std::string sphere_text(const ObjectData& data) {
    const Vec3f& c = data.atlas_centre;
    return number(static_cast<double>(data.atlas_radius), 6) + " m about (" + number(static_cast<double>(c.x), 6) +
           ", " + number(static_cast<double>(c.y), 6) + ", " + number(static_cast<double>(c.z), 6) + ")";
}

}  // namespace

void compare_hits(const Archive& a, const Archive& b, Changes& out) {
    compare_count("tables", "hit_volumes", "volumes with hit probabilities", a.data().hit_volumes.size(), b.data().hit_volumes.size(), out);
    for (const bool whole : {true, false}) compare_probabilities(a, b, whole, out);
}

void compare_atlases(const ObjectData& a, const ObjectData& b, Changes& out) {
    if (a.atlas_coverage.empty() || b.atlas_coverage.empty()) return;
    const auto compare_texts = [&](const char* kind, const std::string& what, const std::string& before,
                                   const std::string& after) {
        if (before != after)
            out.push_back({"tables", kind, what, before, after, {}, what + ": " + before + " -> " + after});
    };
    compare_texts("atlas_layout", "silhouettes", layout_text(a), layout_text(b));
    if (a.atlas_centre != b.atlas_centre || a.atlas_radius != b.atlas_radius)
        out.push_back({"tables", "atlas_sphere", "sphere of the silhouettes", sphere_text(a), sphere_text(b), {},
                       "sphere of the silhouettes: " + sphere_text(a) + " -> " + sphere_text(b)});
    if (a.atlas_coverage.size() != b.atlas_coverage.size() || std::ranges::equal(a.atlas_coverage, b.atlas_coverage))
        return;
    const double before = mean_coverage(a), after = mean_coverage(b);
    const double rms = rms_change(a.atlas_coverage, b.atlas_coverage);
    out.push_back({"tables", "silhouette", "silhouettes", before, after, {{"rms", rms}},
                   "silhouettes: mean share covered " + from_to(before, after) + ", changed by an RMS of " +
                       number(rms, 2) + " over the pixels"});
}

}  // namespace rro
