// What lies where in an archive: the fixed structs of the container and, per section, the fields of its tables. FORMAT.md
// tells the same to people, schemas/rro.fbs to FlatBuffers; a change here is a change there.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <type_traits>

#include "format/object_data.h"
#include "format/section.h"

namespace rro::layout {

static_assert(std::endian::native == std::endian::little, "archives are little-endian and read in place");

inline constexpr std::array<char, 4> kMagic{'R', 'R', 'O', '\x1a'};
inline constexpr std::uint16_t kVersionMajor = 1;
inline constexpr std::uint16_t kVersionMinor = 1;

/// Sections and the directory start at multiples of this: a cache line, and more than any type in them needs.
inline constexpr std::uint64_t kSectionAlignment = 64;
/// FlatBuffers offsets are 32 bits, signed where they point back to a vtable.
inline constexpr std::uint64_t kMaxSectionBytes = 0x7fffffff;

// Limits on what a file can ask of its reader (FORMAT.md, "Limits").

/// D = 16384 directions.
inline constexpr std::uint32_t kMaxGridSize = 128;
/// Of the silhouette atlas, pixels along each side of an image.
inline constexpr std::uint32_t kMaxAtlasImageSize = 256;
/// Far more than any version has; bounds the work on a directory.
inline constexpr std::uint32_t kMaxSections = 256;
/// Of clusters and volumes, so that whoever walks a tree may recurse.
inline constexpr std::uint32_t kMaxTreeDepth = 256;

/// Bytes that all packed sections of a file may unfold to: patch visibility, the densest, shrinks by 2 to 10, and small
/// files of flat objects by more. Memory for reading is bounded by the file's size with this.
constexpr std::uint64_t max_unpacked_bytes(std::uint64_t archive_bytes) {
    return (std::uint64_t{64} << 20) + 16 * archive_bytes;
}

/// The first bytes of every archive. Offsets count from the start of the file.
struct ArchiveHeader {
    std::array<char, 4> magic;       //  0  "RRO\x1a"
    std::uint16_t version_major;     //  4  a reader refuses any major but its own
    std::uint16_t version_minor;     //  6  any minor is read; unknown sections and fields are skipped
    std::uint64_t archive_bytes;     //  8  equals the file size
    std::uint64_t directory_offset;  // 16  multiple of 64
    std::uint32_t section_count;     // 24
    std::uint32_t directory_crc32;   // 28  of section_count * 64 bytes
    std::uint32_t reserved;          // 32  0
    std::uint32_t header_crc32;      // 36  of the 36 bytes before it
};
static_assert(std::is_trivially_copyable_v<ArchiveHeader> && sizeof(ArchiveHeader) == 40);
inline constexpr std::size_t kHeaderCrcOffset = 36;

enum class Codec : std::uint32_t { Raw = 0, Zlib = 1 };

/// One entry of the section directory.
struct SectionEntry {
    std::array<char, 24> name;   //  0  a-z, 0-9, _; padded with zeros, at least one
    Codec codec;                 // 24
    std::uint32_t crc32;         // 28  of the stored bytes
    std::uint64_t offset;        // 32  multiple of 64
    std::uint64_t stored_bytes;  // 40
    std::uint64_t raw_bytes;     // 48  after decompression; equals stored_bytes for raw
    std::uint64_t reserved;      // 56  0
};
static_assert(std::is_trivially_copyable_v<SectionEntry> && sizeof(SectionEntry) == 64);

/// How a field of a table is stored.
enum class FieldKind : std::uint8_t {
    InPlace,  // a scalar or struct inside the table
    Text,     // a string, ended by a zero byte
    Array,    // a vector of scalars or structs
    Tables,   // a vector of tables
};

struct FieldSpec {
    std::string_view name;
    FieldKind kind;
    std::uint32_t bytes = 0;      // of the value or of one element
    std::uint32_t alignment = 1;  // natural
    std::span<const FieldSpec> table{};
};

template <class T>
constexpr FieldSpec in_place(std::string_view name) {
    return {name, FieldKind::InPlace, sizeof(T), alignof(T)};
}
template <class T>
constexpr FieldSpec array_of(std::string_view name) {
    return {name, FieldKind::Array, sizeof(T), alignof(T)};
}
constexpr FieldSpec text(std::string_view name) { return {name, FieldKind::Text}; }

// Field numbers are for ever: fields are appended, never moved, reused or removed.

struct MetaField {
    enum Number : std::uint16_t {
        tool_version, source_name, source_sha256, options, grid_map, grid_size, image_resolution, source_triangles,
        bounds_lo, bounds_hi, area, closed, convex
    };
};
inline constexpr std::array kMeta{
    text("tool_version"),
    text("source_name"),
    text("source_sha256"),
    text("options"),
    in_place<std::uint8_t>("grid_map"),
    in_place<std::uint32_t>("grid_size"),
    in_place<std::uint32_t>("image_resolution"),
    in_place<std::uint32_t>("source_triangles"),
    in_place<Vec3>("bounds_lo"),
    in_place<Vec3>("bounds_hi"),
    in_place<double>("area"),
    in_place<std::uint8_t>("closed"),
    in_place<std::uint8_t>("convex"),
};
inline constexpr std::uint32_t kDefaultGridSize = 12;

struct MeshField {
    enum Number : std::uint16_t { origin, positions, triangles, faces };
};
inline constexpr std::array kMesh{
    in_place<Vec3>("origin"),
    array_of<Vec3f>("positions"),
    array_of<TriangleIndices>("triangles"),
    array_of<Face>("faces"),
};

struct MaterialField {
    enum Number : std::uint16_t { name, reflectance, exitance, textured };
};
inline constexpr std::array kMaterial{
    text("name"),
    in_place<Vec3>("reflectance"),
    in_place<Vec3>("exitance"),
    in_place<std::uint8_t>("textured"),
};

struct MaterialsField {
    enum Number : std::uint16_t { materials };
};
inline constexpr std::array kMaterials{FieldSpec{"materials", FieldKind::Tables, 4, 4, kMaterial}};

struct PatchesField {
    enum Number : std::uint16_t { patches };
};
inline constexpr std::array kPatches{array_of<Patch>("patches")};

struct ClustersField {
    enum Number : std::uint16_t { clusters };
};
inline constexpr std::array kClusters{array_of<Cluster>("clusters")};

struct AreaField {
    enum Number : std::uint16_t { clusters, whole, whole_scale, intrinsic, intrinsic_scale };
};
inline constexpr std::array kArea{
    array_of<std::uint32_t>("clusters"), array_of<std::uint8_t>("whole"),     array_of<float>("whole_scale"),
    array_of<std::uint8_t>("intrinsic"), array_of<float>("intrinsic_scale"),
};

struct VisibilityField {
    enum Number : std::uint16_t { visibility };
};
inline constexpr std::array kVisibility{array_of<std::uint8_t>("visibility")};

struct ErrorsField {
    enum Number : std::uint16_t { directions, whole, intrinsic, visibility };
};
inline constexpr std::array kErrors{
    in_place<std::uint32_t>("directions"),
    array_of<float>("whole"),
    array_of<float>("intrinsic"),
    array_of<float>("visibility"),
};

struct HbvField {
    enum Number : std::uint16_t { volumes, triangles };
};
inline constexpr std::array kHbv{array_of<Volume>("volumes"), array_of<std::uint32_t>("triangles")};

struct SourceField {
    enum Number : std::uint16_t { triangles };
};
inline constexpr std::array kSource{array_of<std::uint32_t>("triangles")};

struct HitField {
    enum Number : std::uint16_t { volumes, whole, intrinsic };
};
inline constexpr std::array kHit{
    array_of<std::uint32_t>("volumes"),
    array_of<std::uint8_t>("whole"),
    array_of<std::uint8_t>("intrinsic"),
};

struct AtlasField {
    enum Number : std::uint16_t { centre, radius, grid_size, image_size, coverage };
};
inline constexpr std::array kAtlas{
    in_place<Vec3f>("centre"),
    in_place<float>("radius"),
    in_place<std::uint32_t>("grid_size"),
    in_place<std::uint32_t>("image_size"),
    array_of<std::uint8_t>("coverage"),
};

struct SelfLinksField {
    enum Number : std::uint16_t { steps, exchange, visibility, escape, received, black };
};
inline constexpr std::array kSelfLinks{
    array_of<std::uint8_t>("steps"), array_of<float>("exchange"), array_of<std::uint8_t>("visibility"),
    array_of<float>("escape"),       array_of<float>("received"), array_of<float>("black"),
};

/// A section this version knows.
struct SectionSpec {
    std::string_view name;
    std::span<const FieldSpec> table;
    Codec codec;       // the writer's choice; a reader takes either
    bool required;     // others are written only where there is something in them
    SectionSet needs;  // sections that its numbers refer to
};

/// Indexed by Section. Raw: what is large and used in place, or too small to matter. FORMAT.md has the measurements.
inline constexpr std::array<SectionSpec, kSectionKinds> kSections{{
    {"meta", kMeta, Codec::Raw, true, {}},
    {"mesh", kMesh, Codec::Raw, true, {}},
    {"materials", kMaterials, Codec::Raw, true, {}},
    {"patches", kPatches, Codec::Zlib, true, Section::Mesh | Section::Materials},
    {"clusters", kClusters, Codec::Zlib, true, Section::Patches},
    {"area", kArea, Codec::Zlib, false, Section::Meta | Section::Clusters},
    {"visibility", kVisibility, Codec::Zlib, false, Section::Meta | Section::Patches},
    {"errors", kErrors, Codec::Raw, false, Section::Area},
    {"hbv", kHbv, Codec::Zlib, false, Section::Mesh},
    {"source", kSource, Codec::Zlib, true, Section::Meta | Section::Mesh},
    {"hit", kHit, Codec::Zlib, false, Section::Meta | Section::Hbv},
    {"atlas", kAtlas, Codec::Zlib, false, {}},
    {"selflinks", kSelfLinks, Codec::Zlib, false, Section::Patches | Section::Clusters},
}};
constexpr const SectionSpec& spec_of(Section section) { return kSections[static_cast<std::size_t>(section)]; }

// What FlatBuffers requires of the records that arrays hold: natural alignment and no hidden padding.
static_assert(sizeof(Vec3) == 24 && alignof(Vec3) == 8);
static_assert(sizeof(Vec3f) == 12 && alignof(Vec3f) == 4);
static_assert(sizeof(TriangleIndices) == 12 && alignof(TriangleIndices) == 4);
static_assert(sizeof(Face) == 4 && std::is_trivially_copyable_v<Face>);
static_assert(sizeof(Patch) == 56 && alignof(Patch) == 4 && std::is_trivially_copyable_v<Patch>);
static_assert(sizeof(Cluster) == 60 && alignof(Cluster) == 4 && std::is_trivially_copyable_v<Cluster>);
static_assert(sizeof(Volume) == 36 && alignof(Volume) == 4 && std::is_trivially_copyable_v<Volume>);
static_assert(offsetof(Patch, reflectance) == 16 && offsetof(Patch, cone_cosine) == 52);
static_assert(offsetof(Cluster, radius) == 16 && offsetof(Cluster, lo) == 20 && offsetof(Cluster, cone_cosine) == 56);
static_assert(offsetof(Volume, first) == 24);

}  // namespace rro::layout
