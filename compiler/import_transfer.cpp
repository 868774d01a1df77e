#include "compiler/import_transfer.h"

#include <cstring>
#include <filesystem>
#include <type_traits>
#include <vector>

namespace rro {
namespace {

/// Calls stream(field) for every field: one list for both directions. T is a type, or a constant one to write from.
template <class Stream>
void each_field(Stream& stream, auto& imported) requires requires {
    imported.mesh;
}
{
    auto& mesh = imported.mesh;
    stream(mesh.positions);
    stream(mesh.triangles);
    stream(mesh.source_triangle);
    stream(mesh.material);
    stream(mesh.reflectance);
    stream(mesh.materials);
    stream(mesh.two_sided);
    stream(mesh.source_triangles);
    stream(mesh.closed);
    stream(mesh.slits);
    auto& report = imported.report;
    stream(report.source_triangles);
    stream(report.dropped_not_finite);
    stream(report.dropped_degenerate);
    stream(report.ignored_faces);
    stream(report.duplicate_triangles);
    stream(report.welded_vertices);
    stream(report.polygons_triangulated);
    stream(report.polygons_ear_clipped);
    stream(report.reflectance_clamped);
    stream(report.reflectance_assumed);
    stream(report.textures_not_read);
    stream(report.components);
    stream(report.closed_components);
    stream(report.open_edges);
    stream(report.non_manifold_edges);
    stream(report.one_sided_triangles);
    stream(report.two_sided_triangles);
    stream(report.winding_fixed);
    stream(report.extent);
    stream(report.warnings);
    stream(report.absent);
    stream(imported.sha256);
    stream(imported.files);
}

template <class Stream>
void each_field(Stream& stream, auto& error) requires requires {
    error.hint;
}
{
    stream(error.kind);
    stream(error.where);
    stream(error.message);
    stream(error.hint);
}

template <class Stream>
void each_field(Stream& stream, auto& material) requires requires {
    material.exitance;
}
{
    stream(material.name);
    stream(material.reflectance);
    stream(material.exitance);
    stream(material.textured);
}

/// Lengths stand before what they count.
class Writer {
  public:
    template <class T>
    void operator()(const T& value) {
        if constexpr (std::is_trivially_copyable_v<T>)
            bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
        else
            each_field(*this, value);
    }
    void operator()(const std::string& text) {
        (*this)(text.size());
        bytes_ += text;
    }
    void operator()(const std::filesystem::path& path) { (*this)(path.native()); }
    template <class T>
    void operator()(const std::vector<T>& values) {
        (*this)(values.size());
        if constexpr (std::is_trivially_copyable_v<T>) {
            bytes_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
        } else {
            for (const T& value : values) (*this)(value);
        }
    }
    std::string bytes() && { return std::move(bytes_); }

  private:
    std::string bytes_;
};

/// After the first length beyond the bytes at hand everything reads as empty, and is_complete() stays false.
class Reader {
  public:
    explicit Reader(std::string_view bytes) : bytes_(bytes) {}

    template <class T>
    void operator()(T& value) {
        if constexpr (std::is_trivially_copyable_v<T>)
            take(&value, 1, sizeof value);
        else
            each_field(*this, value);
    }
    void operator()(std::string& text) { fill(text); }
    void operator()(std::filesystem::path& path) {
        std::string text;
        fill(text);
        path = text;
    }
    template <class T>
    void operator()(std::vector<T>& values) {
        if constexpr (std::is_trivially_copyable_v<T>) {
            fill(values);
        } else {
            for (std::size_t left = length(1); left > 0 && good_; --left) (*this)(values.emplace_back());
        }
    }
    bool is_complete() const { return good_ && bytes_.empty(); }

  private:
    /// The length of what follows, at most as many as there are bytes for.
    std::size_t length(std::size_t bytes_each) {
        std::size_t count = 0;
        (*this)(count);
        good_ = good_ && count <= bytes_.size() / bytes_each;
        return good_ ? count : 0;
    }
    template <class Container>
    void fill(Container& container) {
        constexpr std::size_t kBytesEach = sizeof(typename Container::value_type);
        container.resize(length(kBytesEach));
        take(container.data(), container.size(), kBytesEach);
    }
    void take(void* to, std::size_t count, std::size_t bytes_each) {
        good_ = good_ && count <= bytes_.size() / bytes_each;
        if (!good_ || count == 0) return;
        std::memcpy(to, bytes_.data(), count * bytes_each);
        bytes_.remove_prefix(count * bytes_each);
    }

    std::string_view bytes_;
    bool good_ = true;
};

}  // namespace

std::string encode_import(const Result<ImportedMesh>& imported) {
    Writer writer;
    writer(static_cast<bool>(imported));
    if (imported)
        each_field(writer, *imported);
    else
        each_field(writer, imported.error());
    return std::move(writer).bytes();
}

std::optional<Result<ImportedMesh>> decode_import(std::string_view bytes) {
    Reader reader(bytes);
    bool good = false;
    reader(good);
    Result<ImportedMesh> result = ImportedMesh{};
    if (good) {
        each_field(reader, *result);
    } else {
        Error error;
        each_field(reader, error);
        result = std::move(error);
    }
    if (!reader.is_complete()) return std::nullopt;
    return result;
}

}  // namespace rro
