#include "compiler/archive_diff.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>

#include "compiler/compile_object.h"
#include "format/archive_writer.h"
#include "format/layout.h"
#include "format/section_codec.h"
#include "format/tool/json_document.h"
#include "schemas/diff_schema.h"
#include "tests/support/meshes.h"
#include "tests/support/tiny_object.h"

using namespace rro;
using Catch::Matchers::Contains;
using test::tiny_object;
using test::TinyObject;

namespace {

using Bytes = std::vector<std::byte>;

Archive opened(Result<Bytes> bytes) {
    REQUIRE(bytes);
    auto archive = Archive::from_bytes(*std::move(bytes), "in memory");
    if (!archive) FAIL(archive.error().where + ": " + archive.error().message);
    return *std::move(archive);
}

Archive archive_of(const TinyObject& object) {
    return opened(encode_archive(object.data()));
}

Archive compiled(const Mesh& mesh, CompileOptions options = {}) {
    options.image_resolution = 64;
    const auto object = compile_object(mesh, options);
    REQUIRE(object);
    return opened(encode_archive(object->data));
}

/// The diff, after a check that holds for all: the JSON fits its schema.
ArchiveDiff diff_of(const Archive& a, const Archive& b) {
    const ArchiveDiff diff = diff_archives(a, b);
    const auto fits = check_schema(nlohmann::json::parse(diff_json(diff, "a.rro", "b.rro")), diff_schema, "diff");
    if (!fits) FAIL(fits.error().where + ": " + fits.error().message);
    return diff;
}

/// All kinds but those of sections and the file.
std::set<std::string> kinds(const ArchiveDiff& diff) {
    std::set<std::string> found;
    for (const Change& change : diff.changes)
        if (change.group != "sections" && change.group != "file") found.insert(change.kind);
    return found;
}

const Change& only(const ArchiveDiff& diff, const std::string& kind) {
    const auto is_it = [&](const Change& change) { return change.kind == kind; };
    INFO(kind);
    REQUIRE(std::count_if(diff.changes.begin(), diff.changes.end(), is_it) == 1);
    return *std::find_if(diff.changes.begin(), diff.changes.end(), is_it);
}

template <class T>
T figure(const Change& change, const std::string& name) {
    for (const auto& [key, value] : change.more)
        if (key == name) return std::get<T>(value);
    FAIL("no figure " + name);
    return {};
}

/// A section as it stands in a file.
struct Stored {
    std::string name;
    std::uint32_t codec;
    std::uint64_t raw_bytes;
    Bytes bytes;
};

std::vector<Stored> unpacked(const Archive& archive) {
    std::vector<Stored> sections;
    for (const SectionInfo& info : archive.sections()) {
        const auto raw = archive.section(info.name);
        REQUIRE(raw);
        sections.push_back({info.name, 0, info.raw_bytes, *raw});
    }
    return sections;
}

/// An archive as another writer might lay it out.
Archive assembled(const std::vector<Stored>& sections, std::uint16_t minor = layout::kVersionMinor) {
    const auto aligned = [](std::size_t n) { return (n + 63) / 64 * 64; };
    std::vector<layout::SectionEntry> entries;
    Bytes file(64 + 64 * sections.size());
    for (const Stored& section : sections) {
        file.resize(aligned(file.size()));
        layout::SectionEntry entry{};
        std::copy(section.name.begin(), section.name.end(), entry.name.begin());
        entry.codec = static_cast<layout::Codec>(section.codec);
        entry.crc32 = crc32_of(section.bytes);
        entry.offset = file.size();
        entry.stored_bytes = section.bytes.size();
        entry.raw_bytes = section.raw_bytes;
        entries.push_back(entry);
        file.insert(file.end(), section.bytes.begin(), section.bytes.end());
    }
    const auto directory = std::as_bytes(std::span(entries));
    layout::ArchiveHeader header{layout::kMagic,
                                 layout::kVersionMajor,
                                 minor,
                                 file.size(),
                                 64,
                                 static_cast<std::uint32_t>(entries.size()),
                                 crc32_of(directory),
                                 0,
                                 0};
    header.header_crc32 = crc32_of(std::as_bytes(std::span(&header, 1)).first(layout::kHeaderCrcOffset));
    std::memcpy(file.data(), &header, sizeof header);
    std::memcpy(file.data() + 64, directory.data(), directory.size());
    return opened(std::move(file));
}

}  // namespace

