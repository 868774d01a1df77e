#include "solver/tradeoff/truth.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <string_view>

#include "format/atomic_file.h"
#include "format/tool/csv_field.h"
#include "solver/scene/file_bytes.h"

namespace rro {
namespace {

constexpr double kMatters = 1e-3;        // instances with less of the reflected power are not named as the worst
constexpr double kStandardErrors = 2;    // from the error to `low` and `high`
constexpr std::uint64_t kMostBytes = std::uint64_t{4} << 30;  // of a truth's file: some 30 million triangles

std::size_t place_of(const ObjectData& data, Face face) {
    return std::size_t{data.source_triangle[face.triangle()]} * 2 + static_cast<std::size_t>(face.side());
}

/// Sums over faces, of area times square or value.
struct Sums {
    double difference = 0, noise = 0, reference = 0;
    double variance = 0;            // of difference - noise
    double off = 0, reflected = 0;  // of area times value, all channels

    double squared() const { return reference > 0 ? (difference - noise) / reference : 0; }
    double error() const { return std::sqrt(std::max(0.0, squared())); }
    void add(const Sums& s) {
        difference += s.difference, noise += s.noise, reference += s.reference, variance += s.variance;
        off += s.off, reflected += s.reflected;
    }
};

/// Calls body(face, area, R_true, R - R_true, standard error) for the faces of an instance.
template <class Body>
void for_each_face(const Scene& scene, const Solution& solution, const Truth& truth, std::size_t i, const Body& body) {
    const Instance& instance = scene.instances[i];
    const ObjectData& data = instance.data();
    for (std::size_t f = 0; f < data.faces.size(); ++f) {
        const TruthFace& t = *truth.instances[i].faces[place_of(data, data.faces[f])];
        const Vec3 emitted = to_double(instance.exitance[instance.object->patch_of_face[f]]);
        const Vec3 radiosity = to_double(t.radiosity);
        body(f, length(area_vector(instance.world_corners(data.faces[f]))), radiosity - emitted,
             to_double(solution.instances[i].radiosity[f]) - radiosity, to_double(t.standard_error));
    }
}

double sum(const Vec3& v) {
    return v.x + v.y + v.z;
}

Sums sums_of(const Scene& scene, const Solution& solution, const Truth& truth, std::size_t i) {
    Sums s;
    for_each_face(scene, solution, truth, i,
                  [&](std::size_t, double area, const Vec3& reflected, const Vec3& off, const Vec3& noise) {
                      s.difference += area * length2(off);
                      s.noise += area * length2(noise);
                      s.reference += area * (length2(reflected) - length2(noise));
                      // |off|^2 varies by 4 d^2 s^2 + 2 s^4 with the truth's noise s, d = what it would be without;
                      // |off|^2 = d^2 + s^2 on the average. The channels of a path rise and fall together.
                      s.variance += area * area * 4 * length2(off) * length2(noise);
                      s.off += area * sum(off);
                      s.reflected += area * sum(reflected);
                  });
    return s;
}

void append(std::string& out, const Rgb& value) {
    for (const float channel : {value.x, value.y, value.z}) {
        std::array<char, 32> text;
        out += ',';
        out.append(text.data(), std::to_chars(text.data(), text.data() + text.size(), channel).ptr);
    }
}

/// Rows of a CSV, one after the other [RFC 4180].
class CsvReader {
  public:
    explicit CsvReader(std::string_view text) : text_(text) {}

    /// False at the end. Line breaks within quotes belong to the field.
    bool next(std::vector<std::string>& row) {
        row.clear();
        if (at_ >= text_.size()) return false;
        ++line_;
        bool quoted = false;
        std::string field;
        for (; at_ < text_.size() && (quoted || text_[at_] != '\n'); ++at_) {
            const char c = text_[at_];
            if (c == '"') {
                if (quoted && at_ + 1 < text_.size() && text_[at_ + 1] == '"') field += text_[++at_];
                else quoted = !quoted;
            } else if (c == ',' && !quoted) {
                row.push_back(std::move(field));
                field.clear();
            } else if (c != '\r' || quoted) {
                field += c;
            }
        }
        ++at_;
        row.push_back(std::move(field));
        return true;
    }
    std::size_t line() const { return line_; }

