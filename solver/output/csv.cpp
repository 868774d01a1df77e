#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "format/atomic_file.h"
#include "format/parallel.h"
#include "format/source_order.h"
#include "format/tool/csv_field.h"
#include "solver/output/output.h"

namespace rro {
namespace {

constexpr int kDigits = 9;             // enough to give back every float
constexpr std::size_t kRowsAtATime = 8192;
constexpr std::size_t kBytesPerRow = 128;  // a usual row; only to reserve

void append_integer(std::string& out, std::uint32_t value) {
    std::array<char, 16> text;
    out.append(text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr);
}

void append_number(std::string& out, float value) {
    std::array<char, 32> text;
    const float without_negative_zero = value + 0.0f;
    out += ',';
    out.append(text.data(), std::to_chars(text.data(), text.data() + text.size(), without_negative_zero,
                                          std::chars_format::general, kDigits).ptr);
}

void append_rgb(std::string& out, const Rgb& value) {
    append_number(out, value.x);
    append_number(out, value.y);
    append_number(out, value.z);
}

void append_row(std::string& out, const std::string& name, const Object& object, const InstanceSolution& solution,
                bool with_errors, std::uint32_t triangle) {
    const std::uint32_t front = object.front_face[triangle], back = object.back_face[triangle];
    out += name;
    out += ',';
    append_integer(out, object.data().source_triangle[triangle]);
    append_rgb(out, solution.radiosity[front]);
    append_rgb(out, solution.irradiance[front]);
    if (back == kNoFace) out += ",,,";
    else append_rgb(out, solution.radiosity[back]);
    if (with_errors) append_rgb(out, solution.standard_error[front]);
    out += '\n';
}

void append_instance(std::string& out, const Instance& instance, const InstanceSolution& solution, bool with_errors) {
    const std::string name = csv_field(instance.name);
    const std::vector<std::uint32_t> order = by_source_number(instance.data());
    std::vector<std::string> parts((order.size() + kRowsAtATime - 1) / kRowsAtATime);
    parallel_chunks(order.size(), kRowsAtATime, [&](std::size_t begin, std::size_t end) {
        std::string& part = parts[begin / kRowsAtATime];
        part.reserve((end - begin) * (kBytesPerRow + name.size()));
        for (std::size_t i = begin; i < end; ++i)
            append_row(part, name, *instance.object, solution, with_errors, order[i]);
    });
    for (const std::string& part : parts) out += part;
}

}  // namespace

Status write_radiosity_csv(const Scene& scene, const Solution& solution, const std::filesystem::path& path) {
    const bool with_errors = std::any_of(solution.instances.begin(), solution.instances.end(),
                                         [](const InstanceSolution& s) { return !s.standard_error.empty(); });
    std::string text =
        "instance,triangle,radiosity_r,radiosity_g,radiosity_b,irradiance_r,irradiance_g,irradiance_b,"
        "back_r,back_g,back_b";
    if (with_errors) text += ",stderr_r,stderr_g,stderr_b";
    text += '\n';
    for (std::size_t i = 0; i < scene.instances.size(); ++i)
        append_instance(text, scene.instances[i], solution.instances[i], with_errors);
    return write_file_atomically(path, text);
}

}  // namespace rro