TEST_CASE("an archive does not differ from itself", "[compiler][diff]") {
    const Archive archive = archive_of(tiny_object());
    const ArchiveDiff diff = diff_of(archive, archive);
    CHECK(diff.same);
    CHECK(diff.changes.empty());
    CHECK(diff.unchanged_sections.size() == archive.sections().size());
    CHECK(diff_text(diff, "a.rro", "b.rro") == "a.rro -> b.rro: the same, byte for byte\n");
}

TEST_CASE("packing, format version and layout are not content", "[compiler][diff]") {
    const Archive archive = archive_of(tiny_object());
    std::vector<Stored> sections = unpacked(archive);
    SECTION("another codec and minor version") {
        for (Stored& section : sections)
            if (section.name == "mesh") section = {"mesh", 1, section.raw_bytes, compress_zlib(section.bytes)};
        const ArchiveDiff diff = diff_of(archive, assembled(sections, layout::kVersionMinor + 1));
        CHECK(diff.same);
        CHECK(diff.summary == "same content; the files differ in format version and compression");
        CHECK(kinds(diff) == std::set<std::string>{"format_version"});
        std::set<std::string> repacked;
        for (const Change& change : diff.changes)
            if (change.kind == "codec") repacked.insert(change.what);
        std::set<std::string> expected{"mesh"};
        for (const SectionInfo& section : archive.sections())
            if (section.codec == "zlib") expected.insert(section.name);
        CHECK(expected.size() > 2);
        CHECK(repacked == expected);
    }
    SECTION("another order of sections") {
        const Archive straight = assembled(sections);
        std::reverse(sections.begin(), sections.end());
        const ArchiveDiff diff = diff_of(straight, assembled(sections));
        CHECK(diff.same);
        CHECK(diff.summary == "same content; the files differ in the layout of their sections");
    }
    SECTION("a section that this version cannot unpack is judged by its checksum") {
        sections.push_back({"later", 7, 1000, Bytes(10, std::byte{1})});
        const Archive first = assembled(sections);
        std::vector<Stored> changed = sections;
        changed.back().bytes[3] = std::byte{2};
        CHECK(diff_of(first, assembled(sections)).same);
        const ArchiveDiff diff = diff_of(first, assembled(changed));
        CHECK(!diff.same);
        CHECK(only(diff, "section_changed").what == "later");
    }
    SECTION("a section more or less is") {
        const Archive more = assembled(sections);
        std::erase_if(sections, [](const Stored& s) { return s.name == "hbv"; });
        const Archive less = assembled(sections);
        CHECK(!diff_of(more, less).same);
        CHECK(only(diff_of(more, less), "section_removed").what == "hbv");
        CHECK(only(diff_of(less, more), "section_added").what == "hbv");
        CHECK(std::get<std::uint64_t>(only(diff_of(less, more), "volumes").before) == 0);
    }
}

