// What opening an archive costs, against reading its bytes.
//
//   archive_bench FILE.rro... [--runs N]     medians, files cached, all cores
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include "format/archive_reader.h"
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

struct Step {
    const char* name;
    bool (*run)(const std::string& path, const Bytes& bytes);
};

template <class Opened>
bool good(const Opened& opened) {
    if (!opened) std::fprintf(stderr, "%s: %s\n", opened.error().where.c_str(), opened.error().message.c_str());
    return static_cast<bool>(opened);
}

const Step kSteps[] = {
    {"read the bytes", [](const std::string& path, const Bytes&) { return !read_file(path).empty(); }},
    {"verify the container (checksums)",
     [](const std::string& path, const Bytes& bytes) { return good(verify_container(bytes, path)); }},
    {"open: mesh and materials",
     [](const std::string& path, const Bytes&) {
         return good(Archive::open(path, Section::Mesh | Section::Materials));
     }},
    {"open: what a solve needs",
     [](const std::string& path, const Bytes&) { return good(Archive::open(path, kGeometry | kTables)); }},
    {"open: everything", [](const std::string& path, const Bytes&) { return good(Archive::open(path)); }},
};

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
        const auto archive = Archive::open(path);
        if (!good(archive)) return 3;
        const Bytes bytes = read_file(path);
        std::uint64_t raw = 0;
        for (const SectionInfo& section : archive->sections()) raw += section.raw_bytes;
        std::printf("%s: %zu triangles, %.2f MB, %.2f MB unpacked\n", path.c_str(), archive->data().triangles.size(),
                    1e-6 * static_cast<double>(bytes.size()), 1e-6 * static_cast<double>(raw));
        // Interleaved, so that drift of the machine meets all steps alike.
        std::vector<std::vector<double>> milliseconds(std::size(kSteps));
        for (std::size_t run = 0; run < runs; ++run)
            for (std::size_t s = 0; s < std::size(kSteps); ++s) {
                const auto start = std::chrono::steady_clock::now();
                if (!kSteps[s].run(path, bytes)) return 3;
                const std::chrono::duration<double, std::milli> taken = std::chrono::steady_clock::now() - start;
                milliseconds[s].push_back(taken.count());
            }
        for (std::size_t s = 0; s < std::size(kSteps); ++s) {
            std::vector<double>& times = milliseconds[s];
            std::nth_element(times.begin(), times.begin() + static_cast<std::ptrdiff_t>(runs / 2), times.end());
            const double median = times[runs / 2];
            std::printf("  %-34s %7.2f ms   %5.2f GB/s of the file\n", kSteps[s].name, median,
                        1e-6 * static_cast<double>(bytes.size()) / median);
        }
    }
    return 0;
}
