#include "compiler/mesh_import.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <span>

#include "compiler/mesh_polygon.h"
#include "compiler/mesh_readers.h"
#include "compiler/mesh_text.h"
#include "compiler/mesh_weld.h"
#include "format/sha256.h"

namespace rro {
namespace {

constexpr double kLargestReflectance = 0.95;  // imported ones; a scene with 1 would never settle
constexpr Vec3 kUnknownReflectance{0.5, 0.5, 0.5};

/// Of (longest edge)^2: below, a triangle's area and normal are rounding errors of its coordinates.
constexpr double kNoArea = 1e-14;

/// Metres. Areas of such extents, of triangles a million times smaller, and their products with radiosities are floats.
constexpr double kLargestExtent = 1e15, kSmallestExtent = 1e-13;

/// Distance from the origin over extent. Beyond it double coordinates resolve a shape to less than 1 in 10,000.
constexpr double kLargestDistance = 1e11;

std::string place_of_face(const SourceMesh& source, std::size_t face, const std::filesystem::path& path) {
    return source.face_line.empty() ? path.string() + ": face " + std::to_string(face)
                                    : at_line(path, source.face_line[face]);
}

Status check_indices(const SourceMesh& source, const std::filesystem::path& path) {
    std::size_t corner = 0;
    for (std::size_t face = 0; face < source.face_end.size(); ++face)
        for (; corner < source.face_end[face]; ++corner)
            if (source.corners[corner] >= source.positions.size())
                return bad_input(place_of_face(source, face, path),
                                 "index " + std::to_string(source.corners[corner]) + " counted from 0, but there are " +
                                     std::to_string(source.positions.size()) + " vertices");
    return Done{};
}

/// Into metres, y up.
void to_archive_frame(std::vector<Vec3>& positions, const ImportOptions& options) {
    for (Vec3& p : positions) {
        if (options.z_up) p = {p.x, p.z, -p.y};
        p *= options.unit;
    }
}

/// A triangle of the source that is kept so far: its corners as places in SourceMesh::corners.
struct KeptTriangle {
    std::array<std::uint32_t, 3> corners;
    std::uint32_t face, number;
};

/// All triangles whose corners are finite; counts the others.
Result<std::vector<KeptTriangle>> finite_triangles(const SourceMesh& source, const std::filesystem::path& path,
                                                   const ImportLimits& limits, ImportReport& report) {
    std::uint64_t steps = limits.polygon_steps;
    std::vector<KeptTriangle> kept;
    std::vector<Vec3> polygon;
    std::uint32_t first = 0;
    for (std::uint32_t face = 0; face < source.face_end.size(); first = source.face_end[face++]) {
        const std::uint32_t k = source.face_end[face] - first;
        report.ignored_faces += k < 3 ? 1 : 0;
        if (k < 3) continue;
        polygon.clear();
        for (std::uint32_t i = 0; i < k; ++i) polygon.push_back(source.positions[source.corners[first + i]]);
        const auto cut = triangulate_polygon(polygon, steps);
        if (!cut)
            return bad_input(place_of_face(source, face, path),
                             "found a face of " + std::to_string(k) +
                                 " corners, not convex, that would take too long to cut into triangles",
                             "triangulate the mesh in the program that wrote it");
        report.polygons_triangulated += k > 3 ? 1 : 0;
        report.polygons_ear_clipped += cut->ear_clipped ? 1 : 0;
        for (const auto& [a, b, c] : cut->triangles) {
            const std::uint32_t number = report.source_triangles++;
            if (is_finite(polygon[a]) && is_finite(polygon[b]) && is_finite(polygon[c]))
                kept.push_back({{first + a, first + b, first + c}, face, number});
            else
                ++report.dropped_not_finite;
        }
    }
    return kept;
}

TriangleCorners corners_of(const SourceMesh& source, const KeptTriangle& triangle) {
    const auto at = [&](std::size_t i) { return source.positions[source.corners[triangle.corners[i]]]; };
    return {at(0), at(1), at(2)};
}

bool has_area(const TriangleCorners& t) {
    const double longest = std::max({length2(t[1] - t[0]), length2(t[2] - t[1]), length2(t[0] - t[2])});
    return length(area_vector(t)) > kNoArea * longest;
}

Vec3 extent_of(const std::vector<Vec3>& positions) {
    Box3 box;
    for (const Vec3& p : positions) box.add(p);
    return box.extent();
}

Status check_extent(const SourceMesh& source, const std::vector<KeptTriangle>& triangles,
                    const std::filesystem::path& path) {
    Box3 box;
    for (const KeptTriangle& triangle : triangles)
        for (const Vec3& p : corners_of(source, triangle)) box.add(p);
    if (box.empty()) return Done{};  // what follows says that nothing is left
    const double extent = max_component(box.extent());
    const double distance = std::max(max_component(box.hi), max_component(-box.lo));
    const auto metres = [](double x) {
        std::array<char, 32> text;
        std::snprintf(text.data(), text.size(), "%.3g m", x);
        return std::string(text.data());
    };
    if (extent > kLargestExtent || (extent > 0 && extent < kSmallestExtent))
        return bad_input(path.string(),
                         "the mesh extends over " + metres(extent) + ", expected " + metres(kSmallestExtent) + " to " +
                             metres(kLargestExtent) + ": its areas would be no numbers",
                         "check --unit, and the file for stray vertices");
    if (distance > kLargestDistance * extent)
        return bad_input(path.string(),
                         "the mesh lies " + metres(distance) + " from the origin but extends over " + metres(extent) +
                             " only: its coordinates do not resolve its shape",
                         "move it nearer to the origin");
    return Done{};
}

/// Takes those without an area out and returns them.
std::vector<KeptTriangle> drop_degenerate(const SourceMesh& source, std::vector<KeptTriangle>& triangles,
                                          ImportReport& report) {
    std::vector<KeptTriangle> dropped;
    std::erase_if(triangles, [&](const KeptTriangle& triangle) {
        if (has_area(corners_of(source, triangle))) return false;
        dropped.push_back(triangle);
        return true;
    });
    report.dropped_degenerate = static_cast<std::uint32_t>(dropped.size());
    return dropped;
}

/// Positions in use, equal ones as one, in order of first use; triangles over them; and slits, those of the dropped
/// ones that have three corners in use.
void fill_triangles(const SourceMesh& source, const std::vector<KeptTriangle>& triangles,
                    const std::vector<KeptTriangle>& dropped, Mesh& mesh, ImportReport& report) {
    constexpr std::uint32_t kUnused = std::numeric_limits<std::uint32_t>::max();
    const std::vector<std::uint32_t> welded = weld_positions(source.positions);
    std::vector<std::uint32_t> index(source.positions.size(), kUnused);
    std::vector<bool> met(source.positions.size(), false);
    std::uint32_t vertices = 0;
    for (const KeptTriangle& triangle : triangles) {
        TriangleIndices corners;
        for (std::size_t i = 0; i < 3; ++i) {
            const std::uint32_t vertex = source.corners[triangle.corners[i]], position = welded[vertex];
            vertices += met[vertex] ? 0 : 1;
            met[vertex] = true;
            if (index[position] == kUnused) {
                index[position] = static_cast<std::uint32_t>(mesh.positions.size());
                mesh.positions.push_back(source.positions[position]);
            }
            corners[i] = index[position];
        }
        mesh.triangles.push_back(corners);
        mesh.source_triangle.push_back(triangle.number);
    }
    report.welded_vertices = vertices - static_cast<std::uint32_t>(mesh.positions.size());
    for (const KeptTriangle& triangle : dropped) {
        TriangleIndices corners;
        for (std::size_t i = 0; i < 3; ++i) corners[i] = index[welded[source.corners[triangle.corners[i]]]];
        const auto [a, b, c] = corners;
        if (a != b && b != c && c != a && a != kUnused && b != kUnused && c != kUnused) mesh.slits.push_back(corners);
    }
}

/// Materials of faces that have triangles, in order of first use. Returns their numbers in the source.
std::vector<std::uint32_t> fill_materials(const SourceMesh& source, const std::vector<KeptTriangle>& triangles,
                                          Mesh& mesh) {
    std::vector<std::uint32_t> used;
    std::vector<std::optional<std::uint32_t>> index(source.materials.size());
    std::uint32_t first = 0;
    for (std::size_t face = 0; face < source.face_end.size(); first = source.face_end[face++]) {
        auto& at = index[source.face_material[face]];
        if (at || source.face_end[face] - first < 3) continue;
        at = static_cast<std::uint32_t>(used.size());
        used.push_back(source.face_material[face]);
    }
    for (const KeptTriangle& triangle : triangles) mesh.material.push_back(*index[source.face_material[triangle.face]]);
    return used;
}

Vec3 clamped(Vec3 reflectance, bool& was_above) {
    for (int c = 0; c < 3; ++c) {
        was_above = was_above || reflectance[c] > kLargestReflectance;
        reflectance[c] = std::clamp(reflectance[c], 0.0, kLargestReflectance);
    }
    return reflectance;
}

/// What texture and colours make of a triangle, as a factor.
Vec3 colour_factor(const SourceMesh& source, const SourceMaterial& material, const KeptTriangle& triangle,
                   std::uint64_t most_samples) {
    Vec3 factor{1, 1, 1};
    const auto& c = triangle.corners;
    if (!source.colours.empty()) factor = (source.colours[c[0]] + source.colours[c[1]] + source.colours[c[2]]) / 3;
    if (!material.texture) return factor;
    const Texture& texture = source.textures[material.texture->texture];
    if (source.uvs.empty()) return hadamard(factor, texture.mean);
    const std::array<Uv, 3> corners{source.uvs[c[0]], source.uvs[c[1]], source.uvs[c[2]]};
    return hadamard(factor, mean_over_triangle(texture, *material.texture, corners, most_samples));
}

/// Reflectances per triangle, and per material as their mean over its area.
void fill_colours(const SourceMesh& source, const std::vector<KeptTriangle>& triangles,
                  const std::vector<std::uint32_t>& used, const ImportOptions& options, Mesh& mesh,
                  ImportReport& report) {
    struct Sum {
        Vec3 colour;
        double area = 0;
        bool above = false;
    };
    std::vector<Sum> sums(used.size());
    std::vector<Vec3> base;
    for (const std::uint32_t number : used) {
        const auto& known = source.materials[number].reflectance;
        report.reflectance_assumed += known ? 0 : 1;
        base.push_back(known.value_or(options.reflectance.value_or(kUnknownReflectance)));
    }
    const std::uint64_t samples = options.limits.texture_samples / triangles.size();
    bool varies = !source.colours.empty();
    for (const std::uint32_t number : used) varies = varies || source.materials[number].texture.has_value();
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        const std::uint32_t m = mesh.material[t];
        const Vec3 factor = colour_factor(source, source.materials[used[m]], triangles[t], samples);
        const Vec3 colour = clamped(hadamard(base[m], factor), sums[m].above);
        const double area = length(area_vector(corners_of(source, triangles[t])));
        sums[m].colour += colour * area;
        sums[m].area += area;
        if (varies) mesh.reflectance.push_back(to_float(colour));
    }
    for (std::size_t m = 0; m < used.size(); ++m) {
        const SourceMaterial& material = source.materials[used[m]];
        const bool textured = material.texture || !source.colours.empty();
        const Vec3 whole =
            material.texture ? hadamard(base[m], source.textures[material.texture->texture].mean) : base[m];
        bool by_rounding = false;  // that the mean is above what it is the mean of
        const Vec3 reflectance = textured && sums[m].area > 0 ? clamped(sums[m].colour / sums[m].area, by_rounding)
                                                              : clamped(whole, sums[m].above);
        mesh.materials.push_back({material.name, reflectance, material.exitance, textured});
        report.reflectance_clamped += sums[m].above ? 1 : 0;
    }
}

Error nothing_left(const std::filesystem::path& path, const ImportReport& report) {
    if (report.source_triangles == 0) return bad_input(path.string(), "the file has no faces, expected at least one");
    return bad_input(path.string(), "none of the " + std::to_string(report.source_triangles) +
                                        " triangles has an area: " + std::to_string(report.dropped_not_finite) +
                                        " with corners that are not finite, " +
                                        std::to_string(report.dropped_degenerate) + " degenerate");
}

}  // namespace