TEST_CASE("each change is told by its kind and nothing else is", "[compiler][diff]") {
    struct Case {
        std::set<std::string> kinds;
        std::function<void(TinyObject&)> make;
    };
    const std::vector<Case> cases{
        {{"tool_version"}, [](auto& o) { o.meta.tool_version = "9"; }},
        {{"source_name"}, [](auto& o) { o.meta.source_name = "cube.obj"; }},
        {{"source_sha256"}, [](auto& o) { o.meta.source_sha256 = std::string(64, 'b'); }},
        {{"option"}, [](auto& o) { o.meta.options = "grid=3 up=z"; }},
        {{"source_triangles"}, [](auto& o) { o.meta.source_triangles = 20; }},
        {{"area"}, [](auto& o) { o.meta.area = 23; }},
        {{"bounds_lo"}, [](auto& o) { o.meta.bounds.lo.x = -1; }},
        {{"bounds_hi"}, [](auto& o) { o.meta.bounds.hi.z = 4; }},
        {{"closed"}, [](auto& o) { o.meta.closed = false; }},
        {{"convex"}, [](auto& o) { o.meta.convex = false; }},
        {{"image_resolution"}, [](auto& o) { o.meta.image_resolution = 512; }},
        {{"reflectance"}, [](auto& o) { o.materials[0].reflectance.y = 0.3; }},
        {{"exitance"}, [](auto& o) { o.materials[1].exitance.z = 0; }},
        {{"textured"}, [](auto& o) { o.materials[0].textured = true; }},
        {{"material_added"},
         [](auto& o) {
             o.materials.push_back({"spare", {}, {}, false});
         }},
        {{"material_removed", "material_added", "triangles_material"}, [](auto& o) { o.materials[0].name = "wood"; }},
        {{"triangles_material"}, [](auto& o) { o.patches[0].material = 1; }},
        {{"texture"}, [](auto& o) { o.patches[1].reflectance.x = 0.5f; }},
        {{"triangles", "triangles_moved"}, [](auto& o) { o.positions[7].x = 1.5f; }},
        {{"triangles", "triangles_turned"}, [](auto& o) { std::swap(o.triangles[4][1], o.triangles[4][2]); }},
        {{"triangles", "triangles_renumbered"}, [](auto& o) { o.source_triangle[11] = 0; }},
        {{"stored_order"},
         [](auto& o) { std::rotate(o.triangles[0].begin(), o.triangles[0].begin() + 1, o.triangles[0].end()); }},
        {{"triangles_sides"}, [](auto& o) { o.faces[0] = Face::make(0, Side::Back); }},
        {{"vertices"}, [](auto& o) { o.positions.push_back({}); }},
        {{"volumes", "volume_depth", "hit_volumes"},
         [](auto& o) {
             o.volumes.resize(1), o.volumes[0].right_child = 0;
             o.hit_volumes.resize(1), o.whole_hit.resize(9), o.intrinsic_hit.resize(9);
         }},
        {{"area_clusters"},
         [](auto& o) {
             o.area_clusters.pop_back(), o.whole_area_scale.pop_back(), o.intrinsic_area_scale.pop_back();
             o.whole_area.resize(9), o.intrinsic_area.resize(9);
             o.whole_area_error.pop_back(), o.intrinsic_area_error.pop_back(), o.visibility_error.pop_back();
         }},
        {{"whole_area"}, [](auto& o) { o.whole_area_scale[0] *= 2; }},
        {{"intrinsic_area"}, [](auto& o) { o.intrinsic_area[3] = 0; }},
        {{"whole_area_of_clusters"}, [](auto& o) { o.whole_area_scale[1] *= 2; }},
        {{"intrinsic_area_of_clusters"}, [](auto& o) { o.intrinsic_area[12] = 7; }},
        {{"visibility"}, [](auto& o) { o.visibility[20] = 0; }},
        {{"whole_area_error"}, [](auto& o) { o.whole_area_error[0] = 0.5f; }},
        {{"intrinsic_area_error"}, [](auto& o) { o.intrinsic_area_error[0] = 0.5f; }},
        {{"visibility_error"}, [](auto& o) { o.visibility_error[0] = 0.5f; }},
        {{"hit_volumes"}, [](auto& o) { o.hit_volumes.pop_back(), o.whole_hit.resize(9), o.intrinsic_hit.resize(9); }},
        {{"hit_probability"}, [](auto& o) { o.whole_hit[3] = 0; }},
        {{"intrinsic_hit_probability"}, [](auto& o) { o.intrinsic_hit[8] = 0; }},
        {{"hit_probability_of_volumes"}, [](auto& o) { o.whole_hit[9] = 0; }},
        {{"intrinsic_hit_probability_of_volumes"}, [](auto& o) { o.intrinsic_hit[17] = 0; }},
        {{"atlas_layout"}, [](auto& o) { o.atlas_image_size = 1, o.atlas_coverage.resize(2); }},
        {{"atlas_sphere"}, [](auto& o) { o.atlas_radius = 2; }},
        {{"silhouette"}, [](auto& o) { o.atlas_coverage[7] = 0; }},
        // Bits that no kind of its own tells: the section does.
        {{}, [](auto& o) { o.patches[2].cone_cosine = 0.5f; }},
    };
    const Archive before = archive_of(tiny_object());
    for (const Case& example : cases) {
        TinyObject object = tiny_object();
        example.make(object);
        const Archive after = archive_of(object);
        const ArchiveDiff forth = diff_of(before, after), back = diff_of(after, before);
        const std::string text = diff_text(forth, "a.rro", "b.rro");
        INFO(text);
        CHECK(!forth.same);
        std::set<std::string> found = kinds(forth);
        // A patch with a turned side is another patch.
        if (example.kinds.contains("triangles_sides")) found.erase("patches");
        CHECK(found == example.kinds);
        CHECK(forth.unchanged_sections == back.unchanged_sections);
        // The errors are per area cluster, the hit probabilities per volume.
        const std::size_t changed = example.kinds.contains("area_clusters") || example.kinds.contains("volumes") ? 2 : 1;
        CHECK(forth.unchanged_sections.size() + changed == before.sections().size());
        // Back is forth the other way round.
        if (example.kinds == std::set<std::string>{"material_added"})
            CHECK(kinds(back) == std::set<std::string>{"material_removed"});
        else
            CHECK(kinds(back) == kinds(forth));
        if (example.kinds.size() == 1 && kinds(back) == kinds(forth)) {
            CHECK(only(forth, *example.kinds.begin()).before == only(back, *example.kinds.begin()).after);
            CHECK(only(forth, *example.kinds.begin()).after == only(back, *example.kinds.begin()).before);
        }
    }
}

