// PLY: text, binary little- and big-endian; elements and properties in any order, unknown ones are skipped.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "compiler/mesh_readers.h"
#include "compiler/mesh_text.h"

namespace rro {
namespace {

enum class PlyType { Int8, Uint8, Int16, Uint16, Int32, Uint32, Float, Double };
enum class PlyFormat { Text, LittleEndian, BigEndian };

struct PlyProperty {
    std::string name;
    PlyType type = PlyType::Float;
    std::optional<PlyType> count_type;  // a list where it has one
};

struct PlyElement {
    std::string name;
    std::int64_t count = 0;
    std::vector<PlyProperty> properties;

    std::optional<std::size_t> find(std::initializer_list<std::string_view> names) const {
        for (std::size_t i = 0; i < properties.size(); ++i)
            if (std::find(names.begin(), names.end(), properties[i].name) != names.end()) return i;
        return std::nullopt;
    }
};

std::optional<PlyType> parse_type(std::string_view word) {
    struct Name {
        std::string_view old_name, new_name;
        PlyType type;
    };
    static constexpr std::array<Name, 8> names{{{"char", "int8", PlyType::Int8},
                                                {"uchar", "uint8", PlyType::Uint8},
                                                {"short", "int16", PlyType::Int16},
                                                {"ushort", "uint16", PlyType::Uint16},
                                                {"int", "int32", PlyType::Int32},
                                                {"uint", "uint32", PlyType::Uint32},
                                                {"float", "float32", PlyType::Float},
                                                {"double", "float64", PlyType::Double}}};
    for (const Name& name : names)
        if (word == name.old_name || word == name.new_name) return name.type;
    return std::nullopt;
}

constexpr double kLargestWhole = std::numeric_limits<std::uint32_t>::max();  // of all types

bool is_whole(PlyType type) {
    return type != PlyType::Float && type != PlyType::Double;
}

/// Reads values from the body, one after the other.
class PlyBody {
  public:
    PlyBody(const std::filesystem::path& path, std::string_view bytes, std::size_t offset, std::size_t line,
            PlyFormat format)
        : path_(path), bytes_(bytes), offset_(offset), line_(line), format_(format) {}

    std::string place() const { return format_ == PlyFormat::Text ? at_line(path_, line_) : at_byte(path_, offset_); }
    std::uint32_t line() const { return format_ == PlyFormat::Text ? static_cast<std::uint32_t>(line_) : 0; }

    /// The next value of that type, exactly; every type fits a double.
    Result<double> next(PlyType type) {
        if (format_ == PlyFormat::Text) return next_word(type);
        switch (type) {
            case PlyType::Int8:
                return next_binary<std::int8_t>();
            case PlyType::Uint8:
                return next_binary<std::uint8_t>();
            case PlyType::Int16:
                return next_binary<std::int16_t>();
            case PlyType::Uint16:
                return next_binary<std::uint16_t>();
            case PlyType::Int32:
                return next_binary<std::int32_t>();
            case PlyType::Uint32:
                return next_binary<std::uint32_t>();
            case PlyType::Float:
                return next_binary<float>();
            case PlyType::Double:
                break;
        }
        return next_binary<double>();
    }

    bool at_end() const {
        return format_ == PlyFormat::Text ? bytes_.find_first_not_of(" \t\r\n", offset_) == bytes_.npos
                                          : offset_ == bytes_.size();
    }

  private:
    Result<double> next_word(PlyType type) {
        for (; offset_ < bytes_.size(); ++offset_) {
            const char c = bytes_[offset_];
            const bool ends_line = c == '\n' || (c == '\r' && bytes_.substr(offset_ + 1, 1) != "\n");
            line_ += ends_line ? 1 : 0;
            if (c != ' ' && c != '\t' && c != '\n' && c != '\r') break;
        }
        const std::size_t end = std::min(bytes_.find_first_of(" \t\r\n", offset_), bytes_.size());
        const std::string_view word = bytes_.substr(offset_, end - offset_);
        if (word.empty()) return bad_input(place(), "found the end of the file, expected a number");
        offset_ = end;
        const auto value = parse_real(word);
        const bool whole = value && *value == std::floor(*value) && std::abs(*value) <= kLargestWhole;
        if (!value || (is_whole(type) && !whole))
            return bad_input(
                place(), "found " + in_quotes(word) + ", expected a " + (is_whole(type) ? "whole " : "") + "number");
        return *value;
    }

    template <class Value>
    Result<double> next_binary() {
        if (bytes_.size() - offset_ < sizeof(Value))
            return bad_input(place(), "found the end of the file, expected more values", "the file is cut off");
        std::array<char, sizeof(Value)> raw;
        std::memcpy(raw.data(), bytes_.data() + offset_, sizeof(Value));
        static_assert(std::endian::native == std::endian::little);
        if (format_ == PlyFormat::BigEndian) std::reverse(raw.begin(), raw.end());
        offset_ += sizeof(Value);
        return static_cast<double>(std::bit_cast<Value>(raw));
    }