Result<ImportedMesh> import_mesh(const std::filesystem::path& path, const ImportOptions& options) {
    assert(options.unit > 0);
    SourceFiles files(options.limits);
    auto read = read_source(path, files);
    if (!read) return read.error();
    SourceMesh source = *std::move(read);
    if (auto checked = check_indices(source, path); !checked) return checked.error();
    to_archive_frame(source.positions, options);

    ImportedMesh imported;
    Mesh& mesh = imported.mesh;
    ImportReport& report = imported.report;
    report.warnings = std::move(source.warnings);
    report.textures_not_read = source.textures_not_read;
    auto finite = finite_triangles(source, path, options.limits, report);
    if (!finite) return finite.error();
    std::vector<KeptTriangle> triangles = *std::move(finite);
    if (auto checked = check_extent(source, triangles, path); !checked) return checked.error();
    const std::vector<KeptTriangle> dropped = drop_degenerate(source, triangles, report);
    if (triangles.empty()) return nothing_left(path, report);
    fill_triangles(source, triangles, dropped, mesh, report);
    report.extent = extent_of(mesh.positions);
    const std::vector<std::uint32_t> used = fill_materials(source, triangles, mesh);
    fill_colours(source, triangles, used, options, mesh, report);
    mesh.source_triangles = report.source_triangles;
    imported.sha256 = sha256_hex(std::as_bytes(std::span(files.bytes())));
    imported.files = files.paths();
    report.absent.assign(files.absent().begin(), files.absent().end());
    return imported;
}

}  // namespace rro
