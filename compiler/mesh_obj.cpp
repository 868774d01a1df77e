// OBJ. tinyobjloader splits the file into statements and gives them in the order of the file, which its own mesh does
// not keep (it groups by shape and counts at most 255 corners). Numbers are read from the statement's line a second
// time: the library takes "nan", "1,5" and a missing coordinate for other numbers without a word.
#include <algorithm>
#include <array>
#include <limits>
#include <numbers>
#include <set>
#include <sstream>
#include <unordered_map>

#define TINYOBJLOADER_USE_DOUBLE
#include <tiny_obj_loader.h>

#include "compiler/mesh_readers.h"
#include "compiler/mesh_text.h"

namespace rro {
namespace {

constexpr std::uint32_t kNoUv = std::numeric_limits<std::uint32_t>::max();

/// "i", "i/t", "i//n" or "i/t/n"; 0 where t is absent.
struct CornerWord {
    std::int64_t position = 0, uv = 0;
};

std::optional<CornerWord> parse_corner(std::string_view word) {
    CornerWord corner;
    for (int field = 0; field < 3; ++field) {
        const std::size_t slash = word.find('/');
        const std::string_view text = word.substr(0, slash);
        const auto value = parse_integer(text);
        if (!value && !(text.empty() && field == 1 && slash != word.npos)) return std::nullopt;
        if (value && *value == 0) return std::nullopt;
        if (field == 0) corner.position = *value;
        if (field == 1) corner.uv = value.value_or(0);
        if (slash == word.npos) return corner;
        word.remove_prefix(slash + 1);
    }
    return std::nullopt;
}

/// Follows the parser through the text: where the statement it has just read begins, and on which line.
class Statement {
  public:
    Statement(std::string_view original, std::string_view joined) : lines_(original), joined_(joined) {}

    /// Moves to the statement that ends before `end`; stays where it is already there.
    void move_to(std::size_t end) {
        if (lines_.offset() >= end) return;
        std::string_view line;
        std::size_t begin = lines_.offset();
        bool continues = false;
        while (lines_.offset() < end) {
            if (!continues) {
                begin = lines_.offset();
                number_ = lines_.line_number() + 1;
            }
            lines_.next(line);
            continues = joined_[lines_.offset() - 1] == ' ' && lines_.offset() < joined_.size();
        }
        text_ = joined_.substr(begin, end - begin);
        text_ = text_.substr(0, text_.find_first_of("\r\n"));
    }
    std::string_view text() const { return text_; }
    std::size_t line() const { return number_; }

  private:
    LineReader lines_;
    std::string_view joined_, text_;
    std::size_t number_ = 0;
};

/// The text with "\" at a line's end turned into blanks, so that every statement stands on one line; same length.
std::string joined_lines(std::string_view text) {
    std::string joined(text);
    if (text.find("\\\n") == text.npos && text.find("\\\r") == text.npos) return joined;
    LineReader lines(text);
    std::string_view line;
    for (std::size_t begin = 0; lines.next(line); begin = lines.offset()) {
        // A comment may end in a path of another system; it does not go on.
        if (!line.ends_with('\\') || trimmed(line).starts_with('#')) continue;
        std::fill(joined.begin() + static_cast<std::ptrdiff_t>(begin + line.size() - 1),
                  joined.begin() + static_cast<std::ptrdiff_t>(lines.offset()), ' ');
    }
    return joined;
}

/// Everything that the callbacks write to.
class ObjReader {
  public:
    ObjReader(const std::filesystem::path& path, std::string_view text, SourceFiles& files)
        : path_(path), files_(files), joined_(joined_lines(text)), stream_(joined_), statement_(text, joined_) {}

    Result<SourceMesh> read();
    bool read_library(const std::string& name);

