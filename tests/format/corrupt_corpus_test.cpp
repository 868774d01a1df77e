// Hostile archives, each with one fault and otherwise sound (checksums included), kept as files named by their fault.
//
//   format_tests "[make_corpus]"     writes the files anew, after a change of the format or a new fault
#include <filesystem>
#include <functional>
#include <limits>
#include <set>

#include <catch2/catch.hpp>

#include "format/archive_reader.h"
#include "format/archive_writer.h"
#include "format/section_tables.h"
#include "tests/support/archive_bytes.h"
#include "tests/support/flatc.h"
#include "tests/support/tiny_object.h"

using namespace rro;
using namespace rro::test;

namespace {

constexpr std::uint64_t k2e32 = std::uint64_t{1} << 32, kAllOnes = ~std::uint64_t{0};
constexpr const char* kFolder = RRO_SOURCE_DIR "/tests/corrupt";

struct Fault {
    std::string name;     // of the file, without .rro
    std::string refusal;  // a part of what the reader says: place, field, what it found
    std::function<Bytes(const Bytes& good)> make;
};

template <class Change>
auto header(Change change) {
    return [change](const Bytes& good) {
        Bytes bytes = good;
        change_header(bytes, change);
        return bytes;
    };
}

template <class Change>
auto entry(std::string section, Change change) {
    return [section, change](const Bytes& good) {
        Bytes bytes = good;
        change_entry(bytes, section, change);
        return bytes;
    };
}

/// The section with a changed payload.
template <class Change>
auto payload(std::string section, Change change) {
    return [section, change](const Bytes& good) {
        Bytes content = payload_of(good, section);
        change(content);
        return with_payload(good, section, content);
    };
}

/// The section of a changed object, written without the writer's own checks.
template <class Change>
auto object(Section section, Change change) {
    return [section, change](const Bytes& good) {
        TinyObject changed = tiny_object(2);
        change(changed);
        const ObjectData data = changed.data();
        return with_payload(good, std::string(layout::spec_of(section).name), section_table(data, section).finish());
    };
}

template <class T>
T load(const Bytes& bytes, std::size_t at) {
    T value;
    std::memcpy(&value, bytes.data() + at, sizeof value);
    return value;
}
template <class T>
void put(Bytes& bytes, std::size_t at, T value) {
    std::memcpy(bytes.data() + at, &value, sizeof value);
}

std::size_t root_of_table(const Bytes& bytes) { return load<std::uint32_t>(bytes, 0); }
std::size_t vtable_of(const Bytes& bytes) {
    const std::size_t root = root_of_table(bytes);
    return root - static_cast<std::size_t>(load<std::int32_t>(bytes, root));
}
/// Where a field of the root table is.
std::size_t field(const Bytes& bytes, std::size_t number) {
    return root_of_table(bytes) + load<std::uint16_t>(bytes, vtable_of(bytes) + 4 + 2 * number);
}
/// Where the count of a vector or string is that a field refers to.
std::size_t target(const Bytes& bytes, std::size_t number) {
    const std::size_t at = field(bytes, number);
    return at + load<std::uint32_t>(bytes, at);
}

/// The section's stored bytes, packed, then changed; its checksum is right, its declared size as before.
template <class Change>
auto stream(std::string section, Change change) {
    return [section, change](const Bytes& good) {
        const Bytes raw = payload_of(good, section);
        Bytes packed = compress_zlib(raw);
        change(packed);
        Bytes bytes = with_payload(good, section, packed);
        change_entry(bytes, section, [&](auto& e) {
            e.codec = layout::Codec::Zlib;
            e.raw_bytes = raw.size();
        });
        return bytes;
    };
}

const float kNan = std::numeric_limits<float>::quiet_NaN();

std::vector<Fault> container_faults() {
    return {
        {"header_magic", "header: field magic", header([](auto& h) { h.magic[0] = 'Z'; })},
        {"header_major_newer", "is format 2.1, this build reads 1.x", header([](auto& h) { h.version_major = 2; })},
        {"header_major_older", "is format 0.1, this build reads 1.x", header([](auto& h) { h.version_major = 0; })},
        {"header_size_less", "header: field archive_bytes", header([](auto& h) { h.archive_bytes -= 1; })},
        {"header_size_2e64", "header: field archive_bytes: found 18446744073709551615",
         header([](auto& h) { h.archive_bytes = kAllOnes; })},
        {"header_directory_unaligned", "header: field directory_offset", header([](auto& h) { h.directory_offset = 65; })},
        {"header_directory_2e64", "header: field directory_offset",
         header([](auto& h) { h.directory_offset = kAllOnes - 63; })},
        {"header_directory_beyond_end", "header: field section_count", header([](auto& h) {
             h.directory_offset = h.archive_bytes / 64 * 64;
         })},
        {"header_sections_2e32", "header: field section_count: found 4294967295",
         header([](auto& h) { h.section_count = 0xffffffff; })},
        {"header_sections_none", "directory_crc32", header([](auto& h) { h.section_count = 0; })},
        {"header_checksum", "header: field header_crc32", [](const Bytes& good) {
             Bytes bytes = good;
             bytes[36] ^= std::byte{1};
             return bytes;
         }},
        {"directory_checksum", "header: field directory_crc32", [](const Bytes& good) {
             Bytes bytes = good;
             bytes[64 + 56] ^= std::byte{1};
             return bytes;
         }},
        {"entry_name_empty", "directory entry 1: field name", entry("mesh", [](auto& e) { e.name.fill('\0'); })},
        {"entry_name_full", "directory entry 1: field name", entry("mesh", [](auto& e) { e.name.fill('m'); })},
        {"entry_name_capital", "directory entry 1: field name", entry("mesh", [](auto& e) { e.name[0] = 'M'; })},
        {"entry_name_padding", "directory entry 1: field name", entry("mesh", [](auto& e) { e.name[20] = 'x'; })},
        {"entry_name_twice", "field name: found meta again",
         entry("mesh", [](auto& e) { std::memcpy(e.name.data(), "meta", 4); })},
        {"entry_missing", "found no section mesh", entry("mesh", [](auto& e) { e.name[0] = 'f'; })},
        {"entry_codec_unknown", "section mesh: field codec: found 9",
         entry("mesh", [](auto& e) { e.codec = layout::Codec{9}; })},
        {"entry_offset_unaligned", "section mesh: field offset", entry("mesh", [](auto& e) { e.offset += 8; })},
        {"entry_offset_2e64", "section mesh: field offset", entry("mesh", [](auto& e) { e.offset = kAllOnes - 63; })},
        {"entry_offset_in_header", "section mesh: field offset", entry("mesh", [](auto& e) { e.offset = 0; })},
        {"entry_overlaps", "field offset", entry("mesh", [](auto& e) { e.offset -= 64; })},
        {"entry_stored_2e32", "section mesh: field stored_bytes: found 4294967296",
         entry("mesh", [](auto& e) { e.stored_bytes = k2e32; })},
        {"entry_stored_2e64", "section mesh: field stored_bytes: found 18446744073709551615",
         entry("mesh", [](auto& e) { e.stored_bytes = kAllOnes; })},
        {"entry_raw_differs", "section mesh: field raw_bytes", entry("mesh", [](auto& e) { e.raw_bytes += 1; })},
        {"entry_raw_2e31", "section visibility: field raw_bytes: found 2147483648",
         entry("visibility", [](auto& e) { e.raw_bytes = k2e32 / 2; })},
        {"entry_raw_2e64", "section visibility: field raw_bytes: found 18446744073709551615",
         entry("visibility", [](auto& e) { e.raw_bytes = kAllOnes; })},
        {"section_checksum", "section mesh: field crc32", entry("mesh", [](auto& e) { e.crc32 += 1; })},
        {"padding_filled", "found a byte other than 0 in the padding", [](const Bytes& good) {
             Bytes bytes = good;
             bytes[41] = std::byte{7};
             return bytes;
         }},
        {"tail", "where the last section ends", [](const Bytes& good) {
             Bytes bytes = good;
             bytes.resize(bytes.size() + 64);
             change_header(bytes, [](auto& h) { h.archive_bytes += 64; });
             return bytes;
         }},
    };
}

std::vector<Fault> codec_faults() {
    return {
        {"zlib_garbage", "section visibility: found", stream("visibility", [](Bytes& s) { s.assign(s.size(), std::byte{0xa5}); })},
        {"zlib_breaks_off", "that break off", stream("visibility", [](Bytes& s) { s.resize(s.size() / 2); })},
        {"zlib_goes_on", "go on after their end", stream("visibility", [](Bytes& s) { s.push_back({}); })},
        {"zlib_sum", "that are damaged", stream("visibility", [](Bytes& s) { s.back() ^= std::byte{1}; })},
        {"zlib_empty", "section visibility: found 0 bytes", stream("visibility", [](Bytes& s) { s.clear(); })},
        {"zlib_bomb", "hold more", [](const Bytes& good) {
             Bytes bytes = with_payload(good, "visibility", Bytes(1000000), layout::Codec::Zlib);
             change_entry(bytes, "visibility", [](auto& e) { e.raw_bytes = 100; });
             return bytes;
         }},
        {"zlib_bombs_together", "in all packed sections so far", [](const Bytes& good) {
             Bytes bytes = good;
             for (const char* section : {"visibility", "hbv", "source"})
                 change_entry(bytes, section, [](auto& e) {
                     e.codec = layout::Codec::Zlib;
                     e.raw_bytes = 30000000;
                 });
             return bytes;
         }},
    };
}

std::vector<Fault> wire_faults() {
    return {
        {"wire_nothing", "section mesh: field root", payload("mesh", [](Bytes& b) { b.clear(); })},
        {"wire_root_zero", "section mesh: field root", payload("mesh", [](Bytes& b) { put(b, 0, 0u); })},
        {"wire_root_2e32", "section mesh: field root", payload("mesh", [](Bytes& b) { put(b, 0, 0xfffffffcu); })},
        {"wire_root_unaligned", "section mesh: field root",
         payload("mesh", [](Bytes& b) { put(b, 0, load<std::uint32_t>(b, 0) + 1); })},
        {"wire_vtable_before_start", "section mesh: field root: found a vtable at byte -",
         payload("mesh", [](Bytes& b) { put(b, root_of_table(b), std::int32_t{1 << 30}); })},
        {"wire_vtable_beyond_end", "section mesh: field root: found a vtable at byte",
         payload("mesh", [](Bytes& b) { put(b, root_of_table(b), std::int32_t{-(1 << 30)}); })},
        {"wire_vtable_long", "found a vtable of 65534 bytes",
         payload("mesh", [](Bytes& b) { put(b, vtable_of(b), std::uint16_t{0xfffe}); })},
        {"wire_vtable_odd", "found a vtable of 7 bytes",
         payload("mesh", [](Bytes& b) { put(b, vtable_of(b), std::uint16_t{7}); })},
        {"wire_table_long", "found a table of 65535 bytes",
         payload("mesh", [](Bytes& b) { put(b, vtable_of(b) + 2, std::uint16_t{0xffff}); })},
        {"wire_table_short", "section mesh: field positions: found a place",
         payload("mesh", [](Bytes& b) { put(b, vtable_of(b) + 2, std::uint16_t{4}); })},
        {"wire_field_outside", "section mesh: field positions: found a place 60000 bytes",
         payload("mesh", [](Bytes& b) { put(b, vtable_of(b) + 6, std::uint16_t{60000}); })},
        {"wire_field_unaligned", "section mesh: field positions: found a place",
         payload("mesh", [](Bytes& b) {
             put(b, vtable_of(b) + 6, static_cast<std::uint16_t>(load<std::uint16_t>(b, vtable_of(b) + 6) + 1));
         })},
        {"wire_vector_zero_offset", "section mesh: field positions: found an offset",
         payload("mesh", [](Bytes& b) { put(b, field(b, 1), 0u); })},
        {"wire_vector_offset_2e32", "section mesh: field positions: found an offset",
         payload("mesh", [](Bytes& b) { put(b, field(b, 1), 0xffffffffu); })},
        {"wire_vector_count_2e32", "section mesh: field positions: found 4294967295 elements",
         payload("mesh", [](Bytes& b) { put(b, target(b, 1), 0xffffffffu); })},
        {"wire_vector_count_one_more", "section mesh: field faces: found 13 elements",
         payload("mesh", [](Bytes& b) { put(b, target(b, 3), 13u); })},
        {"wire_string_2e32", "section meta: field tool_version: found a string of 4294967295 bytes",
         payload("meta", [](Bytes& b) { put(b, target(b, 0), 0xffffffffu); })},
        {"wire_string_unended", "section meta: field tool_version: found a string of 2 bytes without a zero",
         payload("meta", [](Bytes& b) { put(b, target(b, 0), 2u); })},
        {"wire_tables_2e32", "section materials: field materials: found 1073741824 elements",
         payload("materials", [](Bytes& b) { put(b, target(b, 0), 0x40000000u); })},
        {"wire_table_offset_beyond_end", "section materials: field materials[1]: found an offset",
         payload("materials", [](Bytes& b) { put(b, target(b, 0) + 8, 0x40000000u); })},
    };
}

std::vector<Fault> content_faults() {
    using O = TinyObject;
    return {
        {"meta_grid_1", "meta: field grid_size: found 1", object(Section::Meta, [](O& o) { o.meta.grid_size = 1; })},
        {"meta_grid_2e32", "meta: field grid_size: found 4294967295",
         object(Section::Meta, [](O& o) { o.meta.grid_size = 0xffffffff; })},
        {"meta_map_unknown", "meta: field grid_map: found 77",
         object(Section::Meta, [](O& o) { o.meta.grid_map = GridMap{77}; })},
        {"meta_bounds_nan", "meta: field bounds_lo",
         object(Section::Meta, [](O& o) { o.meta.bounds.lo.x = static_cast<double>(kNan); })},
        {"meta_bounds_turned", "meta: field bounds_hi", object(Section::Meta, [](O& o) { std::swap(o.meta.bounds.lo, o.meta.bounds.hi); })},
        {"mesh_vertex_2e32", "mesh: field triangles[3]: found vertex 4294967295",
         object(Section::Mesh, [](O& o) { o.triangles[3][1] = 0xffffffff; })},
        {"mesh_position_nan", "mesh: field positions[2]", object(Section::Mesh, [](O& o) { o.positions[2].y = kNan; })},
        {"mesh_origin_infinite", "mesh: field origin",
         object(Section::Mesh, [](O& o) { o.origin.z = std::numeric_limits<double>::infinity(); })},
        {"mesh_face_beyond_end", "mesh: field faces[4]: found 24", object(Section::Mesh, [](O& o) { o.faces[4].packed = 24; })},
        {"mesh_face_twice", "mesh: field faces[4]", object(Section::Mesh, [](O& o) { o.faces[4] = o.faces[0]; })},
        {"mesh_empty", "patches: field patches[0].face_count",
         object(Section::Mesh, [](O& o) { o.positions.clear(), o.triangles.clear(), o.faces.clear(); })},
        {"materials_reflect_all", "materials: field materials[0].reflectance",
         object(Section::Materials, [](O& o) { o.materials[0].reflectance.x = 1; })},
        {"materials_exitance_negative", "materials: field materials[1].exitance",
         object(Section::Materials, [](O& o) { o.materials[1].exitance.x = -1; })},
        {"materials_none", "patches: field patches[0].material", object(Section::Materials, [](O& o) { o.materials.clear(); })},
        {"patches_none", "patches: field patches", object(Section::Patches, [](O& o) { o.patches.clear(); })},
        {"patches_gap", "patches: field patches[2].first_face", object(Section::Patches, [](O& o) { o.patches[2].first_face = 5; })},
        {"patches_count_2e32", "patches: field patches[2].face_count: found 4294967295",
         object(Section::Patches, [](O& o) { o.patches[2].face_count = 0xffffffff; })},
        {"patches_material_2e32", "patches: field patches[2].material: found 4294967295",
         object(Section::Patches, [](O& o) { o.patches[2].material = 0xffffffff; })},
        {"clusters_cycle", "clusters: field clusters[3].right_child: found 0", object(Section::Clusters, [](O& o) { o.clusters[3].right_child = 0; })},
        {"clusters_child_2e32", "clusters: field clusters[0].right_child: found 4294967295",
         object(Section::Clusters, [](O& o) { o.clusters[0].right_child = 0xffffffff; })},
        {"clusters_child_itself", "clusters: field clusters[6].right_child: found 6",
         object(Section::Clusters, [](O& o) { o.clusters[6].right_child = 6; })},
        {"clusters_count_zero", "clusters: field clusters[1].patch_count: found 0",
         object(Section::Clusters, [](O& o) { o.clusters[1].patch_count = 0; })},
        {"clusters_missing", "clusters: field clusters: found 10 clusters", object(Section::Clusters, [](O& o) { o.clusters.pop_back(); })},
        {"area_cluster_2e32", "area: field clusters[1]: found 4294967295", object(Section::Area, [](O& o) { o.area_clusters[1] = 0xffffffff; })},
        {"area_clusters_turned", "area: field clusters[1]", object(Section::Area, [](O& o) { std::swap(o.area_clusters[0], o.area_clusters[1]); })},
        {"area_short", "area: field whole: found 7 bytes", object(Section::Area, [](O& o) { o.whole_area.pop_back(); })},
        {"area_scale_nan", "area: field whole_scale[0]", object(Section::Area, [](O& o) { o.whole_area_scale[0] = kNan; })},
        {"visibility_short", "visibility: field visibility: found 23 bytes", object(Section::Visibility, [](O& o) { o.visibility.pop_back(); })},
        {"errors_too_many", "errors: field whole: found 3 numbers", object(Section::Errors, [](O& o) { o.whole_area_error.push_back(0); })},
        {"hit_volume_2e32", "hit: field volumes[1]: found 4294967295", object(Section::Hit, [](O& o) { o.hit_volumes[1] = 0xffffffff; })},
        {"hit_short", "hit: field whole: found", object(Section::Hit, [](O& o) { o.whole_hit.pop_back(); })},
        {"atlas_image_2e32", "atlas: field image_size: found 4294967295", object(Section::Atlas, [](O& o) { o.atlas_image_size = 0xffffffff; })},
        {"atlas_grid_2e31", "atlas: field grid_size: found 2147483648", object(Section::Atlas, [](O& o) { o.atlas_grid_size = 0x80000000; })},
        {"selflinks_step_255", "selflinks: field steps[3]: found 255", object(Section::SelfLinks, [](O& o) { o.self_steps[3] = 255; })},
        {"selflinks_steps_endless", "selflinks: field steps[8]: found the end", object(Section::SelfLinks, [](O& o) { o.self_steps[7] = 4; })},
        {"selflinks_exchange_nan", "selflinks: field exchange[1]", object(Section::SelfLinks, [](O& o) { o.self_exchange[1] = kNan; })},
        {"selflinks_links_short", "selflinks: field visibility: found 2 bytes", object(Section::SelfLinks, [](O& o) { o.self_visibility.pop_back(); })},
        {"hbv_triangle_2e32", "hbv: field triangles[3]: found 4294967295",
         object(Section::Hbv, [](O& o) { o.volume_triangles[3] = 0xffffffff; })},
        {"hbv_triangle_twice", "hbv: field triangles[3]", object(Section::Hbv, [](O& o) { o.volume_triangles[3] = o.volume_triangles[0]; })},
        {"hbv_cycle", "hbv: field volumes[2].right_child: found 1", object(Section::Hbv, [](O& o) { o.volumes[2].right_child = 1; })},
        {"hbv_child_2e32", "hbv: field volumes[0].right_child: found 4294967295",
         object(Section::Hbv, [](O& o) { o.volumes[0].right_child = 0xffffffff; })},
        {"hbv_box_turned", "hbv: field volumes[1].hi", object(Section::Hbv, [](O& o) { o.volumes[1].hi.x = -1; })},
        {"source_beyond_end", "source: field triangles[0]: found 13", object(Section::Source, [](O& o) { o.source_triangle[0] = 13; })},
        {"source_short", "source: field triangles: found 11 numbers", object(Section::Source, [](O& o) { o.source_triangle.pop_back(); })},
    };
}

std::vector<Fault> all_faults() {
    std::vector<Fault> all;
    for (auto& part : {container_faults(), codec_faults(), wire_faults(), content_faults()})
        all.insert(all.end(), part.begin(), part.end());
    return all;
}

std::filesystem::path file_of(const Fault& fault) { return std::filesystem::path(kFolder) / (fault.name + ".rro"); }

}  // namespace

