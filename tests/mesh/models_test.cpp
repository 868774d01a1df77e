// Real meshes, where a folder of them is given: RRO_MODELS with a MANIFEST.tsv of "file <tab> triangles <tab> ...".
#include <cstdlib>
#include <sstream>

#include "mesh_files.h"

using namespace rro;
using namespace rro::test;

TEST_CASE("the models of RRO_MODELS have as many triangles as their list says", "[mesh][models]") {
    const char* folder = std::getenv("RRO_MODELS");
    if (folder == nullptr) {
        WARN("RRO_MODELS is not set: skipped");
        return;
    }
    std::ifstream list(std::filesystem::path(folder) / "MANIFEST.tsv");
    REQUIRE(list.is_open());
    std::string line;
    std::getline(list, line);  // column names
    while (std::getline(list, line)) {
        std::istringstream columns(line);
        std::string name, triangles;
        std::getline(columns, name, '\t');
        std::getline(columns, triangles, '\t');
        if (triangles == "-" || name.ends_with(".xz")) continue;
        INFO(name);
        const std::filesystem::path file = std::filesystem::path(folder) / name;
        ImportedMesh model = imported(file);
        CHECK(model.mesh.source_triangles == std::stoul(triangles));
        CHECK(model.mesh.triangles.size() + model.report.dropped_degenerate + model.report.dropped_not_finite ==
              model.mesh.source_triangles);
        decide_sides(model.mesh, TwoSided::Auto, false, model.report);
        CHECK(model.report.one_sided_triangles + model.report.two_sided_triangles == model.mesh.triangles.size());
    }
}
