// Lines, words and numbers of text formats, read strictly: a word that is not wholly a number is none.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace rro {

/// A decimal number with a point, an optional sign and exponent; "nan" and "inf" are numbers too. Locale-free,
/// correctly rounded. None for anything else ("1,5", "1.5x", "", beyond double's range).
std::optional<double> parse_real(std::string_view word);

/// A whole decimal number; none for anything else.
std::optional<std::int64_t> parse_integer(std::string_view word);

/// Without blanks and tabs at its ends.
std::string_view trimmed(std::string_view text);

/// The text behind its UTF-8 byte order mark, if it has one.
std::string_view without_mark(std::string_view text);

/// The number of the first line, from 1, that is longer than any has a reason to be (16 MiB: its words would take eight
/// times as much); none where there is no such line.
std::optional<std::size_t> find_long_line(std::string_view text);

/// The words of a line, between blanks and tabs.
void split_words(std::string_view line, std::vector<std::string_view>& words);

/// A word of the file in quotes for a message: shortened, unprintable bytes as '?'.
std::string in_quotes(std::string_view word);

/// "mesh.obj:12".
std::string at_line(const std::filesystem::path& path, std::size_t line);

/// "mesh.stl: byte 84".
std::string at_byte(const std::filesystem::path& path, std::size_t byte);

/// Lines one after the other; ends are LF, CRLF or CR.
class LineReader {
  public:
    explicit LineReader(std::string_view text) : text_(text) {}

    /// False at the end of the text.
    bool next(std::string_view& line);
    std::size_t line_number() const { return line_number_; }  // of the line given last, from 1
    std::size_t offset() const { return offset_; }            // of the line to come

  private:
    std::string_view text_;
    std::size_t offset_ = 0, line_number_ = 0;
};

}  // namespace rro