TEST_CASE("every hostile archive is refused for its own fault", "[corrupt]") {
    std::set<std::filesystem::path> files;
    for (const Fault& fault : all_faults()) {
        const std::filesystem::path file = file_of(fault);
        files.insert(file);
        INFO(file.filename().string());
        const auto archive = Archive::open(file);
        REQUIRE_FALSE(archive);
        CHECK(archive.error().kind == ErrorKind::BadInput);
        const std::string said = archive.error().where + ": " + archive.error().message;
        INFO(said);
        CHECK(said.find(fault.refusal) != std::string::npos);
        CHECK(said.starts_with(file.string()));
    }
    for (const auto& file : std::filesystem::directory_iterator(kFolder))
        if (file.path().extension() == ".rro") {
            INFO(file.path().filename().string() << " is not in the list of faults");
            CHECK(files.contains(file.path()));
        }
}

TEST_CASE("the corpus of hostile archives is written", "[.][make_corpus]") {
    const auto good = encode_archive(tiny_object(2).data());
    REQUIRE(good);
    REQUIRE(Archive::from_bytes(*good, "good"));
    for (const Fault& fault : all_faults()) {
        const Bytes bytes = fault.make(*good);
        REQUIRE(bytes != *good);
        write_bytes(file_of(fault), bytes);
    }
}
