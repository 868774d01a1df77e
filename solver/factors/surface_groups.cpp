#include "solver/factors/surface_groups.h"

#include <algorithm>
#include <map>

#include "format/tool/json_document.h"
#include "format/tool/names.h"

namespace rro {
namespace {

Error usage(std::string message) {
    return {ErrorKind::Usage, "", std::move(message), ""};
}

/// Which materials of an archive have faces.
std::vector<std::uint8_t> used_materials(const ObjectData& data) {
    std::vector<std::uint8_t> used(data.materials.size(), 0);
    for (const Patch& patch : data.patches) used[patch.material] = 1;
    return used;
}

SurfaceGroups by_instance(const Scene& scene) {
    SurfaceGroups groups;
    groups.by = GroupBy::Instance;
    for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
        groups.names.push_back(scene.instances[i].name);
        groups.of_material.emplace_back(scene.instances[i].data().materials.size(), i);
    }
    return groups;
}

/// Materials of one instance with the same name are one surface.
SurfaceGroups by_material(const Scene& scene) {
    SurfaceGroups groups;
    groups.by = GroupBy::Material;
    for (const Instance& instance : scene.instances) {
        const auto& materials = instance.data().materials;
        const std::vector<std::uint8_t> used = used_materials(instance.data());
        std::map<std::string_view, std::uint32_t> known;
        auto& of_material = groups.of_material.emplace_back(materials.size(), kNoGroup);
        for (std::size_t m = 0; m < materials.size(); ++m) {
            if (!used[m]) continue;
            const auto [at, is_new] =
                known.emplace(materials[m].name, static_cast<std::uint32_t>(groups.names.size()));
            if (is_new) groups.names.push_back(instance.name + "/" + materials[m].name);
            of_material[m] = at->second;
        }
    }
    return groups;
}

/// A member of a group: an instance, or some of its materials.
struct Member {
    std::uint32_t instance = 0;
    std::vector<std::uint32_t> materials;
};

Result<Member> find_member(const Scene& scene, const std::map<std::string_view, std::uint32_t>& instances,
                           const std::string& name, const std::string& where) {
    const auto slash = name.find('/');  // names of instances have none
    const std::string instance_name = name.substr(0, slash);
    const auto found = instances.find(instance_name);
    if (found == instances.end()) {
        std::vector<std::string> names;
        for (const Instance& i : scene.instances) names.push_back(i.name);
        return bad_input(where, "there is no instance \"" + instance_name + "\"", nearest_hint(instance_name, names));
    }
    Member member{found->second, {}};
    const auto& materials = scene.instances[member.instance].data().materials;
    const std::vector<std::uint8_t> used = used_materials(scene.instances[member.instance].data());
    for (std::uint32_t m = 0; m < materials.size(); ++m)
        if (used[m] && (slash == std::string::npos || materials[m].name == name.substr(slash + 1)))
            member.materials.push_back(m);
    if (member.materials.empty()) {
        std::vector<std::string> names;
        for (std::uint32_t m = 0; m < materials.size(); ++m)
            if (used[m]) names.push_back(materials[m].name);
        return bad_input(where, "instance \"" + instance_name + "\" has no material \"" + name.substr(slash + 1) +
                                    "\", expected one of: " + listed(names),
                         nearest_hint(name.substr(slash + 1), names));
    }
    return member;
}

Result<SurfaceGroups> by_group(const Scene& scene) {
    const std::string file = scene.manifest.path.string();
    if (scene.manifest.groups.empty())
        return bad_input(file, "has no \"groups\", expected some for --by group", "use --by instance or --by material");
    std::map<std::string_view, std::uint32_t> instances;
    for (std::uint32_t i = 0; i < scene.instances.size(); ++i) instances.emplace(scene.instances[i].name, i);
    SurfaceGroups groups;
    groups.by = GroupBy::Group;
    for (const Instance& i : scene.instances) groups.of_material.emplace_back(i.data().materials.size(), kNoGroup);
    for (const GroupEntry& entry : scene.manifest.groups) {
        const std::string place = "/groups/" + pointer_step(entry.name);
        const auto number = static_cast<std::uint32_t>(groups.names.size());
        if (entry.members.empty())
            return bad_input(json_place(file, place), "group \"" + entry.name + "\" is empty, expected members");
        for (std::size_t k = 0; k < entry.members.size(); ++k) {
            const std::string where = json_place(file, place + "/" + std::to_string(k));
            const auto member = find_member(scene, instances, entry.members[k], where);
            if (!member) return member.error();
            for (const std::uint32_t m : member->materials) {
                std::uint32_t& group = groups.of_material[member->instance][m];
                if (group != kNoGroup)
                    return bad_input(where, "\"" + entry.members[k] + "\" is in group \"" +
                                                (group == number ? entry.name : groups.names[group]) +
                                                "\" already; a surface can be in one group, once");
                group = number;
            }
        }
        groups.names.push_back(entry.name);
    }
    return groups;
}

}  // namespace

std::uint32_t SurfaceGroups::of(const Scene& scene, std::uint32_t instance, std::uint32_t triangle) const {
    const Object& object = *scene.instances[instance].object;
    const std::uint32_t front = object.front_face[triangle];
    const std::uint32_t face = front != kNoFace ? front : object.back_face[triangle];
    return of_material[instance][object.data().patches[object.patch_of_face[face]].material];
}

Result<GroupBy> parse_group_by(std::string_view name) {
    if (name == "instance") return GroupBy::Instance;
    if (name == "material") return GroupBy::Material;
    if (name == "group") return GroupBy::Group;
    return usage("--by " + std::string(name) + ": expected instance, material or group");
}

Result<Sides> parse_sides(std::string_view name) {
    if (name == "front") return Sides::Front;
    if (name == "both") return Sides::Both;
    return usage("--sides " + std::string(name) + ": expected front or both");
}

Result<SurfaceGroups> surface_groups(const Scene& scene, GroupBy by) {
    if (by == GroupBy::Auto) by = scene.manifest.groups.empty() ? GroupBy::Instance : GroupBy::Group;
    if (by == GroupBy::Group) return by_group(scene);
    return by == GroupBy::Material ? by_material(scene) : by_instance(scene);
}

}  // namespace rro
