#include "solver/scene/lights.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "format/sample_points.h"

namespace rro {
namespace {

using std::numbers::pi;

// An overcast sky changes with altitude alone; rows of 2.8 degrees choose directions close to by brightness.
constexpr std::size_t kOvercastRows = 64;

// Cosine-weighted directions alone do well until a piece of sky is this many times brighter than the mean.
constexpr double kPeak = 4;

double channel_sum(const Vec3& v) {
    return v.x + v.y + v.z;
}

bool is_grey_colour(const Vec3& c) {
    return c.x == c.y && c.y == c.z;
}

/// The number whose step of an ascending sum holds u, and the place within that step as a new number in [0, 1).
struct Choice {
    std::size_t index;
    double rest;
};

Choice choose(const double* cumulative, std::size_t count, double u) {
    const double at = u * cumulative[count - 1];
    const auto index = static_cast<std::size_t>(std::upper_bound(cumulative, cumulative + count - 1, at) - cumulative);
    const double below = index > 0 ? cumulative[index - 1] : 0, step = cumulative[index] - below;
    return {index, step > 0 ? std::clamp((at - below) / step, 0.0, 1.0) : 0.5};
}

/// The lamp's axes: its vertical angle 0 along `down`, its horizontal angle 0 along x where down is -y, and turned from
/// there by the smallest rotation.
struct LampFrame {
    Vec3 down, first, second;
};

LampFrame lamp_frame(const Vec3& down) {
    const Vec3 rest{0, -1, 0};
    const Vec3 axis = cross(rest, down);
    const double cosine = dot(rest, down);
    const auto turned = [&](const Vec3& v) {
        if (!(cosine > -1 + 1e-12)) return Vec3{v.x, -v.y, -v.z};  // half a turn about x
        return v * cosine + cross(axis, v) + axis * (dot(axis, v) / (1 + cosine));
    };
    return {down, turned({1, 0, 0}), turned({0, 0, -1})};
}

}  // namespace

Sky Sky::uniform(const Vec3& radiance, bool ground) {
    Sky sky;
    sky.kind_ = Kind::Uniform;
    sky.colour_ = radiance;
    sky.ground_ = ground;
    sky.rows_ = ground ? 2 : 1;
    sky.build_table();
    return sky;
}

Sky Sky::cie_overcast(const Vec3& zenith, bool ground) {
    Sky sky;
    sky.kind_ = Kind::Overcast;
    sky.colour_ = zenith;
    sky.ground_ = ground;
    sky.rows_ = kOvercastRows;
    sky.build_table();
    return sky;
}

Sky Sky::image(int width, int height, std::vector<Rgb> pixels, bool ground) {
    Sky sky;
    sky.kind_ = Kind::Image;
    sky.ground_ = ground;
    sky.rows_ = static_cast<std::size_t>(height);
    sky.columns_ = static_cast<std::size_t>(width);
    sky.pixels_ = std::move(pixels);
    sky.build_table();
    return sky;
}

double Sky::row_edge(std::size_t row) const {
    return std::cos(pi * static_cast<double>(row) / static_cast<double>(rows_));
}

double Sky::row_solid_angle(std::size_t row) const {
    return (row_edge(row) - row_edge(row + 1)) * 2 * pi / static_cast<double>(columns_);
}

std::size_t Sky::cell(const Vec3& from) const {
    const auto index = [](double share, std::size_t count) {
        return std::min(static_cast<std::size_t>(std::max(0.0, share * static_cast<double>(count))), count - 1);
    };
    const double row_share = std::acos(std::clamp(from.y, -1.0, 1.0)) / pi;
    const double column_share = 0.5 - std::atan2(from.x, from.z) / (2 * pi);
    return index(row_share, rows_) * columns_ + index(column_share, columns_);
}

/// A cell has one radiance but for the overcast sky's.
Vec3 Sky::cell_radiance(std::size_t cell, const Vec3& from) const {
    if (ground_ && from.y < 0) return {};
    if (kind_ == Kind::Uniform) return colour_;
    if (kind_ == Kind::Overcast) return colour_ * ((1 + 2 * std::max(0.0, from.y)) / 3);
    return to_double(pixels_[cell]);
}

void Sky::build_table() {
    for (std::size_t row = 0; row < rows_; ++row) {
        const double sine = 0.5 * (row_edge(row) + row_edge(row + 1));  // an overcast row's mean is that at its mean sine
        // A row of a picture that crosses the horizon may be chosen as often as if it did not.
        const bool below = ground_ && !(row_edge(row) > 1e-9);
        double sum = 0;
        for (std::size_t column = 0; column < columns_; ++column) {
            if (!below) sum += channel_sum(cell_radiance(row * columns_ + column, {0, kind_ == Kind::Image ? 1 : sine, 0}));
            cumulative_cells_.push_back(sum);
        }
        total_ += sum * row_solid_angle(row);
        cumulative_rows_.push_back(total_);
    }
}

Vec3 Sky::radiance(const Vec3& from) const {
    return cell_radiance(cell(from), from);
}

double Sky::density(const Vec3& from) const {
    const std::size_t at = cell(from);
    return (cumulative_cells_[at] - (at % columns_ > 0 ? cumulative_cells_[at - 1] : 0)) / total_;
}

Sky::Sample Sky::sample(double u, double v) const {
    const Choice row = choose(cumulative_rows_.data(), rows_, u);
    const double* cells = cumulative_cells_.data() + row.index * columns_;
    const Choice column = choose(cells, columns_, v);
    const double sine = row_edge(row.index) + (row_edge(row.index + 1) - row_edge(row.index)) * row.rest;
    const double longitude =
        (0.5 - (static_cast<double>(column.index) + column.rest) / static_cast<double>(columns_)) * 2 * pi;
    const double cosine = std::sqrt(std::max(0.0, 1 - sine * sine));
    const Vec3 from{cosine * std::sin(longitude), sine, cosine * std::cos(longitude)};
    const double chosen = cells[column.index] - (column.index > 0 ? cells[column.index - 1] : 0);
    return {from, cell_radiance(row.index * columns_ + column.index, from), chosen / total_};
}

bool Sky::is_grey() const {
    return kind_ == Kind::Image ? std::all_of(pixels_.begin(), pixels_.end(),
                                              [](const Rgb& c) { return c.x == c.y && c.y == c.z; })
                                : is_grey_colour(colour_);
}

Sky Sky::grey() const {
    Sky sky = *this;
    sky.colour_ = rro::grey(colour_);
    for (Rgb& pixel : sky.pixels_) pixel = to_float(rro::grey(to_double(pixel)));
    sky.cumulative_cells_.clear();
    sky.cumulative_rows_.clear();
    sky.total_ = 0;
    sky.build_table();
    return sky;
}

bool Sky::is_peaked() const {
    double brightest = 0;
    for (std::size_t i = 0; i < cumulative_cells_.size(); ++i)
        brightest = std::max(brightest, cumulative_cells_[i] - (i % columns_ > 0 ? cumulative_cells_[i - 1] : 0));
    return brightest * 4 * pi > kPeak * total_;
}

Sun::Sample Sun::sample(double u, double v) const {
    const double reach = std::sin(angular_radius);
    const Vec3 on_disc = square_to_cosine_hemisphere(u, v);  // x, y are uniform on the unit disc
    const double x = reach * on_disc.x, y = reach * on_disc.y, z = std::sqrt(1 - x * x - y * y);
    const std::array<Vec3, 3> frame = frame_about(-direction);
    return {frame[0] * x + frame[1] * y + frame[2] * z, irradiance / z};
}

Vec3 Sun::radiance(const Vec3& from) const {
    if (angular_radius <= 0) return {};
    if (length(cross(from, direction)) > std::sin(angular_radius) || dot(from, direction) > 0) return {};
    return irradiance / (pi * std::sin(angular_radius) * std::sin(angular_radius));
}

Vec3 PointLight::intensity_towards(const Vec3& towards) const {
    const double cosine = dot(direction, towards);
    if (cone_cosine > -1 && cosine < cone_cosine) return {};
    if (!measured) return intensity;
    const LampFrame frame = lamp_frame(direction);
    const double vertical = std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / pi;
    const double horizontal = std::atan2(dot(frame.second, towards), dot(frame.first, towards)) * 180 / pi;
    return intensity * (measured->intensity(vertical, horizontal) / measured->largest());
}

Vec3 Medium::transmittance(double distance) const {
    const auto left = [&](double a) { return a > 0 ? std::exp(-a * distance) : 1.0; };
    return {left(absorption.x), left(absorption.y), left(absorption.z)};
}

}  // namespace rro
