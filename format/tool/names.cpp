#include "format/tool/names.h"

#include <algorithm>
#include <numeric>
#include <vector>

namespace rro {
namespace {

constexpr std::size_t kLongestName = 64;  // the distance takes time with the product of the lengths

/// Letters to insert, remove or replace to make one of the other [Levenshtein 1966].
std::size_t edit_distance(std::string_view a, std::string_view b) {
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 0; i < a.size(); ++i) {
        std::size_t diagonal = row[0];
        row[0] = i + 1;
        for (std::size_t j = 0; j < b.size(); ++j) {
            const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
            diagonal = row[j + 1];
            row[j + 1] = std::min({replaced, diagonal + 1, row[j] + 1});
        }
    }
    return row.back();
}

}  // namespace

std::string listed(std::span<const std::string> names) {
    std::string text;
    for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
    return text;
}

std::string nearest_hint(std::string_view name, std::span<const std::string> names) {
    if (name.size() > kLongestName) return {};
    std::size_t best = std::max<std::size_t>(2, name.size() / 3) + 1;  // further away it is another word
    const std::string* nearest = nullptr;
    for (const std::string& candidate : names) {
        if (candidate.size() > kLongestName) continue;
        const std::size_t distance = edit_distance(name, candidate);
        if (distance < best && distance < candidate.size()) {
            best = distance;
            nearest = &candidate;
        }
    }
    return nearest ? "did you mean \"" + *nearest + "\"?" : "";
}

}  // namespace rro
