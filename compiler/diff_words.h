// Numbers and their changes in words, for `rro-compile diff`.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "compiler/archive_diff.h"

namespace rro {

/// "1 triangle", "2 triangles".
std::string counted(std::size_t count, const std::string& noun);

/// "0.25", with so many significant digits.
std::string number(double value, int digits = 4);

/// "0.5 -> 0.25", with as many digits as it takes to tell them apart.
std::string from_to(double before, double after);
/// The same.
std::string from_to(const Vec3& before, const Vec3& after);
/// The same.
std::string from_to(std::uint64_t before, std::uint64_t after);

/// Adds the change of a number, if it is one: "WHAT: 1 -> 2".
template <class T>
void compare_number(const std::string& group, const std::string& kind, const std::string& what, T before, T after,
                    std::vector<Change>& out) {
    if (before != after) out.push_back({group, kind, what, before, after, {}, what + ": " + from_to(before, after)});
}
/// The same for counts.
inline void compare_count(const std::string& group, const std::string& kind, const std::string& what, std::uint64_t before,
                          std::uint64_t after, std::vector<Change>& out) {
    compare_number(group, kind, what, before, after, out);
}

/// (after - before) / before, or none where that has no value.
DiffValue relative_change(double before, double after);

/// " (+5.4 %)", " (x 100)" where that is much, or nothing where before is 0.
std::string in_percent(double before, double after);

/// Ranges of ascending numbers.
NumberRanges ranges_of(const std::vector<std::uint32_t>& numbers);

/// "3, 7-9, 12, ...": the first few.
std::string range_text(const NumberRanges& ranges);

}  // namespace rro
