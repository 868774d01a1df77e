#include "solver/factors/obstructed.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "format/form_factor.h"
#include "format/sample_points.h"

namespace rro {
namespace {

constexpr int kMostDepth = 9;       // quarterings by disagreement
constexpr int kMostForcedDepth = 6;  // and because of small blockers near by
constexpr double kSliver = 1e-13;   // of the emitter: less is left between blockers that share an edge by rounding
constexpr double kAlike = 2;        // quarters of a symmetric scene err alike: their errors do not quite add as squares
constexpr double kEdgeOn = 1e-12;   // sine below which a blocker is seen edge-on and hides nothing

/// Convex polygons one after another in one array that only grows, so that cutting them allocates nothing.
class Pieces {
  public:
    void clear() {
        used_ = 0;
        ends_.clear();
    }
    std::size_t size() const { return ends_.size(); }
    bool empty() const { return ends_.empty(); }
    std::span<const Vec3> operator[](std::size_t piece) const {
        const std::size_t begin = piece == 0 ? 0 : ends_[piece - 1];
        return {points_.data() + begin, ends_[piece] - begin};
    }
    /// Room for the corners of one more piece; `close` says how many it has got.
    Vec3* room(std::size_t corners) {
        if (points_.size() < used_ + corners) points_.resize(2 * (used_ + corners));
        return points_.data() + used_;
    }
    void close(std::size_t corners, double least_area) {  // dropped if it is too small
        if (corners < 3) return;
        const Vec3* piece = points_.data() + used_;
        Vec3 area;
        for (std::size_t k = 1; k + 1 < corners; ++k) area += area_vector(piece[0], piece[k], piece[k + 1]);
        if (length2(area) <= least_area * least_area) return;
        used_ += corners;
        ends_.push_back(used_);
    }
    void add(std::span<const Vec3> piece) {
        std::copy(piece.begin(), piece.end(), room(piece.size()));
        used_ += piece.size();
        ends_.push_back(used_);
    }

  private:
    std::vector<Vec3> points_;
    std::vector<std::size_t> ends_;
    std::size_t used_ = 0;
};

/// A blocker between the two planes, with the ball around it.
struct Blocker {
    std::vector<Vec3> corners;
    Vec3 normal, centre;
    double radius = 0;
};

// Corners of doubles nearer than this part of their coordinates are one.
constexpr double kOnePlace = 0x1p-49;

/// Clipping where an edge runs in the plane leaves corners a rounding apart, or at one place: an edge between them has no
/// direction, and a plane through it hides nothing or anything.
void drop_short_edges(std::vector<Vec3>& corners) {
    double largest = 0;
    for (const Vec3& c : corners) largest = std::max({largest, std::abs(c.x), std::abs(c.y), std::abs(c.z)});
    const auto same = [&](const Vec3& a, const Vec3& b) { return length(b - a) <= kOnePlace * largest; };
    corners.erase(std::unique(corners.begin(), corners.end(), same), corners.end());
    while (corners.size() > 1 && same(corners.back(), corners.front())) corners.pop_back();
}

/// What a point sees of b: all of it, less what each blocker hides of what the ones before it have left.
class Integrand {
  public:
    Integrand(const Polygon& a, const Polygon& b, const Obstacles& obstacles) : a_(a), b_(b) {
        for (const Solid* solid : obstacles.solids)  // what is behind b hides nothing of it
            solids_.push_back(solid->in_front_of(b.normal, b.offset) ? *solid : solid->in_front(b.normal, b.offset));
        std::vector<Vec3> part, rest;
        for (const Polygon* blocker : obstacles.bodies) {
            clip_to_front(blocker->corners, a.normal, a.offset, part);
            if (part.empty()) continue;
            clip_to_front(part, b.normal, b.offset, rest);
            drop_short_edges(rest);
            if (rest.size() < 3) continue;
            Blocker between{rest, blocker->normal, {}, 0};
            for (const Vec3& c : rest) between.centre += c / static_cast<double>(rest.size());
            for (const Vec3& c : rest) between.radius = std::max(between.radius, length(c - between.centre));
            blockers_.push_back(std::move(between));
        }
        // Large ones first: they leave little for the others to cut.
        std::stable_sort(blockers_.begin(), blockers_.end(),
                         [](const Blocker& x, const Blocker& y) { return x.radius > y.radius; });
    }

