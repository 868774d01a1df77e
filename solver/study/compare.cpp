#include "solver/study/compare.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <unordered_map>

namespace rro {
namespace {

constexpr double kMatters = 1e-3;       // instances with less of the light's square are not named as the worst
constexpr std::size_t kRunsPerCut = 8;  // of so many runs, one outlier at each end does not count

double median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    const std::size_t n = values.size();
    return n % 2 == 1 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
}

double spread(const std::vector<double>& values) {
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    return *high - *low;
}

double ratio(double base, double head) {
    if (base > 0) return head / base;
    return head > 0 ? std::numeric_limits<double>::infinity() : 1.0;
}

/// A face's triangle in the source and its side: what versions of an archive have in common.
std::uint64_t key_of(const ObjectData& data, Face face) {
    return std::uint64_t{data.source_triangle[face.triangle()]} * 2 + static_cast<std::uint64_t>(face.side());
}

Vec3 reflected(const SolvedScene& s, std::size_t instance, std::size_t face) {
    const Instance& i = s.scene.instances[instance];
    return to_double(s.solution.instances[instance].radiosity[face]) -
           to_double(i.exitance[i.object->patch_of_face[face]]);
}

struct Sums {
    double difference = 0, base = 0;
    double relative() const {
        if (difference == 0) return 0;
        return base > 0 ? std::sqrt(difference / base) : std::numeric_limits<double>::infinity();
    }
};

Sums compare_instance(const SolvedScene& base, const SolvedScene& head, std::size_t i, RadiosityDifference& out) {
    const Instance &instance = base.scene.instances[i], &other = head.scene.instances[i];
    std::unordered_map<std::uint64_t, std::size_t> face_of;
    for (std::size_t f = 0; f < other.data().faces.size(); ++f) face_of[key_of(other.data(), other.data().faces[f])] = f;
    Sums sums;
    std::size_t matched = 0;
    for (std::size_t f = 0; f < instance.data().faces.size(); ++f) {
        const Face face = instance.data().faces[f];
        const auto found = face_of.find(key_of(instance.data(), face));
        if (found == face_of.end()) continue;
        ++matched;
        const double area = length(area_vector(instance.world_corners(face)));
        const Vec3 before = reflected(base, i, f), difference = reflected(head, i, found->second) - before;
        sums.difference += area * length2(difference);
        sums.base += area * length2(before);
        for (int c = 0; c < 3; ++c)
            if (std::abs(difference[c]) > out.largest) {
                out.largest = std::abs(difference[c]);
                out.instance = instance.name;
                out.triangle = instance.data().source_triangle[face.triangle()];
            }
    }
    out.unmatched += instance.data().faces.size() + other.data().faces.size() - 2 * matched;
    return sums;
}

std::uint64_t archive_bytes(const Manifest& manifest) {
    std::set<std::filesystem::path> files;
    for (const InstanceEntry& entry : manifest.instances) files.insert(entry.archive);
    std::uint64_t bytes = 0;
    for (const std::filesystem::path& file : files) {
        std::error_code gone;
        const auto size = std::filesystem::file_size(file, gone);
        if (!gone) bytes += size;
    }
    return bytes;
}

std::vector<Pairing> sizes_of(const SolvedScene& base, const SolvedScene& head, const Manifest& base_manifest,
                              const Manifest& head_manifest) {
    const Solution &b = base.solution, &h = head.solution;
    return {{"links", b.links.total(), h.links.total()},
            {"far links", b.links.far, h.links.far},
            {"near links", b.links.near, h.links.near},
            {"self links", b.links.self, h.links.self},
            {"rays", b.rays, h.rays},
            {"iterations", std::uint64_t(b.iterations), std::uint64_t(h.iterations)},
            {"bytes of links", b.links.bytes, h.links.bytes},
            {"bytes of memory (estimated)", base.memory, head.memory},
            {"bytes of archives", archive_bytes(base_manifest), archive_bytes(head_manifest)}};
}

std::string tables_of(const ObjectMeta& meta) {
    return std::to_string(meta.grid_size) + " x " + std::to_string(meta.grid_size) +
           (meta.grid_map == GridMap::LatLong ? " latlong" : " octahedral");
}

/// Every value that occurs among a scene's archives.
template <class ValueOf>
std::string occurring(const Scene& scene, const ValueOf& value_of) {
    std::set<std::string> values;
    for (const auto& object : scene.objects) values.insert(value_of(object->data().meta));
    std::string text;
    for (const std::string& value : values) text += (text.empty() ? "" : ", ") + value;
    return text;
}

void tell_making(const Scene& base, const Scene& head, Comparison& c) {
    const auto compiler = [](const ObjectMeta& meta) { return meta.tool_version; };
    c.made = {{"tables", occurring(base, tables_of), occurring(head, tables_of)},
              {"compiler", occurring(base, compiler), occurring(head, compiler)}};
    std::set<std::string> in_head;
    for (const auto& object : head.objects) in_head.insert(object->archive.content_sha256());
    c.archives = base.objects.size();
    for (const auto& object : base.objects) c.changed += in_head.contains(object->archive.content_sha256()) ? 0 : 1;
}

constexpr std::array kPhases{"load", "plan", "links", "visibility", "iterate", "total"};

std::array<double, kPhases.size()> seconds_of(const PhaseSeconds& s) {
    return {s.load, s.plan, s.links, s.visibility, s.iterate, s.load + s.total};
}

}  // namespace

