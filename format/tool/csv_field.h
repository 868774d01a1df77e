// One field of a CSV file, for every table that either program writes.
#pragma once

#include <string>
#include <string_view>

namespace rro {

/// RFC 4180: quotes only where the text has a comma, a quote or a line break; quotes inside are doubled.
inline std::string csv_field(std::string_view text) {
    if (text.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(text);
    std::string out = "\"";
    for (const char c : text) {
        if (c == '"') out += '"';
        out += c;
    }
    return out + '"';
}

}  // namespace rro
