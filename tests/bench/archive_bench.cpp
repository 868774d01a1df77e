// What opening an archive costs, against reading its bytes.
//
//   archive_bench FILE.rro... [--runs N]     medians, files cached, all cores
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include "format/archive_reader.h"
#include "format/clock.h"
#include "format/verifier.h"

using namespace rro;

namespace {

using Bytes = std::vector<std::byte>;

Bytes read_file(const std::string& path) {
    std::ifstream in(path, std::ios::binary | std::ios::ate);
    Bytes bytes(static_cast<std::size_t>(in.tellg()));
    in.seekg(0);
    in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    return bytes;
}

template <class Opened>
bool good(const Opened& opened) {
    if (!opened) std::fprintf(stderr, "%s: %s\n", opened.error().where.c_str(), opened.error().message.c_str());
    return static_cast<bool>(opened);
}

/// A file, opened once, and the payloads of its sections.
struct Subject {
    std::string path;
    Archive archive;
    Bytes bytes;
    std::vector<Bytes> payloads;  // by Section; empty where there is none
    std::uint64_t payload_bytes = 0;
};

bool verify_payloads(const Subject& s) {
    for (std::uint32_t i = 0; i < kSectionKinds; ++i)
        if (!s.payloads[i].empty() && !good(verify_table(s.payloads[i], layout::kSections[i].table, s.path))) return false;
    return good(verify_content(s.archive.data(), SectionSet::all(), s.path));
}

bool unpack(const Subject& s) {
    for (const SectionInfo& section : s.archive.sections())
        if (section.codec != "raw" && !s.archive.section(section.name)) return false;
    return true;
}

struct Step {
    const char* name;
    bool of_payloads;  // the rate is of the unpacked bytes, not of the file's
    bool (*run)(const Subject& subject);
};

const Step kSteps[] = {
    {"read the file", false, [](const Subject& s) { return !read_file(s.path).empty(); }},
    {"verify the container (checksums)", false, [](const Subject& s) { return good(verify_container(s.bytes, s.path)); }},
    {"verify the sections, unpacked", true, verify_payloads},
    {"unpack the packed ones, one thread", true, unpack},
    {"open: mesh and materials", false,
     [](const Subject& s) { return good(Archive::open(s.path, Section::Mesh | Section::Materials)); }},
    {"open: what a solve needs", false, [](const Subject& s) { return good(Archive::open(s.path, kGeometry | kTables)); }},
    {"open: everything", false, [](const Subject& s) { return good(Archive::open(s.path)); }},
};

Result<Subject> open_subject(const std::string& path) {
    auto archive = Archive::open(path);
    if (!archive) return archive.error();
    Subject subject{path, *std::move(archive), read_file(path), std::vector<Bytes>(kSectionKinds), 0};
    for (std::uint32_t i = 0; i < kSectionKinds; ++i)
        if (auto payload = subject.archive.section(std::string(layout::kSections[i].name))) {
            subject.payload_bytes += payload->size();
            subject.payloads[i] = *std::move(payload);
        }
    return subject;
}

}  // namespace

int main(int argc, char** argv) {
    std::vector<std::string> files(argv + 1, argv + argc);
    std::size_t runs = 21;
    if (files.size() > 2 && files[files.size() - 2] == "--runs") {
        runs = static_cast<std::size_t>(std::max(1, std::atoi(files.back().c_str())));
        files.resize(files.size() - 2);
    }
    if (files.empty()) {
        std::fprintf(stderr, "usage: archive_bench FILE.rro... [--runs N]\n");
        return 2;
    }
    for (const std::string& path : files) {
        const auto subject = open_subject(path);
        if (!good(subject)) return 3;
        const double file_bytes = static_cast<double>(subject->bytes.size());
        const double payload_bytes = static_cast<double>(subject->payload_bytes);
        std::printf("%s: %zu triangles, %.2f MB, %.2f MB unpacked\n", path.c_str(),
                    subject->archive.data().triangles.size(), 1e-6 * file_bytes, 1e-6 * payload_bytes);
        // Interleaved, so that drift of the machine meets all steps alike.
        std::vector<std::vector<double>> milliseconds(std::size(kSteps));
        for (std::size_t run = 0; run < runs; ++run)
            for (std::size_t s = 0; s < std::size(kSteps); ++s) {
                const auto start = Clock::now();
                if (!kSteps[s].run(*subject)) return 3;
                milliseconds[s].push_back(milliseconds_since(start));
            }
        for (std::size_t s = 0; s < std::size(kSteps); ++s) {
            std::vector<double>& times = milliseconds[s];
            std::nth_element(times.begin(), times.begin() + static_cast<std::ptrdiff_t>(runs / 2), times.end());
            const double median = times[runs / 2];
            std::printf("  %-36s %7.2f ms   %5.2f GB/s\n", kSteps[s].name, median,
                        1e-6 * (kSteps[s].of_payloads ? payload_bytes : file_bytes) / median);
        }
    }
    return 0;
}