  private:
    void move_here() {
        const auto end = stream_.rdbuf()->pubseekoff(0, std::ios::cur, std::ios::in);
        statement_.move_to(static_cast<std::size_t>(end));
        split_words(statement_.text(), words_);
        const auto comment = std::find_if(words_.begin(), words_.end(), [](auto w) { return w.starts_with('#'); });
        words_.erase(comment, words_.end());
    }
    std::string here() const { return at_line(path_, statement_.line()); }
    void fail_with(Error error) {
        if (!error_) error_ = std::move(error);
    }
    void fail(std::string message, std::string hint = {}) {
        fail_with(bad_input(here(), std::move(message), std::move(hint)));
    }
    void vertex();
    void texture_coordinate();
    void face();
    void use_material(std::string_view name);
    std::optional<std::uint32_t> resolved(std::int64_t index, std::size_t count, const char* what);
    std::uint32_t material_named(const std::string& name);
    void warn_of_ignored();
    void describe_materials();
    void describe(SourceMaterial& material, const MtlMaterial& source);
    std::optional<std::uint32_t> texture_of(const std::string& name);
    Status resolve_uvs();

    const std::filesystem::path& path_;
    SourceFiles& files_;
    std::string joined_;
    std::istringstream stream_;
    Statement statement_;
    std::vector<std::string_view> words_;
    std::optional<Error> error_;

