// The files of a mesh, and which reader takes them.
#include <algorithm>
#include <fstream>

#include "compiler/mesh_readers.h"
#include "compiler/mesh_text.h"

namespace rro {
namespace {

/// Files that one mesh may consist of: far more than any has, and few enough to look one up among them.
constexpr std::uint64_t kMostReads = 4096;

/// The format that the content begins like, as its ending; "" for OBJ and whatever else has no beginning of its own.
std::string_view ending_of_content(std::string_view bytes) {
    const std::size_t start = std::min(bytes.find_first_not_of(" \t\r\n"), bytes.size());
    const std::string_view text = bytes.substr(start);
    if (bytes.starts_with("glTF")) return ".glb";
    if (text.starts_with("{")) return ".gltf";
    if (bytes.starts_with("ply\n") || bytes.starts_with("ply\r")) return ".ply";
    if (text.starts_with("solid")) return ".stl";
    if (text.starts_with("OFF")) return ".off";
    return "";
}

/// The ending that suits the content, where that begins like another format than its ending tells; else "".
std::string_view other_format(std::string_view bytes, std::string_view ending) {
    const std::string_view likely = ending_of_content(bytes);
    const bool same = likely == ending || (ending.starts_with(".gl") && likely.starts_with(".gl"));
    return same ? "" : likely;
}

Result<SourceMesh> read_format(const std::filesystem::path& path, std::string_view ending, std::string_view bytes,
                               SourceFiles& files) {
    if (ending == ".obj") return read_obj(path, bytes, files);
    if (ending == ".ply") return read_ply(path, bytes, files.limits());
    if (ending == ".stl") return read_stl(path, bytes, files.limits());
    if (ending == ".off") return read_off(path, bytes, files.limits());
    return read_gltf(path, bytes, files);
}

}  // namespace

std::uint64_t pixels_left(const SourceMesh& mesh, const ImportLimits& limits) {
    std::uint64_t used = 0;
    for (const Texture& texture : mesh.textures) used += std::uint64_t{texture.width} * texture.height;
    return std::min(limits.image_pixels, limits.texture_pixels - std::min(used, limits.texture_pixels));
}

bool SourceFiles::has(const std::filesystem::path& path) {
    std::error_code ignored;
    if (std::filesystem::is_regular_file(path, ignored)) return true;
    if (!path.empty()) absent_.insert(path);
    return false;
}

Result<std::string> SourceFiles::read(const std::filesystem::path& path) {
    std::error_code fault;
    has(path);
    const auto status = std::filesystem::status(path, fault);
    if (!std::filesystem::exists(status)) return bad_input(path.string(), "no such file");
    if (std::filesystem::is_directory(status)) return bad_input(path.string(), "found a folder, expected a file");
    // A pipe may never end, and a device neither.
    if (!std::filesystem::is_regular_file(status))
        return bad_input(path.string(), "found a pipe or a device, expected a file");
    const std::uint64_t size = std::filesystem::file_size(path, fault);
    if (fault) return bad_input(path.string(), "the file cannot be read");
    if (size > limits_.file_bytes - bytes_read_ || reads_ == kMostReads)
        return bad_input(path.string(), "found " + std::to_string(size) + " bytes, after " +
                                            std::to_string(bytes_read_) + " of " + std::to_string(reads_) +
                                            " files, expected a mesh of at most " + std::to_string(limits_.file_bytes) +
                                            " bytes in " + std::to_string(kMostReads) + " files");
    bytes_read_ += size;
    ++reads_;
    std::ifstream stream(path, std::ios::binary);
    std::string content(size, '\0');
    stream.read(content.data(), static_cast<std::streamsize>(size));
    if (!stream.is_open() || stream.bad()) return bad_input(path.string(), "the file cannot be read");
    content.resize(static_cast<std::size_t>(stream.gcount()));
    if (std::find(paths_.begin(), paths_.end(), path) == paths_.end()) {
        paths_.push_back(path);
        bytes_ += content;
    }
    return content;
}

Result<SourceMesh> read_source(const std::filesystem::path& path, SourceFiles& files) {
    std::string ending = path.extension().string();
    for (char& c : ending)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    if (ending != ".obj" && ending != ".gltf" && ending != ".glb" && ending != ".ply" && ending != ".stl" &&
        ending != ".off")
        return bad_input(path.string(),
                         "found the ending " + in_quotes(ending) + ", expected .obj, .gltf, .glb, .ply, .stl or .off",
                         "the ending tells the format");
    const auto content = files.read(path);
    if (!content) return content.error();
    if (content->empty()) return bad_input(path.string(), "the file is empty");
    const std::string_view bytes = without_mark(*content);
    auto source = read_format(path, ending, bytes, files);
    if (const std::string_view likely = other_format(bytes, ending); !likely.empty()) {
        const std::string hint = "the content begins like that of a " + std::string(likely) + " file: rename it";
        if (!source) return bad_input(source.error().where, source.error().message, hint);
        if (source->face_end.empty()) return bad_input(path.string(), "the file has no faces", hint);
    }
    return source;
}

}  // namespace rro