    const std::filesystem::path& path_;
    std::string_view bytes_;
    std::size_t offset_, line_;
    PlyFormat format_;
};

/// The header: formats and elements, and where the body begins.
class PlyHeader {
  public:
    PlyHeader(const std::filesystem::path& path, std::string_view bytes) : path_(path), lines_(bytes) {}

    Status read() {
        std::string_view line;
        if (!lines_.next(line) || trimmed(line) != "ply") return wrong("found " + in_quotes(line) + ", expected 'ply'");
        while (lines_.next(line)) {
            split_words(line, words_);
            if (words_.empty() || words_[0] == "comment" || words_[0] == "obj_info") continue;
            if (words_[0] == "end_header")
                return format_ ? Status(Done{}) : Status(wrong("the header has no format line"));
            if (auto read = statement(); !read) return read;
        }
        return wrong("found the end of the file, expected 'end_header'");
    }

    const std::vector<PlyElement>& elements() const { return elements_; }
    PlyBody body(std::string_view bytes) const {
        return {path_, bytes, lines_.offset(), lines_.line_number() + 1, *format_};
    }

  private:
    Error wrong(const std::string& message) const {
        return bad_input(at_line(path_, std::max<std::size_t>(lines_.line_number(), 1)), message);
    }

    Status statement() {
        const auto word = [&](std::size_t i) { return i < words_.size() ? words_[i] : std::string_view(); };
        if (word(0) == "format") {
            if (word(1) == "ascii") format_ = PlyFormat::Text;
            if (word(1) == "binary_little_endian") format_ = PlyFormat::LittleEndian;
            if (word(1) == "binary_big_endian") format_ = PlyFormat::BigEndian;
            if (!format_ || word(2) != "1.0")
                return wrong("found format " + in_quotes(word(1)) + " " + in_quotes(word(2)) +
                             ", expected ascii, binary_little_endian or binary_big_endian 1.0");
        } else if (word(0) == "element") {
            const auto count = parse_integer(word(2));
            if (!count || *count < 0) return wrong("found " + in_quotes(word(2)) + ", expected the number of elements");
            elements_.push_back({std::string(word(1)), *count, {}});
        } else if (word(0) == "property" && !elements_.empty()) {
            const bool is_list = word(1) == "list";
            const auto type = parse_type(word(is_list ? 3 : 1));
            const auto count_type = is_list ? parse_type(word(2)) : std::nullopt;
            if (!type) return wrong("found " + in_quotes(word(is_list ? 3 : 1)) + ", expected the type of a property");
            if (is_list && (!count_type || !is_whole(*count_type)))
                return wrong("found " + in_quotes(word(2)) + ", expected a whole number's type for a list's length");
            elements_.back().properties.push_back({std::string(word(is_list ? 4 : 2)), *type, count_type});
        } else {
            return wrong("found " + in_quotes(word(0)) + ", expected format, element, property or end_header");
        }
        return Done{};
    }

    const std::filesystem::path& path_;
    LineReader lines_;
    std::vector<std::string_view> words_;
    std::optional<PlyFormat> format_;
    std::vector<PlyElement> elements_;
};

/// One element's values; scalars as lists of one.
using PlyRow = std::vector<std::vector<double>>;

Status read_row(PlyBody& body, const PlyElement& element, const ImportLimits& limits, PlyRow& row) {
    row.resize(element.properties.size());
    for (std::size_t i = 0; i < element.properties.size(); ++i) {
        const PlyProperty& property = element.properties[i];
        std::int64_t count = 1;
        if (property.count_type) {
            const auto length = body.next(*property.count_type);
            if (!length) return length.error();
            if (*length < 0) return bad_input(body.place(), "a list of " + std::to_string(*length) + " values");
            count = static_cast<std::int64_t>(*length);
            if (static_cast<std::uint64_t>(count) > limits.corners)
                return bad_input(body.place(), "a list of " + std::to_string(count) + " values, expected at most " +
                                                   std::to_string(limits.corners));
        }
        row[i].clear();
        for (std::int64_t k = 0; k < count; ++k) {
            const auto value = body.next(property.type);
            if (!value) return value.error();
            row[i].push_back(*value);
        }
    }
    return Done{};
}

/// Where an element keeps its 8-bit colour, if it has one.
struct PlyColour {
    std::array<std::size_t, 3> at{};
    bool present = false, unusable = false;

