// A manifest with its archives open: what the solvers work on.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "format/archive_reader.h"
#include "format/rays/object_rays.h"
#include "format/self_links.h"
#include "solver/scene/built_in.h"
#include "solver/scene/lights.h"
#include "solver/scene/manifest.h"

namespace rro {

/// One archive, loaded once and shared by its instances.
struct Object {
    std::filesystem::path path;
    Archive archive;
    std::unique_ptr<ObjectRays> rays;  // built with the object
    std::vector<std::uint32_t> front_face;  // [T] face number of a triangle's front
    std::vector<std::uint32_t> back_face;   // [T] of its back, or kNoFace
    std::vector<std::uint32_t> patch_of_face;  // [F]
    std::vector<SelfPair> self_pairs;          // preorder; empty where the archive has none

    const ObjectData& data() const { return archive.data(); }
};
/// In place of a face's number: none.
inline constexpr std::uint32_t kNoFace = 0xffffffffu;

/// The archive with its ray structure, the lookups from triangles and faces, and its pair tree.
std::unique_ptr<Object> make_object(std::filesystem::path path, Archive archive);

/// One placed object with its radiometry resolved.
struct Instance {
    std::string name;
    const Object* object = nullptr;
    Affine3 to_world;
    Affine3 to_local;
    double determinant_sign = 1;       // of to_world.linear; world normals are M^-T n, winding flips where negative
    Box3 bounds;                       // world, of all triangles
    std::vector<Rgb> reflectance;      // [P] per patch
    std::vector<Rgb> exitance;         // [P] per patch, W/m^2
    std::vector<Rgb> transmittance;    // [P] per patch, diffuse, on two-sided triangles only; empty where nothing transmits
    std::vector<std::uint32_t> light_group;  // [P] per patch, into Scene::light_groups; empty where all are 0

    const ObjectData& data() const { return object->data(); }

    Rgb transmittance_of(std::size_t patch) const {
        return !built_in("transmission") || transmittance.empty() ? Rgb{} : transmittance[patch];
    }
    std::uint32_t light_group_of(std::size_t patch) const {
        return !built_in("groups") || light_group.empty() ? 0 : light_group[patch];
    }

    /// World corners, counter-clockwise as seen from the face's side, also where the transform mirrors.
    TriangleCorners world_corners(Face face) const {
        TriangleCorners c = data().corners(face);
        for (Vec3& p : c) p = to_world.point(p);
        if (determinant_sign < 0) std::swap(c[1], c[2]);
        return c;
    }
};

/// A scene, ready to be solved. Immutable while it is.
struct Scene {
    Manifest manifest;
    std::vector<std::shared_ptr<const Object>> objects;  // in the order of first use
    std::vector<Instance> instances;   // in manifest order
    Box3 bounds;                       // world
    std::optional<Sky> sky;            // none where it is dark, and so on: what is here has an effect
    std::optional<Sun> sun;
    std::vector<PointLight> lights;
    std::optional<Medium> medium;
    std::vector<std::string> light_groups = {""};  // names by number; 0 is all light without a group, sky and sun too

    std::size_t triangle_count() const {
        std::size_t n = 0;
        for (const Instance& i : instances) n += i.data().triangles.size();
        return n;
    }
};

/// Opens every archive once (several at a time), checks `content` pins, resolves materials, builds ray structures.
///
/// wanted   what will be used of the archives; the rest is not unpacked
/// opened   objects at hand, opened with no less than what is wanted: an archive whose path is one of theirs is not read again
/// errors   BadInput naming manifest, instance and archive: missing or refused archive, one without the tables that are
///          wanted, wrong content, a material the archive lacks (lists those there are), a transmittance on one-sided
///          triangles or one that exceeds 1 with the reflectance; a picture of the sky or a photometric file that cannot be used
Result<Scene> open_scene(Manifest manifest, SectionSet wanted = kGeometry | kTables | Section::Source,
                         std::span<const std::shared_ptr<const Object>> opened = {});

}  // namespace rro