    SourceMesh mesh_;
    std::vector<Uv> uvs_;                     // of the file
    std::vector<std::uint32_t> corner_uv_;    // into uvs_, or kNoUv
    std::optional<std::uint32_t> current_;    // material; none before the first usemtl
    std::vector<std::size_t> material_line_;  // of first use
    std::unordered_map<std::string, std::uint32_t> material_index_;
    std::unordered_map<std::string, MtlMaterial> library_;
    std::unordered_map<std::string, std::optional<std::uint32_t>> texture_index_;
    std::set<std::filesystem::path> libraries_read_;
    std::filesystem::path library_folder_;
    bool has_colours_ = false;
};

void ObjReader::vertex() {
    move_here();
    if (error_) return;
    if (is_too_large(mesh_, files_.limits(), 1)) return fail_with(too_large(here(), files_.limits()));
    Vec3 p;
    for (int i = 0; i < 3; ++i) {
        const std::size_t at = static_cast<std::size_t>(i) + 1;
        if (at >= words_.size()) return fail("a vertex with fewer than three coordinates");
        const auto value = parse_real(words_[at]);
        if (!value)
            return fail("found " + in_quotes(words_[at]) + ", expected a coordinate",
                        "numbers are written with a decimal point: 1.5");
        p[i] = *value;
    }
    has_colours_ |= words_.size() >= 7;
    mesh_.positions.push_back(p);
}

void ObjReader::texture_coordinate() {
    move_here();
    if (error_) return;
    if (uvs_.size() >= files_.limits().corners) return fail_with(too_large(here(), files_.limits()));
    Uv uv{0, 0};
    for (std::size_t i = 0; i < 2 && i + 1 < words_.size(); ++i) {
        const auto value = parse_real(words_[i + 1]);
        if (!value) return fail("found " + in_quotes(words_[i + 1]) + ", expected a texture coordinate");
        uv[i] = *value;
    }
    uvs_.push_back(uv);
}

/// 0-based index; one from the end where negative. Forward references are checked when the file has been read.
std::optional<std::uint32_t> ObjReader::resolved(std::int64_t index, std::size_t count, const char* what) {
    const std::int64_t at = index > 0 ? index - 1 : index + static_cast<std::int64_t>(count);
    if (at >= 0 && at < kNoUv) return static_cast<std::uint32_t>(at);
    fail(std::string("index ") + std::to_string(index) + ", but there are " + std::to_string(count) + " " + what +
         " so far");
    return std::nullopt;
}

void ObjReader::face() {
    move_here();
    if (error_) return;
    if (is_too_large(mesh_, files_.limits(), words_.size())) return fail_with(too_large(here(), files_.limits()));
    if (!current_) current_ = material_named(default_material);
    for (std::size_t i = 1; i < words_.size(); ++i) {
        const auto corner = parse_corner(words_[i]);
        if (!corner)
            return fail("found " + in_quotes(words_[i]) + ", expected a corner such as 1, 1/2, 1//3 or 1/2/3",
                        "indices count from 1");
        const auto position = resolved(corner->position, mesh_.positions.size(), "vertices");
        if (!position) return;
        std::uint32_t uv = kNoUv;
        if (corner->uv != 0) {
            const auto index = resolved(corner->uv, uvs_.size(), "texture coordinates");
            if (!index) return;
            uv = *index;
        }
        mesh_.corners.push_back(*position);
        corner_uv_.push_back(uv);
    }
    mesh_.face_line.push_back(static_cast<std::uint32_t>(statement_.line()));
    end_face(mesh_, *current_);
}

void ObjReader::use_material(std::string_view name) {
    move_here();
    name = trimmed(name);
    current_ = material_named(name.empty() ? default_material : std::string(name));
}

std::uint32_t ObjReader::material_named(const std::string& name) {
    const auto [at, is_new] = material_index_.try_emplace(name, static_cast<std::uint32_t>(mesh_.materials.size()));
    if (is_new) {
        mesh_.materials.push_back({name, {}, {}, {}});
        material_line_.push_back(statement_.line());
    }
    return at->second;
}

/// Only now: an mtllib may stand behind the usemtl that needs it.
void ObjReader::describe_materials() {
    std::size_t unknown = 0, first_unknown = 0;
    for (std::size_t i = 0; i < mesh_.materials.size(); ++i) {
        SourceMaterial& material = mesh_.materials[i];
        if (const auto known = library_.find(material.name); known != library_.end())
            describe(material, known->second);
        else if (material.name != default_material && unknown++ == 0)
            first_unknown = i;
    }
    if (unknown > 0)
        mesh_.warnings.push_back(at_line(path_, material_line_[first_unknown]) + ": no MTL describes material " +
                                 in_quotes(mesh_.materials[first_unknown].name) +
                                 (unknown > 1 ? " and " + std::to_string(unknown - 1) + " more" : "") +
                                 ": taken as without colour");
}

void ObjReader::describe(SourceMaterial& material, const MtlMaterial& source) {
    const auto warn = [&](const char* text) {
        mesh_.warnings.push_back("material " + in_quotes(material.name) + ": " + text);
    };
    material.reflectance = source.kd;
    material.exitance = source.ke * std::numbers::pi;
    if (source.transparent) warn("transparency (d, Tr) is ignored: it is opaque");
    if (source.emissive_map) warn("map_Ke is ignored: Ke alone counts");
    if (source.map_kd.empty()) return;
    const auto texture = texture_of(source.map_kd);
    if (!texture) return;
    if (!material.reflectance) material.reflectance = Vec3{1, 1, 1};
    material.texture = source.use;
    material.texture->texture = *texture;
}

/// Looks where the MTL says, then for the same file name beside the MTL (paths of the author's own disk are common).
std::optional<std::uint32_t> ObjReader::texture_of(const std::string& name) {
    const auto [at, is_new] = texture_index_.try_emplace(name, std::nullopt);
    if (!is_new) return at->second;
    std::string portable = name;
    for (char& c : portable)
        if (c == '\\') c = '/';
    std::filesystem::path file = library_folder_ / portable;
    std::error_code ignored;
    if (!files_.has(file) && !std::filesystem::exists(file, ignored))
        file = library_folder_ / std::filesystem::path(portable).filename();
    const auto bytes = files_.read(file);
    auto texture = bytes ? decode_texture(*bytes, pixels_left(mesh_, files_.limits())) : bytes.error();
    if (!texture) {
        // The end of a long path tells more than its beginning.
        const std::string shown = name.size() > 40 ? std::filesystem::path(portable).filename().string() : name;
        leave_out_texture(mesh_, "texture " + in_quotes(shown), texture.error(), "Kd");
        return std::nullopt;
    }
    at->second = static_cast<std::uint32_t>(mesh_.textures.size());
    mesh_.textures.push_back(std::move(*texture));
    return at->second;
}

/// False where there is no such file (the library then tries the statement's next name).
bool ObjReader::read_library(const std::string& name) {
    if (error_) return false;
    move_here();
    // One name with blanks in it is more common than several names.
    const std::string_view text = trimmed(statement_.text());
    std::filesystem::path file = path_.parent_path() / std::string(trimmed(text.substr(6)));
    if (!files_.has(file)) file = path_.parent_path() / name;
    if (!files_.has(file)) {
        mesh_.warnings.push_back(here() + ": material file " + in_quotes(name) +
                                 " is missing");
        return false;
    }
    if (!libraries_read_.insert(file).second) return true;  // many exporters name the same one before every object
    const auto content = files_.read(file);
    if (!content) {
        error_ = content.error();
        return false;
    }
    const auto materials = read_mtl(file, *content);
    if (!materials) {
        error_ = materials.error();
        return false;
    }
    library_folder_ = file.parent_path();
    for (const auto& [material, description] : *materials) library_.try_emplace(material, description);
    return true;
}

/// Hands mtllib statements to the reader. The library wants one material of its own per file read.
class LibraryReader : public tinyobj::MaterialReader {
  public:
    explicit LibraryReader(ObjReader& reader) : reader_(reader) {}
    bool operator()(const std::string& name, std::vector<tinyobj::material_t>* materials, std::map<std::string, int>*,
                    std::string*, std::string*) override {
        if (!reader_.read_library(name)) return false;
        materials->emplace_back();
        return true;
    }

