#include "solver/edit/edit_arguments.h"

#include <charconv>
#include <cmath>
#include <optional>

namespace rro {
namespace {

/// "1,-2.5,3e2": numbers with one comma between; none where one of them is no finite number.
std::optional<std::vector<double>> parse_numbers(std::string_view text) {
    std::vector<double> numbers;
    for (const char* at = text.data(); ; ++at) {
        double value = 0;
        if (at != text.data() + text.size() && *at == '+') ++at;
        const auto [end, fault] = std::from_chars(at, text.data() + text.size(), value);
        if (fault != std::errc() || !std::isfinite(value)) return {};
        numbers.push_back(value);
        at = end;
        if (at == text.data() + text.size()) return numbers;
        if (*at != ',') return {};
    }
}

Status read_option(const char* name, const std::string& text, const char* expected, std::vector<std::size_t> counts,
                   std::vector<double>& out) {
    if (text.empty()) return Done{};
    const auto numbers = parse_numbers(text);
    for (const std::size_t count : counts)
        if (numbers && numbers->size() == count) {
            out = *numbers;
            return Done{};
        }
    return Error{ErrorKind::Usage, "", std::string(name) + " " + text + ": expected " + expected, ""};
}

}  // namespace

Result<TransformChange> parse_transform(const TransformOptions& options) {
    TransformChange change;
    std::string matrix;
    for (const std::string& part : options.matrix) matrix += (matrix.empty() ? "" : ",") + part;
    for (const Status& read :
         {read_option("--translate", options.translate, "x,y,z in metres", {3}, change.translate),
          read_option("--rotate", options.rotate, "ax,ay,az,degrees", {4}, change.rotate),
          read_option("--scale", options.scale, "one factor, or x,y,z", {1, 3}, change.scale),
          read_option("--matrix", matrix, "16 numbers, row by row, points are columns", {16}, change.matrix)})
        if (!read) return read.error();
    if (!change.matrix.empty() && !(change.translate.empty() && change.rotate.empty() && change.scale.empty()))
        return Error{ErrorKind::Usage, "", "--matrix is the whole transform: expected no --translate, --rotate or --scale", ""};
    return change;
}

}  // namespace rro
