// The content of a small valid archive, filled by hand: a closed box of 12 one-sided triangles, two per wall.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "format/object_data.h"

namespace rro::test {

/// An object with the vectors that its views point into. Fill the vectors, then call data().
struct TinyObject {
    ObjectMeta meta;
    std::vector<Material> materials;
    Vec3 origin;
    std::vector<Vec3f> positions;
    std::vector<TriangleIndices> triangles;
    std::vector<std::uint32_t> source_triangle;
    std::vector<Face> faces;
    std::vector<Patch> patches;
    std::vector<Cluster> clusters;
    std::vector<Volume> volumes;
    std::vector<std::uint32_t> volume_triangles;
    std::vector<std::uint32_t> area_clusters;
    std::vector<std::uint8_t> whole_area, intrinsic_area, visibility;
    std::vector<float> whole_area_scale, intrinsic_area_scale;
    std::uint32_t error_directions = 0;
    std::vector<float> whole_area_error, intrinsic_area_error, visibility_error;
    std::vector<std::uint32_t> hit_volumes;
    std::vector<std::uint8_t> whole_hit, intrinsic_hit;
    Vec3f atlas_centre;
    float atlas_radius = 0;
    std::uint32_t atlas_grid_size = 0, atlas_image_size = 0;
    std::vector<std::uint8_t> atlas_coverage;
    std::vector<std::uint8_t> self_steps, self_visibility;
    std::vector<float> self_exchange, self_escape, self_received, self_black;

