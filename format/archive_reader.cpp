#include "format/archive_reader.h"

#include <array>
#include <cerrno>
#include <optional>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "format/parallel.h"
#include "format/section_codec.h"
#include "format/section_tables.h"
#include "format/sha256.h"
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

/// The sections wanted and all that they refer to; meta is always among them.
SectionSet with_needs(SectionSet wanted) {
    wanted = wanted | Section::Meta;
    for (std::uint32_t i = kSectionKinds; i-- > 0;)  // each needs only sections before it
        if (wanted.has(static_cast<Section>(i))) wanted = wanted | layout::kSections[i].needs;
    return wanted;
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
    std::array<Bytes, kSectionKinds> unpacked;  // sections that are not used in place
    ObjectData data;
    std::optional<DirectionGrid> grid;

    const SectionEntry* find(std::string_view section) const;
    Result<Bytes> unpack(const SectionEntry& entry) const;
    Result<std::span<const std::byte>> payload(Section section, const SectionEntry& entry);
    using Entries = std::array<const SectionEntry*, kSectionKinds>;
    Result<Entries> entries_to_load(SectionSet wanted) const;
    Status load(SectionSet wanted);
    Status load_section(Section section, const SectionEntry& entry);

    static Result<Archive> finish(std::unique_ptr<Impl> impl, SectionSet wanted) {
        if (auto loaded = impl->load(wanted); !loaded) return loaded.error();
        return Archive(std::move(impl));
    }
};

const SectionEntry* Archive::Impl::find(std::string_view section) const {
    for (const SectionEntry& entry : container.entries)
        if (section_name(entry) == section) return &entry;
    return nullptr;
}

/// The content of a section whose codec is not raw.
Result<Bytes> Archive::Impl::unpack(const SectionEntry& entry) const {
    const std::string where = name + ": section " + section_name(entry);
    if (entry.codec != Codec::Zlib)
        return bad_input(where + ": field codec",
                         "found " + std::to_string(static_cast<std::uint32_t>(entry.codec)) + ", expected 0 or 1",
                         "the file was written by a newer version");
    return decompress_zlib(bytes.subspan(entry.offset, entry.stored_bytes), entry.raw_bytes, where);
}

Result<std::span<const std::byte>> Archive::Impl::payload(Section section, const SectionEntry& entry) {
    if (entry.codec == Codec::Raw) return bytes.subspan(entry.offset, entry.stored_bytes);
    auto raw = unpack(entry);
    if (!raw) return raw.error();
    Bytes& kept = unpacked[static_cast<std::size_t>(section)];
    kept = *std::move(raw);
    return std::span<const std::byte>(kept);
}

/// Writes to the section's own part of `data` alone.
Status Archive::Impl::load_section(Section section, const SectionEntry& entry) {
    const layout::SectionSpec& spec = layout::spec_of(section);
    const auto raw = payload(section, entry);
    if (!raw) return raw.error();
    if (auto checked = verify_table(*raw, spec.table, name + ": section " + std::string(spec.name)); !checked)
        return checked;
    read_section(TableView::root(*raw), section, data);
    return Done{};
}

/// By section, nullptr where there is nothing to load: not wanted, not in the file, packed in a way of later versions, or
/// of no use without another section that is none of this file's. Required sections are there in any case.
auto Archive::Impl::entries_to_load(SectionSet wanted) const -> Result<Entries> {
    Entries entries{};
    for (std::size_t i = 0; i < kSectionKinds; ++i) {
        const layout::SectionSpec& spec = layout::kSections[i];
        const SectionEntry* entry = find(spec.name);
        if (!entry && spec.required)
            return bad_input(name + ": directory", "found no section " + std::string(spec.name) + ", expected one");
        if (!entry || !wanted.has(static_cast<Section>(i))) continue;
        bool usable = spec.required || entry->codec == Codec::Raw || entry->codec == Codec::Zlib;
        for (std::size_t other = 0; other < i; ++other)
            if (spec.needs.has(static_cast<Section>(other)) && !entries[other]) usable = false;
        if (usable) entries[i] = entry;
    }
    return entries;
}

/// Verifies from the outside in; a view of a section is made only after its bytes have passed.
Status Archive::Impl::load(SectionSet wanted) {
    auto verified = verify_container(bytes, name);
    if (!verified) return verified.error();
    container = *std::move(verified);
    for (const SectionEntry& entry : container.entries) sections.push_back(info_of(entry));

    const auto entries = entries_to_load(with_needs(wanted));
    if (!entries) return entries.error();
    std::vector<Status> loaded(kSectionKinds, Done{});
    parallel_for(kSectionKinds, 1, [&](std::size_t i) {
        if ((*entries)[i]) loaded[i] = load_section(static_cast<Section>(i), *(*entries)[i]);
    });
    for (Status& status : loaded)
        if (!status) return std::move(status);
    SectionSet present;
    for (std::size_t i = 0; i < kSectionKinds; ++i)
        if ((*entries)[i]) present = present | static_cast<Section>(i);
    if (auto checked = verify_content(data, present, name); !checked) return checked;
    grid.emplace(data.meta.grid_map, data.meta.grid_size);
    return Done{};
}

Archive::Archive(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Archive::Archive(Archive&&) noexcept = default;
Archive& Archive::operator=(Archive&&) noexcept = default;
Archive::~Archive() = default;

Result<Archive> Archive::open(const std::filesystem::path& path, SectionSet wanted) {
    auto mapping = FileMapping::open(path);
    if (!mapping) return mapping.error();
    auto impl = std::make_unique<Impl>();
    impl->name = path.string();
    impl->mapping = *std::move(mapping);
    impl->bytes = impl->mapping.bytes();
    return Impl::finish(std::move(impl), wanted);
}

Result<Archive> Archive::from_bytes(std::vector<std::byte> bytes, const std::string& name, SectionSet wanted) {
    auto impl = std::make_unique<Impl>();
    impl->name = name;
    impl->own = std::move(bytes);
    impl->bytes = impl->own;
    return Impl::finish(std::move(impl), wanted);
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
        return impl_->unpack(*entry);
    }
    std::string names;
    for (const SectionInfo& info : impl_->sections) names += (names.empty() ? "" : ", ") + info.name;
    return bad_input(impl_->name, "found no section " + name + ", expected one of: " + names);
}

}  // namespace rro
