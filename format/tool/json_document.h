// Strict JSON and its check against a schema, with messages for people.
#pragma once

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "format/result.h"

namespace rro {

/// Reads a JSON file: no comments, no repeated keys, no numbers beyond double, nesting of at most 256.
///
/// errors   BadInput: cannot be read; not JSON (line and column); a repeated key (its place as a JSON pointer)
Result<nlohmann::json> read_json(const std::filesystem::path& path);

/// The same from text at hand; `name` stands in error messages.
Result<nlohmann::json> parse_json(std::string_view text, const std::string& name);

/// One step of a JSON pointer, escaped [RFC 6901].
std::string pointer_step(std::string_view key);

/// "room.json: /instances/3", or "room.json" for the whole document.
std::string json_place(const std::string& name, const std::string& pointer);

/// Found values in messages: a scalar as it is, "an array of 3", "an object".
std::string described(const nlohmann::json& value);

/// A JSON schema (draft 7), read once to check any number of documents; safe to share between threads. The schema is the
/// only source of what is allowed: a message says what was found, and gives the schema's "description" of the place as
/// what was expected.
class JsonSchema {
  public:
    explicit JsonSchema(std::string_view text);
    ~JsonSchema();

    /// errors   BadInput with the place as a JSON pointer: the first fault, a wrong or missing key, type, range, length
    Status check(const nlohmann::json& document, const std::string& name) const;

  private:
    struct Parts;
    std::unique_ptr<const Parts> parts_;
};

/// The same for a schema that is used once.
Status check_schema(const nlohmann::json& document, std::string_view schema, const std::string& name);

}  // namespace rro
