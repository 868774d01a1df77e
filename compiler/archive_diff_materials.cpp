#include <algorithm>
#include <cmath>
#include <map>

#include "compiler/archive_diff_parts.h"
#include "compiler/archive_facts.h"
#include "compiler/diff_words.h"

namespace rro {
namespace {

/// A name and which of its bearers: glTF may give one name to several materials.
using MaterialKey = std::pair<std::string, std::uint32_t>;

/// Key of every material, in order.
std::vector<MaterialKey> keys_of(const std::vector<Material>& materials) {
    std::map<std::string, std::uint32_t> seen;
    std::vector<MaterialKey> keys;
    for (const Material& material : materials) keys.emplace_back(material.name, ++seen[material.name]);
    return keys;
}

std::vector<MaterialKey> sorted(std::vector<MaterialKey> keys) {
    std::sort(keys.begin(), keys.end());
    return keys;
}

std::string quoted(const MaterialKey& key) {
    return "\"" + key.first + "\"" + (key.second > 1 ? " (no. " + std::to_string(key.second) + " of this name)" : "");
}

Change change_of(const std::string& kind, const MaterialKey& key, DiffValue before, DiffValue after,
                 const std::string& text) {
    Change change{"materials", kind, key.first, std::move(before), std::move(after), {}, quoted(key) + text};
    if (key.second > 1) change.more.emplace_back("occurrence", std::uint64_t{key.second});
    return change;
}

void compare_material(const MaterialKey& key, const Material& a, const Material& b, Changes& out) {
    if (a.reflectance != b.reflectance)
        out.push_back(change_of("reflectance", key, a.reflectance, b.reflectance,
                                ": reflectance " + from_to(a.reflectance, b.reflectance)));
    if (a.exitance != b.exitance)
        out.push_back(change_of("exitance", key, a.exitance, b.exitance,
                                ": exitance " + from_to(a.exitance, b.exitance) + " W/m^2"));
    if (a.textured != b.textured)
        out.push_back(change_of("textured", key, a.textured, b.textured,
                                b.textured ? " now has a texture" : " no longer has a texture"));
}

void list_material(const std::string& kind, const MaterialKey& key, const Material& material, Changes& out) {
    Change& change = out.emplace_back(change_of(kind, key, {}, {}, kind == "material_added" ? " added" : " removed"));
    change.more.insert(change.more.end(), {{"reflectance", material.reflectance}, {"exitance", material.exitance}});
}

/// Triangles whose material has another name now, by both names; the most numerous first.
void compare_assignment(const ObjectData& a, const ObjectData& b, const TrianglePairs& triangles, Changes& out) {
    std::map<std::string, std::uint32_t> number_of_name;
    const auto numbered = [&](const std::vector<Material>& materials) {
        std::vector<std::uint32_t> numbers;
        for (const Material& m : materials)
            numbers.push_back(
                number_of_name.try_emplace(m.name, static_cast<std::uint32_t>(number_of_name.size())).first->second);
        return numbers;
    };
    const std::vector<std::uint32_t> names_a = numbered(a.materials), names_b = numbered(b.materials);
    const std::vector<std::uint32_t> of_a = triangle_materials(a), of_b = triangle_materials(b);
    struct Group {
        std::string before, after;
        std::vector<std::uint32_t> triangles;
    };
    std::map<std::pair<std::uint32_t, std::uint32_t>, Group> groups;
    for (const TrianglePair& pair : triangles.all()) {
        const std::uint32_t before = of_a[pair.a], after = of_b[pair.b];
        if (names_a[before] == names_b[after]) continue;
        Group& group = groups[{names_a[before], names_b[after]}];
        if (group.triangles.empty()) group = {a.materials[before].name, b.materials[after].name, {}};
        group.triangles.push_back(a.source_triangle[pair.a]);
    }
    std::vector<Group> listed;
    for (auto& [names, group] : groups) listed.push_back(std::move(group));
    std::stable_sort(listed.begin(), listed.end(),
                     [](const Group& x, const Group& y) { return x.triangles.size() > y.triangles.size(); });
    for (Group& group : listed) {
        std::sort(group.triangles.begin(), group.triangles.end());
        const NumberRanges ranges = ranges_of(group.triangles);
        out.push_back({"materials",
                       "triangles_material",
                       "material of triangles",
                       group.before,
                       group.after,
                       {{"count", std::uint64_t{group.triangles.size()}}, {"triangles", ranges}},
                       counted(group.triangles.size(), "triangle") + " \"" + group.before + "\" -> \"" + group.after +
                           "\": " + range_text(ranges)});
    }
}

}  // namespace

void compare_materials(const ObjectData& a, const ObjectData& b, const TrianglePairs& triangles, Changes& out) {
    const std::vector<MaterialKey> keys_a = keys_of(a.materials), keys_b = keys_of(b.materials);
    std::map<MaterialKey, std::size_t> place_in_b;
    for (std::size_t i = 0; i < keys_b.size(); ++i) place_in_b.emplace(keys_b[i], i);
    std::vector<bool> paired(keys_b.size(), false);
    for (std::size_t i = 0; i < keys_a.size(); ++i) {
        const auto found = place_in_b.find(keys_a[i]);
        if (found == place_in_b.end()) {
            list_material("material_removed", keys_a[i], a.materials[i], out);
            continue;
        }
        paired[found->second] = true;
        compare_material(keys_a[i], a.materials[i], b.materials[found->second], out);
    }
    for (std::size_t i = 0; i < keys_b.size(); ++i)
        if (!paired[i]) list_material("material_added", keys_b[i], b.materials[i], out);
    if (keys_a != keys_b && sorted(keys_a) == sorted(keys_b))
        out.push_back(
            {"materials", "material_order", "order of materials", {}, {}, {}, "the same materials in another order"});
    compare_assignment(a, b, triangles, out);
}

void compare_textures(const ObjectData& a, const ObjectData& b, const TreeMatch& trees, Changes& out) {
    std::uint64_t count = 0;
    double largest = 0;
    for (std::size_t p = 0; p < a.patches.size(); ++p) {
        if (trees.patch_in_b[p] == kNoPatch) continue;
        const Patch &before = a.patches[p], &after = b.patches[trees.patch_in_b[p]];
        if (!a.materials[before.material].textured || !b.materials[after.material].textured) continue;
        if (before.reflectance == after.reflectance) continue;
        ++count;
        const Vec3 change = to_double(after.reflectance) - to_double(before.reflectance);
        largest = std::max({largest, std::abs(change.x), std::abs(change.y), std::abs(change.z)});
    }
    if (count == 0) return;
    out.push_back({"materials",
                   "texture",
                   "textures",
                   {},
                   {},
                   {{"count", count}, {"largest", largest}},
                   "textures: the reflectance of " + std::to_string(count) +
                       " of the patches that both have changed by at most " + number(largest, 2)});
}

}  // namespace rro
