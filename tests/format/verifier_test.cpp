// Every reference inside an archive is checked; a refusal names the section and the field.
#include "format/verifier.h"

#include <array>
#include <cstring>
#include <functional>
#include <limits>

#include <catch2/catch.hpp>

#include "format/archive_writer.h"
#include "format/table_builder.h"
#include "format/table_view.h"
#include "tests/support/tiny_object.h"

using namespace rro;
using test::tiny_object;
using test::TinyObject;

namespace {

using Bytes = std::vector<std::byte>;

struct Fault {
    const char* place;
    std::function<void(TinyObject&)> make;
};

const float kNan = std::numeric_limits<float>::quiet_NaN();
const double kInfinity = std::numeric_limits<double>::infinity();

void check_faults(const std::vector<Fault>& faults) {
    for (const Fault& fault : faults) {
        TinyObject object = tiny_object();
        fault.make(object);
        const Status status = verify_content(object.data(), SectionSet::all(), "tiny.rro");
        INFO(fault.place);
        REQUIRE_FALSE(status);
        CHECK(status.error().kind == ErrorKind::BadInput);
        CHECK(status.error().where == "tiny.rro: section " + std::string(fault.place));
        CHECK(status.error().message.starts_with("found "));
        CHECK(status.error().message.find(", expected ") != std::string::npos);
    }
}

template <class T>
void put(Bytes& bytes, std::size_t at, T value) {
    std::memcpy(bytes.data() + at, &value, sizeof value);
}

constexpr std::array kTiny{layout::in_place<double>("number"), layout::text("word"),
                           layout::array_of<std::uint32_t>("list"),
                           layout::FieldSpec{"inner", layout::FieldKind::Tables, 4, 4, layout::kMaterial}};

Bytes tiny_table() {
    static const std::vector<std::uint32_t> list{1, 2, 3};
    TableBuilder inner;
    inner.text(0, "steel");
    TableBuilder table;
    table.scalar(0, 2.5);
    table.text(1, "word");
    table.array<std::uint32_t>(2, list);
    table.tables(3, {inner, inner});
    return table.finish();
}

}  // namespace

TEST_CASE("the tiny object fits together", "[verifier]") { CHECK(verify_content(tiny_object().data(), SectionSet::all(), "tiny.rro")); }

TEST_CASE("faults of meta and materials", "[verifier]") {
    check_faults({
        {"meta: field grid_map", [](auto& o) { o.meta.grid_map = GridMap{2}; }},
        {"meta: field grid_size", [](auto& o) { o.meta.grid_size = 1; }},
        {"meta: field grid_size", [](auto& o) { o.meta.grid_size = 65536; }},
        {"meta: field bounds_lo", [](auto& o) { o.meta.bounds.lo.y = -kInfinity; }},
        {"meta: field bounds_hi", [](auto& o) { o.meta.bounds.hi.z = -1; }},
        {"meta: field area", [](auto& o) { o.meta.area = -1; }},
        {"materials: field materials[1].reflectance", [](auto& o) { o.materials[1].reflectance.y = 1; }},
        {"materials: field materials[0].reflectance", [](auto& o) { o.materials[0].reflectance.x = -0.1; }},
        {"materials: field materials[1].exitance", [](auto& o) { o.materials[1].exitance.z = kInfinity; }},
    });
}

TEST_CASE("faults of the mesh", "[verifier]") {
    check_faults({
        {"mesh: field origin", [](auto& o) { o.origin.x = kInfinity; }},
        {"mesh: field positions[5]", [](auto& o) { o.positions[5].y = kNan; }},
        {"mesh: field triangles[11]", [](auto& o) { o.triangles[11][2] = 8; }},
        {"mesh: field faces[2]", [](auto& o) { o.faces[2].packed = 24; }},
        {"mesh: field faces[2]", [](auto& o) { o.faces[2] = o.faces[1]; }},
    });
}

TEST_CASE("faults of the source numbers", "[verifier]") {
    check_faults({
        {"source: field triangles", [](auto& o) { o.source_triangle.pop_back(); }},
        {"source: field triangles", [](auto& o) { o.meta.source_triangles = 11; }},
        {"source: field triangles[3]", [](auto& o) { o.source_triangle[3] = 13; }},
    });
}

