// What goes into an archive comes out of it, the same bytes each time, and refusals say why.
#include <cstring>

#include <catch2/catch.hpp>

#include "format/archive_reader.h"
#include "format/archive_writer.h"
#include "format/layout.h"
#include "format/parallel.h"
#include "format/section_codec.h"
#include "format/sha256.h"
#include "tests/support/archive_bytes.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_object.h"

using namespace rro;
using test::change_entry;
using test::change_header;
using test::entry_of;
using test::tiny_object;
using test::TinyObject;

namespace {

using Bytes = std::vector<std::byte>;

Bytes encoded(const TinyObject& object) {
    auto bytes = encode_archive(object.data());
    INFO((bytes ? "" : bytes.error().where + ": " + bytes.error().message));
    REQUIRE(bytes);
    return *std::move(bytes);
}

template <class T>
bool same_bytes(std::span<const T> a, std::span<const T> b) {
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}

void check_same(const ObjectData& a, const ObjectData& b) {
    CHECK(a.meta.tool_version == b.meta.tool_version);
    CHECK(a.meta.source_name == b.meta.source_name);
    CHECK(a.meta.source_sha256 == b.meta.source_sha256);
    CHECK(a.meta.options == b.meta.options);
    CHECK(a.meta.grid_map == b.meta.grid_map);
    CHECK(a.meta.grid_size == b.meta.grid_size);
    CHECK(a.meta.image_resolution == b.meta.image_resolution);
    CHECK(a.meta.source_triangles == b.meta.source_triangles);
    CHECK(a.meta.bounds.lo == b.meta.bounds.lo);
    CHECK(a.meta.bounds.hi == b.meta.bounds.hi);
    CHECK(a.meta.area == b.meta.area);
    CHECK(a.meta.closed == b.meta.closed);
    CHECK(a.meta.convex == b.meta.convex);
    REQUIRE(a.materials.size() == b.materials.size());
    for (std::size_t i = 0; i < a.materials.size(); ++i) {
        CHECK(a.materials[i].name == b.materials[i].name);
        CHECK(a.materials[i].reflectance == b.materials[i].reflectance);
        CHECK(a.materials[i].exitance == b.materials[i].exitance);
        CHECK(a.materials[i].textured == b.materials[i].textured);
    }
    CHECK(a.origin == b.origin);
    CHECK(same_bytes(a.positions, b.positions));
    CHECK(same_bytes(a.triangles, b.triangles));
    CHECK(same_bytes(a.source_triangle, b.source_triangle));
    CHECK(same_bytes(a.faces, b.faces));
    CHECK(same_bytes(a.patches, b.patches));
    CHECK(same_bytes(a.clusters, b.clusters));
    CHECK(same_bytes(a.volumes, b.volumes));
    CHECK(same_bytes(a.volume_triangles, b.volume_triangles));
    CHECK(same_bytes(a.area_clusters, b.area_clusters));
    CHECK(same_bytes(a.whole_area, b.whole_area));
    CHECK(same_bytes(a.whole_area_scale, b.whole_area_scale));
    CHECK(same_bytes(a.intrinsic_area, b.intrinsic_area));
    CHECK(same_bytes(a.intrinsic_area_scale, b.intrinsic_area_scale));
    CHECK(same_bytes(a.visibility, b.visibility));
    CHECK(a.error_directions == b.error_directions);
    CHECK(same_bytes(a.whole_area_error, b.whole_area_error));
    CHECK(same_bytes(a.intrinsic_area_error, b.intrinsic_area_error));
    CHECK(same_bytes(a.visibility_error, b.visibility_error));
    CHECK(same_bytes(a.hit_volumes, b.hit_volumes));
    CHECK(same_bytes(a.whole_hit, b.whole_hit));
    CHECK(same_bytes(a.intrinsic_hit, b.intrinsic_hit));
    CHECK(same_bytes(a.self_steps, b.self_steps));
    CHECK(same_bytes(a.self_exchange, b.self_exchange));
    CHECK(same_bytes(a.self_visibility, b.self_visibility));
    CHECK(same_bytes(a.self_escape, b.self_escape));
    CHECK(same_bytes(a.self_received, b.self_received));
    CHECK(same_bytes(a.self_black, b.self_black));
    CHECK(a.atlas_centre == b.atlas_centre);
    CHECK(a.atlas_radius == b.atlas_radius);
    CHECK(a.atlas_grid_size == b.atlas_grid_size);
    CHECK(a.atlas_image_size == b.atlas_image_size);
    CHECK(same_bytes(a.atlas_coverage, b.atlas_coverage));
}

/// The place and the message of the refusal.
std::string refusal(Bytes bytes) {
    const auto archive = Archive::from_bytes(std::move(bytes), "tiny.rro");
    REQUIRE_FALSE(archive);
    CHECK(archive.error().kind == ErrorKind::BadInput);
    return archive.error().where + ": " + archive.error().message;
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("an object comes back as it was written", "[archive]") {
    TinyObject object = tiny_object(3, {1e6, -2e6, 0.125});
    object.meta.grid_map = GridMap::LatLong;
    const auto archive = Archive::from_bytes(encoded(object), "tiny.rro");
    REQUIRE(archive);
    check_same(archive->data(), object.data());
    CHECK(archive->grid().n() == 3);
    CHECK(archive->grid().map() == GridMap::LatLong);
    CHECK(archive->version_major() == layout::kVersionMajor);
    CHECK(archive->version_minor() == layout::kVersionMinor);
}

TEST_CASE("defaults and what is left out come back too", "[archive]") {
    TinyObject object = tiny_object(12);  // the grid's default size is not stored
    object.meta.tool_version.clear();
    object.meta.closed = object.meta.convex = false;
    object.materials[1].name.clear();
    object.area_clusters.clear();
    object.whole_area.clear();
    object.whole_area_scale.clear();
    object.intrinsic_area.clear();
    object.intrinsic_area_scale.clear();
    object.visibility.clear();
    object.error_directions = 0;
    object.whole_area_error.clear();
    object.intrinsic_area_error.clear();
    object.visibility_error.clear();
    object.volumes.clear();
    object.volume_triangles.clear();
    object.hit_volumes.clear();
    object.whole_hit.clear();
    object.intrinsic_hit.clear();
    object.self_steps.clear();
    object.self_exchange.clear();
    object.self_visibility.clear();
    object.self_escape.clear();
    object.self_received.clear();
    object.self_black.clear();
    object.atlas_centre = {};
    object.atlas_radius = 0;
    object.atlas_grid_size = object.atlas_image_size = 0;
    object.atlas_coverage.clear();
    const auto archive = Archive::from_bytes(encoded(object), "tiny.rro");
    REQUIRE(archive);
    check_same(archive->data(), object.data());
    CHECK(archive->sections().size() == 6);
}

TEST_CASE("a file is mapped and used in place", "[archive]") {
    const test::TemporaryFolder folder;
    const TinyObject object = tiny_object();
    const auto path = folder / "tiny.rro";
    REQUIRE(write_archive(object.data(), path));
    auto opened = Archive::open(path);
    REQUIRE(opened);
    const Archive archive = *std::move(opened);
    check_same(archive.data(), object.data());
    CHECK(archive.file_bytes() == std::filesystem::file_size(path));
    const std::string text = test::file_text(path);
    CHECK(archive.content_sha256() == sha256_hex(std::as_bytes(std::span(text))));
    for (const SectionInfo& section : archive.sections()) {
        CHECK(section.offset % 64 == 0);
        const bool in_place = section.name == "mesh" || section.name == "meta";
        CHECK((section.codec == "raw" || !in_place));
    }
    CHECK(reinterpret_cast<std::uintptr_t>(archive.data().positions.data()) % 16 == 0);
    CHECK(reinterpret_cast<std::uintptr_t>(archive.data().whole_area.data()) % 16 == 0);
}

TEST_CASE("the same object gives the same bytes", "[archive]") {
    const TinyObject object = tiny_object();
    const Bytes once = encoded(object);
    for (const unsigned threads : {1u, 2u, 8u}) {
        set_thread_count(threads);
        CHECK(encoded(tiny_object()) == once);
    }
    set_thread_count(0);
    TinyObject other = object;
    other.positions[3].x += 1e-6f;
    CHECK(encoded(other) != once);
}

TEST_CASE("a file that is not there, or is no file, is bad input and named", "[archive]") {
    const test::TemporaryFolder folder;
    for (const auto& path : {folder / "missing.rro", folder.path()}) {
        const auto archive = Archive::open(path);
        REQUIRE_FALSE(archive);
        CHECK(archive.error().kind == ErrorKind::BadInput);
        CHECK(archive.error().where == path.string());
    }
    std::ofstream(folder / "empty.rro").flush();
    const auto empty = Archive::open(folder / "empty.rro");
    REQUIRE_FALSE(empty);
    CHECK(contains(empty.error().message, "found 0 bytes"));
}

TEST_CASE("a newer major version is refused with the way out, a newer minor is read", "[archive]") {
    Bytes bytes = encoded(tiny_object());
    change_header(bytes, [](auto& header) { header.version_minor = 99; });
    const auto minor = Archive::from_bytes(bytes, "tiny.rro");
    REQUIRE(minor);
    CHECK(minor->version_minor() == 99);

    change_header(bytes, [](auto& header) { header.version_major = layout::kVersionMajor + 1; });
    const auto major = Archive::from_bytes(bytes, "tiny.rro");
    REQUIRE_FALSE(major);
    CHECK(major.error().kind == ErrorKind::BadInput);
    CHECK(contains(major.error().message, "is format 2.99, this build reads 1.x"));
    CHECK(contains(major.error().hint, "rro-compile build"));
}

TEST_CASE("unknown sections are skipped, whatever their codec; extract still gives the raw ones", "[archive]") {
    Bytes bytes = encoded(tiny_object());
    // `area` and `visibility` are optional: renamed they are unknown, and the `errors` of `area` are of no use.
    const auto rename = [](auto& entry) { std::memcpy(entry.name.data(), "brand_new\0\0", 11); };
    change_entry(bytes, "area", rename);
    change_entry(bytes, "visibility", [](auto& entry) {
        std::memcpy(entry.name.data(), "later_codec", 11);
        entry.codec = layout::Codec{7};
    });
    const auto archive = Archive::from_bytes(bytes, "tiny.rro");
    REQUIRE(archive);
    CHECK(archive->data().area_clusters.empty());
    CHECK(archive->data().visibility.empty());
    CHECK(archive->data().whole_area_error.empty());
    CHECK(archive->sections()[5].name == "brand_new");
    CHECK(archive->sections()[6].codec == "7");
    CHECK(archive->section("brand_new"));
    const auto later = archive->section("later_codec");
    REQUIRE_FALSE(later);
    CHECK(contains(later.error().where, "later_codec"));
    const auto missing = archive->section("nothing");
    REQUIRE_FALSE(missing);
    CHECK(contains(missing.error().message, "meta, mesh, materials"));
}

TEST_CASE("an optional section packed in a way of later versions counts as missing", "[archive][version]") {
    Bytes bytes = encoded(tiny_object());
    change_entry(bytes, "area", [](auto& entry) { entry.codec = layout::Codec{2}; });
    const auto archive = Archive::from_bytes(bytes, "tiny.rro");
    REQUIRE(archive);
    CHECK(archive->data().whole_area.empty());
    CHECK(archive->data().whole_area_error.empty());
    CHECK_FALSE(archive->data().visibility.empty());
    change_entry(bytes, "clusters", [](auto& entry) { entry.codec = layout::Codec{2}; });
    CHECK(contains(refusal(bytes), "section clusters: field codec: found 2, expected 0 or 1"));
}

TEST_CASE("the container's faults are named", "[archive]") {
    const Bytes good = encoded(tiny_object());
    const auto with_entry = [&](const std::string& section, const auto& change) {
        Bytes bytes = good;
        change_entry(bytes, section, change);
        return refusal(std::move(bytes));
    };
    const auto with_header = [&](const auto& change) {
        Bytes bytes = good;
        change_header(bytes, change);
        return refusal(std::move(bytes));
    };
    CHECK(contains(with_header([](auto& h) { h.archive_bytes += 64; }), "tiny.rro: header: field archive_bytes: found"));
    CHECK(contains(with_header([](auto& h) { h.section_count = 0xffffffff; }),
                   "header: field section_count: found 4294967295, expected at most 256"));
    CHECK(contains(with_header([](auto& h) { h.section_count = 256; }), "header: field section_count: found 256"));
    CHECK(contains(with_entry("mesh", [](auto& e) { e.offset += 4; }), "section mesh: field offset"));
    CHECK(contains(with_entry("mesh", [](auto& e) { e.offset = ~std::uint64_t{63}; }), "section mesh: field offset"));
    CHECK(contains(with_entry("mesh", [](auto& e) { e.offset -= 64; }), "section mesh: field offset"));
    CHECK(contains(with_entry("mesh", [](auto& e) { e.stored_bytes = 1u << 30; }), "section mesh: field stored_bytes"));
    CHECK(contains(with_entry("mesh", [](auto& e) { e.raw_bytes += 1; }), "section mesh: field raw_bytes"));
    CHECK(contains(with_entry("mesh", [](auto& e) { e.crc32 ^= 1; }), "section mesh: field crc32"));
    CHECK(contains(with_entry("mesh", [](auto& e) { e.codec = layout::Codec{2}; }), "section mesh: field codec: found 2"));
    CHECK(contains(with_entry("mesh", [](auto& e) { std::memcpy(e.name.data(), "meta", 4); }), "entry 1: field name: found meta"));
    CHECK(contains(with_entry("mesh", [](auto& e) { e.name[0] = 'M'; }), "directory entry 1: field name"));
    CHECK(contains(with_entry("mesh", [](auto& e) { e.name[0] = 'n'; }), "found no section mesh"));
}

TEST_CASE("a section that inflates to more or less than declared is refused before memory is spent", "[archive]") {
    const Bytes good = encoded(tiny_object());
    const auto with_size = [&](std::uint64_t raw_bytes) {
        Bytes bytes = good;
        change_entry(bytes, "visibility", [&](auto& e) { e.raw_bytes = raw_bytes; });
        return refusal(std::move(bytes));
    };
    const layout::SectionEntry entry = entry_of(good, "visibility");
    REQUIRE(entry.codec == layout::Codec::Zlib);
    CHECK(contains(with_size(entry.raw_bytes - 1), "section visibility: found"));
    CHECK(contains(with_size(entry.raw_bytes - 1), "hold more"));
    CHECK(contains(with_size(entry.raw_bytes + 1), "hold less"));
    CHECK(contains(with_size(0x3ffffff), "cannot hold as much"));
    CHECK(contains(with_size(0x7fffffff), "field raw_bytes: found 2147483647, "));
    CHECK(contains(with_size(0xffffffff), "section visibility: field raw_bytes"));
}

TEST_CASE("packed sections may not unfold to more than the file's size allows", "[archive]") {
    // Zeros shrink a thousandfold; each section is within its own bound, both together are not.
    Bytes bytes = encoded(tiny_object());
    const Bytes zeros(std::size_t{40} << 20);
    bytes = test::with_payload(bytes, "hbv", zeros, layout::Codec::Zlib);
    CHECK(contains(refusal(bytes), "section hbv"));  // as what it holds; one such section alone may be unpacked
    CHECK_FALSE(contains(refusal(bytes), "raw_bytes"));
    bytes = test::with_payload(bytes, "visibility", zeros, layout::Codec::Zlib);
    CHECK(contains(refusal(bytes), "section hbv: field raw_bytes: found 41943040, 8388"));
    CHECK(contains(refusal(bytes), "in all packed sections so far, expected at most 68"));
}

TEST_CASE("the writer stores raw what a reader would take for a bomb", "[archive]") {
    // 128 x 128 directions of 6 patches, all seen: within the bound of small files, so there are 4500.
    TinyObject object = tiny_object(128);
    object.patches.resize(4500, object.patches.back());
    for (std::uint32_t p = 5; p < 4500; ++p) {
        object.patches[p].first_face = p + 5;
        object.patches[p].face_count = 1;
    }
    object.triangles.resize(4505, object.triangles.back());
    object.source_triangle.resize(4505, 0);
    object.meta.source_triangles = 5000;
    object.volumes.clear();
    object.volume_triangles.clear();
    object.faces.clear();
    for (std::uint32_t t = 0; t < 4505; ++t) object.faces.push_back(Face::make(t, Side::Front));
    object.clusters.clear();
    test::add_clusters(object, 0, 4500, {1, 2, 3});
    object.area_clusters.clear();
    object.whole_area.clear();
    object.intrinsic_area.clear();
    object.whole_area_scale.clear();
    object.intrinsic_area_scale.clear();
    object.error_directions = 0;
    object.whole_area_error.clear();
    object.intrinsic_area_error.clear();
    object.visibility_error.clear();
    object.hit_volumes.clear();
    object.whole_hit.clear();
    object.intrinsic_hit.clear();
    object.self_steps.clear();
    object.self_exchange.clear();
    object.self_visibility.clear();
    object.self_escape.clear();
    object.self_received.clear();
    object.self_black.clear();
    object.visibility.assign(std::size_t{4500} * 128 * 128, 255);
    const Bytes bytes = encoded(object);
    CHECK(entry_of(bytes, "visibility").codec == layout::Codec::Raw);
    const auto archive = Archive::from_bytes(bytes, "flat.rro");
    REQUIRE(archive);
    CHECK(archive->data().visibility.size() == object.visibility.size());
}

TEST_CASE("only what is wanted is unpacked and shown, with what it refers to", "[archive]") {
    const Bytes bytes = encoded(tiny_object());
    const auto meta = Archive::from_bytes(bytes, "tiny.rro", Section::Meta);
    REQUIRE(meta);
    CHECK(meta->data().meta.source_name == "box.obj");
    CHECK(meta->data().positions.empty());
    CHECK(meta->sections().size() == 13);
    const auto tables = Archive::from_bytes(bytes, "tiny.rro", Section::Visibility);
    REQUIRE(tables);
    CHECK_FALSE(tables->data().visibility.empty());
    CHECK_FALSE(tables->data().patches.empty());  // visibility is per patch, and patches are ranges of faces
    CHECK_FALSE(tables->data().faces.empty());
    CHECK(tables->data().clusters.empty());
    CHECK(tables->data().source_triangle.empty());

    // What is not wanted is not looked at beyond its checksum; what is wanted is refused.
    const Bytes damaged = test::with_payload(bytes, "hbv", Bytes(100, std::byte{0xff}), layout::Codec::Zlib);
    CHECK(Archive::from_bytes(damaged, "tiny.rro", kGeometry | kTables));
    CHECK(contains(refusal(damaged), "section hbv"));
}

TEST_CASE("zlib streams survive damage of any byte", "[codec]") {
    Bytes raw(5000);
    for (std::size_t i = 0; i < raw.size(); ++i) raw[i] = static_cast<std::byte>(i * i / 7);
    const Bytes stored = compress_zlib(raw);
    const auto back = decompress_zlib(stored, raw.size(), "here");
    REQUIRE(back);
    CHECK(*back == raw);
    for (std::size_t i = 0; i < stored.size(); ++i) {
        Bytes damaged = stored;
        damaged[i] ^= std::byte{0x55};
        const auto result = decompress_zlib(damaged, raw.size(), "here");
        CHECK((!result || *result == raw));
        CHECK_FALSE(decompress_zlib(std::span(stored).first(i), raw.size(), "here"));
    }
    Bytes longer = stored;
    longer.push_back({});
    CHECK_FALSE(decompress_zlib(longer, raw.size(), "here"));
}

TEST_CASE("a section beyond 2 GiB is refused before it is built", "[archive]") {
    TinyObject object = tiny_object();
    ObjectData data = object.data();
    // The writer counts before it reads: the elements past the end are never touched.
    data.visibility = {data.visibility.data(), std::size_t{1} << 31};
    const auto bytes = encode_archive(data);
    REQUIRE_FALSE(bytes);
    CHECK(bytes.error().kind == ErrorKind::BadInput);
    CHECK(contains(bytes.error().where, "visibility"));
}
