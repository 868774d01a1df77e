// Lists of names in messages, and the one that was probably meant.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace rro {

/// "a, b, c".
std::string listed(std::span<const std::string> names);

/// "did you mean "desk"?" where one of the names is a few letters away (ties: the first), else empty.
std::string nearest_hint(std::string_view name, std::span<const std::string> names);

}  // namespace rro