TEST_CASE("faults of patches", "[verifier]") {
    check_faults({
        {"patches: field patches", [](auto& o) { o.patches.clear(); }},
        {"patches: field patches", [](auto& o) { o.patches.pop_back(); }},
        {"patches: field patches[2].first_face", [](auto& o) { o.patches[2].first_face = 3; }},
        {"patches: field patches[2].face_count", [](auto& o) { o.patches[2].face_count = 0; }},
        {"patches: field patches[2].face_count", [](auto& o) { o.patches[2].face_count = 0xffffffff; }},
        {"patches: field patches[4].material", [](auto& o) { o.patches[4].material = 2; }},
        {"patches: field patches[4].area", [](auto& o) { o.patches[4].area = kNan; }},
        {"patches: field patches[4].reflectance", [](auto& o) { o.patches[4].reflectance.z = 1.5f; }},
        {"patches: field patches[4].centre", [](auto& o) { o.patches[4].centre.z = kNan; }},
        {"patches: field patches[4].normal", [](auto& o) { o.patches[4].normal.z = kNan; }},
        {"patches: field patches[4].cone_cosine", [](auto& o) { o.patches[4].cone_cosine = kNan; }},
    });
}

TEST_CASE("faults of the cluster tree", "[verifier]") {
    // Preorder of 6 patches: 0 (6) = 1 (3) + 6 (3); 1 = 2 (1) + 3 (2); 3 = 4 + 5; 6 = 7 (1) + 8 (2); 8 = 9 + 10.
    check_faults({
        {"clusters: field clusters", [](auto& o) { o.clusters.pop_back(); }},
        {"clusters: field clusters[0].first_patch", [](auto& o) { o.clusters[0].first_patch = 1; }},
        {"clusters: field clusters[0].patch_count", [](auto& o) { o.clusters[0].patch_count = 5; }},
        {"clusters: field clusters[0].right_child", [](auto& o) { o.clusters[0].right_child = 0; }},
        {"clusters: field clusters[3].right_child", [](auto& o) { o.clusters[3].right_child = 3; }},
        {"clusters: field clusters[3].right_child", [](auto& o) { o.clusters[3].right_child = 4000000000u; }},
        {"clusters: field clusters[4].right_child", [](auto& o) { o.clusters[4].right_child = 5; }},
        {"clusters: field clusters[1].first_patch", [](auto& o) { o.clusters[1].first_patch = 1; }},
        {"clusters: field clusters[1].patch_count", [](auto& o) { o.clusters[1].patch_count = 6; }},
        {"clusters: field clusters[1].patch_count", [](auto& o) { o.clusters[1].patch_count = 0; }},
        {"clusters: field clusters[6].first_patch", [](auto& o) { o.clusters[6].first_patch = 4; }},
        {"clusters: field clusters[6].patch_count", [](auto& o) { o.clusters[6].patch_count = 4; }},
        {"clusters: field clusters[7].area", [](auto& o) { o.clusters[7].area = -1; }},
        {"clusters: field clusters[7].radius", [](auto& o) { o.clusters[7].radius = kNan; }},
        {"clusters: field clusters[7].hi", [](auto& o) { o.clusters[7].hi.x = -1; }},
        {"clusters: field clusters[7].normal", [](auto& o) { o.clusters[7].normal.x = kNan; }},
        {"clusters: field clusters[7].cone_cosine", [](auto& o) { o.clusters[7].cone_cosine = kNan; }},
    });
}

TEST_CASE("faults of the bounding volumes", "[verifier]") {
    check_faults({
        {"hbv: field volumes", [](auto& o) { o.volumes.clear(); }},
        {"hbv: field triangles", [](auto& o) { o.volume_triangles.pop_back(); }},
        {"hbv: field triangles[2]", [](auto& o) { o.volume_triangles[2] = 12; }},
        {"hbv: field triangles[2]", [](auto& o) { o.volume_triangles[2] = 11; }},
        {"hbv: field volumes[0].first", [](auto& o) { o.volumes[0].first = 1; }},
        {"hbv: field volumes[0].count", [](auto& o) { o.volumes[0].count = 11; }},
        {"hbv: field volumes[0].right_child", [](auto& o) { o.volumes[0].right_child = 0; }},
        {"hbv: field volumes[0].right_child", [](auto& o) { o.volumes[0].right_child = 1; }},
        {"hbv: field volumes[0].right_child", [](auto& o) { o.volumes[0].right_child = 3; }},
        {"hbv: field volumes[1].right_child", [](auto& o) { o.volumes[1].right_child = 2; }},
        {"hbv: field volumes[2].right_child", [](auto& o) { o.volumes[2].right_child = 2; }},
        {"hbv: field volumes[1].first", [](auto& o) { o.volumes[1].first = 1; }},
        {"hbv: field volumes[1].count", [](auto& o) { o.volumes[1].count = 12; }},
        {"hbv: field volumes[2].first", [](auto& o) { o.volumes[2].first = 6; }},
        {"hbv: field volumes[2].count", [](auto& o) { o.volumes[2].count = 6; }},
        {"hbv: field volumes[2].hi", [](auto& o) { o.volumes[2].hi.y = -1; }},
    });
}