Result<Manifest> with_archives_in(Manifest manifest, const std::filesystem::path& folder) {
    for (InstanceEntry& entry : manifest.instances) {
        const std::filesystem::path there = folder / entry.archive.filename();
        std::error_code unreadable;
        if (!std::filesystem::is_regular_file(there, unreadable))
            return bad_input(folder.string(), "no archive " + entry.archive.filename().string() + ", which instance " +
                                                  entry.name + " of " + manifest.path.string() + " needs",
                             "archives are looked up by their file names");
        entry.archive = there;
        entry.content.clear();
    }
    return manifest;
}

PhaseTimes phase_times(std::string phase, const std::vector<double>& base, const std::vector<double>& head) {
    PhaseTimes t{std::move(phase), median(base), median(head), spread(base), spread(head)};
    t.ratio = ratio(t.base, t.head);
    std::vector<double> ratios;
    for (std::size_t k = 0; k < base.size(); ++k) ratios.push_back(ratio(base[k], head[k]));
    std::sort(ratios.begin(), ratios.end());
    const std::size_t cut = ratios.size() / kRunsPerCut;
    t.low = ratios[cut];
    t.high = ratios[ratios.size() - 1 - cut];
    if (ratios.size() > 1 && t.low > 1) t.verdict = TimingVerdict::Slower;
    if (ratios.size() > 1 && t.high < 1) t.verdict = TimingVerdict::Faster;
    return t;
}

RadiosityDifference radiosity_difference(const SolvedScene& base, const SolvedScene& head) {
    RadiosityDifference out;
    std::vector<Sums> each;
    Sums all;
    for (std::size_t i = 0; i < base.scene.instances.size(); ++i) {
        each.push_back(compare_instance(base, head, i, out));
        all.difference += each.back().difference;
        all.base += each.back().base;
    }
    out.relative_rms = all.relative();
    for (std::size_t i = 0; i < each.size(); ++i)
        if (each[i].base >= kMatters * all.base && each[i].relative() > out.worst_relative_rms) {
            out.worst_relative_rms = each[i].relative();
            out.worst_instance = base.scene.instances[i].name;
        }
    return out;
}

Result<Comparison> compare_archives(const Manifest& manifest, const CompareOptions& options, const SolveOnce& solve,
                                    const Progress& progress) {
    const std::array<Result<Manifest>, 2> manifests{with_archives_in(manifest, options.base),
                                                    with_archives_in(manifest, options.head)};
    for (const auto& m : manifests)
        if (!m) return m.error();
    // The first run of each fills the caches of files; its results count, as they are the same every time.
    std::array<std::optional<SolvedScene>, 2> first;
    std::array<std::array<std::vector<double>, 2>, kPhases.size()> seconds;
    for (int run = 0; run <= options.runs; ++run)
        for (std::size_t version = 0; version < 2; ++version) {
            if (progress) progress("compare", (2.0 * run + double(version)) / (2.0 * options.runs + 2));
            auto solved = solve(*manifests[version]);
            if (!solved) return solved.error();
            const auto spent = seconds_of(solved->solution.seconds);
            if (run == 0)
                first[version] = std::move(*solved);
            else
                for (std::size_t p = 0; p < kPhases.size(); ++p) seconds[p][version].push_back(spent[p]);
        }
    Comparison c;
    c.scene = manifest.path.string();
    c.options = options;
    tell_making(first[0]->scene, first[1]->scene, c);
    for (std::size_t p = 0; p < kPhases.size(); ++p)
        c.times.push_back(phase_times(kPhases[p], seconds[p][0], seconds[p][1]));
    c.radiosity = radiosity_difference(*first[0], *first[1]);
    c.sizes = sizes_of(*first[0], *first[1], *manifests[0], *manifests[1]);
    c.base_error = first[0]->solution.estimated_error;
    c.head_error = first[1]->solution.estimated_error;
    const PhaseTimes& total = c.times.back();
    c.too_slow = options.fail_if_slower && total.verdict == TimingVerdict::Slower && total.ratio > *options.fail_if_slower;
    c.too_different = options.fail_if_differs && !(c.radiosity.relative_rms <= *options.fail_if_differs);
    return c;
}

}  // namespace rro