    explicit PlyColour(const PlyElement& element) {
        const std::array<std::optional<std::size_t>, 3> found{element.find({"red", "diffuse_red"}),
                                                              element.find({"green", "diffuse_green"}),
                                                              element.find({"blue", "diffuse_blue"})};
        present = true;
        for (std::size_t c = 0; c < 3; ++c) {
            const bool usable = found[c] && element.properties[*found[c]].type == PlyType::Uint8 &&
                                !element.properties[*found[c]].count_type;
            present = present && usable;
            unusable = unusable || (found[c] && !usable);
            at[c] = found[c].value_or(0);
        }
    }
    Vec3 of(const PlyRow& row) const {
        Vec3 rgb;
        for (std::size_t c = 0; c < 3; ++c)
            rgb[static_cast<int>(c)] = srgb_to_linear(static_cast<std::uint8_t>(std::clamp(row[at[c]][0], 0.0, 255.0)));
        return rgb;
    }
};

class PlyReader {
  public:
    PlyReader(const std::filesystem::path& path, PlyBody body, const ImportLimits& limits)
        : path_(path), body_(body), limits_(limits) {
        mesh_.materials.push_back({default_material, {}, {}, {}});
    }

    Status vertices(const PlyElement& element) {
        const auto x = element.find({"x"}), y = element.find({"y"}), z = element.find({"z"});
        if (!x || !y || !z) return bad_input(path_.string(), "the vertices have no properties x, y and z");
        const PlyColour colour(element);
        warn_of(colour);
        PlyRow row;
        for (std::int64_t i = 0; i < element.count; ++i) {
            if (auto read = read_row(body_, element, limits_, row); !read) return read;
            if (is_too_large(mesh_, limits_, 1)) return too_large(body_.place(), limits_);
            if (row[*x].empty() || row[*y].empty() || row[*z].empty())
                return bad_input(body_.place(), "a vertex without coordinates");
            mesh_.positions.emplace_back(row[*x][0], row[*y][0], row[*z][0]);
            if (colour.present) vertex_colours_.push_back(colour.of(row));
        }
        return Done{};
    }

    Status faces(const PlyElement& element) {
        const auto list = element.find({"vertex_indices", "vertex_index"});
        if (!list || !element.properties[*list].count_type || !is_whole(element.properties[*list].type))
            return bad_input(path_.string(), "the faces have no list 'vertex_indices' of whole numbers");
        const PlyColour colour(element);
        warn_of(colour);
        PlyRow row;
        for (std::int64_t i = 0; i < element.count; ++i) {
            if (auto read = read_row(body_, element, limits_, row); !read) return read;
            if (is_too_large(mesh_, limits_, row[*list].size()) || mesh_.face_end.size() >= limits_.corners)
                return too_large(body_.place(), limits_);
            for (const double index : row[*list]) {
                if (!(index >= 0 && index < std::numeric_limits<std::uint32_t>::max()))
                    return bad_input(body_.place(), "face " + std::to_string(i) + " has the vertex " +
                                                        std::to_string(static_cast<std::int64_t>(index)) +
                                                        ", expected 0 or more");
                mesh_.corners.push_back(static_cast<std::uint32_t>(index));
            }
            end_face(mesh_, 0);
            if (body_.line() != 0) mesh_.face_line.push_back(body_.line());
            if (colour.present) mesh_.colours.resize(mesh_.corners.size(), colour.of(row));
        }
        return Done{};
    }

    /// Passes over an element, with a word if it holds a part of the surface.
    Status skip(const PlyElement& element) {
        if (element.name == "tristrips" && element.count > 0)
            mesh_.warnings.emplace_back("triangle strips are ignored: only faces are read");
        PlyRow row;
        for (std::int64_t i = 0; i < element.count && !element.properties.empty(); ++i)
            if (auto read = read_row(body_, element, limits_, row); !read) return read;
        return Done{};
    }

    SourceMesh finished() {
        if (!body_.at_end()) mesh_.warnings.push_back(body_.place() + ": what follows the last element is ignored");
        if (mesh_.colours.empty() && !vertex_colours_.empty())
            for (const std::uint32_t corner : mesh_.corners)
                mesh_.colours.push_back(corner < vertex_colours_.size() ? vertex_colours_[corner] : Vec3{});
        if (!mesh_.colours.empty()) mesh_.materials[0].reflectance = Vec3{1, 1, 1};
        return std::move(mesh_);
    }

  private:
    void warn_of(const PlyColour& colour) {
        if (colour.unusable) mesh_.warnings.emplace_back("colours that are no 8-bit numbers are ignored");
    }

    const std::filesystem::path& path_;
    PlyBody body_;
    const ImportLimits& limits_;
    SourceMesh mesh_;
    std::vector<Vec3> vertex_colours_;
};

}  // namespace

Result<SourceMesh> read_ply(const std::filesystem::path& path, std::string_view bytes, const ImportLimits& limits) {
    PlyHeader header(path, bytes);
    if (auto read = header.read(); !read) return read.error();
    PlyReader reader(path, header.body(bytes), limits);
    for (const PlyElement& element : header.elements()) {
        auto read = element.name == "vertex" ? reader.vertices(element)
                    : element.name == "face" ? reader.faces(element)
                                             : reader.skip(element);
        if (!read) return read.error();
    }
    return reader.finished();
}

}  // namespace rro