TEST_CASE("faults of the tables", "[verifier]") {
    check_faults({
        {"area: field clusters[1]", [](auto& o) { o.area_clusters[1] = 0; }},
        {"area: field clusters[1]", [](auto& o) { o.area_clusters[1] = 11; }},
        {"area: field whole", [](auto& o) { o.whole_area.pop_back(); }},
        {"area: field whole", [](auto& o) { o.whole_area.clear(); }},
        {"area: field whole_scale", [](auto& o) { o.whole_area_scale.pop_back(); }},
        {"area: field whole_scale[1]", [](auto& o) { o.whole_area_scale[1] = kNan; }},
        {"area: field intrinsic", [](auto& o) { o.intrinsic_area.push_back(0); }},
        {"area: field intrinsic_scale[0]", [](auto& o) { o.intrinsic_area_scale[0] = -1; }},
        {"visibility: field visibility", [](auto& o) { o.visibility.pop_back(); }},
        {"errors: field whole", [](auto& o) { o.whole_area_error.pop_back(); }},
        {"errors: field intrinsic[1]", [](auto& o) { o.intrinsic_area_error[1] = -0.5f; }},
        {"errors: field visibility[0]", [](auto& o) { o.visibility_error[0] = kNan; }},
    });
}

TEST_CASE("faults of self links", "[verifier]") {
    check_faults({
        {"selflinks: field exchange[1]", [](auto& o) { o.self_exchange[1] = -0.5f; }},
        {"selflinks: field exchange[2]", [](auto& o) { o.self_exchange[2] = kNan; }},
        {"selflinks: field visibility", [](auto& o) { o.self_visibility.pop_back(); }},
        {"selflinks: field escape", [](auto& o) { o.self_escape.pop_back(); }},
        {"selflinks: field received[5]", [](auto& o) { o.self_received[5] = std::numeric_limits<float>::infinity(); }},
        {"selflinks: field black[0]", [](auto& o) { o.self_black[0] = -1; }},
        {"selflinks: field steps[3]", [](auto& o) { o.self_steps[3] = 5; }},
        {"selflinks: field steps[2]", [](auto& o) { o.self_steps[2] = 4; }},
        {"selflinks: field steps[5]", [](auto& o) { o.self_steps.resize(5); }},
        {"selflinks: field steps[8]", [](auto& o) { o.self_exchange.push_back(1), o.self_visibility.push_back(0); }},
    });
}

TEST_CASE("faults of hit probabilities and silhouettes", "[verifier]") {
    check_faults({
        {"hit: field volumes[1]", [](auto& o) { o.hit_volumes[1] = 3; }},
        {"hit: field volumes[1]", [](auto& o) { o.hit_volumes[1] = 0; }},
        {"hit: field volumes[0]", [](auto& o) { o.hit_volumes[0] = 1; }},  // without the root above it
        {"hit: field volumes[0]", [](auto& o) { o.volumes.clear(), o.volume_triangles.clear(); }},
        {"hit: field whole", [](auto& o) { o.whole_hit.pop_back(); }},
        {"hit: field whole", [](auto& o) { o.whole_hit.clear(); }},
        {"hit: field intrinsic", [](auto& o) { o.intrinsic_hit.push_back(0); }},
        {"hit: field whole", [](auto& o) { o.hit_volumes.clear(); }},
        {"atlas: field centre", [](auto& o) { o.atlas_centre.y = kNan; }},
        {"atlas: field radius", [](auto& o) { o.atlas_radius = 0; }},
        {"atlas: field radius", [](auto& o) { o.atlas_radius = std::numeric_limits<float>::infinity(); }},
        {"atlas: field grid_size", [](auto& o) { o.atlas_grid_size = 0; }},
        {"atlas: field grid_size", [](auto& o) { o.atlas_grid_size = 3; }},
        {"atlas: field grid_size", [](auto& o) { o.atlas_grid_size = 0x80000000u; }},
        {"atlas: field image_size", [](auto& o) { o.atlas_image_size = 0; }},
        {"atlas: field image_size", [](auto& o) { o.atlas_image_size = 0xffffffffu; }},
        {"atlas: field coverage", [](auto& o) { o.atlas_coverage.pop_back(); }},
        {"atlas: field coverage", [](auto& o) { o.atlas_coverage.clear(); }},
    });
}

