#include "format/tool/json_document.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <optional>
#include <vector>

namespace rro {
namespace {

using nlohmann::json;

constexpr std::size_t kDeepest = 256;      // so that no recursion over a document can exhaust the stack
constexpr std::size_t kLongestQuote = 60;  // of a string found, in a message

/// Builds a document from the parser's events and refuses what nlohmann::json would let pass: a repeated key silently
/// replaces the value before it.
class StrictBuilder final : public nlohmann::json_sax<json> {
  public:
    StrictBuilder(std::string_view text, std::string name) : text_(text), name_(std::move(name)) {}

    json document;
    std::optional<Error> error;

    bool null() override { return add(nullptr); }
    bool boolean(bool value) override { return add(value); }
    bool number_integer(number_integer_t value) override { return add(value); }
    bool number_unsigned(number_unsigned_t value) override { return add(value); }
    bool number_float(number_float_t value, const string_t&) override { return add(value); }
    bool string(string_t& value) override { return add(std::move(value)); }
    bool binary(binary_t&) override { return false; }  // JSON text has none
    bool start_object(std::size_t) override { return open(json::object()); }
    bool start_array(std::size_t) override { return open(json::array()); }
    bool end_object() override { return close(); }
    bool end_array() override { return close(); }

    bool key(string_t& name) override {
        if (open_.back()->contains(name)) {
            error = bad_input(json_place(name_, pointer()), "the key \"" + name + "\" appears twice");
            return false;
        }
        keys_.back() = name;
        return true;
    }

    bool parse_error(std::size_t position, const std::string&, const nlohmann::detail::exception& fault) override {
        const std::size_t at = std::min(position > 0 ? position - 1 : 0, text_.size());
        const std::string_view before = text_.substr(0, at);
        const auto line = 1 + std::count(before.begin(), before.end(), '\n');
        const std::size_t column = at - (before.rfind('\n') + 1) + 1;  // npos + 1 is 0
        const std::string where = name_ + ": line " + std::to_string(line) + ", column " + std::to_string(column);
        std::string message = fault.what();
        message.erase(0, std::min(message.find("] ") + 2, message.size()));
        if (const auto syntax = message.find("syntax error"); syntax != std::string::npos) message.erase(0, syntax);
        if (at < text_.size() && text_[at] == '/')
            error = bad_input(where, "found a comment; JSON has none", "keep notes under a key \"extras\"");
        else
            error = bad_input(where, "not valid JSON: " + message);
        return false;
    }

  private:
    template <class T>
    json* place(T&& value) {
        if (open_.empty()) return &(document = std::forward<T>(value));
        json& parent = *open_.back();
        if (parent.is_array()) return &parent.emplace_back(std::forward<T>(value));
        return &(parent[keys_.back()] = std::forward<T>(value));
    }

    template <class T>
    bool add(T&& value) {
        place(std::forward<T>(value));
        return true;
    }

    bool open(json empty) {
        if (open_.size() == kDeepest) {
            error = bad_input(name_, "nested deeper than " + std::to_string(kDeepest) + " levels");
            return false;
        }
        open_.push_back(place(std::move(empty)));
        keys_.emplace_back();
        return true;
    }

    bool close() {
        open_.pop_back();
        keys_.pop_back();
        return true;
    }

    /// Of the container being read.
    std::string pointer() const {
        std::string path;
        for (std::size_t i = 0; i + 1 < open_.size(); ++i)
            path += "/" + (open_[i]->is_array() ? std::to_string(open_[i]->size() - 1) : pointer_step(keys_[i]));
        return path;
    }

    std::string_view text_;
    std::string name_;
    std::vector<json*> open_;        // containers being read, outermost first; a parent does not grow meanwhile
    std::vector<std::string> keys_;  // of each, the key being read
};

}  // namespace

Result<json> parse_json(std::string_view text, const std::string& name) {
    StrictBuilder builder(text, name);
    if (!json::sax_parse(text.begin(), text.end(), &builder)) return *builder.error;
    return std::move(builder.document);
}

Result<json> read_json(const std::filesystem::path& path) {
    const std::string name = path.string();
    std::error_code code;
    if (std::filesystem::is_directory(path, code)) return bad_input(name, "is a folder, expected a JSON file");
    errno = 0;
    std::ifstream file(path, std::ios::binary);
    if (!file) return bad_input(name, std::string("cannot be read: ") + std::strerror(errno ? errno : EIO));
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    if (file.bad()) return bad_input(name, std::string("cannot be read: ") + std::strerror(errno ? errno : EIO));
    return parse_json(text, name);
}

std::string pointer_step(std::string_view key) {
    std::string step;
    for (const char c : key) {
        if (c == '~')
            step += "~0";
        else if (c == '/')
            step += "~1";
        else
            step += c;
    }
    return step;
}

std::string json_place(const std::string& name, const std::string& pointer) {
    return pointer.empty() ? name : name + ": " + pointer;
}

std::string described(const json& value) {
    if (value.is_object()) return "an object";
    if (value.is_array()) return "an array of " + std::to_string(value.size());
    if (!value.is_string()) return value.dump();
    std::string text = value.get<std::string>();
    if (text.size() > kLongestQuote) text = text.substr(0, kLongestQuote) + "...";
    // Control characters are escaped; a letter cut in half above is replaced.
    return json(text).dump(-1, ' ', false, json::error_handler_t::replace);
}

}  // namespace rro