TEST_CASE("options are compared key by key", "[compiler][diff]") {
    TinyObject a = tiny_object(), b = tiny_object();
    a.meta.options = "grid=3 up=y weights=size:1,aspect:2 old=1";
    b.meta.options = "grid=3 up=z weights=size:1,aspect:2 new=";
    const ArchiveDiff diff = diff_of(archive_of(a), archive_of(b));
    CHECK(diff.summary == "same source, compiled with other options");
    REQUIRE(diff.changes.size() >= 3);
    CHECK(diff.changes[0].text == "option new: (absent) -> ");
    CHECK(diff.changes[1].text == "option old: 1 -> (absent)");
    CHECK(diff.changes[2].text == "option up: y -> z");
    CHECK(std::holds_alternative<std::monostate>(diff.changes[0].before));
}

TEST_CASE("the summary says which of source, options and compiler changed", "[compiler][diff]") {
    const auto summary = [](const std::function<void(TinyObject&)>& change) {
        TinyObject object = tiny_object();
        change(object);
        return diff_of(archive_of(tiny_object()), archive_of(object)).summary;
    };
    const auto other_source = [](TinyObject& o) { o.meta.source_sha256[5] = '0'; };
    CHECK(summary(other_source) == "the source changed");
    CHECK(summary([&](TinyObject& o) { other_source(o), o.meta.options = "grid=4"; }) ==
          "the source and the options changed");
    CHECK(summary([](TinyObject& o) { o.meta.tool_version = "2"; }) ==
          "same source and options, other compiler version");
    CHECK(summary([](TinyObject& o) { o.meta.options += " table_version=2"; }) ==
          "same source and options, other compiler version");
    CHECK(summary([](TinyObject& o) { o.whole_area[0] = 1; }) == "same source, options and compiler version");
}

