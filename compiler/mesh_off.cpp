// OFF and its kin (COFF, NOFF, STOFF and combinations) as text; one vertex or face per line.
#include <limits>

#include "compiler/mesh_readers.h"
#include "compiler/mesh_text.h"

namespace rro {
namespace {

/// What the keyword says about a vertex line.
struct OffKind {
    bool texture = false, colour = false, normal = false;
};

/// "[ST][C][N]OFF"; none for anything else (4OFF, nOFF: other dimensions).
std::optional<OffKind> parse_kind(std::string_view word) {
    OffKind kind;
    const auto take = [&](std::string_view prefix) {
        const bool found = word.starts_with(prefix);
        if (found) word.remove_prefix(prefix.size());
        return found;
    };
    kind.texture = take("ST");
    kind.colour = take("C");
    kind.normal = take("N");
    if (word != "OFF") return std::nullopt;
    return kind;
}

class OffReader {
  public:
    OffReader(const std::filesystem::path& path, std::string_view text, const ImportLimits& limits)
        : path_(path), text_(text), lines_(text), limits_(limits) {
        mesh_.materials.push_back({default_material, {}, {}, {}});
    }

    Result<SourceMesh> read() {
        if (const auto line = find_long_line(text_))
            return bad_input(at_line(path_, *line), "the line is too long to be one");
        if (auto header = read_header(); !header) return header.error();
        for (std::int64_t i = 0; i < vertices_; ++i)
            if (auto vertex = read_vertex(i); !vertex) return vertex.error();
        for (std::int64_t i = 0; i < faces_; ++i)
            if (auto face = read_face(i); !face) return face.error();
        if (next_line()) mesh_.warnings.push_back(place() + ": what follows the last face is ignored");
        if (coloured_) mesh_.materials[0].reflectance = Vec3{1, 1, 1};
        if (!coloured_) mesh_.colours.clear();
        return std::move(mesh_);
    }

  private:
    std::string place() const { return at_line(path_, lines_.line_number()); }
    Error wrong(const std::string& message) const { return bad_input(place(), message); }
    std::string found() const { return words_.empty() ? "found the end of the file" : "found " + in_quotes(words_[0]); }

    /// The words of the next line that has any; comments cut off.
    bool next_line() {
        std::string_view line;
        while (lines_.next(line)) {
            split_words(line.substr(0, line.find('#')), words_);
            if (!words_.empty()) return true;
        }
        words_.clear();
        return false;
    }

    Status read_header() {
        next_line();
        const auto kind = words_.empty() ? std::nullopt : parse_kind(words_[0]);
        if (!kind) return wrong(found() + ", expected OFF, COFF, NOFF or STOFF");
        kind_ = *kind;
        words_.erase(words_.begin());
        if (!words_.empty() && words_[0] == "BINARY")
            return bad_input(place(), "binary OFF is not supported", "save the mesh as PLY, or as text");
        if (words_.empty()) next_line();
        const auto vertices = words_.empty() ? std::nullopt : parse_integer(words_[0]);
        const auto faces = words_.size() < 2 ? std::nullopt : parse_integer(words_[1]);
        if (!vertices || !faces || *vertices < 0 || *faces < 0)
            return wrong(found() + ", expected the numbers of vertices, faces and edges");
        vertices_ = *vertices;
        faces_ = *faces;
        return Done{};
    }

    Status read_vertex(std::int64_t number) {
        if (!next_line())
            return wrong("found " + std::to_string(number) + " vertices, expected " + std::to_string(vertices_));
        if (is_too_large(mesh_, limits_, 1)) return too_large(place(), limits_);
        if (words_.size() < 3) return wrong("a vertex with fewer than three coordinates");
        Vec3 p;
        for (int i = 0; i < 3; ++i) {
            const std::string_view word = words_[static_cast<std::size_t>(i)];
            const auto value = parse_real(word);
            if (!value) return wrong("found " + in_quotes(word) + ", expected a coordinate");
            p[i] = *value;
        }
        mesh_.positions.push_back(p);
        const std::size_t behind = kind_.normal ? 6 : 3;
        Vec3 colour{1, 1, 1};
        if (kind_.colour && words_.size() >= behind + 3) {
            auto read = read_colour(behind);
            if (!read) return read.error();
            colour = *read;
        }
        vertex_colour_.push_back(colour);
        return Done{};
    }

    /// Three whole numbers are 8-bit sRGB, three others linear.
    Result<Vec3> read_colour(std::size_t first) {
        Vec3 colour;
        bool whole = true;
        for (std::size_t i = 0; i < 3; ++i) whole = whole && parse_integer(words_[first + i]);
        for (std::size_t i = 0; i < 3; ++i) {
            const std::string_view word = words_[first + i];
            const auto value = parse_real(word);
            if (!value || !(*value >= 0) || *value > (whole ? 255 : 1))
                return wrong("found " + in_quotes(word) + ", expected a colour of 0 to " + (whole ? "255" : "1"));
            colour[static_cast<int>(i)] = whole ? srgb_to_linear(static_cast<std::uint8_t>(*value)) : *value;
        }
        coloured_ = true;
        return colour;
    }

    Status read_face(std::int64_t number) {
        if (!next_line())
            return wrong("found " + std::to_string(number) + " faces, expected " + std::to_string(faces_));
        const auto count = parse_integer(words_[0]);
        if (!count || *count < 0) return wrong(found() + ", expected the number of corners");
        const auto corners = static_cast<std::size_t>(*count);
        if (corners >= words_.size())
            return wrong("a face with " + std::to_string(words_.size() - 1) + " corners, expected " +
                         std::to_string(corners));
        if (is_too_large(mesh_, limits_, corners) || mesh_.face_end.size() >= limits_.corners)
            return too_large(place(), limits_);
        std::optional<Vec3> colour;
        if (words_.size() >= corners + 4) {  // one number alone names an entry of a colour table that nobody has
            auto read = read_colour(corners + 1);
            if (!read) return read.error();
            colour = *read;
        }
        for (std::size_t i = 1; i <= corners; ++i) {
            const auto index = parse_integer(words_[i]);
            if (!index) return wrong("found " + in_quotes(words_[i]) + ", expected the number of a vertex");
            if (*index < 0 || *index >= vertices_)
                return wrong("vertex " + std::to_string(*index) + ", but there are " + std::to_string(vertices_) +
                             " (0 is the first)");
            mesh_.corners.push_back(static_cast<std::uint32_t>(*index));
            mesh_.colours.push_back(colour.value_or(vertex_colour_[static_cast<std::size_t>(*index)]));
        }
        mesh_.face_line.push_back(static_cast<std::uint32_t>(lines_.line_number()));
        end_face(mesh_, 0);
        return Done{};
    }

    const std::filesystem::path& path_;
    std::string_view text_;
    LineReader lines_;
    const ImportLimits& limits_;
    std::vector<std::string_view> words_;
    OffKind kind_;
    std::int64_t vertices_ = 0, faces_ = 0;
    std::vector<Vec3> vertex_colour_;
    bool coloured_ = false;
    SourceMesh mesh_;
};

}  // namespace

Result<SourceMesh> read_off(const std::filesystem::path& path, std::string_view bytes, const ImportLimits& limits) {
    return OffReader(path, bytes, limits).read();
}

}  // namespace rro
