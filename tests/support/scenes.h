// Scenes built in memory from meshes, without files: compile, encode, read back, place.
#pragma once

#include <algorithm>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "compiler/compile_object.h"
#include "format/archive_writer.h"
#include "solver/scene/scene.h"
#include "tests/support/meshes.h"

namespace rro::test {

/// One object of a scene; all its materials get this reflectance and exitance.
struct Placed {
    Mesh mesh;
    Affine3 to_world = {};
    Vec3 reflectance = {0.5, 0.5, 0.5};
    Vec3 exitance = {};
    std::string name = {};  // "0", "1", ... by position in the list where empty
};

/// Small tables, for tests of laws that hold at any resolution.
inline CompileOptions coarse_tables() {
    CompileOptions options;
    options.image_resolution = 64;
    options.tables.hit = false;
    options.tables.atlas = false;
    return options;
}

/// The mesh as an archive, opened, with its ray structure and lookups.
inline std::unique_ptr<Object> compile_to_object(const Mesh& mesh, const CompileOptions& options = {}) {
    auto compiled = compile_object(mesh, options);
    if (!compiled) throw std::runtime_error(compiled.error().message);
    auto bytes = encode_archive(compiled->data);
    if (!bytes) throw std::runtime_error(bytes.error().message);
    auto archive = Archive::from_bytes(std::move(*bytes), "in memory");
    if (!archive) throw std::runtime_error(archive.error().message);
    return make_object("in memory", std::move(*archive));
}

/// Places one more instance of `object`, which the scene must hold.
inline void add_instance(Scene& scene, const Object& object, const Affine3& to_world, const Vec3& reflectance,
                         const Vec3& exitance, std::string name = {}) {
    if (name.empty()) name = std::to_string(scene.instances.size());
    const ObjectData& data = object.data();
    Instance instance;
    instance.name = name;
    instance.object = &object;
    instance.to_world = to_world;
    instance.to_local = to_world.inverse();
    instance.determinant_sign = to_world.linear.determinant() < 0 ? -1 : 1;
    for (std::uint32_t t = 0; t < data.triangles.size(); ++t)
        for (const Vec3& corner : data.corners(t)) instance.bounds.add(to_world.point(corner));
    instance.reflectance.assign(data.patches.size(), to_float(reflectance));
    instance.exitance.assign(data.patches.size(), to_float(exitance));
    scene.bounds.add(instance.bounds);
    scene.manifest.instances.push_back({name, "in memory", {}, to_world, {{"*", {reflectance, exitance}}}});
    scene.instances.push_back(std::move(instance));
}

/// One archive per entry.
inline Scene make_scene(const std::vector<Placed>& placed, const CompileOptions& options = {}) {
    Scene scene;
    scene.manifest.path = "in memory";
    for (const Placed& p : placed) {
        scene.objects.push_back(compile_to_object(p.mesh, options));
        add_instance(scene, *scene.objects.back(), p.to_world, p.reflectance, p.exitance, p.name);
    }
    return scene;
}

inline Affine3 translation(const Vec3& by) {
    return {Mat3{}, by};
}

}  // namespace rro::test
