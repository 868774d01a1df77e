// printf into a string, for lines of text.
#pragma once

#include <array>
#include <cstdio>
#include <string>

namespace rro {

/// What printf would print, cut at 511 bytes.
template <class... Values>
std::string printed(const char* format, Values... values) {
    std::array<char, 512> text;
    std::snprintf(text.data(), text.size(), format, values...);
    return text.data();
}

}  // namespace rro
