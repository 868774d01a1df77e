#include "tests/fuzz/json_mutator.h"

#include <array>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>
#include <vector>

namespace rro::fuzz {
namespace {

using nlohmann::json;

constexpr int kDeepest = 64;             // deeper values are dropped: nobody here may exhaust the stack
constexpr std::size_t kLongestText = 64;  // that a text grows to

class JsonMutator {
  public:
    JsonMutator(json& document, unsigned seed, Mutate mutate) : engine_(seed), mutate_(mutate) {
        collect(document);
    }

    void run() {
        json& value = any();
        switch (below(4)) {
            case 0:
                value = json(any());  // a copy: either may be part of the other
                break;
            case 1:
                take_one(value);
                break;
            case 2:
                add_one(value);
                break;
            default:
                change(value);
        }
    }

  private:
    std::size_t below(std::size_t count) { return engine_() % count; }
    json& any() { return *values_[below(values_.size())]; }

    void collect(json& value) {
        values_.push_back(&value);
        if (value.is_structured())
            for (json& part : value) collect(part);
    }

    void take_one(json& value) {
        if (!value.is_structured() || value.empty()) return change(value);
        auto at = value.begin();
        std::advance(at, below(value.size()));
        value.erase(at);
    }

    /// An element of an array a second time, or a member with the key of another one somewhere.
    void add_one(json& value) {
        if (value.is_array() && !value.empty()) {
            value.push_back(json(value[below(value.size())]));
            return;
        }
        const json& other = any();
        if (!value.is_object() || !other.is_object() || other.empty()) return change(value);
        auto member = other.begin();
        std::advance(member, below(other.size()));
        const std::string key = member.key();
        value[key] = json(any());
    }

    void change(json& value) {
        if (value.is_number() && below(2) == 0) {
            value = near(value);
        } else if (value.is_number()) {
            value = number();
        } else if (value.is_string()) {
            std::string text = value.get<std::string>();
            const std::size_t size = text.size();
            text.resize(std::max(size, kLongestText));
            text.resize(mutate_(reinterpret_cast<std::uint8_t*>(text.data()), size, text.size()));
            value = std::move(text);
        } else if (value.is_boolean()) {
            value = !value.get<bool>();
        } else {
            value = json(any());
        }
    }

    json near(const json& value) {
        if (value.is_number_float()) return value.get<double>() * (below(2) == 0 ? -1 : 0.5);
        return value.get<std::int64_t>() / 2 + static_cast<std::int64_t>(below(5)) - 2;
    }

    json number() {
        const std::array<json, 12> numbers{0,      1,    -1,    255,    65536, std::numeric_limits<std::int32_t>::max(),
                                           -1e300, 1e30, 1e-30, 5e-324, 0.5,   std::numeric_limits<std::uint64_t>::max()};
        return numbers[below(numbers.size())];
    }

    std::minstd_rand engine_;
    Mutate mutate_;
    std::vector<json*> values_;
};

}  // namespace

std::optional<std::string> mutate_json(std::string_view text, unsigned seed, Mutate mutate) {
    const auto shallow = [](int depth, json::parse_event_t, json&) { return depth < kDeepest; };
    json document = json::parse(text, shallow, false);
    if (document.is_discarded() || document.is_null()) return std::nullopt;
    JsonMutator(document, seed, mutate).run();
    return document.dump(-1, ' ', false, json::error_handler_t::replace);
}

}  // namespace rro::fuzz