TEST_CASE("a moved vertex names its triangles and how far it went", "[compiler][diff]") {
    TinyObject moved = tiny_object();
    moved.positions[0] = {-0.3f, 0, -0.4f};
    std::uint64_t touching = 0;
    for (const TriangleIndices& t : moved.triangles) touching += std::count(t.begin(), t.end(), 0u);
    const ArchiveDiff diff = diff_of(archive_of(tiny_object()), archive_of(moved));
    const Change& change = only(diff, "triangles_moved");
    CHECK(figure<std::uint64_t>(change, "count") == touching);
    CHECK(figure<double>(change, "largest") == Approx(0.5));
    CHECK(figure<double>(change, "largest_relative") == Approx(0.5 / std::sqrt(14.0)));
    CHECK(std::get<Vec3>(change.before) == Vec3{0, 0, 0});
    CHECK(length(std::get<Vec3>(change.after) - Vec3{-0.3, 0, -0.4}) < 1e-7);
    const auto number = static_cast<std::uint32_t>(figure<std::uint64_t>(change, "largest_triangle"));
    const auto ranges = figure<NumberRanges>(change, "triangles");
    CHECK(std::any_of(ranges.begin(), ranges.end(), [&](const auto& r) { return r[0] <= number && number <= r[1]; }));
    CHECK(std::get<std::uint64_t>(only(diff, "triangles").after) == 12);
    CHECK(figure<std::uint64_t>(only(diff, "triangles"), "kept") == 12 - touching);
}

TEST_CASE("taking triangles out of a file renumbers the rest, which is not a change of shape", "[compiler][diff]") {
    const Mesh whole = test::make_sphere(2);  // 320 triangles
    Mesh cut = test::empty_mesh(false);
    cut.positions = whole.positions;
    for (std::size_t t = 0; t < whole.triangles.size(); ++t)
        if (t < 100 || t >= 110)
            test::add_triangle(cut, whole.triangles[t][0], whole.triangles[t][1], whole.triangles[t][2]);
    const ArchiveDiff diff = diff_of(compiled(whole), compiled(cut));
    const Change& removed = only(diff, "triangles_removed");
    CHECK(figure<NumberRanges>(removed, "triangles") == NumberRanges{{100, 109}});
    CHECK(removed.text == "10 triangles removed: 100-109");
    const Change& renumbered = only(diff, "triangles_renumbered");
    CHECK(figure<NumberRanges>(renumbered, "triangles") == NumberRanges{{110, 319}});
    CHECK(figure<NumberRanges>(renumbered, "triangles_after") == NumberRanges{{100, 309}});
    CHECK(!kinds(diff).contains("triangles_moved"));
    CHECK(!kinds(diff).contains("triangles_added"));
    CHECK(std::get<bool>(only(diff, "closed").after) == false);

    const ArchiveDiff back = diff_of(compiled(cut), compiled(whole));
    CHECK(figure<NumberRanges>(only(back, "triangles_added"), "triangles") == NumberRanges{{100, 109}});
    CHECK(!kinds(back).contains("triangles_removed"));
}

TEST_CASE("turning a box inside out turns every triangle and moves none", "[compiler][diff]") {
    const Mesh box = test::make_box(1, 2, 3);
    const ArchiveDiff diff = diff_of(compiled(box), compiled(test::turned_inside_out(box)));
    CHECK(figure<std::uint64_t>(only(diff, "triangles_turned"), "count") == 12);
    CHECK(!kinds(diff).contains("triangles_moved"));
    CHECK(std::get<bool>(only(diff, "convex").before));
}

TEST_CASE("triangles that become two-sided are counted, and the area doubles", "[compiler][diff]") {
    const ArchiveDiff diff =
        diff_of(compiled(test::make_quad(1, 1, false, 3)), compiled(test::make_quad(1, 1, true, 3)));
    const Change& sides = only(diff, "triangles_sides");
    CHECK(std::get<std::string>(sides.before) == "one-sided");
    CHECK(std::get<std::string>(sides.after) == "two-sided");
    CHECK(figure<NumberRanges>(sides, "triangles") == NumberRanges{{0, 17}});
    CHECK(figure<double>(only(diff, "area"), "relative") == Approx(1));
    CHECK(!kinds(diff).contains("triangles"));
}