  private:
    std::string_view text_;
    std::size_t at_ = 0, line_ = 0;
};

/// Where in a row three channels stand.
using Columns = std::array<std::size_t, 3>;

std::optional<Columns> find_columns(const std::vector<std::string>& header, const std::string& name) {
    Columns columns;
    for (std::size_t c = 0; c < 3; ++c) {
        const auto found = std::find(header.begin(), header.end(), name + "_" + "rgb"[c]);
        if (found == header.end()) return std::nullopt;
        columns[c] = static_cast<std::size_t>(found - header.begin());
    }
    return columns;
}

bool read_number(const std::string& text, float& value) {
    const char* end = text.data() + text.size();
    const auto read = std::from_chars(text.data(), end, value);
    return read.ec == std::errc() && read.ptr == end && std::isfinite(value);
}

bool read_rgb(const std::vector<std::string>& row, const Columns& columns, Rgb& value) {
    return read_number(row[columns[0]], value.x) && read_number(row[columns[1]], value.y) &&
           read_number(row[columns[2]], value.z);
}

/// The columns of a truth's file.
struct Layout {
    std::size_t instance = 0, triangle = 0, count = 0;
    Columns radiosity, back, noise, back_noise;
};

Result<Layout> layout_of(const std::vector<std::string>& header, const std::string& file) {
    Layout layout;
    layout.count = header.size();
    const auto radiosity = find_columns(header, "radiosity"), back = find_columns(header, "back"),
               noise = find_columns(header, "stderr");
    if (header.size() < 2 || header[0] != "instance" || header[1] != "triangle" || !radiosity || !back || !noise)
        return bad_input(file, "has no columns instance, triangle, radiosity_*, back_* and stderr_* in its first line",
                         "rro-solve run SCENE --method reference --radiosity FILE.csv writes such a file");
    layout.instance = 0, layout.triangle = 1;
    layout.radiosity = *radiosity, layout.back = *back, layout.noise = *noise;
    layout.back_noise = find_columns(header, "back_stderr").value_or(*noise);
    return layout;
}

bool read_row(const std::vector<std::string>& row, const Layout& layout, std::vector<std::optional<TruthFace>>& faces) {
    const std::string& number = row[layout.triangle];
    std::uint32_t triangle = 0;
    const auto read = std::from_chars(number.data(), number.data() + number.size(), triangle);
    const std::size_t place = std::size_t{triangle} * 2;
    if (read.ec != std::errc() || read.ptr != number.data() + number.size() || place + 1 >= faces.size()) return false;
    TruthFace front, back;
    if (!read_rgb(row, layout.radiosity, front.radiosity) || !read_rgb(row, layout.noise, front.standard_error)) return false;
    faces[place] = front;
    if (row[layout.back[0]].empty()) return true;
    if (!read_rgb(row, layout.back, back.radiosity) || !read_rgb(row, layout.back_noise, back.standard_error)) return false;
    faces[place + 1] = back;
    return true;
}

/// A truth with room for every face of the scene, and nothing in it.
Truth empty_truth(const Scene& scene) {
    Truth truth;
    for (const Instance& instance : scene.instances) {
        const auto& sources = instance.data().source_triangle;
        const std::size_t most = sources.empty() ? 0 : *std::max_element(sources.begin(), sources.end()) + std::size_t{1};
        truth.instances.push_back({instance.name, std::vector<std::optional<TruthFace>>(2 * most)});
    }
    return truth;
}

}  // namespace

Truth truth_of(const Scene& scene, const Solution& reference) {
    Truth truth = empty_truth(scene);
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const ObjectData& data = scene.instances[i].data();
        const InstanceSolution& s = reference.instances[i];
        for (std::size_t f = 0; f < data.faces.size(); ++f)
            truth.instances[i].faces[place_of(data, data.faces[f])] =
                TruthFace{s.radiosity[f], s.standard_error.empty() ? Rgb{} : s.standard_error[f]};
    }
    return truth;
}

Status write_truth(const Truth& truth, const std::filesystem::path& path) {
    std::string text =
        "instance,triangle,radiosity_r,radiosity_g,radiosity_b,back_r,back_g,back_b,stderr_r,stderr_g,stderr_b,"
        "back_stderr_r,back_stderr_g,back_stderr_b\n";
    for (const Truth::OfInstance& instance : truth.instances)
        for (std::size_t t = 0; 2 * t + 1 < instance.faces.size(); ++t) {
            const auto &front = instance.faces[2 * t], &back = instance.faces[2 * t + 1];
            if (!front) continue;
            text += csv_field(instance.name) + "," + std::to_string(t);
            append(text, front->radiosity);
            if (back) append(text, back->radiosity);
            else text += ",,,";
            append(text, front->standard_error);
            if (back) append(text, back->standard_error);
            else text += ",,,";
            text += '\n';
        }
    return write_file_atomically(path, text);
}

