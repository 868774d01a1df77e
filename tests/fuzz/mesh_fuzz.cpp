// Mesh files: the first byte chooses the format (mesh_input.h), the rest is the file. What the importer takes must be a
// mesh that later steps can work on.
#include <algorithm>
#include <fstream>

#include "compiler/mesh_import.h"
#include "tests/fuzz/json_mutator.h"
#include "tests/fuzz/mesh_input.h"
#include "tests/fuzz/reading.h"
#include "tests/support/image_files.h"
#include "tests/support/temporary_folder.h"

namespace {

using namespace rro;
using fuzz::require;

void write(const std::filesystem::path& file, std::string_view content) {
    std::ofstream(file, std::ios::binary | std::ios::trunc) << content;
}

/// A hundredth of what the program takes, and less: small files that ask for much are found out quickly.
constexpr ImportLimits kLimits{.file_bytes = 1 << 16,
                               .corners = 1 << 14,
                               .json_values = 1 << 12,
                               .image_pixels = 1 << 16,
                               .texture_pixels = 1 << 18,
                               .texture_samples = 1 << 18,
                               .polygon_steps = 1 << 22};

/// A folder in which a mesh finds a small file of each kind that it may refer to.
const test::TemporaryFolder& mesh_folder() {
    static const test::TemporaryFolder folder;
    static const bool filled = [] {
        write(folder / "a.mtl", "newmtl a\nKd 0.5 0.25 1\nKe 1 2 3\nd 0.5\nnewmtl b\nmap_Kd -s 2 2 1 a.tga\n");
        write(folder / "a.tga", test::tga_file(2, 2, {{114, 103, 98}, {82, 71, 66}, {97, 98, 99}, {65, 66, 67}}));
        constexpr std::array<float, 9> triangle{0, 0, 0, 1, 0, 0, 0, 1, 0};
        write(folder / "a.bin", {reinterpret_cast<const char*>(triangle.data()), sizeof triangle});
        write(folder / "mtl.obj", "mtllib mesh.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl a\n"
                                  "f 1/1 2/2 3/3\nusemtl b\nf 1/1 3/2 2/3\n");
        return true;
    }();
    (void)filled;
    return folder;
}

void check_mesh(const Mesh& mesh, const ImportReport& report) {
    const std::size_t triangles = mesh.triangles.size();
    require(triangles > 0 && mesh.source_triangle.size() == triangles && mesh.material.size() == triangles &&
                mesh.two_sided.size() == triangles &&
                (mesh.reflectance.empty() || mesh.reflectance.size() == triangles),
            "one entry per triangle");
    require(std::all_of(mesh.positions.begin(), mesh.positions.end(), [](const Vec3& p) { return is_finite(p); }),
            "positions are finite");
    for (std::size_t t = 0; t < triangles; ++t) {
        for (const std::uint32_t corner : mesh.triangles[t])
            require(corner < mesh.positions.size(), "corners exist");
        require(mesh.material[t] < mesh.materials.size(), "materials exist");
        require(mesh.source_triangle[t] < mesh.source_triangles, "source numbers are below their count");
    }
    for (const Material& material : mesh.materials)
        for (int c = 0; c < 3; ++c)
            require(material.reflectance[c] >= 0 && material.reflectance[c] <= 0.95 && material.exitance[c] >= 0 &&
                        is_finite(material.exitance),
                    "materials are physical");
    for (const Rgb& reflectance : mesh.reflectance)
        for (const float c : {reflectance.x, reflectance.y, reflectance.z})
            require(c >= 0 && c <= 0.951f, "reflectances of triangles are physical");
    require(report.one_sided_triangles + report.two_sided_triangles == triangles, "triangles have one side or two");
}

/// The input with its JSON changed, none where it has none.
std::optional<std::string> mutate_json_of(std::string_view input, unsigned seed) {
    const std::string_view format = input.empty() ? "" : fuzz::kMeshFormats[fuzz::format_of(input[0])];
    if (format != "gltf" && format != "parts") return std::nullopt;
    const std::size_t end = format == "parts" ? std::min(input.find('\0'), input.size()) : input.size();
    const auto json = fuzz::mutate_json(input.substr(1, end - 1), seed, LLVMFuzzerMutate);
    if (!json) return std::nullopt;
    return input[0] + *json + std::string(input.substr(end));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size == 0) return 0;
    const std::string_view input(reinterpret_cast<const char*>(data), size), content = input.substr(1);
    const std::string_view format = fuzz::kMeshFormats[fuzz::format_of(input[0])];
    const bool parts = format == "parts";
    std::filesystem::path file = mesh_folder() / ("mesh." + std::string(parts ? "glb" : format));
    write(file, parts ? fuzz::glb_of(content) : content);
    if (format == "mtl") file = mesh_folder() / "mtl.obj";

    ImportOptions options;
    options.limits = kLimits;
    auto imported = import_mesh(file, options);
    if (!imported) return 0;
    decide_sides(imported->mesh, TwoSided::Auto, true, imported->report);
    check_mesh(imported->mesh, imported->report);
    return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most, unsigned seed) {
    constexpr unsigned plain_one_in = 4;  // changes bytes, and so mostly what JSON is
    if (seed % plain_one_in != 0)
        if (const auto changed = mutate_json_of({reinterpret_cast<const char*>(data), size}, seed))
            if (const std::size_t changed_size = fuzz::hand_over(*changed, data, most)) return changed_size;
    return LLVMFuzzerMutate(data, size, most);
}
