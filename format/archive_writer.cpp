#include "format/archive_writer.h"

#include <algorithm>
#include <cassert>
#include <cstring>
#include <optional>
#include <string>
#include <utility>

#include "format/atomic_file.h"
#include "format/layout.h"
#include "format/parallel.h"
#include "format/section_codec.h"
#include "format/section_tables.h"
#include "format/verifier.h"

namespace rro {
namespace {

using layout::Codec;
using layout::kSectionAlignment;
using layout::SectionEntry;

using Bytes = std::vector<std::byte>;

struct PackedSection {
    Section section;
    Bytes raw, packed;  // `packed` is empty where the section is to be stored raw

    const Bytes& stored() const { return packed.empty() ? raw : packed; }
};

/// A section is packed where the format says so and it pays.
Result<PackedSection> pack(const ObjectData& object, Section section) {
    constexpr double kWorthwhile = 0.9;  // of the raw size; else reading in place is the better bargain
    const layout::SectionSpec& spec = layout::spec_of(section);
    const TableBuilder table = section_table(object, section);
    PackedSection result{section, {}, {}};
    if (table.content_bytes() <= layout::kMaxSectionBytes) result.raw = table.finish();
    if (result.raw.empty() || result.raw.size() > layout::kMaxSectionBytes)
        return bad_input("section " + std::string(spec.name),
                         "found " + std::to_string(std::max<std::uint64_t>(table.content_bytes(), result.raw.size())) +
                             " bytes, expected at most 2147483647, which is all that a section can hold",
                         "split the mesh into several objects, or ask for fewer tables");
    if (spec.codec == Codec::Raw) return result;
    result.packed = compress_zlib(result.raw);
    if (static_cast<double>(result.packed.size()) > kWorthwhile * static_cast<double>(result.raw.size()))
        result.packed.clear();
    return result;
}

std::uint64_t aligned(std::uint64_t at) {
    return (at + kSectionAlignment - 1) / kSectionAlignment * kSectionAlignment;
}

/// Where each section goes; entries come in the order of the sections.
std::vector<SectionEntry> make_directory(const std::vector<PackedSection>& sections) {
    std::vector<SectionEntry> entries;
    std::uint64_t end = kSectionAlignment + sections.size() * sizeof(SectionEntry);
    for (const PackedSection& section : sections) {
        const std::string_view name = layout::spec_of(section.section).name;
        SectionEntry& entry = entries.emplace_back();
        assert(name.size() < entry.name.size());
        std::copy(name.begin(), name.end(), entry.name.begin());
        entry.codec = section.packed.empty() ? Codec::Raw : Codec::Zlib;
        entry.crc32 = crc32_of(section.stored());
        entry.offset = aligned(end);
        entry.stored_bytes = section.stored().size();
        entry.raw_bytes = section.raw.size();
        end = entry.offset + entry.stored_bytes;
    }
    return entries;
}

Bytes make_archive(const std::vector<PackedSection>& sections) {
    const std::vector<SectionEntry> entries = make_directory(sections);
    const auto directory = std::as_bytes(std::span(entries));
    layout::ArchiveHeader header{};
    header.magic = layout::kMagic;
    header.version_major = layout::kVersionMajor;
    header.version_minor = layout::kVersionMinor;
    header.archive_bytes = entries.back().offset + entries.back().stored_bytes;
    header.directory_offset = kSectionAlignment;
    header.section_count = static_cast<std::uint32_t>(entries.size());
    header.directory_crc32 = crc32_of(directory);
    header.header_crc32 = crc32_of(std::as_bytes(std::span(&header, 1)).first(layout::kHeaderCrcOffset));

    Bytes bytes(header.archive_bytes);
    std::memcpy(bytes.data(), &header, sizeof header);
    std::memcpy(bytes.data() + kSectionAlignment, directory.data(), directory.size());
    for (std::size_t i = 0; i < sections.size(); ++i)
        std::copy(sections[i].stored().begin(), sections[i].stored().end(),
                  bytes.begin() + static_cast<std::ptrdiff_t>(entries[i].offset));
    return bytes;
}

/// What a reader would have to refuse as a decompression bomb, flat objects with huge tables, is stored raw instead.
void stay_within_limits(std::vector<PackedSection>& sections) {
    std::uint64_t stored = 0, unpacked = 0;
    for (const PackedSection& section : sections) {
        stored += section.stored().size();
        if (!section.packed.empty()) unpacked += section.raw.size();
    }
    if (unpacked <= layout::max_unpacked_bytes(stored)) return;
    for (PackedSection& section : sections) section.packed.clear();
}

}  // namespace

Result<std::vector<std::byte>> encode_archive(const ObjectData& object) {
    std::vector<Section> wanted;
    for (std::uint32_t i = 0; i < kSectionKinds; ++i)
        if (has_content(object, static_cast<Section>(i))) wanted.push_back(static_cast<Section>(i));

    std::vector<std::optional<Result<PackedSection>>> packed(wanted.size());
    parallel_for(wanted.size(), 1, [&](std::size_t i) { packed[i] = pack(object, wanted[i]); });
    std::vector<PackedSection> sections;
    for (auto& result : packed) {
        if (!*result) return result->error();
        sections.push_back(**std::move(result));
    }
    // A reader would refuse what does not fit together; better that the compiler does, where it went wrong.
    if (auto checked = verify_content(object, SectionSet::all(), "archive to be written"); !checked) {
        Error error = checked.error();
        error.kind = ErrorKind::Internal;
        return error;
    }
    stay_within_limits(sections);
    return make_archive(sections);
}

Status write_archive(const ObjectData& object, const std::filesystem::path& path) {
    auto bytes = encode_archive(object);
    if (!bytes) {
        Error error = bytes.error();
        error.where = path.string() + ": " + error.where;
        return error;
    }
    return write_file_atomically(path, *bytes);
}

}  // namespace rro