  private:
    ObjReader& reader_;
};

/// Coordinates per corner, and whether all indices exist.
Status ObjReader::resolve_uvs() {
    if (uvs_.empty() && std::all_of(corner_uv_.begin(), corner_uv_.end(), [](auto i) { return i == kNoUv; }))
        return Done{};
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    mesh_.uvs.reserve(corner_uv_.size());
    std::size_t corner = 0;
    for (std::size_t face = 0; face < mesh_.face_end.size(); ++face)
        for (; corner < mesh_.face_end[face]; ++corner) {
            const std::uint32_t uv = corner_uv_[corner];
            if (uv != kNoUv && uv >= uvs_.size())
                return bad_input(at_line(path_, mesh_.face_line[face]),
                                 "texture coordinate " + std::to_string(std::uint64_t{uv} + 1) + ", but there are " +
                                     std::to_string(uvs_.size()));
            mesh_.uvs.push_back(uv == kNoUv ? Uv{kNan, kNan} : uvs_[uv]);
        }
    return Done{};
}

/// What makes no surface here, though its author may think so. (The library passes over it without a word.)
void ObjReader::warn_of_ignored() {
    static constexpr std::array<std::string_view, 18> understood{
        "f",      "v",     "vn",       "vt",       "usemtl",     "g",        "s",  "o",  "mtllib",
        "usemap", "maplib", "c_interp", "d_interp", "shadow_obj", "trace_obj", "lod", "mg", "bevel"};
    LineReader lines(joined_);
    std::string_view line;
    std::size_t drawn = 0, others = 0, first_line = 0;
    std::string first;
    while (lines.next(line)) {
        line = trimmed(line);
        const std::string_view word = line.substr(0, line.find_first_of(" \t"));
        if (word.empty() || word.starts_with('#')) continue;
        if (std::find(understood.begin(), understood.end(), word) != understood.end()) continue;
        if (word == "p" || word == "l") {
            ++drawn;
        } else if (others++ == 0) {
            first = in_quotes(word);
            first_line = lines.line_number();
        }
    }
    if (drawn > 0) mesh_.warnings.push_back("points and lines are ignored");
    if (others > 0)
        mesh_.warnings.push_back(std::to_string(others) + " statements of another kind are ignored, the first is " +
                                 first + " in line " + std::to_string(first_line));
}

Result<SourceMesh> ObjReader::read() {
    if (const auto line = find_long_line(joined_))
        return bad_input(at_line(path_, *line), "the statement is too long to be one");
    tinyobj::callback_t calls;
    calls.vertex_cb = [](void* user, double, double, double, double) { static_cast<ObjReader*>(user)->vertex(); };
    calls.texcoord_cb = [](void* user, double, double, double) { static_cast<ObjReader*>(user)->texture_coordinate(); };
    calls.index_cb = [](void* user, tinyobj::index_t*, int) { static_cast<ObjReader*>(user)->face(); };
    calls.usemtl_cb = [](void* user, const char* name, int) { static_cast<ObjReader*>(user)->use_material(name); };
    LibraryReader library(*this);
    std::string warnings, faults;
    tinyobj::LoadObjWithCallback(stream_, calls, this, &library, &warnings, &faults);
    if (error_) return *error_;
    warn_of_ignored();
    describe_materials();
    if (auto resolved_all = resolve_uvs(); !resolved_all) return resolved_all.error();
    if (has_colours_) mesh_.warnings.push_back("vertex colours are ignored: OBJ does not say what they mean");
    return std::move(mesh_);
}

}  // namespace

Result<SourceMesh> read_obj(const std::filesystem::path& path, std::string_view bytes, SourceFiles& files) {
    return ObjReader(path, bytes, files).read();
}

}  // namespace rro
