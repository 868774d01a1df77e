#include "compiler/mesh_text.h"

#include <algorithm>
#include <charconv>

namespace rro {
namespace {

template <class Number>
std::optional<Number> parse_whole(std::string_view word) {
    // from_chars takes no plus sign, and must not find a second sign behind ours.
    if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
    Number value{};
    const char* end = word.data() + word.size();
    const auto [stop, fault] = std::from_chars(word.data(), end, value);
    if (fault != std::errc{} || stop != end) return std::nullopt;
    return value;
}

constexpr bool is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\v' || c == '\f';
}

}  // namespace

std::optional<double> parse_real(std::string_view word) {
    return parse_whole<double>(word);
}

std::optional<std::int64_t> parse_integer(std::string_view word) {
    return parse_whole<std::int64_t>(word);
}

std::string_view trimmed(std::string_view text) {
    while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
    while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
    return text;
}

std::string_view without_mark(std::string_view text) {
    constexpr std::string_view kMark = "\xef\xbb\xbf";
    if (text.starts_with(kMark)) text.remove_prefix(kMark.size());
    return text;
}

std::optional<std::size_t> find_long_line(std::string_view text) {
    constexpr std::size_t kLongest = std::size_t{1} << 24;
    LineReader lines(text);
    std::string_view line;
    while (lines.next(line))
        if (line.size() > kLongest) return lines.line_number();
    return std::nullopt;
}

void split_words(std::string_view line, std::vector<std::string_view>& words) {
    words.clear();
    for (std::size_t i = 0; i < line.size();) {
        if (is_blank(line[i])) {
            ++i;
            continue;
        }
        std::size_t end = i;
        while (end < line.size() && !is_blank(line[end])) ++end;
        words.push_back(line.substr(i, end - i));
        i = end;
    }
}

std::string in_quotes(std::string_view word) {
    constexpr std::size_t kLongest = 40;  // enough to find the word again
    std::string text = "'";
    for (char c : word.substr(0, kLongest)) {
        const auto byte = static_cast<unsigned char>(c);
        text += byte < 0x20 || byte == 0x7f ? '?' : c;
    }
    return text + (word.size() > kLongest ? "...'" : "'");
}

std::string at_line(const std::filesystem::path& path, std::size_t line) {
    return path.string() + ":" + std::to_string(line);
}

std::string at_byte(const std::filesystem::path& path, std::size_t byte) {
    return path.string() + ": byte " + std::to_string(byte);
}

bool LineReader::next(std::string_view& line) {
    if (offset_ >= text_.size()) return false;
    std::size_t end = offset_;  // by hand: find_first_of looks each character up by a call
    while (end < text_.size() && text_[end] != '\n' && text_[end] != '\r') ++end;
    line = text_.substr(offset_, end - offset_);
    const bool two_bytes = end + 1 < text_.size() && text_[end] == '\r' && text_[end + 1] == '\n';
    offset_ = std::min(end + (two_bytes ? 2 : 1), text_.size());
    ++line_number_;
    return true;
}

}  // namespace rro