TEST_CASE("materials of one name are paired in order", "[compiler][diff]") {
    TinyObject a = tiny_object();
    a.materials = {{"m", {0.1, 0.1, 0.1}, {}, false}, {"m", {0.2, 0.2, 0.2}, {}, false}};
    TinyObject b = a;
    b.materials[1].reflectance = {0.3, 0.2, 0.2};
    b.materials.push_back({"m", {0.4, 0.4, 0.4}, {}, false});
    const ArchiveDiff diff = diff_of(archive_of(a), archive_of(b));
    const Change& reflectance = only(diff, "reflectance");
    CHECK(reflectance.what == "m");
    CHECK(figure<std::uint64_t>(reflectance, "occurrence") == 2);
    CHECK(reflectance.text == "\"m\" (no. 2 of this name): reflectance (0.2, 0.2, 0.2) -> (0.3, 0.2, 0.2)");
    CHECK(figure<std::uint64_t>(only(diff, "material_added"), "occurrence") == 3);

    TinyObject swapped = tiny_object();
    std::swap(swapped.materials[0], swapped.materials[1]);
    for (Patch& patch : swapped.patches) patch.material = 1 - patch.material;
    CHECK(kinds(diff_of(archive_of(tiny_object()), archive_of(swapped))) == std::set<std::string>{"material_order"});
}

TEST_CASE("a table that grows by a tenth changed by a tenth of its mean, the most where it is largest",
          "[compiler][diff]") {
    TinyObject a = tiny_object(5);
    std::fill(a.whole_area.begin(), a.whole_area.begin() + 25, std::uint8_t{100});
    a.whole_area[7] = 255;
    TinyObject b = a;
    b.whole_area_scale[0] *= 1.1f;
    const Archive before = archive_of(a);
    const ArchiveDiff diff = diff_of(before, archive_of(b));
    const Change& change = only(diff, "whole_area");
    CHECK(figure<double>(change, "relative") == Approx(0.1));
    // All values but one are alike, so the RMS is a little above the mean.
    CHECK(figure<double>(change, "rms_relative") >= 0.1);
    CHECK(figure<double>(change, "rms_relative") < 0.12);
    CHECK(figure<double>(change, "largest") == Approx(0.1 * static_cast<double>(a.whole_area_scale[0])));
    CHECK(figure<Vec3>(change, "largest_direction") == before.grid().direction(7));
    CHECK(!kinds(diff).contains("intrinsic_area"));

    // The same tables the other way round: one value fell to nothing.
    b = a;
    std::fill(b.whole_area.begin(), b.whole_area.begin() + 25, std::uint8_t{0});
    const ArchiveDiff gone = diff_of(before, archive_of(b));
    CHECK(std::get<double>(only(gone, "whole_area").after) == 0);
    CHECK(figure<double>(only(gone, "whole_area"), "relative") == -1);
}

TEST_CASE("tables over other directions are compared by their means", "[compiler][diff]") {
    const Mesh sphere = test::make_sphere(3);
    CompileOptions fine;
    fine.grid_size = 17;
    fine.grid_map = GridMap::LatLong;
    const Archive before = compiled(sphere), after = compiled(sphere, fine);
    const ArchiveDiff diff = diff_of(before, after);
    CHECK(std::get<std::string>(only(diff, "grid").before) == "12 x 12 octahedral");
    CHECK(std::get<std::string>(only(diff, "grid").after) == "17 x 17 latlong");
    // Cauchy: a quarter of the surface in both, so both within the 1 % that quantising and small images leave.
    const Change& change = only(diff, "whole_area");
    CHECK(std::get<double>(change.before) == Approx(before.data().meta.area / 4).epsilon(0.01));
    CHECK(std::get<double>(change.after) == Approx(before.data().meta.area / 4).epsilon(0.01));
    CHECK(std::none_of(change.more.begin(), change.more.end(), [](const auto& m) { return m.first == "rms"; }));
    CHECK(!kinds(diff).contains("visibility"));
    CHECK(!kinds(diff).contains("patches"));
}

TEST_CASE("the visibility of patches counts by their area", "[compiler][diff]") {
    TinyObject hidden = tiny_object();
    std::fill(hidden.visibility.begin() + 2 * 9, hidden.visibility.begin() + 3 * 9, std::uint8_t{0});
    const ArchiveDiff diff = diff_of(archive_of(tiny_object()), archive_of(hidden));
    const Change& change = only(diff, "visibility");
    CHECK(figure<std::uint64_t>(change, "count") == 1);
    CHECK(figure<std::uint64_t>(change, "of") == 6);
    // One wall of 3 m^2, of 22 in all, went from seen to hidden.
    CHECK(figure<double>(change, "rms") == Approx(std::sqrt(static_cast<double>(hidden.patches[2].area) / 22)));
}

