#include "compiler/compile_object.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "compiler/convexity.h"
#include "compiler/effective_area.h"
#include "compiler/hit_probability.h"
#include "compiler/inward_shells.h"
#include "compiler/object_bvh.h"
#include "compiler/object_layout.h"
#include "compiler/patches.h"
#include "compiler/self_transport.h"
#include "compiler/silhouette_atlas.h"
#include "compiler/surface.h"
#include "compiler/table_error.h"
#include "format/version.h"

namespace rro {
namespace {

double total_area(const Surface& surface) {
    double area = 0;
    for (const Vec3& a : surface.area_vector) area += length(a);
    return area;
}

ObjectMeta make_meta(const Mesh& mesh, const Surface& surface, const CompileOptions& options) {
    ObjectMeta meta;
    meta.tool_version = kToolVersion;
    meta.grid_map = options.grid_map;
    meta.grid_size = options.grid_size;
    meta.image_resolution = options.image_resolution;
    meta.source_triangles = mesh.source_triangles;
    for (std::uint32_t t = 0; t < surface.triangles.size(); ++t)
        for (const Vec3& p : surface.corners(t)) meta.bounds.add(surface.origin + p);
    meta.area = total_area(surface);
    meta.closed = surface.closed;
    meta.convex = is_convex(surface);
    return meta;
}

/// Points the views of `data` at the vectors, as far as these are filled.
void view_all(CompiledObject& object) {
    ObjectData& data = object.data;
    data.positions = object.positions;
    data.triangles = object.triangles;
    data.source_triangle = object.source_triangle;
    data.faces = object.faces;
    data.patches = object.patches;
    data.clusters = object.clusters;
    data.volumes = object.volumes;
    data.volume_triangles = object.volume_triangles;
    data.area_clusters = object.area_clusters;
    data.whole_area = object.whole_area;
    data.whole_area_scale = object.whole_area_scale;
    data.intrinsic_area = object.intrinsic_area;
    data.intrinsic_area_scale = object.intrinsic_area_scale;
    data.visibility = object.visibility;
    data.whole_area_error = object.whole_area_error;
    data.intrinsic_area_error = object.intrinsic_area_error;
    data.visibility_error = object.visibility_error;
    data.hit_volumes = object.hit_volumes;
    data.whole_hit = object.whole_hit;
    data.intrinsic_hit = object.intrinsic_hit;
    data.atlas_coverage = object.atlas_coverage;
    data.self_steps = object.self_steps;
    data.self_exchange = object.self_exchange;
    data.self_visibility = object.self_visibility;
    data.self_escape = object.self_escape;
    data.self_received = object.self_received;
    data.self_black = object.self_black;
}

void store(EffectiveAreas areas, CompiledObject& object) {
    object.area_clusters = std::move(areas.clusters);
    object.whole_area = std::move(areas.whole);
    object.whole_area_scale = std::move(areas.whole_scale);
    object.intrinsic_area = std::move(areas.intrinsic);
    object.intrinsic_area_scale = std::move(areas.intrinsic_scale);
    object.visibility = std::move(areas.visibility);
    view_all(object);
}

void store(TableErrors errors, CompiledObject& object) {
    object.whole_area_error = std::move(errors.whole);
    object.intrinsic_area_error = std::move(errors.intrinsic);
    object.visibility_error = std::move(errors.visibility);
    object.data.error_directions = errors.directions;
    view_all(object);
}

void store(HitProbabilities hits, CompiledObject& object) {
    object.hit_volumes = std::move(hits.volumes);
    object.whole_hit = std::move(hits.whole);
    object.intrinsic_hit = std::move(hits.intrinsic);
    view_all(object);
}

void store(SilhouetteAtlas atlas, CompiledObject& object) {
    object.atlas_coverage = std::move(atlas.coverage);
    object.data.atlas_centre = atlas.centre;
    object.data.atlas_radius = atlas.radius;
    object.data.atlas_grid_size = atlas.grid_size;
    object.data.atlas_image_size = atlas.image_size;
    view_all(object);
}

void store(SelfLinks links, CompiledObject& object) {
    object.self_steps = std::move(links.steps);
    object.self_exchange = std::move(links.exchange);
    object.self_visibility = std::move(links.visibility);
    view_all(object);
}

void store(Closure closure, CompiledObject& object) {
    object.self_escape = std::move(closure.escape);
    object.self_received = std::move(closure.received);
    object.self_black = std::move(closure.black);
    view_all(object);
}

}  // namespace

Result<CompiledObject> compile_object(const Mesh& mesh, const CompileOptions& options,
                                      const CompileProgress& progress) {
    assert(options.grid_size >= 2 && options.image_resolution > 0 && options.patch_area_divisor > 0);
    // Shares of the work as measured on meshes of 20,000 to 100,000 triangles.
    const auto report = [&](std::string_view phase, double done) {
        if (progress) progress(phase, done);
    };
    report("surface", 0);
    const Result<Surface> made = make_surface(mesh);
    if (!made) return made.error();
    const Surface& surface = *made;
    CompiledObject object;
    object.data.meta = make_meta(mesh, surface, options);
    object.data.materials = mesh.materials;
    object.data.origin = surface.origin;
    object.dropped_by_rounding = surface.dropped_by_rounding;

    report("patches", 0.05);
    PatchLimits limits;
    limits.largest_area = object.data.meta.area / options.patch_area_divisor;
    limits.cone_cosine = options.patch_cone_cosine;
    const PatchGroups patches = make_patches(surface, limits);

    report("clusters", 0.15);
    const ClusterTree clusters = build_cluster_tree(summarise_patches(surface, patches), options.cluster_weights);
    lay_out_object(surface, patches, clusters, object);

    report("volumes", 0.25);
    ObjectBvh bvh = build_object_bvh(object.positions, object.triangles);
    object.volumes = std::move(bvh.volumes);
    object.volume_triangles = std::move(bvh.triangles);
    view_all(object);

    const TableChoice& tables = options.tables;
    report("silhouettes", 0.3);
    if (tables.atlas) store(measure_silhouettes(object.data), object);
    report("hit probabilities", 0.33);
    if (tables.hit) store(measure_hits(object.data, tables), object);
    if (tables.area || tables.visibility) {
        report("effective areas", 0.4);
        EffectiveAreas areas = measure_effective_areas(object.data, tables);
        hide_inward_patches(object.data, areas);
        store(std::move(areas), object);
        report("table errors", 0.65);
        if (tables.errors) store(measure_table_errors(object.data), object);
    }
    if (tables.selflinks) {
        report("self links", 0.75);
        const ObjectRays rays(object.positions, object.triangles);
        store(measure_self_links(object.data, rays), object);
        if (tables.visibility && !object.self_steps.empty())
            store(measure_light_shares(object.data, rays), object);
    }
    report("tables", 1);
    return object;
}

}  // namespace rro
