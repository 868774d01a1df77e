#include "format/verifier.h"

#include <algorithm>
#include <cstring>
#include <set>

#include "format/section_codec.h"

namespace rro {
namespace {

using layout::ArchiveHeader;
using layout::kSectionAlignment;
using layout::SectionEntry;

std::string number(std::uint64_t value) { return std::to_string(value); }

Error wrong(const std::string& where, std::string_view field, const std::string& found, const std::string& expected) {
    return bad_input(where + ": field " + std::string(field), "found " + found + ", expected " + expected);
}

Result<ArchiveHeader> verify_header(std::span<const std::byte> bytes, const std::string& name) {
    const std::string where = name + ": header";
    ArchiveHeader header;
    if (bytes.size() < sizeof header)
        return bad_input(where, "found " + number(bytes.size()) + " bytes, expected at least " + number(sizeof header),
                         "this is not an archive, or it is cut off");
    std::memcpy(&header, bytes.data(), sizeof header);
    if (header.magic != layout::kMagic)
        return bad_input(where + ": field magic", "found other bytes, expected \"RRO\\x1a\"", "this is not an archive");
    if (header.version_major != layout::kVersionMajor)
        return bad_input(name,
                         "is format " + number(header.version_major) + "." + number(header.version_minor) +
                             ", this build reads " + number(layout::kVersionMajor) + ".x",
                         "recompile it with this build: rro-compile build MESH --out " + name);
    const std::uint32_t crc = crc32_of(bytes.first(layout::kHeaderCrcOffset));
    if (header.header_crc32 != crc) return wrong(where, "header_crc32", number(header.header_crc32), number(crc));
    if (header.archive_bytes != bytes.size())
        return wrong(where, "archive_bytes", number(header.archive_bytes), "the file's " + number(bytes.size()));
    return header;
}

/// Half-open range of the file that something occupies.
struct Extent {
    std::uint64_t begin, end;
    std::string what;
};

/// Extents in bounds and aligned; no two overlap; all bytes between them are 0.
Status verify_extents(std::span<const std::byte> bytes, std::vector<Extent> extents, const std::string& name) {
    std::sort(extents.begin(), extents.end(), [](const Extent& a, const Extent& b) {
        return a.begin != b.begin ? a.begin < b.begin : a.end < b.end;
    });
    std::uint64_t at = 0;
    for (const Extent& extent : extents) {
        if (extent.begin < at)
            return wrong(name + ": " + extent.what, "offset", number(extent.begin),
                         number(at) + " or more, where what lies before it ends");
        const auto gap = bytes.subspan(at, extent.begin - at);
        const auto filled = std::find_if(gap.begin(), gap.end(), [](std::byte b) { return b != std::byte{0}; });
        if (filled != gap.end())
            return bad_input(name + ": " + extent.what,
                             "found a byte other than 0 in the padding before it, at offset " +
                                 number(at + static_cast<std::uint64_t>(filled - gap.begin())) + ", expected 0");
        at = extent.end;
    }
    if (at != bytes.size())
        return bad_input(name + ": header: field archive_bytes",
                         "found " + number(bytes.size()) + ", expected " + number(at) + ", where the last section ends");
    return Done{};
}

bool valid_name(const SectionEntry& entry) {
    const auto end = std::find(entry.name.begin(), entry.name.end(), '\0');
    const auto allowed = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_'; };
    return end != entry.name.begin() && end != entry.name.end() && std::all_of(entry.name.begin(), end, allowed) &&
           std::all_of(end, entry.name.end(), [](char c) { return c == '\0'; });
}

/// An entry's own numbers, before anything is read at its offset.
Status verify_entry(const SectionEntry& entry, std::uint64_t archive_bytes, const std::string& where) {
    if (entry.offset % kSectionAlignment != 0 || entry.offset > archive_bytes)
        return wrong(where, "offset", number(entry.offset),
                     "a multiple of 64 within the file's " + number(archive_bytes) + " bytes");
    if (entry.stored_bytes > archive_bytes - entry.offset)
        return wrong(where, "stored_bytes", number(entry.stored_bytes),
                     "at most " + number(archive_bytes - entry.offset) + ", up to the end of the file");
    if (entry.stored_bytes > layout::kMaxSectionBytes)
        return wrong(where, "stored_bytes", number(entry.stored_bytes), "at most " + number(layout::kMaxSectionBytes));
    if (entry.raw_bytes > layout::kMaxSectionBytes)
        return wrong(where, "raw_bytes", number(entry.raw_bytes), "at most " + number(layout::kMaxSectionBytes));
    if (entry.codec == layout::Codec::Raw && entry.raw_bytes != entry.stored_bytes)
        return wrong(where, "raw_bytes", number(entry.raw_bytes), number(entry.stored_bytes) + ", as it is stored raw");
    return Done{};
}

/// What a reader will allocate for packed sections stays in proportion to the file.
Status verify_unpacked_bytes(std::span<const SectionEntry> entries, std::uint64_t archive_bytes,
                             const std::string& name) {
    const std::uint64_t limit = layout::max_unpacked_bytes(archive_bytes);
    std::uint64_t unpacked = 0;
    for (const SectionEntry& entry : entries) {
        if (entry.codec == layout::Codec::Raw) continue;
        unpacked += entry.raw_bytes;
        if (unpacked > limit)
            return wrong(name + ": section " + section_name(entry), "raw_bytes",
                         number(entry.raw_bytes) + ", " + number(unpacked) + " in all packed sections so far",
                         "at most " + number(limit) + " in a file of " + number(archive_bytes) + " bytes");
    }
    return Done{};
}

Result<std::vector<SectionEntry>> verify_directory(std::span<const std::byte> bytes, const ArchiveHeader& header,
                                                   const std::string& name) {
    const std::string where = name + ": header";
    if (header.directory_offset % kSectionAlignment != 0 || header.directory_offset > bytes.size())
        return wrong(where, "directory_offset", number(header.directory_offset),
                     "a multiple of 64 within the file's " + number(bytes.size()) + " bytes");
    if (header.section_count > layout::kMaxSections)
        return wrong(where, "section_count", number(header.section_count), "at most " + number(layout::kMaxSections));
    const std::uint64_t room = (bytes.size() - header.directory_offset) / sizeof(SectionEntry);
    if (header.section_count > room)
        return wrong(where, "section_count", number(header.section_count), "at most " + number(room));
    const auto directory = bytes.subspan(header.directory_offset, header.section_count * sizeof(SectionEntry));
    if (const std::uint32_t crc = crc32_of(directory); crc != header.directory_crc32)
        return wrong(where, "directory_crc32", number(header.directory_crc32), number(crc));

    std::vector<SectionEntry> entries(header.section_count);
    if (!entries.empty()) std::memcpy(entries.data(), directory.data(), directory.size());
    std::vector<Extent> extents{
        {0, sizeof header, "header"},
        {header.directory_offset, header.directory_offset + directory.size(), "directory"},
    };
    std::set<std::string> names;
    for (std::size_t i = 0; i < entries.size(); ++i) {
        const std::string place = name + ": directory entry " + number(i);
        if (!valid_name(entries[i]))
            return wrong(place, "name", "other characters", "a-z, 0-9 and _, padded with zeros");
        const std::string section = section_name(entries[i]);
        if (!names.insert(section).second) return wrong(place, "name", section + " again", "each section once");
        if (auto checked = verify_entry(entries[i], bytes.size(), name + ": section " + section); !checked)
            return checked.error();
        extents.push_back({entries[i].offset, entries[i].offset + entries[i].stored_bytes, "section " + section});
    }
    if (auto checked = verify_extents(bytes, std::move(extents), name); !checked) return checked.error();
    if (auto checked = verify_unpacked_bytes(entries, bytes.size(), name); !checked) return checked.error();
    return entries;
}

}  // namespace

std::string section_name(const SectionEntry& entry) {
    return {entry.name.begin(), std::find(entry.name.begin(), entry.name.end(), '\0')};
}

Result<Container> verify_container(std::span<const std::byte> bytes, const std::string& name) {
    const auto header = verify_header(bytes, name);
    if (!header) return header.error();
    auto entries = verify_directory(bytes, *header, name);
    if (!entries) return entries.error();

    for (const SectionEntry& entry : *entries)
        if (const std::uint32_t crc = crc32_of(bytes.subspan(entry.offset, entry.stored_bytes)); crc != entry.crc32)
            return wrong(name + ": section " + section_name(entry), "crc32", number(entry.crc32),
                         number(crc) + ", that of its bytes: the file is damaged");
    return Container{header->version_major, header->version_minor, *std::move(entries)};
}

}  // namespace rro
