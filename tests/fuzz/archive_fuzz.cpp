// Whole archives: what Archive lets pass must be readable, in every section and through every view, and its indices
// must lead somewhere.
#include <cmath>
#include <string>
#include <vector>

#include "format/archive_reader.h"
#include "format/parallel.h"
#include "format/section_codec.h"
#include "format/verifier.h"
#include "tests/fuzz/archive_mutator.h"
#include "tests/fuzz/reading.h"

namespace {

using namespace rro;
using fuzz::read_array;
using fuzz::require;

void read_views(const ObjectData& o) {
    read_array(o.positions);
    read_array(o.triangles);
    read_array(o.source_triangle);
    read_array(o.faces);
    read_array(o.patches);
    read_array(o.clusters);
    read_array(o.volumes);
    read_array(o.volume_triangles);
    read_array(o.area_clusters);
    read_array(o.whole_area);
    read_array(o.whole_area_scale);
    read_array(o.intrinsic_area);
    read_array(o.intrinsic_area_scale);
    read_array(o.visibility);
    read_array(o.whole_area_error);
    read_array(o.intrinsic_area_error);
    read_array(o.visibility_error);
    for (const Material& material : o.materials) fuzz::read_bytes(std::as_bytes(std::span(material.name)));
}

/// As the solver goes: down the trees to patches, faces, triangles and corners.
void walk(const ObjectData& o) {
    std::vector<std::uint32_t> open{0};
    std::size_t met = 0, faces = 0;
    double sum = 0;
    while (!open.empty()) {
        const std::uint32_t i = open.back();
        open.pop_back();
        require(++met <= o.clusters.size(), "a cluster is met once");
        const Cluster& cluster = o.clusters[i];
        sum += static_cast<double>(cluster.area);
        if (cluster.right_child != 0) {
            open.insert(open.end(), {i + 1, cluster.right_child});
            continue;
        }
        const Patch& patch = o.patches[cluster.first_patch];
        sum += o.materials[patch.material].reflectance.x;
        faces += patch.face_count;
        for (std::uint32_t f = patch.first_face; f < patch.first_face + patch.face_count; ++f)
            for (const Vec3& corner : o.corners(o.faces[f])) sum += corner.x;
    }
    require(met == o.clusters.size() && faces == o.faces.size(), "the tree holds all clusters and faces");
    require(std::isfinite(sum), "numbers are finite");
    for (const Volume& volume : o.volumes)
        for (const std::uint32_t t : o.volume_triangles.subspan(volume.first, volume.count))
            fuzz::read_array(std::span(o.triangles).subspan(t, 1));
}

/// Known sections by their description, all by their bytes, as far as they are not meant to fill the memory.
void read_sections(const Archive& archive) {
    constexpr std::uint64_t most_bytes = std::uint64_t{1} << 20;
    for (const SectionInfo& info : archive.sections()) {
        if (info.raw_bytes > most_bytes) continue;
        const auto content = archive.section(info.name);
        if (!content) continue;  // an unknown section may have an unknown codec, or be damaged inside
        fuzz::read_bytes(*content);
        for (const layout::SectionSpec& spec : layout::kSections)
            // One that is of no use without another section, which is missing, has not been looked at before.
            if (spec.name == info.name && verify_table(*content, spec.table, info.name))
                fuzz::read_table(TableView::root(*content), spec.table);
    }
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
    set_thread_count(1);
    return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const auto bytes = std::as_bytes(std::span(data, size));
    // Mostly all sections; else a single one with those that it needs, chosen by the bytes themselves.
    constexpr std::uint32_t single_one_in = 4;
    const std::uint32_t choice = crc32_of(bytes);
    const bool whole = choice % single_one_in != 0;
    const auto single = static_cast<Section>(choice / single_one_in % kSectionKinds);
    const auto archive =
        Archive::from_bytes({bytes.begin(), bytes.end()}, "fuzz.rro", whole ? SectionSet::all() : single);
    if (!archive) return 0;
    read_views(archive->data());
    if (!whole) return 0;
    walk(archive->data());
    read_sections(*archive);
    return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most, unsigned seed) {
    const auto changed = fuzz::mutate_archive(std::as_bytes(std::span(data, size)), most, seed, LLVMFuzzerMutate);
    return fuzz::hand_over(changed, data, most);
}

extern "C" std::size_t LLVMFuzzerCustomCrossOver(const std::uint8_t* a, std::size_t a_size, const std::uint8_t* b,
                                                 std::size_t b_size, std::uint8_t* out, std::size_t most,
                                                 unsigned seed) {
    const auto crossed =
        fuzz::cross_archives(std::as_bytes(std::span(a, a_size)), std::as_bytes(std::span(b, b_size)), seed);
    return fuzz::hand_over(crossed, out, most);
}
