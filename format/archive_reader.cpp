#include "format/archive_reader.h"

#include <cerrno>
#include <map>
#include <optional>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "format/section_codec.h"
#include "format/sha256.h"
#include "format/table_view.h"
#include "format/verifier.h"

namespace rro {
namespace {

using layout::Codec;
using layout::SectionEntry;

using Bytes = std::vector<std::byte>;

/// The content of a file, mapped read-only. A file that is cut off while it is mapped ends the process (SIGBUS); files
/// replaced by write_file_atomically are safe, as a mapping keeps the old one.
class FileMapping {
  public:
    FileMapping() = default;
    FileMapping(FileMapping&& other) noexcept : bytes_(std::exchange(other.bytes_, {})) {}
    FileMapping& operator=(FileMapping&& other) noexcept {
        std::swap(bytes_, other.bytes_);
        return *this;
    }
    ~FileMapping() {
        if (!bytes_.empty()) ::munmap(const_cast<std::byte*>(bytes_.data()), bytes_.size());
    }

    static Result<FileMapping> open(const std::filesystem::path& path) {
        // Not blocking, so that a pipe in the file's place is refused instead of waited for.
        const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
        if (file < 0) return cannot_read(path, errno);
        auto mapping = map(file, path);
        ::close(file);
        return mapping;
    }

    std::span<const std::byte> bytes() const { return bytes_; }

  private:
    static Error cannot_read(const std::filesystem::path& path, int reason) {
        return bad_input(path.string(), "cannot be read: " + std::generic_category().message(reason));
    }

    static Result<FileMapping> map(int file, const std::filesystem::path& path) {
        struct stat facts {};
        if (::fstat(file, &facts) != 0) return cannot_read(path, errno);
        if (!S_ISREG(facts.st_mode)) return bad_input(path.string(), "is not a regular file, expected an archive");
        FileMapping mapping;
        if (facts.st_size == 0) return mapping;
        const auto size = static_cast<std::size_t>(facts.st_size);
        void* const start = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file, 0);
        if (start == MAP_FAILED) return cannot_read(path, errno);
        mapping.bytes_ = {static_cast<const std::byte*>(start), size};
        return mapping;
    }

    std::span<const std::byte> bytes_;
};

void read_meta(const TableView& table, ObjectMeta& meta) {
    using F = layout::MetaField;
    meta.tool_version = table.text(F::tool_version);
    meta.source_name = table.text(F::source_name);
    meta.source_sha256 = table.text(F::source_sha256);
    meta.options = table.text(F::options);
    meta.grid_map = static_cast<GridMap>(table.value<std::uint8_t>(F::grid_map));
    meta.grid_size = table.value(F::grid_size, layout::kDefaultGridSize);
    meta.image_resolution = table.value<std::uint32_t>(F::image_resolution);
    meta.source_triangles = table.value<std::uint32_t>(F::source_triangles);
    meta.bounds.lo = table.value<Vec3>(F::bounds_lo);
    meta.bounds.hi = table.value<Vec3>(F::bounds_hi);
    meta.area = table.value<double>(F::area);
    meta.closed = table.value<std::uint8_t>(F::closed) != 0;
    meta.convex = table.value<std::uint8_t>(F::convex) != 0;
}

void read_materials(const TableView& table, std::vector<Material>& materials) {
    using F = layout::MaterialField;
    for (const TableView& entry : table.tables(layout::MaterialsField::materials)) {
        Material& material = materials.emplace_back();
        material.name = entry.text(F::name);
        material.reflectance = entry.value<Vec3>(F::reflectance);
        material.exitance = entry.value<Vec3>(F::exitance);
        material.textured = entry.value<std::uint8_t>(F::textured) != 0;
    }
}

/// Copies what is small, points to the rest.
void read_section(std::string_view name, const TableView& table, ObjectData& object) {
    if (name == "meta") read_meta(table, object.meta);
    if (name == "materials") read_materials(table, object.materials);
    if (name == "clusters") object.clusters = table.array<Cluster>(layout::ClustersField::clusters);
    if (name == "patches") object.patches = table.array<Patch>(layout::PatchesField::patches);
    if (name == "visibility") object.visibility = table.array<std::uint8_t>(layout::VisibilityField::visibility);
    if (name == "mesh") {
        using F = layout::MeshField;
        object.origin = table.value<Vec3>(F::origin);
        object.positions = table.array<Vec3f>(F::positions);
        object.triangles = table.array<TriangleIndices>(F::triangles);
        object.source_triangle = table.array<std::uint32_t>(F::source_triangle);
        object.faces = table.array<Face>(F::faces);
    }
    if (name == "hbv") {
        object.volumes = table.array<Volume>(layout::HbvField::volumes);
        object.volume_triangles = table.array<std::uint32_t>(layout::HbvField::triangles);
    }
    if (name == "area") {
        using F = layout::AreaField;
        object.area_clusters = table.array<std::uint32_t>(F::clusters);
        object.whole_area = table.array<std::uint8_t>(F::whole);
        object.whole_area_scale = table.array<float>(F::whole_scale);
        object.intrinsic_area = table.array<std::uint8_t>(F::intrinsic);
        object.intrinsic_area_scale = table.array<float>(F::intrinsic_scale);
    }
}

SectionInfo info_of(const SectionEntry& entry) {
    const auto codec = static_cast<std::uint32_t>(entry.codec);
    return {section_name(entry),
            entry.codec == Codec::Raw    ? "raw"
            : entry.codec == Codec::Zlib ? "zlib"
                                         : std::to_string(codec),
            entry.offset,
            entry.stored_bytes,
            entry.raw_bytes,
            entry.crc32};
}

}  // namespace

