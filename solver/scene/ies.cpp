#include "solver/scene/ies.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <optional>

#include "solver/scene/file_bytes.h"

namespace rro {
namespace {

constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 24;  // published files have some 10 kB
constexpr double kMostAngles = 1e5;                           // of either kind; half degrees all round are 720
constexpr double kLargestCandela = 1e12;                      // the brightest searchlights have 1e9
constexpr double kTypeC = 1;

/// The numbers after the TILT line, one after the other; the first fault stays.
class Numbers {
  public:
    Numbers(std::string_view text, std::string name) : text_(text), name_(std::move(name)) {}

    double next(const char* what) {
        constexpr std::string_view between = " \t\r\n,\f\v";
        if (fault_) return 0;
        text_.remove_prefix(std::min(text_.find_first_not_of(between), text_.size()));
        const std::string_view word = text_.substr(0, text_.find_first_of(between));
        text_.remove_prefix(word.size());
        ++count_;
        double value = 0;
        const std::string_view digits = word.starts_with('+') ? word.substr(1) : word;
        const auto [end, code] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
        if (word.empty())
            fail(what, "nothing, the file ends here", "a number");
        else if (code != std::errc{} || end != digits.data() + digits.size() || !std::isfinite(value))
            fail(what, "\"" + std::string(word.substr(0, 20)) + "\"", "a number");
        return value;
    }

    double at_least(double least, double most, const char* what) {
        const double value = next(what);
        if (!fault_ && !(value >= least && value <= most))
            fail(what, text_of(value), "a number from " + text_of(least) + " to " + text_of(most));
        return value;
    }

    /// A whole number that the rest of the text is long enough for.
    std::size_t count(const char* what) {
        const double value = at_least(1, kMostAngles, what);
        if (!fault_ && value != std::floor(value)) fail(what, text_of(value), "a whole number");
        return fault_ ? 0 : static_cast<std::size_t>(value);
    }

    std::vector<double> ascending(std::size_t n, double most, const char* what) {
        std::vector<double> angles;
        for (std::size_t i = 0; i < n && !fault_; ++i) {
            angles.push_back(at_least(0, most, what));
            if (i > 0 && !fault_ && !(angles[i] > angles[i - 1]))
                fail(what, text_of(angles[i]) + " after " + text_of(angles[i - 1]), "ascending angles");
        }
        return angles;
    }

    void fail(const char* what, const std::string& found, const std::string& expected) {
        fault_ = bad_input(name_, "number " + std::to_string(count_) + " after TILT, " + what + ": found " + found +
                                      ", expected " + expected);
    }

    std::size_t left() const { return text_.size(); }
    const std::optional<Error>& fault() const { return fault_; }

  private:
    static std::string text_of(double value) {
        char text[32];
        std::snprintf(text, sizeof text, "%g", value);
        return text;
    }

