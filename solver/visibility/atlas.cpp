#include "solver/visibility/atlas.h"

#include <algorithm>
#include <cmath>

#include "format/sample_points.h"

namespace rro {
namespace {

// A shaft is wide enough where its narrow width is this many times R over the number of directions along the grid's side
// (measured with visibility_bench).
constexpr double kNarrowest = 5;

// Root mean square error of a partial cover: of the blend of directions for any width, and for edges that lie elsewhere
// between the stored directions, in proportion to R over the narrow width (fitted to visibility_bench).
constexpr double kBlendError = 0.02, kEdgeError = 0.012;
// Where the silhouette covers everything or nothing, most of that is not there.
constexpr double kCertain = 0.1;
// Sub-pixel parts may be missing from an image that proves a shaft clear.
constexpr double kClearError = 0.002;

// A shaft longer than wide in cross-section counts as several side by side.
constexpr int kMostPieces = 6;

double reach(const std::array<Vec3, 3>& spread, const Vec3& along) {
    double sum = 0;
    for (const Vec3& s : spread) sum += std::abs(dot(s, along));
    return std::sqrt(3.0) * sum;
}

}  // namespace

SilhouetteSums::SilhouetteSums(const ObjectData& object)
    : grid_(GridMap::Octahedral, object.atlas_grid_size),
      size_(object.atlas_image_size),
      centre_(object.origin + to_double(object.atlas_centre)),
      radius_(static_cast<double>(object.atlas_radius)) {
    const std::uint32_t lines = grid_.lines(), side = size_ + 1;
    sums_.assign(std::size_t{lines} * side * side, 0);
    for (std::uint32_t line = 0; line < lines; ++line) {
        const auto [right, up, toward] = frame_about(grid_.direction(line));
        frames_.push_back({right, up, toward});
        const std::uint8_t* pixel = object.atlas_coverage.data() + std::size_t{line} * size_ * size_;
        std::uint32_t* sum = sums_.data() + std::size_t{line} * side * side;
        for (std::uint32_t row = 0; row < size_; ++row)
            for (std::uint32_t column = 0, along = 0; column < size_; ++column) {
                along += *pixel++;
                sum[(row + 1) * side + column + 1] = sum[row * side + column + 1] + along;
            }
    }
}

// Coverage is constant over a pixel, so its integral is bilinear between corners.
double SilhouetteSums::sum_below(std::uint32_t line, double column, double row) const {
    const auto most = static_cast<double>(size_);
    column = std::clamp(column, 0.0, most), row = std::clamp(row, 0.0, most);
    const auto c = std::min(static_cast<std::uint32_t>(column), size_ - 1);
    const auto r = std::min(static_cast<std::uint32_t>(row), size_ - 1);
    const double s = column - c, t = row - r;
    const std::uint32_t* at = sums_.data() + (std::size_t{line} * (size_ + 1) + r) * (size_ + 1) + c;
    const std::uint32_t* above = at + size_ + 1;
    return (1 - t) * ((1 - s) * at[0] + s * at[1]) + t * ((1 - s) * above[0] + s * above[1]);
}

double SilhouetteSums::covered_share(std::uint32_t line, const Footprint& f) const {
    const double area = (f.right - f.left) * (f.top - f.bottom);
    if (!(area > 0)) return 0;
    const double sum = sum_below(line, f.right, f.top) - sum_below(line, f.left, f.top) -
                       sum_below(line, f.right, f.bottom) + sum_below(line, f.left, f.bottom);
    return std::clamp(sum / (255 * area), 0.0, 1.0);
}

// Of the cross-section through the object's centre, over the four stored directions about the shaft's.
double SilhouetteSums::blended_share(const CrossSection& section, const LocalShaft& shaft) const {
    const int pieces = std::clamp(static_cast<int>(std::lround(section.wide / section.narrow)), 1, kMostPieces);
    // Half the width of a piece along u, from its variance: across the direction of the shaft, its long side divided.
    const auto half_width = [&](const Vec3& u) {
        const double forward = dot(u, section.direction), lengthwise = dot(u, section.major) * (1 - 1.0 / pieces);
        const Vec3 seen = u - section.direction * forward - section.major * lengthwise;
        double variance = 0;
        const auto square = [](double x) { return x * x; };
        for (const Vec3& s : shaft.spread_a) variance += square((1 - section.t) * dot(s, seen));
        for (const Vec3& s : shaft.spread_b) variance += square(section.t * dot(s, seen));
        return std::sqrt(3 * variance);
    };
    const double pixels = size_ / (2 * radius_);
    const DirectionTaps taps = grid_.taps(section.direction);
    double share = 0;
    for (std::size_t k = 0; k < taps.node.size(); ++k) {
        const auto weight = static_cast<double>(taps.weight[k]);
        if (weight == 0) continue;
        const std::uint32_t line = grid_.line(taps.node[k]);
        const Frame& frame = frames_[line];
        const double x = half_width(frame.right), y = half_width(frame.up);
        for (int piece = 0; piece < pieces; ++piece) {
            const double along = section.wide * ((piece + 0.5) / pieces - 0.5);
            const Vec3 middle = section.at + section.major * along - centre_;
            const double column = dot(middle, frame.right) + radius_, row = dot(middle, frame.up) + radius_;
            share += weight / pieces *
                     covered_share(line, {pixels * (column - x), pixels * (column + x), pixels * (row - y), pixels * (row + y)});
        }
    }
    return share;
}

// All lines of the shaft through the sphere, as seen along one stored direction: where the silhouette is the same all over
// them there is nothing to estimate.
Cover::Kind SilhouetteSums::proof(const LocalShaft& shaft, std::uint32_t line) const {
    Frame frame = frames_[line];
    const Vec3 axis = shaft.b - shaft.a;
    if (dot(axis, frame.line) < 0) frame.line = -frame.line;
    const double deep_a = reach(shaft.spread_a, frame.line), deep_b = reach(shaft.spread_b, frame.line);
    // Heights over the plane through the centre, and the places at which lines may pass it.
    const double below = -dot(shaft.a - centre_, frame.line), above = dot(shaft.b - centre_, frame.line);
    if (below <= deep_a || above <= deep_b) return Cover::Kind::Unknown;
    const double first = (below - deep_a) / (below - deep_a + above + deep_b);
    const double last = (below + deep_a) / (below + deep_a + above - deep_b);
    const double pixels = size_ / (2 * radius_), drop = dot(axis, frame.line) - deep_a - deep_b;
    if (!(drop > 0)) return Cover::Kind::Unknown;
    struct Range {
        double lo, hi;
    };
    const auto range = [&](const Vec3& u) {
        const double at_a = dot(shaft.a - centre_, u), at_b = dot(shaft.b - centre_, u);
        const double wide_a = reach(shaft.spread_a, u), wide_b = reach(shaft.spread_b, u);
        const auto between = [&](double t, double side) {
            return (1 - t) * (at_a + side * wide_a) + t * (at_b + side * wide_b);
        };
        // Inside the sphere a line leaves the place at which it passes the plane by its slope.
        const double slope = (std::abs(at_b - at_a) + wide_a + wide_b) / drop, aside = radius_ * slope;
        return Range{pixels * (std::min(between(first, -1), between(last, -1)) - aside + radius_),
                     pixels * (std::max(between(first, 1), between(last, 1)) + aside + radius_)};
    };
    const Range x = range(frame.right), y = range(frame.up);
    const double most = size_;
    const bool inside = x.lo >= 0 && y.lo >= 0 && x.hi <= most && y.hi <= most;
    if (x.hi <= 0 || y.hi <= 0 || x.lo >= most || y.lo >= most) return Cover::Kind::Clear;
    const auto low = [](double v) { return static_cast<std::uint32_t>(std::max(0.0, std::floor(v))); };
    const auto high = [&](double v) { return static_cast<std::uint32_t>(std::min(most, std::ceil(v))); };
    const std::uint32_t left = low(x.lo), bottom = low(y.lo), right = high(x.hi), top = high(y.hi), side = size_ + 1;
    const std::uint32_t* sum = sums_.data() + std::size_t{line} * side * side;
    const std::uint32_t covered = sum[top * side + right] - sum[top * side + left] - sum[bottom * side + right] + sum[bottom * side + left];
    if (covered == 0) return Cover::Kind::Clear;
    if (inside && covered == 255 * (right - left) * (top - bottom)) return Cover::Kind::Dark;
    return Cover::Kind::Partial;
}

// Lines lie in the hull of two spheres about the ends, and the object in one of its own.
bool SilhouetteSums::passes_by(const LocalShaft& shaft, const CrossSection& section) const {
    const auto radius = [](const std::array<Vec3, 3>& spread) {
        return std::sqrt(3.0) * (length(spread[0]) + length(spread[1]) + length(spread[2]));
    };
    const Vec3 nearest = shaft.a + (shaft.b - shaft.a) * std::clamp(section.t, 0.0, 1.0);
    const double reach = std::max(radius(shaft.spread_a), radius(shaft.spread_b)) + radius_;
    return length2(nearest - centre_) > reach * reach;
}

Cover SilhouetteSums::cover(const LocalShaft& shaft) const {
    Cover c;
    const Vec3 axis = shaft.b - shaft.a;
    if (!(length2(axis) > 0)) return c;
    const CrossSection section = cross_section(shaft, centre_);
    if (passes_by(shaft, section)) return {Cover::Kind::Clear, 0, 0};
    const double along = section.t * length(axis), rest = length(axis) - along;
    if (along - radius_ <= reach(shaft.spread_a, section.direction) || rest - radius_ <= reach(shaft.spread_b, section.direction))
        return c;
    const DirectionTaps taps = grid_.taps(section.direction);
    const auto nearest = static_cast<std::size_t>(std::max_element(taps.weight.begin(), taps.weight.end()) - taps.weight.begin());
    const Cover::Kind known = proof(shaft, grid_.line(taps.node[nearest]));
    if (known == Cover::Kind::Clear) return {known, 0, kClearError};
    if (known == Cover::Kind::Dark) return {known, 1, 0};
    if (section.narrow * grid_.n() < kNarrowest * radius_) return c;
    c.kind = Cover::Kind::Partial;
    c.share = std::clamp(blended_share(section, shaft), 0.0, 1.0);  // weights are floats
    const double partial = std::min(1.0, 4 * c.share * (1 - c.share) + kCertain);
    c.error = std::hypot(kBlendError, kEdgeError * radius_ / section.narrow) * std::sqrt(partial);
    return c;
}

}  // namespace rro