struct Archive::Impl {
    std::string name;
    FileMapping mapping;
    Bytes own;
    std::span<const std::byte> bytes;  // of `mapping` or `own`
    Container container;
    std::vector<SectionInfo> sections;
    std::map<std::string, Bytes> inflated;  // sections that are not used in place
    ObjectData data;
    std::optional<DirectionGrid> grid;

    const SectionEntry* find(std::string_view section) const;
    Result<Bytes> inflate(const SectionEntry& entry) const;
    Result<std::span<const std::byte>> payload(const SectionEntry& entry);
    Status load();

    static Result<Archive> finish(std::unique_ptr<Impl> impl) {
        if (auto loaded = impl->load(); !loaded) return loaded.error();
        return Archive(std::move(impl));
    }
};

const SectionEntry* Archive::Impl::find(std::string_view section) const {
    for (const SectionEntry& entry : container.entries)
        if (section_name(entry) == section) return &entry;
    return nullptr;
}

/// The content of a section whose codec is not raw.
Result<Bytes> Archive::Impl::inflate(const SectionEntry& entry) const {
    const std::string where = name + ": section " + section_name(entry);
    if (entry.codec != Codec::Zlib)
        return bad_input(where + ": field codec",
                         "found " + std::to_string(static_cast<std::uint32_t>(entry.codec)) + ", expected 0 or 1",
                         "the file was written by a newer version");
    return decompress_zlib(bytes.subspan(entry.offset, entry.stored_bytes), entry.raw_bytes, where);
}

Result<std::span<const std::byte>> Archive::Impl::payload(const SectionEntry& entry) {
    if (entry.codec == Codec::Raw) return bytes.subspan(entry.offset, entry.stored_bytes);
    auto raw = inflate(entry);
    if (!raw) return raw.error();
    const Bytes& kept = inflated[section_name(entry)] = *std::move(raw);
    return std::span<const std::byte>(kept);
}

/// Verifies from the outside in; a view of a section is made only after its bytes have passed.
Status Archive::Impl::load() {
    auto verified = verify_container(bytes, name);
    if (!verified) return verified.error();
    container = *std::move(verified);
    for (const SectionEntry& entry : container.entries) sections.push_back(info_of(entry));

    for (const layout::SectionSpec& spec : layout::kSections) {
        const SectionEntry* entry = find(spec.name);
        if (!entry && !spec.required) continue;
        if (!entry)
            return bad_input(name + ": directory", "found no section " + std::string(spec.name) + ", expected one");
        const auto raw = payload(*entry);
        if (!raw) return raw.error();
        if (auto checked = verify_table(*raw, spec.table, name + ": section " + std::string(spec.name)); !checked)
            return checked;
        read_section(spec.name, TableView::root(*raw), data);
    }
    if (auto checked = verify_content(data, name); !checked) return checked;
    grid.emplace(data.meta.grid_map, data.meta.grid_size);
    return Done{};
}

Archive::Archive(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Archive::Archive(Archive&&) noexcept = default;
Archive& Archive::operator=(Archive&&) noexcept = default;
Archive::~Archive() = default;

Result<Archive> Archive::open(const std::filesystem::path& path) {
    auto mapping = FileMapping::open(path);
    if (!mapping) return mapping.error();
    auto impl = std::make_unique<Impl>();
    impl->name = path.string();
    impl->mapping = *std::move(mapping);
    impl->bytes = impl->mapping.bytes();
    return Impl::finish(std::move(impl));
}

Result<Archive> Archive::from_bytes(std::vector<std::byte> bytes, const std::string& name) {
    auto impl = std::make_unique<Impl>();
    impl->name = name;
    impl->own = std::move(bytes);
    impl->bytes = impl->own;
    return Impl::finish(std::move(impl));
}

const ObjectData& Archive::data() const { return impl_->data; }
const DirectionGrid& Archive::grid() const { return *impl_->grid; }
const std::vector<SectionInfo>& Archive::sections() const { return impl_->sections; }
std::uint64_t Archive::file_bytes() const { return impl_->bytes.size(); }
std::uint16_t Archive::version_major() const { return impl_->container.version_major; }
std::uint16_t Archive::version_minor() const { return impl_->container.version_minor; }
std::string Archive::content_sha256() const { return sha256_hex(impl_->bytes); }

Result<std::vector<std::byte>> Archive::section(const std::string& name) const {
    if (const SectionEntry* entry = impl_->find(name)) {
        const auto stored = impl_->bytes.subspan(entry->offset, entry->stored_bytes);
        if (entry->codec == Codec::Raw) return Bytes(stored.begin(), stored.end());
        return impl_->inflate(*entry);
    }
    std::string names;
    for (const SectionInfo& info : impl_->sections) names += (names.empty() ? "" : ", ") + info.name;
    return bad_input(impl_->name, "found no section " + name + ", expected one of: " + names);
}

}  // namespace rro
