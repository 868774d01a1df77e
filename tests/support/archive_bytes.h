// Changes in the bytes of an archive, with the checksums made right again, as a program that edits archives would.
#pragma once

#include <cstddef>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "format/layout.h"
#include "format/section_codec.h"
#include "format/verifier.h"

namespace rro::test {

using Bytes = std::vector<std::byte>;

inline layout::ArchiveHeader header_of(const Bytes& bytes) {
    layout::ArchiveHeader header;
    std::memcpy(&header, bytes.data(), sizeof header);
    return header;
}

inline void put_header(Bytes& bytes, layout::ArchiveHeader header) {
    header.header_crc32 = crc32_of(std::as_bytes(std::span(&header, 1)).first(layout::kHeaderCrcOffset));
    std::memcpy(bytes.data(), &header, sizeof header);
}

/// Where the entry of a section is. Archives under test have their directory at 64.
inline std::size_t entry_offset(const Bytes& bytes, const std::string& section) {
    for (std::uint32_t i = 0; i < header_of(bytes).section_count; ++i) {
        layout::SectionEntry entry;
        std::memcpy(&entry, bytes.data() + 64 + 64 * i, sizeof entry);
        if (section_name(entry) == section) return 64 + 64 * i;
    }
    FAIL("no section " << section);
    return 0;
}

inline layout::SectionEntry entry_of(const Bytes& bytes, const std::string& section) {
    layout::SectionEntry entry;
    std::memcpy(&entry, bytes.data() + entry_offset(bytes, section), sizeof entry);
    return entry;
}

/// Writes the header's and the directory's checksums anew.
inline void seal(Bytes& bytes) {
    layout::ArchiveHeader header = header_of(bytes);
    header.directory_crc32 = crc32_of(std::span(bytes).subspan(header.directory_offset, 64 * header.section_count));
    put_header(bytes, header);
}

template <class Change>
void change_header(Bytes& bytes, const Change& change) {
    layout::ArchiveHeader header = header_of(bytes);
    change(header);
    put_header(bytes, header);
}

template <class Change>
void change_entry(Bytes& bytes, const std::string& section, const Change& change) {
    layout::SectionEntry entry = entry_of(bytes, section);
    const std::size_t at = entry_offset(bytes, section);
    change(entry);
    std::memcpy(bytes.data() + at, &entry, sizeof entry);
    seal(bytes);
}

/// A section's payload.
inline Bytes payload_of(const Bytes& bytes, const std::string& section) {
    const layout::SectionEntry entry = entry_of(bytes, section);
    const auto stored = std::span(bytes).subspan(entry.offset, entry.stored_bytes);
    if (entry.codec == layout::Codec::Raw) return {stored.begin(), stored.end()};
    auto raw = decompress_zlib(stored, entry.raw_bytes, section);
    REQUIRE(raw);
    return *std::move(raw);
}

/// The archive with other bytes for one section, stored by the given codec; the others move as they must.
inline Bytes with_payload(const Bytes& bytes, const std::string& section, const Bytes& payload,
                          layout::Codec codec = layout::Codec::Raw) {
    const layout::ArchiveHeader header = header_of(bytes);
    Bytes result(bytes.begin(), bytes.begin() + std::ptrdiff_t(64 + 64 * header.section_count));
    for (std::uint32_t i = 0; i < header.section_count; ++i) {
        layout::SectionEntry entry;
        std::memcpy(&entry, bytes.data() + 64 + 64 * i, sizeof entry);
        Bytes stored(bytes.begin() + std::ptrdiff_t(entry.offset),
                     bytes.begin() + std::ptrdiff_t(entry.offset + entry.stored_bytes));
        if (section_name(entry) == section) {
            stored = codec == layout::Codec::Zlib ? compress_zlib(payload) : payload;
            entry.codec = codec;
            entry.raw_bytes = payload.size();
        }
        entry.stored_bytes = stored.size();
        entry.crc32 = crc32_of(stored);
        result.resize((result.size() + 63) / 64 * 64);
        entry.offset = result.size();
        std::memcpy(result.data() + 64 + 64 * i, &entry, sizeof entry);
        result.insert(result.end(), stored.begin(), stored.end());
    }
    change_header(result, [&](auto& h) { h.archive_bytes = result.size(); });
    seal(result);
    return result;
}

}  // namespace rro::test
