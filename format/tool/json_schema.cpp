// JsonSchema: valijson is the judge; what is said about a refusal is found by walking schema and document together.
#include <algorithm>
#include <optional>
#include <regex>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validation_results.hpp>
#include <valijson/validator.hpp>
#include <vector>

#include "format/tool/json_document.h"
#include "format/tool/names.h"

namespace rro {
namespace {

using nlohmann::json;

/// A refusal: place as a JSON pointer, what is said there, and how many levels of the document had fitted.
struct Fault {
    std::string pointer, message, hint;
    std::size_t depth = 0;
};

/// Finds the first fault, depth first. Understands the keywords that our schemas use; where it finds nothing,
/// valijson's own words stand.
class Explainer {
  public:
    explicit Explainer(const json& schema) : root_(schema) {}

    std::optional<Fault> explain(const json& schema_or_reference, const json& value, const std::string& pointer) const {
        const json& schema = resolved(schema_or_reference);
        if (schema.contains("oneOf")) return explain_alternatives(schema, value, pointer);
        if (!type_fits(schema, value)) return expected(schema, value, pointer);
        if (value.is_number() && !in_range(schema, value.get<double>())) return expected(schema, value, pointer);
        if (value.is_string() && !text_fits(schema, value)) return expected(schema, value, pointer);
        if (value.is_array()) return explain_array(schema, value, pointer);
        if (value.is_object()) return explain_object(schema, value, pointer);
        return {};
    }

  private:
    const json& resolved(const json& schema) const {
        if (!schema.contains("$ref")) return schema;
        return root_.at(json::json_pointer(schema["$ref"].get<std::string>().substr(1)));  // all are local, "#/..."
    }

    static Fault expected(const json& schema, const json& value, const std::string& pointer) {
        return {pointer, "found " + described(value) + ", expected " + schema.value("description", "something else"),
                "", depth_of(pointer)};
    }

    static bool type_fits(const json& schema, const json& value) {
        const std::string type = schema.value("type", "");
        return type.empty() || (type == "object" && value.is_object()) || (type == "array" && value.is_array()) ||
               (type == "string" && value.is_string()) || (type == "number" && value.is_number()) ||
               (type == "integer" && value.is_number_integer()) || (type == "boolean" && value.is_boolean());
    }

    static bool in_range(const json& schema, double value) {
        return !(schema.contains("minimum") && value < schema["minimum"].get<double>()) &&
               !(schema.contains("maximum") && value > schema["maximum"].get<double>()) &&
               !(schema.contains("exclusiveMinimum") && value <= schema["exclusiveMinimum"].get<double>()) &&
               !(schema.contains("exclusiveMaximum") && value >= schema["exclusiveMaximum"].get<double>());
    }

    static bool text_fits(const json& schema, const json& value) {
        const auto matches = [&](const json& s) {
            return std::regex_search(value.get_ref<const std::string&>(), std::regex(s["pattern"].get<std::string>()));
        };
        if (schema.contains("const") && value != schema["const"]) return false;
        if (schema.contains("enum") &&
            std::find(schema["enum"].begin(), schema["enum"].end(), value) == schema["enum"].end())
            return false;
        if (value.get_ref<const std::string&>().size() < schema.value("minLength", std::size_t{0})) return false;
        if (schema.contains("pattern") && !matches(schema)) return false;
        return !(schema.contains("not") && matches(schema["not"]));
    }

    std::optional<Fault> explain_array(const json& schema, const json& value, const std::string& pointer) const {
        if (value.size() < schema.value("minItems", std::size_t{0}) ||
            value.size() > schema.value("maxItems", value.size()))
            return expected(schema, value, pointer);
        if (!schema.contains("items")) return {};
        for (std::size_t i = 0; i < value.size(); ++i)
            if (auto fault = explain(schema["items"], value[i], pointer + "/" + std::to_string(i))) return fault;
        return {};
    }

    std::optional<Fault> explain_object(const json& schema, const json& value, const std::string& pointer) const {
        const json properties = schema.value("properties", json::object());
        std::vector<std::string> allowed;
        for (const auto& [key, unused] : properties.items()) allowed.push_back(key);
        const json rest = schema.value("additionalProperties", json::object());
        for (const auto& [key, member] : value.items()) {
            const std::string place = pointer + "/" + pointer_step(key);
            if (properties.contains(key)) {
                if (auto fault = explain(properties[key], member, place)) return fault;
            } else if (rest.is_boolean()) {
                return Fault{place, "unknown key " + described(key) + ", expected one of: " + listed(allowed),
                             nearest_hint(key, allowed), depth_of(pointer)};
            } else if (auto fault = explain(rest, member, place)) {
                return fault;
            }
        }
        for (const json& key : schema.value("required", json::array()))
            if (!value.contains(key.get<std::string>()))
                return Fault{pointer,
                             "the key " + key.dump() + " is missing, expected " +
                                 resolved(properties[key.get<std::string>()]).value("description", "a value"),
                             "", depth_of(pointer)};
        return {};
    }

    /// Speaks of the alternative that the value was probably meant to be: of its type, and right furthest into the
    /// document (ties: the later); where none has the type, of the choice as a whole.
    std::optional<Fault> explain_alternatives(const json& schema, const json& value, const std::string& pointer) const {
        std::optional<Fault> deepest;
        for (const json& reference : schema["oneOf"]) {
            const json& alternative = resolved(reference);
            if (!type_fits(alternative, value)) continue;
            auto fault = explain(alternative, value, pointer);
            if (!fault) return {};
            if (!deepest || fault->depth >= deepest->depth) deepest = std::move(fault);
        }
        if (!deepest) return expected(schema, value, pointer);
        if (deepest->hint.empty() && deepest->depth == depth_of(pointer))
            deepest->hint = "expected here: " + schema.value("description", "");
        return deepest;
    }

    static std::size_t depth_of(const std::string& pointer) {
        return static_cast<std::size_t>(std::count(pointer.begin(), pointer.end(), '/'));
    }

    const json& root_;
};

/// valijson's first complaint, for keywords that Explainer does not know.
Fault raw_fault(valijson::Validator& validator, const valijson::Schema& schema, const json& document) {
    valijson::ValidationResults results;
    validator.validate(schema, valijson::adapters::NlohmannJsonAdapter(document), &results);
    Fault fault{"", "does not fit the schema", "", 0};
    if (valijson::ValidationResults::Error error; results.popError(error)) {
        fault.message = error.description;
        for (std::size_t i = 1; i < error.context.size(); ++i) fault.message += " in " + error.context[i];
    }
    return fault;
}

}  // namespace

struct JsonSchema::Parts {
    json document;
    valijson::Schema schema;

    explicit Parts(std::string_view text) : document(json::parse(text)) {
        valijson::SchemaParser().populateSchema(valijson::adapters::NlohmannJsonAdapter(document), schema);
    }
};

JsonSchema::JsonSchema(std::string_view text) : parts_(std::make_unique<const Parts>(text)) {}
JsonSchema::~JsonSchema() = default;

Status JsonSchema::check(const json& document, const std::string& name) const {
    valijson::Validator validator;
    if (validator.validate(parts_->schema, valijson::adapters::NlohmannJsonAdapter(document), nullptr)) return Done{};
    auto fault = Explainer(parts_->document).explain(parts_->document, document, "");
    if (!fault) fault = raw_fault(validator, parts_->schema, document);
    return bad_input(json_place(name, fault->pointer), fault->message, fault->hint);
}

Status check_schema(const json& document, std::string_view schema, const std::string& name) {
    return JsonSchema(schema).check(document, name);
}

}  // namespace rro