    std::string_view text_;
    std::string name_;
    std::size_t count_ = 0;
    std::optional<Error> fault_;
};

/// Takes the text up to and with the line "TILT=...", and gives what stands behind the equals sign.
std::optional<std::string_view> take_tilt(std::string_view& text) {
    while (!text.empty()) {
        const std::string_view line = text.substr(0, text.find_first_of("\r\n"));
        text.remove_prefix(std::min(text.size(), line.size() + 1));
        if (!line.starts_with("TILT=")) continue;
        const std::string_view tilt = line.substr(5);
        return tilt.substr(0, tilt.find_last_not_of(" \t") + 1);
    }
    return std::nullopt;
}

/// Where an angle stands among ascending ones: between `at` and the next, `share` of the way.
struct Between {
    std::size_t at = 0;
    double share = 0;
};

Between between(const std::vector<double>& angles, double angle) {
    if (angles.size() < 2) return {};
    const auto above = std::upper_bound(angles.begin() + 1, angles.end() - 1, angle);
    const auto at = static_cast<std::size_t>(above - angles.begin()) - 1;
    return {at, std::clamp((angle - angles[at]) / (angles[at + 1] - angles[at]), 0.0, 1.0)};
}

/// The horizontal angles say which symmetry a lamp has: about its axis (0 alone), both planes (0 to 90), one plane (0 to
/// 180, or 90 to 270), none (0 to 360).
double folded(const std::vector<double>& horizontal, double angle) {
    angle -= 360 * std::floor(angle / 360);
    const double first = horizontal.front(), last = horizontal.back();
    if (first == 90 && last == 270) return angle < 90 ? 180 - angle : angle > 270 ? 540 - angle : angle;
    if (last <= 180 && angle > 180) angle = 360 - angle;
    if (last <= 90 && angle > 90) angle = 180 - angle;
    return angle;
}

bool known_symmetry(const std::vector<double>& horizontal) {
    const double first = horizontal.front(), last = horizontal.back();
    if (first == 90) return last == 270;
    return first == 0 && (horizontal.size() == 1 || last == 90 || last == 180 || last == 360);
}

}  // namespace

double IesDistribution::intensity(double vertical_degrees, double horizontal_degrees) const {
    if (!(vertical_degrees >= vertical.front() && vertical_degrees <= vertical.back())) return 0;
    const Between v = between(vertical, vertical_degrees), h = between(horizontal, folded(horizontal, horizontal_degrees));
    const auto along = [&](std::size_t column) {
        const double* c = candela.data() + column * vertical.size();
        return c[v.at] + (vertical.size() > 1 ? v.share * (c[v.at + 1] - c[v.at]) : 0);
    };
    const double a = along(h.at);
    return horizontal.size() > 1 ? a + h.share * (along(h.at + 1) - a) : a;
}

double IesDistribution::largest() const {
    return *std::max_element(candela.begin(), candela.end());
}

Result<IesDistribution> parse_ies(std::string_view text, const std::string& name) {
    std::string_view rest = text;
    const auto tilt = take_tilt(rest);
    if (!tilt) return bad_input(name, "has no line \"TILT=...\", expected an IES LM-63 file");
    Numbers numbers(rest, name);
    if (*tilt == "INCLUDE") {  // how the lamp's position changes its flux: measured as it hangs, it is not needed
        numbers.next("lamp-to-luminaire geometry");
        const std::size_t pairs = numbers.count("number of tilt angles");
        for (std::size_t i = 0; i < 2 * pairs && !numbers.fault(); ++i) numbers.next("tilt");
    } else if (*tilt != "NONE") {
        return bad_input(name, "has TILT=" + std::string(tilt->substr(0, 40)) + ", expected NONE or INCLUDE");
    }
    numbers.next("number of lamps");
    numbers.next("lumens per lamp");
    const double multiplier = numbers.at_least(0, kLargestCandela, "candela multiplier");
    const std::size_t verticals = numbers.count("number of vertical angles");
    const std::size_t horizontals = numbers.count("number of horizontal angles");
    const double type = numbers.next("photometric type");
    if (!numbers.fault() && type != kTypeC)
        numbers.fail("photometric type", type == 2 ? "2 (B)" : type == 3 ? "3 (A)" : "another", "1 (C)");
    for (const char* what : {"units", "width", "length", "height"}) numbers.next(what);
    const double ballast = numbers.at_least(0, kLargestCandela, "ballast factor");
    for (const char* what : {"future use", "input watts"}) numbers.next(what);

    IesDistribution web;
    web.vertical = numbers.ascending(verticals, 180, "vertical angle");
    web.horizontal = numbers.ascending(horizontals, 360, "horizontal angle");
    if (!numbers.fault() && !known_symmetry(web.horizontal))
        numbers.fail("horizontal angle", "another range", "0 alone, 0 to 90, 0 to 180, 0 to 360 or 90 to 270");
    if (!numbers.fault() && verticals * horizontals > numbers.left())
        numbers.fail("intensities", "fewer than the angles ask for", std::to_string(verticals * horizontals));
    for (std::size_t i = 0; i < verticals * horizontals && !numbers.fault(); ++i)
        web.candela.push_back(numbers.at_least(0, kLargestCandela, "intensity") * multiplier * ballast);
    if (numbers.fault()) return *numbers.fault();
    if (!(web.largest() > 0 && web.largest() <= kLargestCandela))
        return bad_input(name, "has no intensity above 0, or one above 1e12 cd");
    return web;
}

Result<IesDistribution> read_ies(const std::filesystem::path& path) {
    const auto text = read_bytes(path, kMostBytes);
    if (!text) return text.error();
    return parse_ies(*text, path.string());
}

}  // namespace rro