TEST_CASE("the hit probabilities of a grid of even size are stored for half of its directions", "[verifier]") {
    TinyObject object = tiny_object(4);
    CHECK(object.whole_hit.size() == 2 * 8);
    CHECK(verify_content(object.data(), SectionSet::all(), "tiny.rro"));
    object.whole_hit.resize(2 * 16);
    CHECK_FALSE(verify_content(object.data(), SectionSet::all(), "tiny.rro"));
}

TEST_CASE("trees have a greatest depth, and one level more is refused", "[verifier]") {
    // A list: each inner node's left child is a leaf. P patches make a tree P levels deep.
    const auto list_of = [](std::uint32_t patches) {
        TinyObject object = tiny_object(2);
        object.patches.resize(1);
        object.patches[0].face_count = 1;
        object.patches.resize(patches, object.patches[0]);
        object.triangles.resize(patches, object.triangles[0]);
        object.faces.clear();
        object.clusters.clear();
        for (std::uint32_t p = 0; p < patches; ++p) {
            object.patches[p].first_face = p;
            object.faces.push_back(Face::make(p, Side::Front));
            const std::uint32_t own = 2 * p, rest = patches - p;
            Cluster cluster{};
            cluster.hi = {1, 2, 3};
            cluster.first_patch = p;
            cluster.patch_count = rest;
            cluster.right_child = rest > 1 ? own + 2 : 0;
            object.clusters.push_back(cluster);
            if (rest == 1) break;
            cluster.patch_count = 1;
            cluster.right_child = 0;
            object.clusters.push_back(cluster);
        }
        return object;
    };
    const SectionSet trees = Section::Meta | kGeometry;
    CHECK(verify_content(list_of(layout::kMaxTreeDepth).data(), trees, "tiny.rro"));
    const Status deeper = verify_content(list_of(layout::kMaxTreeDepth + 1).data(), trees, "tiny.rro");
    REQUIRE_FALSE(deeper);
    CHECK(deeper.error().where == "tiny.rro: section clusters: field clusters[511]");
    CHECK(deeper.error().message == "found a tree 257 levels deep, expected at most 256");

    TinyObject object = tiny_object(2);
    const std::uint32_t leaves = layout::kMaxTreeDepth + 1;
    object.triangles.resize(leaves, object.triangles[0]);
    object.volume_triangles.resize(leaves);
    object.volumes.clear();
    for (std::uint32_t v = 0; v < leaves; ++v) {
        object.volume_triangles[v] = v;
        object.volumes.push_back({{}, {1, 2, 3}, v, leaves - v, v + 1 < leaves ? 2 * v + 2 : 0});
        if (v + 1 < leaves) object.volumes.push_back({{}, {1, 2, 3}, v, 1, 0});
    }
    const Status volumes = verify_content(object.data(), Section::Meta | Section::Mesh | Section::Hbv, "tiny.rro");
    REQUIRE_FALSE(volumes);
    CHECK(volumes.error().message == "found a tree 257 levels deep, expected at most 256");
}

TEST_CASE("the writer does not write what a reader would refuse", "[verifier]") {
    TinyObject object = tiny_object();
    object.clusters[3].right_child = 3;
    const auto bytes = encode_archive(object.data());
    REQUIRE_FALSE(bytes);
    CHECK(bytes.error().kind == ErrorKind::Internal);
}

TEST_CASE("a table is read back, absent and unknown fields included", "[table]") {
    const Bytes buffer = tiny_table();
    REQUIRE(verify_table(buffer, kTiny, "here"));
    const TableView view = TableView::root(buffer);
    CHECK(view.value<double>(0) == 2.5);
    CHECK(view.text(1) == "word");
    CHECK(view.array<std::uint32_t>(2).size() == 3);
    CHECK(view.array<std::uint32_t>(2)[2] == 3);
    REQUIRE(view.tables(3).size() == 2);
    CHECK(view.tables(3)[1].text(0) == "steel");
    CHECK(view.tables(3)[1].value<std::uint8_t>(3, 9) == 9);  // not written: the default
    CHECK(view.value<std::uint32_t>(17, 5) == 5);             // not even in the vtable
    // A reader that knows only the first field skips the others.
    CHECK(verify_table(buffer, std::span(kTiny).first(1), "here"));
    CHECK(verify_table(TableBuilder().finish(), kTiny, "here"));
}

