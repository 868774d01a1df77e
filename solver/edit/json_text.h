// JSON as text, with the place of every value: for edits that keep every byte outside what they change.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace rro {

/// Where a value stands in a text: [begin, end), and what is in it.
struct JsonSpan {
    std::size_t begin = 0, end = 0;
    std::vector<std::string> keys;    // of an object, unescaped, in the order of the text
    std::vector<JsonSpan> values;     // of an object or array

    /// The member of an object, or none.
    const JsonSpan* find(std::string_view key) const;
    std::string_view of(std::string_view text) const { return text.substr(begin, end - begin); }
};

/// text   must be valid JSON, as parse_json takes it (asserted in part)
JsonSpan json_spans(std::string_view text);

/// How the text lays out its lines: a line break with the white space before the first thing in a span; empty where that
/// stands on the span's own line.
std::string line_start(std::string_view text, const JsonSpan& span);

/// Each gives the text with one change. `span` is of that text; afterwards spans are out of date.
std::string replaced(std::string_view text, const JsonSpan& span, std::string_view value);
/// Sets a member: its value is replaced, or it becomes the last one, laid out like the one before.
std::string with_member(std::string_view text, const JsonSpan& object, std::string_view key, std::string_view value);
/// Appends to an array, laid out like the value before.
std::string with_value(std::string_view text, const JsonSpan& array, std::string_view value);
/// Takes one value out of an array, with one comma and the white space at that comma.
std::string without_value(std::string_view text, const JsonSpan& array, std::size_t index);

/// A string as JSON; the text must be UTF-8 (is_utf8).
std::string json_string(std::string_view text);
/// Is the text UTF-8?
bool is_utf8(std::string_view text);

/// A finite number as JSON: the shortest text that gives it back.
std::string json_number(double value);
/// Several as an array.
std::string json_numbers(const std::vector<double>& values);

/// JSON text with one space after each comma and colon, shortest numbers, members as they stand.
std::string respaced(std::string_view json);

}  // namespace rro
