// The version of both programs; the project's in CMakeLists.txt.
#pragma once

#include <string_view>

namespace rro {

inline constexpr std::string_view kToolVersion = "0.2.0";

}  // namespace rro