Result<Truth> read_truth(const std::filesystem::path& path, const Scene& scene) {
    const auto text = read_bytes(path, kMostBytes);
    if (!text) return text.error();
    CsvReader csv(*text);
    std::vector<std::string> row;
    csv.next(row);
    const auto layout = layout_of(row, path.string());
    if (!layout) return layout.error();
    Truth truth = empty_truth(scene);
    std::map<std::string, std::size_t> place;
    for (std::size_t i = 0; i < truth.instances.size(); ++i) place[truth.instances[i].name] = i;
    while (csv.next(row)) {
        const auto found = row.size() == layout->count ? place.find(row[layout->instance]) : place.end();
        if (found == place.end() || !read_row(row, *layout, truth.instances[found->second].faces))
            return bad_input(path.string() + ": row " + std::to_string(csv.line()),
                             "expected " + std::to_string(layout->count) + " fields of a triangle of " +
                                 scene.manifest.path.string());
    }
    for (std::size_t i = 0; i < scene.instances.size(); ++i)
        for (const Face face : scene.instances[i].data().faces)
            if (!truth.instances[i].faces[place_of(scene.instances[i].data(), face)])
                return bad_input(path.string(), "has nothing about triangle " +
                                                    std::to_string(scene.instances[i].data().source_triangle[face.triangle()]) +
                                                    " of " + scene.instances[i].name + ", or not about all its sides");
    return truth;
}

MeasuredError measure_error(const Scene& scene, const Solution& solution, const Truth& truth) {
    std::vector<Sums> each;
    Sums all;
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        each.push_back(sums_of(scene, solution, truth, i));
        all.add(each.back());
    }
    MeasuredError m;
    if (!(all.reference > 0)) {  // dark, or nothing but noise
        m.error = m.low = m.high = all.difference > 0 ? std::numeric_limits<double>::infinity() : 0;
        return m;
    }
    const double uncertainty = kStandardErrors * std::sqrt(all.variance) / all.reference;
    m.error = all.error();
    m.low = std::sqrt(std::max(0.0, all.squared() - uncertainty));
    m.high = std::sqrt(std::max(0.0, all.squared() + uncertainty));
    m.bias = all.reflected > 0 ? all.off / all.reflected : 0;
    for (std::size_t i = 0; i < each.size(); ++i)
        if (each[i].reflected > kMatters * all.reflected && each[i].error() > m.worst_error) {
            m.worst_error = each[i].error();
            m.worst_instance = scene.instances[i].name;
        }
    return m;
}

double standard_error(const Scene& scene, const Truth& truth) {
    Solution exact;
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const ObjectData& data = scene.instances[i].data();
        exact.instances.emplace_back();
        for (const Face face : data.faces)
            exact.instances[i].radiosity.push_back(truth.instances[i].faces[place_of(data, face)]->radiosity);
    }
    Sums all;
    for (std::size_t i = 0; i < scene.instances.size(); ++i) all.add(sums_of(scene, exact, truth, i));
    return all.reference > 0 ? std::sqrt(all.noise / all.reference) : 0;
}

std::vector<std::vector<float>> face_errors(const Scene& scene, const Solution& solution, const Truth& truth) {
    std::vector<std::vector<float>> errors(scene.instances.size());
    double square = 0, area_of_all = 0;
    for (std::size_t i = 0; i < scene.instances.size(); ++i)
        for_each_face(scene, solution, truth, i,
                      [&](std::size_t, double area, const Vec3& reflected, const Vec3& off, const Vec3& noise) {
                          errors[i].push_back(static_cast<float>(std::sqrt(std::max(0.0, length2(off) - length2(noise)))));
                          square += area * (length2(reflected) - length2(noise));
                          area_of_all += area;
                      });
    const float scale = square > 0 ? static_cast<float>(std::sqrt(area_of_all / square)) : 0.0f;
    for (auto& of_instance : errors)
        for (float& e : of_instance) e *= scale;
    return errors;
}

}  // namespace rro
