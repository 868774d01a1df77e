// File -> verified archive -> views in place. samples/programs/object_facts.cpp shows it.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "format/object_data.h"
#include "format/result.h"
#include "format/section.h"

namespace rro {

/// One section of the directory, for `inspect`.
struct SectionInfo {
    std::string name;
    std::string codec;  // "raw" or "zlib"
    std::uint64_t offset = 0, stored_bytes = 0, raw_bytes = 0;
    std::uint32_t crc32 = 0;
};

/// A verified archive. Owns the mapping (or the bytes) that its views point into; movable, not copyable.
/// Immutable after opening; safe to share between threads.
class Archive {
  public:
    /// Maps and verifies a file. The container is checked whole, with every checksum; of the sections, those that are
    /// wanted (and those that they refer to) are unpacked, several at a time, and verified. Nothing is read through a
    /// view before that. The others stay as they lie, and data() shows nothing of them.
    ///
    /// errors   BadInput: not there, not an archive, another major version, truncated, or damaged: names section, field,
    ///          found and expected
    static Result<Archive> open(const std::filesystem::path& path, SectionSet wanted = SectionSet::all());

    /// The same from bytes at hand, which it keeps; `name` stands in error messages.
    /// errors   as open
    static Result<Archive> from_bytes(std::vector<std::byte> bytes, const std::string& name,
                                      SectionSet wanted = SectionSet::all());

    Archive(Archive&&) noexcept;
    Archive& operator=(Archive&&) noexcept;
    ~Archive();

    /// What the sections hold that were wanted: views into the archive, valid as long as it (a move keeps them valid).
    /// Metres, in the archive's frame; tables as object_data.h says.
    const ObjectData& data() const;
    /// The directions of the tables: `meta.grid_size` by as many.
    const DirectionGrid& grid() const;
    const std::vector<SectionInfo>& sections() const;  // all in the file, in its order
    std::uint64_t file_bytes() const;
    std::uint16_t version_major() const;
    std::uint16_t version_minor() const;

    /// A section's payload after decompression (a plain FlatBuffers buffer).
    /// errors   BadInput: no such section (names those there are), one packed in a way that this version does not know, or
    ///          damaged inside
    Result<std::vector<std::byte>> section(const std::string& name) const;

    /// SHA-256 of the whole file, lower-case hex.
    std::string content_sha256() const;

  private:
    struct Impl;
    explicit Archive(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace rro
