#include "compiler/input_record.h"

#include <fstream>
#include <span>
#include <system_error>

#include "format/atomic_file.h"
#include "format/sha256.h"

namespace rro {
namespace fs = std::filesystem;
namespace {

// The record is text: the first line below, then a line per file besides the mesh: a mark, a blank, the path.
constexpr const char* kFirstLine = "rro-inputs/1";
constexpr char kRead = '+', kAbsent = '-';

std::optional<std::string> content_of(const fs::path& path) {
    std::error_code fault;
    if (!fs::is_regular_file(path, fault)) return {};  // a pipe would be waited for
    std::string content(fs::file_size(path, fault), '\0');
    std::ifstream file(path, std::ios::binary);
    if (fault || !file.read(content.data(), static_cast<std::streamsize>(content.size()))) return {};
    return content;
}

/// "+ textures/wood.png"; empty for a path that a line cannot hold.
std::string line_of(char mark, const fs::path& path, const fs::path& folder) {
    const fs::path relative = path.lexically_relative(folder);
    const std::string text = (relative.empty() ? path : relative).string();
    return text.find('\n') == std::string::npos ? std::string{mark, ' '} + text + "\n" : "";
}

}  // namespace

fs::path input_record_path(const fs::path& archive) {
    return archive.parent_path() / ("." + archive.filename().string() + ".inputs");
}

void write_input_record(const fs::path& archive, const InputFiles& inputs) {
    std::error_code ignored;
    if (!fs::is_regular_file(archive, ignored)) return;  // a device has no place beside it
    const fs::path folder = inputs.read.front().parent_path();
    std::string text = std::string(kFirstLine) + "\n";
    for (const auto& [mark, files] :
         {std::pair(kRead, std::span(inputs.read).subspan(1)), std::pair(kAbsent, std::span(inputs.absent))})
        for (const fs::path& file : files) {
            const std::string line = line_of(mark, file, folder);
            if (line.empty()) return;
            text += line;
        }
    const fs::path record = input_record_path(archive);
    if (content_of(record) == text) return;
    [[maybe_unused]] const Status may_fail = write_file_atomically(record, text);
}

std::optional<RecordedInputs> read_recorded_inputs(const fs::path& archive, const fs::path& mesh) {
    std::ifstream record(input_record_path(archive), std::ios::binary);
    std::string line;
    if (!std::getline(record, line) || line != kFirstLine) return {};
    RecordedInputs inputs{{mesh}, {}};
    while (std::getline(record, line)) {
        if (line.size() < 3 || line[1] != ' ') return {};
        const fs::path file = mesh.parent_path() / line.substr(2);
        std::error_code ignored;
        if (line[0] == kRead)
            inputs.read.push_back(file);
        else if (fs::is_regular_file(file, ignored))
            return {};
    }
    std::string bytes;
    for (const fs::path& file : inputs.read) {
        const auto content = content_of(file);
        if (!content) return {};
        bytes += *content;
    }
    inputs.sha256 = sha256_hex(std::as_bytes(std::span(bytes)));
    return inputs;
}

}  // namespace rro
