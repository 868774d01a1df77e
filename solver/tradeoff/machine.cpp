#include "solver/tradeoff/machine.h"

#include <sys/utsname.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <span>
#include <thread>

#include "format/parallel.h"
#include "format/sha256.h"
#include "format/version.h"

namespace rro {
namespace {

std::string processor_name() {
    std::ifstream file("/proc/cpuinfo");
    std::string line;
    while (std::getline(file, line))
        if (line.starts_with("model name"))
            if (const auto colon = line.find(": "); colon != std::string::npos) return line.substr(colon + 2);
    return "unknown processor";
}

#ifdef NDEBUG
constexpr const char* kAssertions = ", assertions off";
#else
constexpr const char* kAssertions = ", assertions on";
#endif

}  // namespace

MachineFacts machine_facts() {
    MachineFacts m;
    m.processor = processor_name();
    m.cores = std::thread::hardware_concurrency();
    m.threads = thread_count();
    m.memory = static_cast<std::uint64_t>(::sysconf(_SC_PHYS_PAGES)) * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
    utsname names{};
    if (::uname(&names) == 0) m.system = std::string(names.sysname) + " " + names.release;
    if (::getloadavg(&m.load, 1) != 1) m.load = 0;
    m.program = "rro-solve " + std::string(kToolVersion);
    m.compiler = std::string("g++ ") + __VERSION__ + kAssertions;
    return m;
}

std::string program_digest() {
    std::ifstream file("/proc/self/exe", std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), {}};
    return bytes.empty() ? "" : sha256_hex(std::as_bytes(std::span(bytes)));
}

}  // namespace rro
