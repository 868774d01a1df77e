#include "tests/fuzz/archive_mutator.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <random>

#include "format/layout.h"
#include "format/section_codec.h"

namespace rro::fuzz {
namespace {

using Bytes = std::vector<std::byte>;
using layout::ArchiveHeader;
using layout::Codec;
using layout::SectionEntry;

constexpr std::uint64_t kMostInflated = std::uint64_t{1} << 20;  // keeps a run fast

std::uint64_t aligned(std::uint64_t offset) {
    return (offset + layout::kSectionAlignment - 1) / layout::kSectionAlignment * layout::kSectionAlignment;
}

/// Where header and directory are, if they can be found at all; no checksum has to be right.
struct Directory {
    ArchiveHeader header;
    std::vector<SectionEntry> entries;
};

std::optional<Directory> find_directory(std::span<const std::byte> archive) {
    Directory found;
    if (archive.size() < sizeof found.header) return std::nullopt;
    std::memcpy(&found.header, archive.data(), sizeof found.header);
    const auto [offset, count] = std::pair(found.header.directory_offset, found.header.section_count);
    if (offset > archive.size() || count > (archive.size() - offset) / sizeof(SectionEntry)) return std::nullopt;
    found.entries.resize(count);
    if (count > 0) std::memcpy(found.entries.data(), archive.data() + offset, count * sizeof(SectionEntry));
    return found;
}

bool lies_within(const SectionEntry& entry, std::size_t bytes) {
    return entry.offset <= bytes && entry.stored_bytes <= bytes - entry.offset;
}

/// Sums of the directory and the header, from the innermost to the outermost.
void sign(Bytes& archive, Directory& directory) {
    ArchiveHeader& header = directory.header;
    const std::size_t bytes = directory.entries.size() * sizeof(SectionEntry);
    if (bytes > 0) std::memcpy(archive.data() + header.directory_offset, directory.entries.data(), bytes);
    header.archive_bytes = archive.size();
    header.directory_crc32 = crc32_of(std::span(archive).subspan(header.directory_offset, bytes));
    std::memcpy(archive.data(), &header, sizeof header);
    header.header_crc32 = crc32_of(std::span(archive).first(layout::kHeaderCrcOffset));
    std::memcpy(archive.data(), &header, sizeof header);
}

/// Puts the size and every checksum right, as far as the parts can be found.
void repair(Bytes& archive) {
    auto directory = find_directory(archive);
    if (!directory) return;
    for (SectionEntry& entry : directory->entries)
        if (lies_within(entry, archive.size()))
            entry.crc32 = crc32_of(std::span(archive).subspan(entry.offset, entry.stored_bytes));
    sign(archive, *directory);
}

/// A section with the content it has after decompression.
struct Section {
    SectionEntry entry;
    Bytes content;
    bool readable = true;  // false: `content` are its stored bytes, to be stored again as they are
};

std::vector<Section> take_apart(std::span<const std::byte> archive, const Directory& directory) {
    std::vector<Section> sections;
    for (const SectionEntry& entry : directory.entries) {
        if (!lies_within(entry, archive.size())) continue;
        const auto stored = archive.subspan(entry.offset, entry.stored_bytes);
        Section section{entry, Bytes(stored.begin(), stored.end()), entry.codec == Codec::Raw};
        if (entry.codec == Codec::Zlib && entry.raw_bytes <= kMostInflated)
            if (auto inflated = decompress_zlib(stored, entry.raw_bytes, "")) {
                section.content = *std::move(inflated);
                section.readable = true;
            }
        sections.push_back(std::move(section));
    }
    return sections;
}

/// An archive of these sections, laid out as the writer does it.
Bytes put_together(ArchiveHeader header, const std::vector<Section>& sections) {
    Directory directory{header, {}};
    directory.header.directory_offset = aligned(sizeof header);
    directory.header.section_count = static_cast<std::uint32_t>(sections.size());
    Bytes archive(directory.header.directory_offset + sections.size() * sizeof(SectionEntry));
    for (const Section& section : sections) {
        SectionEntry entry = section.entry;
        Bytes stored = section.content;
        if (section.readable && entry.codec == Codec::Zlib) stored = compress_zlib(section.content);
        if (section.readable) entry.raw_bytes = section.content.size();
        entry.stored_bytes = stored.size();
        entry.crc32 = crc32_of(stored);
        archive.resize(aligned(archive.size()));
        entry.offset = archive.size();
        archive.insert(archive.end(), stored.begin(), stored.end());
        directory.entries.push_back(entry);
    }
    sign(archive, directory);
    return archive;
}

class Random {
  public:
    explicit Random(unsigned seed) : engine_(seed) {}
    std::size_t below(std::size_t count) { return engine_() % count; }
    bool one_in(std::size_t count) { return below(count) == 0; }

