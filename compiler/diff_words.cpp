#include "compiler/diff_words.h"

#include <algorithm>
#include <array>
#include <cstdio>

namespace rro {
namespace {

constexpr std::size_t kRangesShown = 4;
constexpr int kFewDigits = 5;
constexpr double kLargestInPercent = 1.99;  // beyond, a factor reads better
constexpr int kAllDigits = 17;              // tell any two doubles apart

std::string triple(const Vec3& v, int digits) {
    return "(" + number(v.x, digits) + ", " + number(v.y, digits) + ", " + number(v.z, digits) + ")";
}

template <class Value, class Text>
std::string told_apart(const Value& before, const Value& after, const Text& text) {
    int digits = kFewDigits;
    while (digits < kAllDigits && text(before, digits) == text(after, digits)) ++digits;
    return text(before, digits) + " -> " + text(after, digits);
}

}  // namespace

std::string counted(std::size_t count, const std::string& noun) {
    return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

std::string number(double value, int digits) {
    std::array<char, 40> text;
    std::snprintf(text.data(), text.size(), "%.*g", digits, value);
    return text.data();
}

std::string from_to(double before, double after) {
    return told_apart(before, after, number);
}

std::string from_to(const Vec3& before, const Vec3& after) {
    return told_apart(before, after, triple);
}

std::string from_to(std::uint64_t before, std::uint64_t after) {
    return std::to_string(before) + " -> " + std::to_string(after);
}

DiffValue relative_change(double before, double after) {
    if (before == 0) return {};
    return (after - before) / before;
}

std::string in_percent(double before, double after) {
    if (before == 0) return "";
    const double ratio = after / before;
    if (ratio != 0 && (ratio > kLargestInPercent || ratio < 1 / kLargestInPercent)) return " (x " + number(ratio) + ")";
    std::array<char, 40> text;
    std::snprintf(text.data(), text.size(), " (%+.2g %%)", 100 * (ratio - 1));
    return text.data();
}

NumberRanges ranges_of(const std::vector<std::uint32_t>& numbers) {
    NumberRanges ranges;
    for (const std::uint32_t n : numbers) {
        if (!ranges.empty() && n <= ranges.back()[1] + 1)
            ranges.back()[1] = n;
        else
            ranges.push_back({n, n});
    }
    return ranges;
}

std::string range_text(const NumberRanges& ranges) {
    std::string text;
    for (std::size_t i = 0; i < std::min(ranges.size(), kRangesShown); ++i) {
        const auto& [first, last] = ranges[i];
        text += (i ? ", " : "") + std::to_string(first) + (first == last ? "" : "-" + std::to_string(last));
    }
    return text + (ranges.size() > kRangesShown ? ", ..." : "");
}

}  // namespace rro