    /// The factor from a point of a to what it sees of b.
    double operator()(const Vec3& x) {
        double hidden = 0;
        left_.clear();
        left_.add(b_.corners);
        for (std::size_t k = 0; k < blockers_.size() && !left_.empty(); ++k)
            if (edge_planes(x, blockers_[k])) hidden += hide(x);
        for (std::size_t k = 0; k < solids_.size() && !left_.empty(); ++k) {
            solids_[k].outline(x, turned_, inner_);
            hidden += hide(x);
        }
        hid_some_ = hid_some_ || hidden > 0;
        saw_some_ = saw_some_ || !left_.empty();
        return left_.empty() ? 0 : std::max(0.0, point_to_polygon_above(x, a_.normal, b_.corners) - hidden);
    }

    /// Whether all points so far saw all of b, or none of it: then no rule can tell its error.
    bool always_alike() const { return !hid_some_ || !saw_some_; }

    /// Whether a blocker near a triangle is too small for its nodes to notice.
    bool may_miss(const Vec3& centre, double radius) const {
        return std::any_of(blockers_.begin(), blockers_.end(), [&](const Blocker& blocker) {
            return blocker.radius < radius && length(blocker.centre - centre) < radius + 2 * blocker.radius;
        });
    }

  private:
    /// Sets the inner normals of the planes through x and the edges of a blocker; false where it is seen edge-on.
    bool edge_planes(const Vec3& x, const Blocker& blocker) {
        const double height = dot(blocker.normal, x - blocker.centre);
        if (std::abs(height) <= kEdgeOn * length(x - blocker.centre)) return false;
        inner_.clear();
        for (std::size_t k = 0; k < blocker.corners.size(); ++k) {
            const Vec3 from = blocker.corners[k] - x;
            const Vec3 to = blocker.corners[k + 1 == blocker.corners.size() ? 0 : k + 1] - x;
            const Vec3 n = cross(from, to);
            inner_.push_back(height > 0 ? -n : n);
        }
        return true;
    }

    /// Takes what is inside all planes out of what is left of b.
    /// returns  the factor to that
    double hide(const Vec3& x) {
        double hidden = 0;
        bool same = true;  // nothing has been taken yet: the pieces stay where they are
        for (std::size_t piece = 0; piece < left_.size(); ++piece) {
            const bool stays = beyond_one(x, left_[piece]);
            if (same && stays) continue;
            if (same) {
                next_.clear();
                for (std::size_t before = 0; before < piece; ++before) next_.add(left_[before]);
                same = false;
            }
            if (stays) {
                next_.add(left_[piece]);
                continue;
            }
            rest_.assign(left_[piece].begin(), left_[piece].end());
            for (const Vec3& n : inner_) {
                split(x, n);
                if (rest_.empty()) break;
            }
            if (!rest_.empty()) hidden += point_to_polygon_above(x, a_.normal, rest_);
        }
        if (!same) std::swap(left_, next_);
        return hidden;
    }

    /// Does the piece lie outside one of the planes as a whole?
    bool beyond_one(const Vec3& x, std::span<const Vec3> piece) const {
        return std::any_of(inner_.begin(), inner_.end(), [&](const Vec3& n) {
            return std::all_of(piece.begin(), piece.end(), [&](const Vec3& p) { return dot(n, p - x) <= 0; });
        });
    }

    /// What of the rest is outside the plane stays in sight; the inside goes on to the next plane.
    void split(const Vec3& x, const Vec3& n) {
        heights_.resize(rest_.size());
        bool all_inside = true;
        for (std::size_t k = 0; k < rest_.size(); ++k) {
            heights_[k] = dot(n, rest_[k] - x);
            all_inside = all_inside && heights_[k] > 0;
        }
        if (all_inside) return;
        inside_.resize(2 * rest_.size());
        Vec3* in = inside_.data();
        Vec3* const outside = next_.room(2 * rest_.size());
        Vec3* out = outside;
        std::size_t last = rest_.size() - 1;
        for (std::size_t k = 0; k < rest_.size(); last = k++) {
            if ((heights_[k] > 0) != (heights_[last] > 0))
                *in++ = *out++ = rest_[last] + (rest_[k] - rest_[last]) * (heights_[last] / (heights_[last] - heights_[k]));
            (heights_[k] > 0 ? *in++ : *out++) = rest_[k];
        }
        next_.close(static_cast<std::size_t>(out - outside), kSliver * b_.area);
        inside_.resize(static_cast<std::size_t>(in - inside_.data()));
        if (inside_.size() < 3) inside_.clear();
        std::swap(rest_, inside_);
    }