  private:
    std::minstd_rand engine_;
};

void mutate_bytes(Bytes& bytes, std::size_t most, Mutate mutate) {
    const std::size_t size = bytes.size();
    bytes.resize(std::max(most, size));
    bytes.resize(mutate(reinterpret_cast<std::uint8_t*>(bytes.data()), size, bytes.size()));
}

/// Changes one number in its place, by little or to another number of the section: the kind of fault that passes most
/// checks.
void change_number(Bytes& content, Random& random) {
    const std::size_t count = content.size() / sizeof(std::uint32_t);
    if (count == 0) return;
    std::byte* const at = content.data() + sizeof(std::uint32_t) * random.below(count);
    std::uint32_t number, other;
    std::memcpy(&number, at, sizeof number);
    std::memcpy(&other, content.data() + sizeof other * random.below(count), sizeof other);
    const std::uint32_t flipped = number ^ (std::uint32_t{1} << random.below(32));
    number = std::array{number + 1, number - 1, other, flipped}[random.below(4)];
    std::memcpy(at, &number, sizeof number);
}

/// One section has another content, another codec, or is gone.
void mutate_section(std::vector<Section>& sections, Random& random, Mutate mutate) {
    const std::size_t chosen = random.below(sections.size());
    if (random.one_in(64)) {
        sections.erase(sections.begin() + static_cast<std::ptrdiff_t>(chosen));
        return;
    }
    Section& section = sections[chosen];
    if (random.one_in(32) && section.readable)
        section.entry.codec = section.entry.codec == Codec::Raw ? Codec::Zlib : Codec::Raw;
    if (random.one_in(2)) return change_number(section.content, random);
    constexpr std::size_t growth = 256;  // bytes: room for a few more records
    mutate_bytes(section.content, section.content.size() + growth, mutate);
}

}  // namespace

Bytes mutate_archive(std::span<const std::byte> archive, std::size_t most, unsigned seed, Mutate mutate) {
    Random random(seed);
    const auto directory = find_directory(archive);
    if (directory && !random.one_in(6)) {
        auto sections = take_apart(archive, *directory);
        if (!sections.empty()) {
            mutate_section(sections, random, mutate);
            return put_together(directory->header, sections);
        }
    }
    Bytes changed(archive.begin(), archive.end());
    mutate_bytes(changed, most, mutate);
    if (!random.one_in(8)) repair(changed);
    return changed;
}

Bytes cross_archives(std::span<const std::byte> a, std::span<const std::byte> b, unsigned seed) {
    Random random(seed);
    const auto first = find_directory(a), second = find_directory(b);
    if (!first || !second) return {};
    auto sections = take_apart(a, *first);
    auto others = take_apart(b, *second);
    if (others.empty()) return {};
    Section& other = others[random.below(others.size())];
    const auto same = std::find_if(sections.begin(), sections.end(),
                                   [&](const Section& s) { return s.entry.name == other.entry.name; });
    if (same != sections.end())
        *same = std::move(other);
    else
        sections.push_back(std::move(other));
    return put_together(first->header, sections);
}

}  // namespace rro::fuzz