TEST_CASE("a table cut off or changed anywhere is refused or read within its bounds", "[table]") {
    const Bytes good = tiny_table();
    const auto read_all = [](const Bytes& buffer) {
        const TableView view = TableView::root(buffer);
        std::size_t sum = view.text(1).size() + static_cast<std::size_t>(view.value<double>(0) == 0);
        for (const std::uint32_t x : view.array<std::uint32_t>(2)) sum += x;
        for (const TableView& inner : view.tables(3)) {
            for (const char c : inner.text(0)) sum += static_cast<std::size_t>(c);
            sum += static_cast<std::size_t>(inner.value<Vec3>(1).x == 0) + inner.value<std::uint8_t>(3);
        }
        return sum;
    };
    std::size_t refused = 0, sum = 0;
    for (std::size_t length = 0; length < good.size(); ++length) {
        const Bytes cut(good.begin(), good.begin() + std::ptrdiff_t(length));
        if (verify_table(cut, kTiny, "here")) sum += read_all(cut);
        else ++refused;
    }
    CHECK(refused >= good.size() - 1);  // all but padding at the end
    for (std::size_t i = 0; i < good.size(); ++i)
        for (unsigned value = 0; value < 256; ++value) {
            Bytes changed = good;
            changed[i] = static_cast<std::byte>(value);
            if (verify_table(changed, kTiny, "here")) sum += read_all(changed);
            else ++refused;
        }
    CHECK(refused > good.size());
    CHECK(sum > 0);
}

TEST_CASE("faults of the wire format are named", "[table]") {
    const Bytes good = tiny_table();
    const auto root = std::to_integer<std::size_t>(good[0]);
    const auto refusal = [](const Bytes& bytes) {
        const Status status = verify_table(bytes, kTiny, "tiny.rro: section x");
        REQUIRE_FALSE(status);
        return status.error().where;
    };
    const auto changed = [&](std::size_t at, auto value) {
        Bytes bytes = good;
        put(bytes, at, value);
        return refusal(bytes);
    };
    CHECK(refusal({}) == "tiny.rro: section x: field root");
    CHECK(changed(0, std::uint32_t{0xfffffff0}) == "tiny.rro: section x: field root");
    CHECK(changed(root, std::int32_t{1 << 30}) == "tiny.rro: section x: field root");
    const std::size_t vtable = 4;
    CHECK(changed(vtable, std::uint16_t{0xfffe}) == "tiny.rro: section x: field root");
    CHECK(changed(vtable + 2, std::uint16_t{0xfffe}) == "tiny.rro: section x: field root");
    CHECK(changed(vtable + 4, std::uint16_t{4}) == "tiny.rro: section x: field number");  // a double, badly aligned
    CHECK(changed(vtable + 6, std::uint16_t{0xfff0}) == "tiny.rro: section x: field word");
    const std::size_t list = root + std::to_integer<std::size_t>(good[vtable + 8]);
    CHECK(changed(list, std::uint32_t{0x7ffffffc}) == "tiny.rro: section x: field list");
    const std::size_t list_count = list + std::to_integer<std::size_t>(good[list]);
    CHECK(changed(list_count, std::uint32_t{0x40000001}) == "tiny.rro: section x: field list");
}

TEST_CASE("content referred to many times does not unfold", "[table]") {
    // One long name, and a vector of offsets that all lead to the one material with it.
    const std::string name(1000, 'x');
    TableBuilder inner;
    inner.text(0, name);
    TableBuilder table;
    table.tables(0, std::vector<TableBuilder>(50, inner));
    Bytes bytes = table.finish();
    REQUIRE(verify_table(bytes, layout::kMaterials, "here"));
    const std::size_t root = std::to_integer<std::size_t>(bytes[0]), field = root + 4;
    std::uint32_t to_vector = 0, to_first = 0;
    std::memcpy(&to_vector, bytes.data() + field, 4);
    const std::size_t first = field + to_vector + 4;
    std::memcpy(&to_first, bytes.data() + first, 4);
    bytes.resize(first + to_first + 1100);  // the first material, its name, and little more
    for (std::size_t i = 0; i < 50; ++i) put(bytes, first + 4 * i, static_cast<std::uint32_t>(to_first - 4 * i));
    const Status status = verify_table(bytes, layout::kMaterials, "here");
    REQUIRE_FALSE(status);
    CHECK(status.error().message.find("each byte referred to once") != std::string::npos);
}