TEST_CASE("patches in another order are found again", "[compiler][diff]") {
    const Mesh box = test::make_box(1, 1, 1, 3);
    Mesh painted = box;
    painted.materials.push_back({"red", {0.9, 0.1, 0.1}, {}, false});
    for (std::size_t t = 0; t < 36; ++t) painted.material[t] = 1;
    const Archive before = compiled(box), after = compiled(painted);
    const ArchiveDiff diff = diff_of(before, after);
    CHECK(figure<std::uint64_t>(only(diff, "triangles_material"), "count") == 36);
    CHECK(only(diff, "material_added").what == "red");
    CHECK(!kinds(diff).contains("patches"));
    CHECK(!kinds(diff).contains("triangles"));
    CHECK(!kinds(diff).contains("visibility"));  // nothing of a convex body is hidden, whatever its colours
}

TEST_CASE("everything may be of other size", "[compiler][diff]") {
    const Archive tiny = archive_of(tiny_object()), sphere = compiled(test::make_sphere(1));
    TinyObject bare = tiny_object();
    bare.visibility.clear();
    bare.area_clusters.clear(), bare.whole_area.clear(), bare.intrinsic_area.clear();
    bare.whole_area_scale.clear(), bare.intrinsic_area_scale.clear();
    bare.error_directions = 0;
    bare.whole_area_error.clear(), bare.intrinsic_area_error.clear(), bare.visibility_error.clear();
    bare.volumes.clear(), bare.volume_triangles.clear();
    bare.hit_volumes.clear(), bare.whole_hit.clear(), bare.intrinsic_hit.clear(), bare.atlas_coverage.clear();
    bare.atlas_grid_size = bare.atlas_image_size = 0;
    const Archive small = archive_of(bare);
    for (const Archive* a : {&tiny, &sphere, &small})
        for (const Archive* b : {&tiny, &sphere, &small}) CHECK(diff_of(*a, *b).same == (a == b));
}

TEST_CASE("the text keeps groups in order, labels each once, and cuts long lists", "[compiler][diff]") {
    TinyObject a = tiny_object(), b = tiny_object();
    for (int i = 0; i < 20; ++i) {
        a.materials.push_back({"m" + std::to_string(i), {0.5, 0.5, 0.5}, {}, false});
        b.materials.push_back({"m" + std::to_string(i), {0.6, 0.5, 0.5}, {}, false});
    }
    b.meta.area = 11;
    const ArchiveDiff diff = diff_of(archive_of(a), archive_of(b));
    const std::string text = diff_text(diff, "old/a.rro", "new/a.rro");
    CHECK_THAT(text, Catch::Matchers::StartsWith("old/a.rro -> new/a.rro: same source, options and compiler version\n"
                                                 "geometry    area: 22 -> 11 m^2 (x 0.5)\n"
                                                 "materials   \"m0\": reflectance (0.5, 0.5, 0.5) -> (0.6, 0.5, 0.5)\n"
                                                 "            \"m1\": "));
    CHECK_THAT(text, Contains("            and 8 more (--json has all)\n"));
    CHECK_THAT(text, Catch::Matchers::EndsWith("unchanged   mesh, patches, clusters, area, visibility, errors, hbv, source, hit, atlas, selflinks\n"));
    const auto json = nlohmann::json::parse(diff_json(diff, "old/a.rro", "new/a.rro"));
    CHECK(std::count_if(json["changes"].begin(), json["changes"].end(),
                        [](const auto& c) { return c["kind"] == "reflectance"; }) == 20);
    CHECK(json["a"]["file"] == "old/a.rro");
    CHECK(json["same"] == false);
}

TEST_CASE("before and after are printed with the digits that tell them apart", "[compiler][diff]") {
    TinyObject object = tiny_object();
    object.meta.area = 22.00000001;
    const ArchiveDiff diff = diff_of(archive_of(tiny_object()), archive_of(object));
    CHECK_THAT(only(diff, "area").text, Catch::Matchers::StartsWith("area: 22 -> 22.00000001 m^2 (+4.5e-08 %)"));
}
