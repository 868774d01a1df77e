// An independent witness: flatc, which has never seen our code, reads the sections by schemas/rro.fbs.
#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <regex>

#include <catch2/catch.hpp>

#include "format/archive_reader.h"
#include "format/archive_writer.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_object.h"

using namespace rro;

namespace {

/// The section as flatc's JSON without spaces, line ends and quotation marks.
std::string json_of(const Archive& archive, const std::string& section, const std::string& root,
                    const test::TemporaryFolder& folder) {
    const auto bytes = archive.section(section);
    REQUIRE(bytes);
    std::ofstream(folder / (section + ".bin"), std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes->data()), std::streamsize(bytes->size()));
    const std::string command = "cd '" + folder.path().string() + "' && flatc --json --raw-binary --root-type rro." + root +
                                " '" RRO_SOURCE_DIR "/schemas/rro.fbs' -- " + section + ".bin";
    REQUIRE(std::system(command.c_str()) == 0);
    return std::regex_replace(test::file_text(folder / (section + ".json")), std::regex("[\\s\"]"), "");
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("flatc reads every section", "[flatc]") {
    if (std::system("flatc --version > /dev/null 2>&1") != 0) {
        WARN("flatc (flatbuffers-compiler) is not installed: nothing was tested");
        return;
    }
    const test::TemporaryFolder folder;
    test::TinyObject object = test::tiny_object(2, {100, 0, -0.5});
    object.meta.grid_map = GridMap::LatLong;
    const auto encoded = encode_archive(object.data());
    REQUIRE(encoded);
    const auto archive = Archive::from_bytes(*encoded, "tiny.rro");
    REQUIRE(archive);

    const std::string meta = json_of(*archive, "meta", "Meta", folder);
    CHECK(contains(meta, "source_name:box.obj"));
    CHECK(contains(meta, "grid_map:LatLong,grid_size:2,image_resolution:256,source_triangles:13"));
    CHECK(contains(meta, "bounds_hi:{x:101.0,y:2.0,z:2.5}"));
    CHECK(contains(meta, "area:22.0,closed:true,convex:true"));

    const std::string mesh = json_of(*archive, "mesh", "Mesh", folder);
    CHECK(contains(mesh, "origin:{x:100.0,y:0.0,z:-0.5}"));
    CHECK(contains(mesh, "positions:[{x:0.0,y:0.0,z:0.0},{x:1.0,y:0.0,z:0.0},{x:0.0,y:2.0,z:0.0}"));
    CHECK(contains(mesh, "triangles:[{a:0,b:4,c:6},{a:0,b:6,c:2}"));
    CHECK(contains(mesh, "source_triangle:[1,2,3,4,5,6,7,8,9,10,11,12]"));
    CHECK(contains(mesh, "faces:[0,2,4,6,8,10,12,14,16,18,20,22]"));

    const std::string materials = json_of(*archive, "materials", "Materials", folder);
    CHECK(contains(materials, "{name:walls,reflectance:{x:0.5,y:0.25,z:0.125},exitance:{x:0.0,y:0.0,z:0.0}}"));
    CHECK(contains(materials, "{name:lamp,reflectance:{x:0.0,y:0.0,z:0.0},exitance:{x:20.0,y:18.0,z:15.5},textured:true}"));

    const std::string hbv = json_of(*archive, "hbv", "Hbv", folder);
    CHECK(contains(hbv, "hi:{x:1.0,y:2.0,z:3.0},first:5,count:7,right_child:0}]"));
    CHECK(contains(hbv, "triangles:[11,10,9,8,7,6,5,4,3,2,1,0]"));

    const std::string clusters = json_of(*archive, "clusters", "Clusters", folder);
    CHECK(contains(clusters, "clusters:[{first_patch:0,patch_count:6,right_child:6,area:22.0,centre:{x:0.5,y:1.0,z:1.5}"));
    CHECK(contains(clusters, "normal:{x:0.0,y:0.0,z:1.0},cone_cosine:1.0}]"));

    const std::string patches = json_of(*archive, "patches", "Patches", folder);
    CHECK(contains(patches, "{first_face:2,face_count:2,material:1,area:6.0,reflectance:{x:0.0,y:0.0,z:0.0},"
                            "centre:{x:1.0,y:1.0,z:1.5},normal:{x:1.0,y:0.0,z:0.0},cone_cosine:1.0}"));

    const std::string area = json_of(*archive, "area", "Area", folder);
    CHECK(contains(area, "{clusters:[0,1],whole:[0,1,2,3,4,5,6,7],whole_scale:[7.5,3.0],"
                         "intrinsic:[255,254,253,252,251,250,249,248],intrinsic_scale:[7.5,4.0]}"));

    const std::string visibility = json_of(*archive, "visibility", "Visibility", folder);
    CHECK(contains(visibility, "visibility:[255,255,"));
    CHECK(std::count(visibility.begin(), visibility.end(), ',') == 23);  // 6 patches, 4 directions
}
