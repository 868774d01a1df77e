// A program that reads an archive: what the object is, and how much of it is seen from six sides.
//
//   object_facts OBJECT.rro
//
// Built with the tests; programs of your own link rro::format (samples/programs/CMakeLists.txt).
#include <cstdio>

#include "format/archive_reader.h"

namespace {

/// The object's effective area as seen from a direction (from the object to who looks), m^2.
double seen_area(const rro::Archive& archive, const rro::Vec3& direction) {
    const rro::ObjectData& data = archive.data();
    // The first cluster with a table is the whole object.
    const auto table = data.whole_area.first(data.directions());
    return archive.grid().interpolate(table, direction) * double(data.whole_area_scale[0]) / 255;
}

}  // namespace

int main(int count, char** words) {
    if (count != 2) {
        std::fprintf(stderr, "usage: object_facts OBJECT.rro\n");
        return 2;
    }
    const auto archive = rro::Archive::open(words[1], rro::kGeometry | rro::Section::Area);
    if (!archive) {
        std::fprintf(stderr, "object_facts: %s: %s\n", archive.error().where.c_str(), archive.error().message.c_str());
        return 1;
    }
    const rro::ObjectData& data = archive->data();
    const rro::Vec3 size = data.meta.bounds.extent();
    std::printf("%s: %.2f x %.2f x %.2f m, %zu triangles, %zu patches, %zu materials, %.3f m^2\n",
                data.meta.source_name.c_str(), size.x, size.y, size.z, data.triangles.size(), data.patches.size(),
                data.materials.size(), data.meta.area);
    if (data.whole_area.empty()) return 0;  // compiled without tables of areas
    const rro::Vec3 sides[] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    const char* names[] = {"+x", "-x", "+y", "-y", "+z", "-z"};
    for (int i = 0; i < 6; ++i) std::printf("seen from %s: %.4f m^2\n", names[i], seen_area(*archive, sides[i]));
    return 0;
}
