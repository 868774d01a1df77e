// Mutations of JSON texts that stay JSON.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "tests/fuzz/mutate.h"

namespace rro::fuzz {

/// The document with one value changed: another number, another text, another value of the document; or one member or
/// element more or less. None where `text` is no JSON, or an empty one.
///
/// The same text and seed give the same mutation.
std::optional<std::string> mutate_json(std::string_view text, unsigned seed, Mutate mutate);

}  // namespace rro::fuzz
