#include "solver/arguments.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <set>
#include <string>
#include <system_error>

namespace rro {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kDefaultMemory = std::uint64_t{8} << 30;
constexpr int kLargestPicture = 16384;  // pixels along a side: 4 GB of radiances, what the default memory can hold

Error usage(std::string message) {
    return {ErrorKind::Usage, "", std::move(message), ""};
}

/// Reads a whole text as a number, or nothing of it.
template <class T>
bool read_all(std::string_view text, T& value) {
    const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
    return code == std::errc{} && end == text.data() + text.size();
}

Status check_output(const fs::path& path) {
    std::error_code code;
    const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
    const auto refuse = [&](const std::string& reason) {
        return failed(path.string(), "cannot be written: " + reason);
    };
    if (fs::is_directory(path, code)) return refuse("it is a folder");
    if (!fs::is_directory(folder, code)) return refuse("there is no folder " + folder.string());
    const fs::file_status status = fs::status(path, code);
    const bool device = fs::exists(status) && !fs::is_regular_file(status);  // written in place, not replaced
    if (::access(device ? path.c_str() : folder.c_str(), W_OK) != 0)
        return refuse("no permission in folder " + folder.string());
    return Done{};
}

}  // namespace

Result<std::uint64_t> parse_bytes(std::string_view text) {
    const Error refused =
        usage("--memory " + std::string(text) + ": expected a size such as 8G, 512M or a number of bytes");
    constexpr std::string_view kUnits = "KMGT";
    std::string_view digits = text;
    int shift = 0;
    if (!digits.empty())
        if (const auto unit = kUnits.find(digits.back()); unit != std::string_view::npos) {
            shift = 10 * (static_cast<int>(unit) + 1);
            digits.remove_suffix(1);
        }
    std::uint64_t value = 0;
    if (!read_all(digits, value) || value == 0 || value > (~std::uint64_t{0} >> shift)) return refused;
    return value << shift;
}

Result<std::array<int, 2>> parse_size(std::string_view text) {
    const auto times = text.find('x');
    std::array<int, 2> size{};
    const auto good = [](int n) { return n >= 1 && n <= kLargestPicture; };
    if (times == std::string_view::npos || !read_all(text.substr(0, times), size[0]) ||
        !read_all(text.substr(times + 1), size[1]) || !good(size[0]) || !good(size[1]))
        return usage("--size " + std::string(text) + ": expected WIDTHxHEIGHT, each 1 to 16384, such as 960x540");
    return size;
}

std::uint64_t default_memory() {
    rlimit limit{};
    if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return kDefaultMemory;
    return std::min<std::uint64_t>(kDefaultMemory, limit.rlim_cur);
}

Status check_outputs(std::span<const fs::path> outputs, const fs::path& input) {
    std::error_code code;
    std::set<fs::path> seen{fs::weakly_canonical(input, code)};
    for (const fs::path& path : outputs) {
        if (path.empty()) continue;
        if (auto writable = check_output(path); !writable) return writable.error();
        const bool device = fs::exists(path, code) && !fs::is_regular_file(path, code);
        if (!device && !seen.insert(fs::weakly_canonical(path, code)).second)
            return usage(path.string() + " would be written over: it is the manifest or another output");
    }
    return Done{};
}

}  // namespace rro
