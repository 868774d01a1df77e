#include "solver/edit/json_text.h"

#include <algorithm>
#include <cassert>
#include <charconv>
#include <nlohmann/json.hpp>

namespace rro {
namespace {

constexpr std::string_view kSpace = " \t\r\n";

/// Reads valid JSON and notes where things are. Its depth is bounded by parse_json, which has read the text before.
class Scanner {
  public:
    explicit Scanner(std::string_view text) : text_(text) {
        if (text_.starts_with("\xef\xbb\xbf")) at_ = 3;  // a byte order mark
    }

    JsonSpan value() {
        skip_space();
        assert(at_ < text_.size());
        JsonSpan span;
        span.begin = at_;
        if (text_[at_] == '{') members(span);
        else if (text_[at_] == '[') items(span);
        else if (text_[at_] == '"') skip_string();
        else at_ = std::min(text_.find_first_of(" \t\r\n,]}", at_), text_.size());
        span.end = at_;
        return span;
    }

  private:
    void skip_space() { at_ = std::min(text_.find_first_not_of(kSpace, at_), text_.size()); }

    void skip_string() {
        for (++at_; text_[at_] != '"'; ++at_)
            if (text_[at_] == '\\') ++at_;
        ++at_;
    }

    /// Whether another one follows; passes the comma or the closing bracket.
    bool more(char closing) {
        skip_space();
        if (text_[at_] != ',' && text_[at_] != closing) return true;
        return text_[at_++] == ',';
    }

    void members(JsonSpan& span) {
        ++at_;
        while (more('}')) {
            skip_space();
            const std::size_t begin = at_;
            skip_string();
            span.keys.push_back(nlohmann::json::parse(text_.substr(begin, at_ - begin)).get<std::string>());
            skip_space();
            ++at_;  // the colon
            span.values.push_back(value());
        }
    }

    void items(JsonSpan& span) {
        ++at_;
        while (more(']')) span.values.push_back(value());
    }

    std::string_view text_;
    std::size_t at_ = 0;
};

/// A value appended after the last of an object or array: what stood between the last two, or before the only one.
std::string appended(std::string_view text, const JsonSpan& span, std::string_view value) {
    std::string out(text);
    if (span.values.empty()) return out.insert(span.begin + 1, value);
    const std::string line = line_start(text, span);
    const std::string before = line.empty() ? " " : line;
    return out.insert(span.values.back().end, "," + before + std::string(value));
}

void write_spaced(const nlohmann::ordered_json& value, std::string& out) {
    const auto list = [&](char open, char close, const auto& write_one) {
        out += open;
        bool first = true;
        for (const auto& [key, member] : value.items()) {
            if (!std::exchange(first, false)) out += ", ";
            write_one(key, member);
        }
        out += close;
    };
    if (value.is_object())
        list('{', '}', [&](const std::string& key, const auto& member) {
            out += json_string(key) + ": ";
            write_spaced(member, out);
        });
    else if (value.is_array())
        list('[', ']', [&](const std::string&, const auto& member) { write_spaced(member, out); });
    else
        out += value.is_number_float() ? json_number(value.template get<double>()) : value.dump();
}

}  // namespace

const JsonSpan* JsonSpan::find(std::string_view key) const {
    const auto at = std::find(keys.begin(), keys.end(), key);
    return at == keys.end() ? nullptr : &values[static_cast<std::size_t>(at - keys.begin())];
}

JsonSpan json_spans(std::string_view text) {
    return Scanner(text).value();
}

std::string line_start(std::string_view text, const JsonSpan& span) {
    const auto first = text.find_first_not_of(kSpace, span.begin + 1);
    std::string_view space = text.substr(span.begin + 1, first - span.begin - 1);
    const auto line = space.rfind('\n');
    if (line == std::string_view::npos) return {};
    return std::string(space.substr(line > 0 && space[line - 1] == '\r' ? line - 1 : line));
}

std::string replaced(std::string_view text, const JsonSpan& span, std::string_view value) {
    return std::string(text).replace(span.begin, span.end - span.begin, value);
}

std::string with_member(std::string_view text, const JsonSpan& object, std::string_view key, std::string_view value) {
    if (const JsonSpan* member = object.find(key)) return replaced(text, *member, value);
    return appended(text, object, json_string(key) + ": " + std::string(value));
}

std::string with_value(std::string_view text, const JsonSpan& array, std::string_view value) {
    return appended(text, array, value);
}

std::string without_value(std::string_view text, const JsonSpan& array, std::size_t index) {
    const auto& values = array.values;
    const std::size_t begin = index > 0 ? values[index - 1].end : values[index].begin;
    const std::size_t end = index == 0 && values.size() > 1 ? values[1].begin : values[index].end;
    return std::string(text).erase(begin, end - begin);
}

std::string json_string(std::string_view text) {
    return nlohmann::json(text).dump();
}

bool is_utf8(std::string_view text) {
    return nlohmann::json::accept("\"" + [&] {
        std::string plain;  // only what could be wrong: letters beyond ASCII
        std::copy_if(text.begin(), text.end(), std::back_inserter(plain), [](char c) { return c < 0; });
        return plain;
    }() + "\"");
}

std::string json_number(double value) {
    char text[32];
    return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

std::string json_numbers(const std::vector<double>& values) {
    std::string text = "[";
    for (const double value : values) text += (text.size() > 1 ? ", " : "") + json_number(value);
    return text + "]";
}

std::string respaced(std::string_view json) {
    std::string out;
    write_spaced(nlohmann::ordered_json::parse(json), out);
    return out;
}

}  // namespace rro