    /// Views of the vectors as they are now.
    ObjectData data() const {
        ObjectData d;
        d.meta = meta;
        d.materials = materials;
        d.origin = origin;
        d.positions = positions;
        d.triangles = triangles;
        d.source_triangle = source_triangle;
        d.faces = faces;
        d.patches = patches;
        d.clusters = clusters;
        d.volumes = volumes;
        d.volume_triangles = volume_triangles;
        d.area_clusters = area_clusters;
        d.whole_area = whole_area;
        d.whole_area_scale = whole_area_scale;
        d.intrinsic_area = intrinsic_area;
        d.intrinsic_area_scale = intrinsic_area_scale;
        d.visibility = visibility;
        d.error_directions = error_directions;
        d.whole_area_error = whole_area_error;
        d.intrinsic_area_error = intrinsic_area_error;
        d.visibility_error = visibility_error;
        d.hit_volumes = hit_volumes;
        d.whole_hit = whole_hit;
        d.intrinsic_hit = intrinsic_hit;
        d.atlas_centre = atlas_centre;
        d.atlas_radius = atlas_radius;
        d.atlas_grid_size = atlas_grid_size;
        d.atlas_image_size = atlas_image_size;
        d.atlas_coverage = atlas_coverage;
        d.self_steps = self_steps;
        d.self_exchange = self_exchange;
        d.self_visibility = self_visibility;
        d.self_escape = self_escape;
        d.self_received = self_received;
        d.self_black = self_black;
        return d;
    }
};

/// Corners of wall `w` of the box [0, size]: two triangles (0 1 2), (0 2 3), counter-clockwise from outside. Wall
/// 2 * axis is the one at 0, 2 * axis + 1 the one at `size`. Corner bit 0, 1, 2 = x, y, z.
inline std::array<std::uint32_t, 4> wall_corners(std::uint32_t w) {
    const std::uint32_t axis = w / 2, u = 1u << (axis + 1) % 3, v = 1u << (axis + 2) % 3, base = (w % 2) << axis;
    if (w % 2) return {base, base | u, base | u | v, base | v};
    return {base, base | v, base | u | v, base | u};
}

/// Preorder cluster tree over the patches [first, first + count), halved at each node; every cluster has the box's
/// bounds.
inline void add_clusters(TinyObject& o, std::uint32_t first, std::uint32_t count, const Vec3f& size) {
    const auto self = o.clusters.size();
    Cluster c{};
    c.first_patch = first;
    c.patch_count = count;
    for (std::uint32_t p = first; p < first + count; ++p) c.area += o.patches[p].area;
    c.hi = size;
    c.radius = static_cast<float>(0.5 * length(to_double(size)));
    c.cone_cosine = -1;
    o.clusters.push_back(c);
    if (count == 1) {
        o.clusters[self].normal = o.patches[first].normal;
        o.clusters[self].cone_cosine = 1;
        return;
    }
    add_clusters(o, first, count / 2, size);
    o.clusters[self].right_child = static_cast<std::uint32_t>(o.clusters.size());
    add_clusters(o, first + count / 2, count - count / 2, size);
}

/// The box [origin, origin + size] with six patches (one per wall, materials alternating), a cluster tree, an HBV of
/// three volumes, area tables of the root and its left child with error bars, full visibility, and hit probabilities of
/// two volumes, over a `grid_size`^2 grid; an atlas of two lines of 2 x 2 pixels; three self links,
/// of walls 0 with the three far ones, 1 with 3, and the three far ones with one another.
inline TinyObject tiny_object(std::uint32_t grid_size = 3, const Vec3& origin = {}) {
    const Vec3f size{1, 2, 3};
    TinyObject o;
    o.origin = origin;
    o.materials = {{"walls", {0.5, 0.25, 0.125}, {}, false}, {"lamp", {0, 0, 0}, {20, 18, 15.5}, true}};
    for (std::uint32_t i = 0; i < 8; ++i)
        o.positions.push_back({i & 1 ? size.x : 0, i & 2 ? size.y : 0, i & 4 ? size.z : 0});
    for (std::uint32_t w = 0; w < 6; ++w) {
        const auto [a, b, c, d] = wall_corners(w);
        o.triangles.insert(o.triangles.end(), {{a, b, c}, {a, c, d}});
        o.faces.insert(o.faces.end(), {Face::make(2 * w, Side::Front), Face::make(2 * w + 1, Side::Front)});
        const auto at = [&](std::uint32_t corner) { return to_double(o.positions[corner]); };
        const Vec3 area = area_vector(at(a), at(b), at(c)) + area_vector(at(a), at(c), at(d));
        const Material& material = o.materials[w % 2];
        o.patches.push_back({2 * w, 2, w % 2, static_cast<float>(length(area)), to_float(material.reflectance),
                             to_float(0.5 * (at(a) + at(c))), to_float(normalised(area)), 1});
    }
    for (std::uint32_t t = 0; t < 12; ++t) {
        o.source_triangle.push_back(t + 1);  // number 0 of the source was dropped
        o.volume_triangles.push_back(11 - t);
    }
    add_clusters(o, 0, 6, size);
    o.volumes = {{{}, size, 0, 12, 2}, {{}, size, 0, 5, 0}, {{}, size, 5, 7, 0}};

    const std::uint32_t directions = grid_size * grid_size;
    o.area_clusters = {0, 1};
    o.whole_area_scale = {7.5f, 3.0f};
    o.intrinsic_area_scale = {7.5f, 4.0f};
    for (std::uint32_t i = 0; i < 2 * directions; ++i) {
        o.whole_area.push_back(static_cast<std::uint8_t>(i));
        o.intrinsic_area.push_back(static_cast<std::uint8_t>(255 - i));
    }
    o.visibility.assign(6 * std::size_t{directions}, 255);
    o.error_directions = 24;
    o.whole_area_error = {0.0625f, 0.125f};
    o.intrinsic_area_error = {0.03125f, 0.25f};
    o.visibility_error = {0, 0.5f};
    const std::uint32_t lines = directions % 2 == 0 ? directions / 2 : directions;
    o.hit_volumes = {0, 2};
    o.whole_hit.assign(2 * std::size_t{lines}, 255);
    for (std::uint32_t i = 0; i < 2 * lines; ++i) o.intrinsic_hit.push_back(static_cast<std::uint8_t>(255 - i));
    o.atlas_centre = {0.5f, 1, 1.5f};
    o.atlas_radius = 1.875f;
    o.atlas_grid_size = o.atlas_image_size = 2;
    o.atlas_coverage = {0, 16, 32, 255, 64, 80, 96, 112};

    o.self_steps = {4, 0, 2, 1, 3, 1, 0, 1};
    o.self_exchange = {0.5f, 0.25f, 1.5f};
    o.self_visibility = {255, 128, 0};
    o.self_escape = {1, 0.5f, 0.75f, 0.25f, 0, 0.125f};
    o.self_received = {0, 0.5f, 0.25f, 0.5f, 1, 0.375f};
    o.self_black = {0, 0, 0, 0.25f, 0, 0.5f};

    o.meta.tool_version = "1.0.0";
    o.meta.source_name = "box.obj";
    o.meta.source_sha256 = std::string(64, 'a');
    o.meta.options = "grid=" + std::to_string(grid_size);
    o.meta.grid_size = grid_size;
    o.meta.image_resolution = 256;
    o.meta.source_triangles = 13;
    o.meta.bounds.add(origin);
    o.meta.bounds.add(origin + to_double(size));
    o.meta.area = 22;
    o.meta.closed = o.meta.convex = true;
    return o;
}

}  // namespace rro::test
