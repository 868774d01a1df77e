// Which faces of a scene belong together: the rows and columns of the matrix of factors.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "format/result.h"
#include "solver/scene/scene.h"

namespace rro {

/// What a row is: --by.
enum class GroupBy { Auto, Instance, Material, Group };
/// Which sides of two-sided triangles exchange: --sides.
enum class Sides { Front, Both };

/// In place of a group's number: none.
inline constexpr std::uint32_t kNoGroup = 0xffffffffu;

/// G groups, and whose they are.
struct SurfaceGroups {
    GroupBy by = GroupBy::Instance;                     // never Auto
    std::vector<std::string> names;                     // [G]
    std::vector<std::vector<std::uint32_t>> of_material;  // [instances][materials of its archive], or kNoGroup

    /// The group of a triangle (of the archive), or kNoGroup.
    std::uint32_t of(const Scene& scene, std::uint32_t instance, std::uint32_t triangle) const;
};

/// errors   Usage: none of "instance", "material", "group"
Result<GroupBy> parse_group_by(std::string_view name);
/// errors   Usage: neither "front" nor "both"
Result<Sides> parse_sides(std::string_view name);

/// Rows in manifest order: an instance each; a material of an instance each ("instance/material", those with faces, in
/// the archive's order); or the manifest's groups as they stand there. Auto: groups where the manifest has any, else
/// instances.
///
/// errors   BadInput: --by group without groups; a member that is no instance or material; a group without faces; a
///          surface in two groups: named, with its place
Result<SurfaceGroups> surface_groups(const Scene& scene, GroupBy by);

}  // namespace rro
