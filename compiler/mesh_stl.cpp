// STL, text and binary; corners in file order, stored normals are not used.
#include <bit>
#include <cstring>

#include "compiler/mesh_readers.h"
#include "compiler/mesh_text.h"

namespace rro {
namespace {

static_assert(std::endian::native == std::endian::little, "binary STL is little-endian and copied as it is");

constexpr std::size_t kHeaderBytes = 84;  // 80 of comment, then the count
constexpr std::size_t kFacetBytes = 50;   // normal, three corners, two bytes of attributes

std::uint32_t facet_count(std::string_view bytes) {
    std::uint32_t count = 0;
    std::memcpy(&count, bytes.data() + 80, sizeof count);
    return count;
}

SourceMesh mesh_of_default_material() {
    SourceMesh mesh;
    mesh.materials.push_back({default_material, {}, {}, {}});
    return mesh;
}

SourceMesh read_binary(std::string_view bytes) {
    SourceMesh mesh = mesh_of_default_material();
    const std::uint32_t count = facet_count(bytes);
    if (bytes.substr(0, kHeaderBytes).find("COLOR=") != bytes.npos)
        mesh.warnings.emplace_back("colours are ignored: STL does not say what they mean");
    mesh.positions.reserve(std::size_t{3} * count);
    for (std::uint32_t facet = 0; facet < count; ++facet) {
        std::array<float, 9> corners;
        std::memcpy(corners.data(), bytes.data() + kHeaderBytes + facet * kFacetBytes + 12, sizeof corners);
        for (std::size_t i = 0; i < 9; i += 3) {
            mesh.corners.push_back(static_cast<std::uint32_t>(mesh.positions.size()));
            mesh.positions.emplace_back(corners[i], corners[i + 1], corners[i + 2]);
        }
        end_face(mesh, 0);
    }
    return mesh;
}

/// Words of the whole text with the line they stand on. Names behind "solid" and "endsolid" are skipped to the line's
/// end.
class TextReader {
  public:
    TextReader(const std::filesystem::path& path, std::string_view text, const ImportLimits& limits)
        : path_(path), text_(text), lines_(text), limits_(limits) {}

    Result<SourceMesh> read() {
        if (const auto line = find_long_line(text_))
            return bad_input(at_line(path_, *line), "the line is too long to be one");
        bool in_solid = false;
        while (const auto word = next()) {
            if (*word == (in_solid ? "endsolid" : "solid")) {
                in_solid = !in_solid;
                at_ = words_.size();
            } else if (!in_solid || *word != "facet") {
                return wrong(*word, in_solid ? "'facet' or 'endsolid'" : "'solid'");
            } else if (auto read = facet(); !read) {
                return read.error();
            }
        }
        if (in_solid) return wrong({}, "'endsolid'");
        return std::move(mesh_);
    }

  private:
    std::optional<std::string_view> next() {
        while (at_ == words_.size()) {
            std::string_view line;
            if (!lines_.next(line)) return std::nullopt;
            split_words(line, words_);
            at_ = 0;
        }
        return words_[at_++];
    }

    Error wrong(std::optional<std::string_view> found, const std::string& expected) const {
        return bad_input(at_line(path_, lines_.line_number()),
                         "found " +
                             (found && !found->empty() ? in_quotes(*found) : std::string("the end of the file")) +
                             ", expected " + expected);
    }

    Status words(std::initializer_list<std::string_view> expected) {
        for (const std::string_view word : expected)
            if (const auto found = next(); found != word) return wrong(found, in_quotes(word));
        return Done{};
    }

    Result<Vec3> point() {
        Vec3 p;
        for (int i = 0; i < 3; ++i) {
            const auto word = next();
            const auto value = word ? parse_real(*word) : std::nullopt;
            if (!value) return wrong(word, "a number");
            p[i] = *value;
        }
        return p;
    }

    Status facet() {
        if (auto read = words({"normal"}); !read) return read;
        const std::size_t line = lines_.line_number();
        if (auto normal = point(); !normal) return normal.error();
        if (auto read = words({"outer", "loop"}); !read) return read;
        if (is_too_large(mesh_, limits_, 3)) return too_large(at_line(path_, line), limits_);
        for (int corner = 0; corner < 3; ++corner) {
            if (auto read = words({"vertex"}); !read) return read;
            const auto p = point();
            if (!p) return p.error();
            mesh_.corners.push_back(static_cast<std::uint32_t>(mesh_.positions.size()));
            mesh_.positions.push_back(*p);
        }
        mesh_.face_line.push_back(static_cast<std::uint32_t>(line));
        end_face(mesh_, 0);
        return words({"endloop", "endfacet"});
    }

    const std::filesystem::path& path_;
    std::string_view text_;
    LineReader lines_;
    const ImportLimits& limits_;
    std::vector<std::string_view> words_;
    std::size_t at_ = 0;
    SourceMesh mesh_ = mesh_of_default_material();
};

}  // namespace

Result<SourceMesh> read_stl(const std::filesystem::path& path, std::string_view bytes, const ImportLimits& limits) {
    // By its size: many binary files begin with "solid", too.
    const bool has_header = bytes.size() >= kHeaderBytes;
    const std::uint64_t expected = has_header ? kHeaderBytes + std::uint64_t{kFacetBytes} * facet_count(bytes) : 0;
    if (has_header && bytes.size() == expected) {
        if (std::uint64_t{3} * facet_count(bytes) > limits.corners) return too_large(path.string(), limits);
        return read_binary(bytes);
    }
    const std::size_t start = bytes.find_first_not_of(" \t\r\n");
    if (start != bytes.npos && bytes.substr(start).starts_with("solid")) return TextReader(path, bytes, limits).read();
    if (!has_header)
        return bad_input(path.string(), "found " + std::to_string(bytes.size()) +
                                            " bytes, expected 'solid' or a binary STL of at least 84 bytes");
    return bad_input(path.string(),
                     "found " + std::to_string(bytes.size()) + " bytes, expected " + std::to_string(expected) +
                         " for the " + std::to_string(facet_count(bytes)) + " triangles that the header announces",
                     "the file is cut off, or no STL");
}

}  // namespace rro