    const Polygon& a_;
    const Polygon& b_;
    std::vector<Blocker> blockers_;
    std::vector<Solid> solids_;
    std::vector<std::uint8_t> turned_;
    Pieces left_, next_;
    std::vector<Vec3> inner_, rest_, inside_;
    std::vector<double> heights_;
    bool hid_some_ = false, saw_some_ = false;
};

/// The exchange by the nodes of a rule over the whole polygon.
double estimate(Integrand& seen, const PolygonRule& rule) {
    double sum = 0;
    for (std::uint32_t i = 0; i < rule.count; ++i) {
        const FourVec3& at = rule.nodes[i / 4];
        const std::size_t lane = i % 4;
        sum += rule.weights[i / 4][lane] * seen({at.x[lane], at.y[lane], at.z[lane]});
    }
    return sum;
}

double estimate(Integrand& seen, const TriangleCorners& t, int points) {
    double sum = 0;
    for (const auto& node : triangle_rule(points).nodes) sum += node.weight * seen(triangle_point(t, node.b1, node.b2));
    return sum * length(area_vector(t));
}

/// Whether b is seen otherwise from somewhere near the corners of a than from all points so far. (What one convex blocker
/// hides from all corners it hides from all of a.)
bool corners_differ(Integrand& seen, const Polygon& a) {
    constexpr double kInwards = 1e-3;  // on a corner itself, which b may touch, no factor is defined
    return std::any_of(a.corners.begin(), a.corners.end(), [&](const Vec3& corner) {
        seen(corner + (a.centre - corner) * kInwards);
        return !seen.always_alike();
    });
}

/// value and the square of its error
struct Part {
    double value = 0, error2 = 0;
};

/// Quarters a triangle until its value, by the rule of degree 5, is that of its quarters.
Part refine(Integrand& seen, const TriangleCorners& t, double value, double tolerance, int depth) {
    const Vec3 ab = (t[0] + t[1]) * 0.5, bc = (t[1] + t[2]) * 0.5, ca = (t[2] + t[0]) * 0.5;
    const std::array<TriangleCorners, 4> quarters{{{t[0], ab, ca}, {ab, t[1], bc}, {ca, bc, t[2]}, {ab, bc, ca}}};
    std::array<double, 4> values{};
    for (std::size_t k = 0; k < 4; ++k) values[k] = estimate(seen, quarters[k], 7);
    const double sum = (values[0] + values[1]) + (values[2] + values[3]), difference = std::abs(sum - value);
    const Vec3 centre = (t[0] + t[1] + t[2]) / 3;
    const double radius = std::sqrt(std::max({length2(t[0] - centre), length2(t[1] - centre), length2(t[2] - centre)}));
    const bool agree = difference <= tolerance || depth >= kMostDepth;
    if (agree && (depth >= kMostForcedDepth || !seen.may_miss(centre, radius))) return {sum, difference * difference};
    Part part;
    for (std::size_t k = 0; k < 4; ++k) {  // errors add as squares: each quarter may have half
        const Part of_quarter = refine(seen, quarters[k], values[k], tolerance / 2, depth + 1);
        part.value += of_quarter.value;
        part.error2 += of_quarter.error2;
    }
    return part;
}

}  // namespace

double rough_exchange(const Polygon& a, const Polygon& b, const Obstacles& obstacles) {
    Integrand seen(a, b, obstacles);
    return estimate(seen, a.coarse);
}

ObstructedExchange obstructed_exchange(const Polygon& a, const Polygon& b, const Obstacles& obstacles,
                                       double tolerance, bool quick) {
    Integrand seen(a, b, obstacles);
    if (quick) {
        const double value = estimate(seen, a.fine), difference = std::abs(value - estimate(seen, a.coarse));
        if (difference <= tolerance / 2 && !(seen.always_alike() && corners_differ(seen, a)))
            return {value, 2 * kAlike * difference};
    }
    Part part;
    for (std::size_t k = 1; k + 1 < a.corners.size(); ++k) {
        const TriangleCorners t{a.corners[0], a.corners[k], a.corners[k + 1]};
        const double share = length(area_vector(t)) / a.area;
        const Part of_triangle = refine(seen, t, estimate(seen, t, 7), tolerance * std::sqrt(share), 0);
        part.value += of_triangle.value;
        part.error2 += of_triangle.error2;
    }
    return {part.value, kAlike * std::sqrt(part.error2)};
}

}  // namespace rro
