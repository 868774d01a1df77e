// write_seeds TESTS FOLDER: what the fuzzers start from, one folder per target in FOLDER. Archives and sections are made
// here, by the writer of this very build, so that no seed is of yesterday's format, and taken from the tests' goldens and
// bad archives; meshes and manifests are files of fuzz/corpus, to which the binary mesh formats come. TESTS is the
// folder of all tests.
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "format/archive_reader.h"
#include "format/archive_writer.h"
#include "format/layout.h"
#include "tests/fuzz/mesh_input.h"
#include "tests/support/image_files.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_object.h"

namespace {

using namespace rro;
namespace fs = std::filesystem;

void write(const fs::path& file, std::string_view content) {
    fs::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary) << content;
}

std::string text_of(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// The box as it is, without what is optional, and far from its own zero.
std::vector<ObjectData> objects() {
    static const test::TinyObject box = test::tiny_object(2), far_away = test::tiny_object(3, {1e6, 0, -1e6});
    static test::TinyObject bare = test::tiny_object(2);
    bare.volumes.clear();
    bare.volume_triangles.clear();
    bare.area_clusters.clear();
    bare.whole_area.clear();
    bare.whole_area_scale.clear();
    bare.intrinsic_area.clear();
    bare.intrinsic_area_scale.clear();
    bare.visibility.clear();
    bare.error_directions = 0;
    bare.whole_area_error.clear();
    bare.intrinsic_area_error.clear();
    bare.visibility_error.clear();
    return {box.data(), far_away.data(), bare.data()};
}

/// Archives of this build, with each of their known sections behind the number of its kind.
void write_archives(const fs::path& folder) {
    int number = 0;
    for (const ObjectData& object : objects()) {
        const std::string name = "box" + std::to_string(number++);
        const auto bytes = encode_archive(object);
        if (!bytes) continue;
        write(folder / "archive_fuzz" / name, text_of(*bytes));
        const auto archive = Archive::from_bytes(*bytes, name);
        for (std::size_t kind = 0; archive && kind < layout::kSections.size(); ++kind) {
            const std::string section(layout::kSections[kind].name);
            if (const auto content = archive->section(section))
                write(folder / "section_fuzz" / (name + "." + section),
                      std::string(1, static_cast<char>(kind)) + text_of(*content));
        }
    }
}

/// Archives of the tests: good ones of every version, bad ones named by their fault.
void copy_archives(const fs::path& tests, const fs::path& folder) {
    for (const char* kind : {"golden", "corrupt"})
        for (const auto& file : fs::recursive_directory_iterator(tests / kind))
            if (file.path().extension() == ".rro")
                write(folder / "archive_fuzz" / (std::string(kind) + "." + file.path().stem().string()),
                      test::file_text(file.path()));
}

template <class Number, std::size_t count>
std::string raw(const std::array<Number, count>& numbers) {
    return text_of(std::as_bytes(std::span(numbers)));
}

constexpr std::array<float, 9> kTriangle{0, 0, 0, 1, 0, 0, 0, 1, 0};

std::string binary_stl() {
    return std::string(80, ' ') + raw(std::array<std::uint32_t, 1>{1}) + std::string(12, '\0') + raw(kTriangle) +
           std::string(2, '\0');
}

std::string binary_ply() {
    return "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
           "property float z\nelement face 1\nproperty list uchar int vertex_index\nend_header\n" +
           raw(kTriangle) + "\3" + raw(std::array<std::int32_t, 3>{0, 1, 2});
}

std::string gltf_parts() {
    return R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0}],)"
           R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],"buffers":[{"byteLength":48}],)"
           R"("bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":12}],)"
           R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},)"
           R"({"bufferView":1,"componentType":5125,"count":3,"type":"SCALAR"}]})" +
           std::string(1, '\0') + raw(kTriangle) + raw(std::array<std::uint32_t, 3>{0, 1, 2});
}

/// A triangle with texture coordinates, and its texture in a buffer view of its own.
std::string textured_parts(const std::string& image) {
    const std::string bytes = std::to_string(image.size());
    return R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0}],)"
           R"("meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},"material":0}]}],)"
           R"("materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}],"textures":[{"source":0}],)"
           R"("images":[{"bufferView":1,"mimeType":"image/png"}],"buffers":[{"byteLength":)" +
           std::to_string(36 + image.size()) + R"(}],"bufferViews":[{"buffer":0,"byteLength":36},)" +
           R"({"buffer":0,"byteOffset":36,"byteLength":)" + bytes +
           R"(}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},)"
           R"({"bufferView":0,"componentType":5126,"count":3,"type":"VEC2"}]})" +
           std::string(1, '\0') + raw(kTriangle) + image;
}

/// A small picture in each format that textures come in.
std::vector<std::pair<std::string, std::string>> pictures() {
    constexpr unsigned width = 5, height = 3;
    std::vector<unsigned char> rgb(width * height * 3);
    for (std::size_t i = 0; i < rgb.size(); ++i) rgb[i] = static_cast<unsigned char>(17 * i);
    return {{"png", test::png_file(width, height, {}, rgb)},
            {"jpg", test::jpeg_file(width, height, 3, true, rgb)},
            {"tga", test::tga_file(width, height, std::vector<test::Pixel>(width * height, {17, 34, 51}))}};
}

/// Mesh files behind the byte that names their format, the ending.
void write_meshes(const fs::path& corpus, const fs::path& folder) {
    const auto add = [&](const fs::path& name, const std::string& content) {
        for (std::size_t format = 0; format < fuzz::kMeshFormats.size(); ++format)
            if (name.extension() == "." + std::string(fuzz::kMeshFormats[format]))
                write(folder / name, fuzz::first_byte(format) + content);
    };
    for (const auto& file : fs::directory_iterator(corpus)) add(file.path().filename(), test::file_text(file.path()));
    add("binary.stl", binary_stl());
    add("binary.ply", binary_ply());
    add("triangle.parts", gltf_parts());
    for (const auto& [name, image] : pictures()) add(name + ".parts", textured_parts(image));
    add("triangle.glb", fuzz::glb_of(gltf_parts()));
}

}  // namespace

int main(int count, char** arguments) {
    if (count != 3) {
        std::fprintf(stderr, "usage: write_seeds TESTS FOLDER\n");
        return 2;
    }
    const fs::path tests = arguments[1], corpus = tests / "fuzz/corpus", folder = arguments[2];
    write_archives(folder);
    copy_archives(tests, folder);
    write_meshes(corpus / "mesh_fuzz", folder / "mesh_fuzz");
    for (const char* target : {"manifest_fuzz", "lights_fuzz"})
        for (const auto& file : fs::directory_iterator(corpus / target))
            write(folder / target / file.path().filename(), test::file_text(file.path()));
    return 0;
}
