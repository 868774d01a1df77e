#include "format/section_tables.h"

#include <utility>

#include "format/layout.h"

namespace rro {
namespace {

TableBuilder meta_table(const ObjectMeta& meta) {
    using F = layout::MetaField;
    TableBuilder table;
    table.text(F::tool_version, meta.tool_version);
    table.text(F::source_name, meta.source_name);
    table.text(F::source_sha256, meta.source_sha256);
    table.text(F::options, meta.options);
    table.scalar(F::grid_map, static_cast<std::uint8_t>(meta.grid_map));
    table.scalar(F::grid_size, meta.grid_size, layout::kDefaultGridSize);
    table.scalar(F::image_resolution, meta.image_resolution);
    table.scalar(F::source_triangles, meta.source_triangles);
    table.structure(F::bounds_lo, meta.bounds.lo);
    table.structure(F::bounds_hi, meta.bounds.hi);
    table.scalar(F::area, meta.area);
    table.scalar(F::closed, static_cast<std::uint8_t>(meta.closed));
    table.scalar(F::convex, static_cast<std::uint8_t>(meta.convex));
    return table;
}

void read_meta(const TableView& table, ObjectMeta& meta) {
    using F = layout::MetaField;
    meta.tool_version = table.text(F::tool_version);
    meta.source_name = table.text(F::source_name);
    meta.source_sha256 = table.text(F::source_sha256);
    meta.options = table.text(F::options);
    meta.grid_map = static_cast<GridMap>(table.value<std::uint8_t>(F::grid_map));
    meta.grid_size = table.value(F::grid_size, layout::kDefaultGridSize);
    meta.image_resolution = table.value<std::uint32_t>(F::image_resolution);
    meta.source_triangles = table.value<std::uint32_t>(F::source_triangles);
    meta.bounds.lo = table.value<Vec3>(F::bounds_lo);
    meta.bounds.hi = table.value<Vec3>(F::bounds_hi);
    meta.area = table.value<double>(F::area);
    meta.closed = table.value<std::uint8_t>(F::closed) != 0;
    meta.convex = table.value<std::uint8_t>(F::convex) != 0;
}

TableBuilder mesh_table(const ObjectData& object) {
    using F = layout::MeshField;
    TableBuilder table;
    if (object.origin != Vec3{}) table.structure(F::origin, object.origin);
    table.array(F::positions, object.positions);
    table.array(F::triangles, object.triangles);
    table.array(F::faces, object.faces);
    return table;
}

void read_mesh(const TableView& table, ObjectData& object) {
    using F = layout::MeshField;
    object.origin = table.value<Vec3>(F::origin);
    object.positions = table.array<Vec3f>(F::positions);
    object.triangles = table.array<TriangleIndices>(F::triangles);
    object.faces = table.array<Face>(F::faces);
}

TableBuilder materials_table(const std::vector<Material>& materials) {
    using F = layout::MaterialField;
    std::vector<TableBuilder> entries;
    for (const Material& material : materials) {
        TableBuilder& entry = entries.emplace_back();
        entry.text(F::name, material.name);
        entry.structure(F::reflectance, material.reflectance);
        entry.structure(F::exitance, material.exitance);
        entry.scalar(F::textured, static_cast<std::uint8_t>(material.textured));
    }
    TableBuilder table;
    table.tables(layout::MaterialsField::materials, std::move(entries));
    return table;
}

void read_materials(const TableView& table, std::vector<Material>& materials) {
    using F = layout::MaterialField;
    for (const TableView& entry : table.tables(layout::MaterialsField::materials)) {
        Material& material = materials.emplace_back();
        material.name = entry.text(F::name);
        material.reflectance = entry.value<Vec3>(F::reflectance);
        material.exitance = entry.value<Vec3>(F::exitance);
        material.textured = entry.value<std::uint8_t>(F::textured) != 0;
    }
}

TableBuilder area_table(const ObjectData& object) {
    using F = layout::AreaField;
    TableBuilder table;
    table.array(F::clusters, object.area_clusters);
    table.array(F::whole, object.whole_area);
    table.array(F::whole_scale, object.whole_area_scale);
    table.array(F::intrinsic, object.intrinsic_area);
    table.array(F::intrinsic_scale, object.intrinsic_area_scale);
    return table;
}

void read_area(const TableView& table, ObjectData& object) {
    using F = layout::AreaField;
    object.area_clusters = table.array<std::uint32_t>(F::clusters);
    object.whole_area = table.array<std::uint8_t>(F::whole);
    object.whole_area_scale = table.array<float>(F::whole_scale);
    object.intrinsic_area = table.array<std::uint8_t>(F::intrinsic);
    object.intrinsic_area_scale = table.array<float>(F::intrinsic_scale);
}

TableBuilder errors_table(const ObjectData& object) {
    using F = layout::ErrorsField;
    TableBuilder table;
    table.scalar(F::directions, object.error_directions);
    table.array(F::whole, object.whole_area_error);
    table.array(F::intrinsic, object.intrinsic_area_error);
    table.array(F::visibility, object.visibility_error);
    return table;
}

void read_errors(const TableView& table, ObjectData& object) {
    using F = layout::ErrorsField;
    object.error_directions = table.value<std::uint32_t>(F::directions);
    object.whole_area_error = table.array<float>(F::whole);
    object.intrinsic_area_error = table.array<float>(F::intrinsic);
    object.visibility_error = table.array<float>(F::visibility);
}

TableBuilder hbv_table(const ObjectData& object) {
    TableBuilder table;
    table.array(layout::HbvField::volumes, object.volumes);
    table.array(layout::HbvField::triangles, object.volume_triangles);
    return table;
}

void read_hbv(const TableView& table, ObjectData& object) {
    object.volumes = table.array<Volume>(layout::HbvField::volumes);
    object.volume_triangles = table.array<std::uint32_t>(layout::HbvField::triangles);
}

TableBuilder hit_table(const ObjectData& object) {
    TableBuilder table;
    table.array(layout::HitField::volumes, object.hit_volumes);
    table.array(layout::HitField::whole, object.whole_hit);
    table.array(layout::HitField::intrinsic, object.intrinsic_hit);
    return table;
}

void read_hit(const TableView& table, ObjectData& object) {
    object.hit_volumes = table.array<std::uint32_t>(layout::HitField::volumes);
    object.whole_hit = table.array<std::uint8_t>(layout::HitField::whole);
    object.intrinsic_hit = table.array<std::uint8_t>(layout::HitField::intrinsic);
}

TableBuilder atlas_table(const ObjectData& object) {
    using F = layout::AtlasField;
    TableBuilder table;
    table.structure(F::centre, object.atlas_centre);
    table.scalar(F::radius, object.atlas_radius);
    table.scalar(F::grid_size, object.atlas_grid_size);
    table.scalar(F::image_size, object.atlas_image_size);
    table.array(F::coverage, object.atlas_coverage);
    return table;
}

void read_atlas(const TableView& table, ObjectData& object) {
    using F = layout::AtlasField;
    object.atlas_centre = table.value<Vec3f>(F::centre);
    object.atlas_radius = table.value<float>(F::radius);
    object.atlas_grid_size = table.value<std::uint32_t>(F::grid_size);
    object.atlas_image_size = table.value<std::uint32_t>(F::image_size);
    object.atlas_coverage = table.array<std::uint8_t>(F::coverage);
}

TableBuilder self_links_table(const ObjectData& object) {
    using F = layout::SelfLinksField;
    TableBuilder table;
    table.array(F::steps, object.self_steps);
    table.array(F::exchange, object.self_exchange);
    table.array(F::visibility, object.self_visibility);
    table.array(F::escape, object.self_escape);
    table.array(F::received, object.self_received);
    table.array(F::black, object.self_black);
    return table;
}

void read_self_links(const TableView& table, ObjectData& object) {
    using F = layout::SelfLinksField;
    object.self_steps = table.array<std::uint8_t>(F::steps);
    object.self_exchange = table.array<float>(F::exchange);
    object.self_visibility = table.array<std::uint8_t>(F::visibility);
    object.self_escape = table.array<float>(F::escape);
    object.self_received = table.array<float>(F::received);
    object.self_black = table.array<float>(F::black);
}

template <class T>
TableBuilder array_table(std::uint16_t field, std::span<const T> values) {
    TableBuilder table;
    table.array(field, values);
    return table;
}

}  // namespace

TableBuilder section_table(const ObjectData& object, Section section) {
    switch (section) {
        case Section::Meta: return meta_table(object.meta);
        case Section::Mesh: return mesh_table(object);
        case Section::Materials: return materials_table(object.materials);
        case Section::Patches: return array_table(layout::PatchesField::patches, object.patches);
        case Section::Clusters: return array_table(layout::ClustersField::clusters, object.clusters);
        case Section::Area: return area_table(object);
        case Section::Visibility: return array_table(layout::VisibilityField::visibility, object.visibility);
        case Section::Errors: return errors_table(object);
        case Section::Hbv: return hbv_table(object);
        case Section::Source: return array_table(layout::SourceField::triangles, object.source_triangle);
        case Section::Hit: return hit_table(object);
        case Section::Atlas: return atlas_table(object);
        case Section::SelfLinks: return self_links_table(object);
    }
    return {};
}

bool has_content(const ObjectData& object, Section section) {
    switch (section) {
        case Section::Area: return !object.area_clusters.empty();
        case Section::Visibility: return !object.visibility.empty();
        case Section::Errors: return object.error_directions != 0;
        case Section::Hbv: return !object.volumes.empty();
        case Section::Hit: return !object.hit_volumes.empty();
        case Section::Atlas: return !object.atlas_coverage.empty();
        case Section::SelfLinks: return !object.self_steps.empty();
        default: return true;
    }
}

void read_section(const TableView& table, Section section, ObjectData& object) {
    switch (section) {
        case Section::Meta: return read_meta(table, object.meta);
        case Section::Mesh: return read_mesh(table, object);
        case Section::Materials: return read_materials(table, object.materials);
        case Section::Patches: object.patches = table.array<Patch>(layout::PatchesField::patches); return;
        case Section::Clusters: object.clusters = table.array<Cluster>(layout::ClustersField::clusters); return;
        case Section::Area: return read_area(table, object);
        case Section::Visibility:
            object.visibility = table.array<std::uint8_t>(layout::VisibilityField::visibility);
            return;
        case Section::Errors: return read_errors(table, object);
        case Section::Hbv: return read_hbv(table, object);
        case Section::Source:
            object.source_triangle = table.array<std::uint32_t>(layout::SourceField::triangles);
            return;
        case Section::Hit: return read_hit(table, object);
        case Section::Atlas: return read_atlas(table, object);
        case Section::SelfLinks: return read_self_links(table, object);
    }
}

}  // namespace rro
