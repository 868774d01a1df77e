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
constexpr double kQuickly = 1e-3;  // tolerance over open exchange from where two rules that agree are believed
constexpr double kSliver = 1e-13;   // of the emitter: less is left between blockers that share an edge by rounding
constexpr double kAlike = 2;        // quarters of a symmetric scene err alike: their errors do not quite add as squares
constexpr double kEdgeOn = 1e-12;   // sine below which a blocker is seen edge-on and hides nothing

/// Convex polygons one after another in one array, so that cutting them allocates nothing.
struct Pieces {
    std::vector<Vec3> points;
    std::vector<std::size_t> ends;

    void clear() {
        points.clear();
        ends.clear();
    }
    std::size_t begin(std::size_t piece) const { return piece == 0 ? 0 : ends[piece - 1]; }
    std::span<const Vec3> operator[](std::size_t piece) const {
        return std::span(points).subspan(begin(piece), ends[piece] - begin(piece));
    }
    void close(double least_area = 0) {  // what has been added since the last end is a piece, unless it is too small
        const std::size_t first = ends.empty() ? 0 : ends.back();
        Vec3 area;
        for (std::size_t k = first + 1; k + 1 < points.size(); ++k)
            area += area_vector(points[first], points[k], points[k + 1]);
        if (length2(area) > least_area * least_area)
            ends.push_back(points.size());
        else
            points.resize(first);
    }
};

/// A blocker between the two planes, with the ball around it.
struct Blocker {
    std::vector<Vec3> corners;
    Vec3 normal, centre;
    double radius = 0;
};

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
            if (rest.empty()) continue;
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
        left_.clear();
        left_.points.assign(b_.corners.begin(), b_.corners.end());
        left_.close();
        for (const Blocker& blocker : blockers_) {
            if (!edge_planes(x, blocker)) continue;
            hide(x);
            if (left_.ends.empty()) return 0;
        }
        // The outline of a solid has many edges: of the last one the part of each piece that it hides is subtracted.
        for (std::size_t k = 0; k + 1 < solids_.size(); ++k) {
            solids_[k].outline(x, turned_, inner_);
            hide(x);
        }
        if (!solids_.empty()) solids_.back().outline(x, turned_, inner_);
        double sum = 0;
        for (std::size_t piece = 0; piece < left_.ends.size(); ++piece) {
            sum += point_to_polygon(x, a_.normal, left_[piece]);
            if (!solids_.empty()) sum -= hidden(x, left_[piece]);
        }
        return std::max(0.0, sum);
    }

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

    /// The factor to the part of a piece inside all planes.
    double hidden(const Vec3& x, std::span<const Vec3> piece) {
        rest_.assign(piece.begin(), piece.end());
        if (beyond_one(x)) return 0;
        for (const Vec3& n : inner_) {
            clip_to_front(rest_, n, dot(n, x), inside_);
            std::swap(rest_, inside_);
            if (rest_.empty()) return 0;
        }
        return point_to_polygon(x, a_.normal, rest_);
    }

    /// Takes what is inside all planes out of what is left of b.
    void hide(const Vec3& x) {
        next_.clear();
        for (std::size_t piece = 0; piece < left_.ends.size(); ++piece) {
            rest_.assign(left_[piece].begin(), left_[piece].end());
            if (beyond_one(x)) {
                next_.points.insert(next_.points.end(), rest_.begin(), rest_.end());
                next_.close();
                continue;
            }
            for (const Vec3& n : inner_) {
                split(x, n);
                if (rest_.empty()) break;
            }
        }
        std::swap(left_, next_);
    }

    /// Does the piece lie outside one of the planes as a whole?
    bool beyond_one(const Vec3& x) const {
        return std::any_of(inner_.begin(), inner_.end(), [&](const Vec3& n) {
            return std::all_of(rest_.begin(), rest_.end(), [&](const Vec3& p) { return dot(n, p - x) <= 0; });
        });
    }

    /// What of the piece is outside the plane stays in sight; the inside goes on to the next plane.
    void split(const Vec3& x, const Vec3& n) {
        inside_.clear();
        Vec3 last = rest_.back();
        double last_height = dot(n, last - x);
        for (const Vec3& p : rest_) {
            const double height = dot(n, p - x);
            if ((height > 0) != (last_height > 0)) {
                const Vec3 cut = last + (p - last) * (last_height / (last_height - height));
                inside_.push_back(cut);
                next_.points.push_back(cut);
            }
            if (height > 0)
                inside_.push_back(p);
            else
                next_.points.push_back(p);
            last = p;
            last_height = height;
        }
        next_.close(kSliver * b_.area);
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
};

double estimate(Integrand& seen, const TriangleCorners& t, int points) {
    double sum = 0;
    for (const auto& node : triangle_rule(points).nodes) sum += node.weight * seen(triangle_point(t, node.b1, node.b2));
    return sum * length(area_vector(t));
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

/// Where the tolerance is a good part of the exchange, two rules on the whole triangle may do.
Part integrate(Integrand& seen, const TriangleCorners& t, double tolerance, bool quick) {
    const double value = estimate(seen, t, 7);
    if (quick)
        if (const double difference = std::abs(value - estimate(seen, t, 3)); difference <= tolerance)
            return {value, difference * difference};
    return refine(seen, t, value, tolerance, 0);
}

}  // namespace

double rough_exchange(const Polygon& a, const Polygon& b, const Obstacles& obstacles) {
    Integrand seen(a, b, obstacles);
    double sum = 0;
    for (std::size_t k = 1; k + 1 < a.corners.size(); ++k)
        sum += estimate(seen, {a.corners[0], a.corners[k], a.corners[k + 1]}, 3);
    return sum;
}

ObstructedExchange obstructed_exchange(const Polygon& a, const Polygon& b, const Obstacles& obstacles, double open,
                                       double tolerance) {
    Integrand seen(a, b, obstacles);
    Part part;
    const bool quick = tolerance >= kQuickly * open;
    for (std::size_t k = 1; k + 1 < a.corners.size(); ++k) {
        const TriangleCorners t{a.corners[0], a.corners[k], a.corners[k + 1]};
        const double share = length(area_vector(t)) / a.area;
        const Part of_triangle = integrate(seen, t, tolerance * std::sqrt(share), quick);
        part.value += of_triangle.value;
        part.error2 += of_triangle.error2;
    }
    return {part.value, kAlike * std::sqrt(part.error2)};
}

}  // namespace rro
