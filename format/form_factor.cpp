#include "format/form_factor.h"

#include <array>
#include <numbers>

#include "format/four.h"
#include "format/sample_points.h"

namespace rro {
namespace {

using std::numbers::pi;
constexpr double kPerTurn = 1 / (2 * pi);

/// Squared ratio of extent to distance below which a polygon is far. Here the contour formula has lost two digits, and
/// the area form errs by 1e-12; that error falls with the sixth power of the ratio.
constexpr double kFar2 = 0.02 * 0.02;

/// Squared distance, relative to the sizes at hand, below which rounding decides whether p is on a plane or a line.
constexpr double kTouching2 = 2e-15 * 2e-15;

/// atan(t) / t for t in [0, 1] as a polynomial in t^2: that of least error, 3e-17, by Chebyshev expansion.
constexpr std::array<double, 20> kArctangent{1.0,
                                             -3.33333333333307003e-1,
                                             1.99999999996479605e-1,
                                             -1.42857142669267329e-1,
                                             1.11111105780020827e-1,
                                             -9.09089979321734132e-2,
                                             7.69219899745829383e-2,
                                             -6.66576491068972266e-2,
                                             5.87682811448727235e-2,
                                             -5.23742347191881660e-2,
                                             4.66874530484852890e-2,
                                             -4.08112475031788546e-2,
                                             3.38712670270067476e-2,
                                             -2.55686236443717387e-2,
                                             1.67195960635073901e-2,
                                             -8.99108054265826059e-3,
                                             3.75113848396514118e-3,
                                             -1.12525443022346450e-3,
                                             2.14238107386039464e-4,
                                             -1.93423475928923002e-5};

template <class Real>
inline Real arctangent_ratio(Real t2) {
    const Real t4 = t2 * t2, t8 = t4 * t4;
    const auto& k = kArctangent;
    const auto every_fourth = [&](std::size_t i) -> Real {  // four short chains instead of a long one
        return (((k[16 + i] * t8 + k[12 + i]) * t8 + k[8 + i]) * t8 + k[4 + i]) * t8 + k[i];
    };
    return (every_fourth(0) + every_fourth(1) * t2) + (every_fourth(2) + every_fourth(3) * t2) * t4;
}

/// angle / |c| of two vectors with dot product d and cross product c, from c2 = |c|^2: atan2(|c|, d) by the tangent of
/// half the acute angle between their lines. Opposite vectors (c2 = 0, d < 0) span no plane and give 0.
template <class Real>
inline Real angle_over_sine(Real c2, Real d) {
    const Real magnitude = d < 0.0 ? -d : d;
    const Real sum = root(c2 + d * d) + magnitude;  // 0 where a vector is: any angle will do
    const Real half = 1.0 / (sum > 0.0 ? sum : sum + 1.0);  // tan(angle / 2) / |c|
    const Real acute = 2.0 * half * arctangent_ratio(c2 * half * half);
    return d >= 0.0 ? acute : c2 > 0.0 ? pi / root(c2) - acute : c2;
}

/// Gamma of the edge from a to b as seen from the origin: the angle times the unit normal of the plane of both, which
/// points to the inside of a contour that runs counter-clockwise.
inline Vec3 edge_vector(const Vec3& a, const Vec3& b) {
    const Vec3 c = cross(b - a, a);  // b x a, but exact to the last digits when b is near a
    return c * angle_over_sine(length2(c), dot(a, b));
}

/// Gamma of four edges. One without length has none.
inline FourVec3 edge_vectors(const FourVec3& a, const FourVec3& b) {
    const FourVec3 c = cross(b - a, a);
    const Four c2 = dot(c, c), d = dot(a, b);
    if (bits_of((d > 0.0) & (c2 <= d * d)) == kAllFour) {  // the usual case, all angles below pi / 4, needs no roots
        const Four inverse = 1.0 / d;
        return c * (inverse * arctangent_ratio(c2 * inverse * inverse));
    }
    return c * angle_over_sine(c2, d);
}

/// Gamma of the edges of a closed contour of four corners. Equal neighbours have none.
inline FourVec3 edge_vectors(const FourVec3& a) {
    return edge_vectors(a, {__builtin_shufflevector(a.x, a.x, 1, 2, 3, 0), __builtin_shufflevector(a.y, a.y, 1, 2, 3, 0),
                            __builtin_shufflevector(a.z, a.z, 1, 2, 3, 0)});
}

/// Sum of Gamma over a closed contour whose corners come one by one. Only their directions count.
class ContourSum {
  public:
    void add(const Vec3& v) {
        if (started_) {
            sum_ += edge_vector(last_, v);
        } else {
            first_ = v;
            started_ = true;
        }
        last_ = v;
    }
    Vec3 closed() const { return started_ ? sum_ + edge_vector(last_, first_) : Vec3{}; }

  private:
    Vec3 first_, last_, sum_;
    bool started_ = false;
};

/// The same over the part of the contour above the plane through the origin with normal n. What is on the plane but for
/// rounding counts as above, as a contour that passes along the horizon must keep its corners there.
class ClippedContourSum {
  public:
    explicit ClippedContourSum(const Vec3& n) : n_(n) {}
    void add(const Vec3& v) {
        const double height = dot(n_, v);
        const Corner corner{v, height, height >= 0 || height * height <= kTouching2 * length2(v)};
        if (started_)
            go_to(corner);
        else
            first_ = corner;
        last_ = corner;
        started_ = true;
    }
    Vec3 closed() {
        if (started_) go_to(first_);
        return above_.closed();
    }

  private:
    struct Corner {
        Vec3 v;
        double height;
        bool above;
    };
    void go_to(const Corner& next) {
        if (last_.above != next.above) {
            const double fall = last_.height - next.height;
            const double share = fall == 0 ? 0 : std::clamp(last_.height / fall, 0.0, 1.0);
            above_.add(last_.v + (next.v - last_.v) * share);
        }
        if (next.above) above_.add(next.v);
    }

    Vec3 n_;
    Corner first_{}, last_{};
    bool started_ = false;
    ContourSum above_;
};

template <class Sum>
Vec3 contour_of(const Vec3& p, std::span<const Vec3> polygon, Sum sum) {
    for (const Vec3& corner : polygon) sum.add(corner - p);
    return sum.closed();
}

/// The contour as seen from just in front of p, which is on the polygon's plane: an edge or corner through p passes
/// along the nadir. A point beside the edges sees nothing.
template <class Sum>
Vec3 touching_contour_of(const Vec3& p, std::span<const Vec3> polygon, const Vec3& nadir, Sum sum) {
    bool touches = false;
    for (std::size_t k = 0; k < polygon.size(); ++k) {
        const Vec3 a = polygon[k] - p, b = polygon[(k + 1) % polygon.size()] - p;
        const double edge2 = length2(b - a), near2 = kTouching2 * (edge2 + length2(p));
        const bool at_a = length2(a) <= near2, at_b = length2(b) <= near2;
        const bool between = !at_a && !at_b && dot(a, b) < 0 && length2(cross(a, b)) <= near2 * edge2;
        sum.add(at_a ? nadir : a);
        if (between) sum.add(nadir);
        touches = touches || at_a || between;
    }
    return touches ? sum.closed() : Vec3{};
}

/// The side of a plane on which p is. `normal` may have any length; `volume` is the height of p times that length.
enum class Side { front, on, behind };
inline Side side_of(double volume, const Vec3& normal, const Vec3& to_plane, const Vec3& p) {
    if (volume * volume <= kTouching2 * length2(normal) * (length2(to_plane) + length2(p))) return Side::on;
    return volume > 0 ? Side::front : Side::behind;
}

inline bool is_far(double extent2, const Vec3& v) {
    return extent2 <= kFar2 * length2(v);
}

/// Rounding must not leave [0, 1]; NaN gives 0.
inline double as_share(double f) {
    return f > 0 ? std::min(f, 1.0) : 0;
}

/// The rule of degree 5, its 7 nodes padded to two Fours by one of no weight.
struct FarRule {
    std::array<Four, 2> b1{}, b2{}, weight{};
};
const FarRule kFarRule = [] {
    FarRule rule;
    std::size_t i = 0;
    for (const auto& node : triangle_rule(7).nodes) {
        rule.b1[i / 4][i % 4] = node.b1;
        rule.b2[i / 4][i % 4] = node.b2;
        rule.weight[i / 4][i % 4] = node.weight;
        ++i;
    }
    return rule;
}();

/// Terms of the vector irradiance, (1/pi) integral of w cos / r^2, of the triangle v, v + e1, v + e2 as seen from the
/// origin, which is volume / |e1 x e2| in front of it. The height is a factor, so that grazing views keep their digits.
inline FourVec3 far_terms(const Vec3& v, const Vec3& e1, const Vec3& e2, double volume) {
    const auto of_nodes = [&](std::size_t i) {
        const Four b1 = kFarRule.b1[i], b2 = kFarRule.b2[i];
        const FourVec3 at{v.x + b1 * e1.x + b2 * e2.x, v.y + b1 * e1.y + b2 * e2.y, v.z + b1 * e1.z + b2 * e2.z};
        const Four r2 = dot(at, at);
        return at * (volume * kPerTurn * kFarRule.weight[i] / (r2 * r2));
    };
    return of_nodes(0) + of_nodes(1);
}

/// A triangle cut by a plane; three corners are filled up by the first once more, which leaves contour and fan alone.
using CutTriangle = std::array<Vec3, 4>;

/// The part of t where the linear function with these values at its corners is above 0; if none is, four equal corners.
CutTriangle part_above(const TriangleCorners& t, const std::array<double, 3>& height) {
    CutTriangle part;
    std::size_t count = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t j = (i + 1) % 3;
        if (height[i] > 0) part[count++] = t[i];
        if ((height[i] > 0) != (height[j] > 0))
            part[count++] = t[i] + (t[j] - t[i]) * (height[i] / (height[i] - height[j]));
    }
    if (count == 3) part[3] = part[0];
    return part;
}

inline FourVec3 four_of(const CutTriangle& c) {
    return {Four{c[0].x, c[1].x, c[2].x, c[3].x}, Four{c[0].y, c[1].y, c[2].y, c[3].y},
            Four{c[0].z, c[1].z, c[2].z, c[3].z}};
}

/// Form factor of a far triangle, negative from behind. What the horizon cuts off is cut in barycentric coordinates:
/// there areas keep the digits that corners relative to a far point have lost.
inline double far_share(const Vec3& n, const Vec3& v, const Vec3& e1, const Vec3& e2, double volume) {
    const std::array<double, 3> height{dot(n, v), dot(n, v + e1), dot(n, v + e2)};
    if (height[0] > 0 && height[1] > 0 && height[2] > 0) return sum_of(dot(n, far_terms(v, e1, e2, volume)));
    if (height[0] <= 0 && height[1] <= 0 && height[2] <= 0) return 0;
    const CutTriangle part = part_above({Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{0, 1, 0}}, height);
    const auto edge = [&](const Vec3& from, const Vec3& to) { return e1 * (to.x - from.x) + e2 * (to.y - from.y); };
    const Vec3 first = v + edge({}, part[0]);
    double sum = 0;
    for (std::size_t k = 1; k < 3; ++k) {
        const double share = cross(part[k] - part[0], part[k + 1] - part[0]).z;
        sum += sum_of(dot(n, far_terms(first, edge(part[0], part[k]), edge(part[0], part[k + 1]), volume * share)));
    }
    return sum;
}

/// What the formulas ask of a planar polygon as a whole.
struct PolygonView {
    Vec3 normal;     // twice its area vector
    double extent2;  // greatest squared distance of a corner from the first
    Side side;       // of the point
};

PolygonView view_of(const Vec3& p, std::span<const Vec3> polygon) {
    const Vec3 origin = polygon.empty() ? Vec3{} : polygon[0];
    PolygonView view{{}, 0, Side::on};
    for (std::size_t k = 1; k + 1 < polygon.size(); ++k)
        view.normal += cross(polygon[k] - origin, polygon[k + 1] - origin);
    for (const Vec3& corner : polygon) view.extent2 = std::max(view.extent2, length2(corner - origin));
    view.side = side_of(dot(p - origin, view.normal), view.normal, origin - p, p);
    return view;
}

/// Sum of a function of the triangles of a fan, each as its first corner seen from p, two edges, and volume with p.
template <class Value, class PerTriangle>
Value sum_of_fan(const Vec3& p, std::span<const Vec3> polygon, PerTriangle&& value) {
    Value sum{};
    for (std::size_t k = 1; k + 1 < polygon.size(); ++k) {
        const Vec3 v = polygon[0] - p, e1 = polygon[k] - polygon[0], e2 = polygon[k + 1] - polygon[0];
        sum += value(v, e1, e2, -dot(v, cross(e1, e2)));
    }
    return sum;
}

/// The rare case of p on the polygon's plane, out of the way of the hot loop.
[[gnu::noinline]] double touching_share(const Vec3& p, const Vec3& n, std::span<const Vec3> polygon,
                                        const Vec3& normal) {
    if (length2(normal) == 0) return 0;
    return as_share(dot(n, touching_contour_of(p, polygon, -normalised(normal), ClippedContourSum(n))) * kPerTurn);
}

}  // namespace

double point_to_polygon(const Vec3& p, const Vec3& n, std::span<const Vec3> polygon) {
    const PolygonView view = view_of(p, polygon);
    if (view.side == Side::behind) return 0;
    if (view.side == Side::on) return touching_share(p, n, polygon, view.normal);
    if (is_far(view.extent2, polygon[0] - p))
        return as_share(
            sum_of_fan<double>(p, polygon, [&](const auto&... triangle) { return far_share(n, triangle...); }));
    return as_share(dot(n, contour_of(p, polygon, ClippedContourSum(n))) * kPerTurn);
}

double point_to_triangle(const Vec3& p, const Vec3& n, const TriangleCorners& t) {
    const Vec3 v0 = t[0] - p, e1 = t[1] - t[0], e2 = t[2] - t[0];
    const Vec3 normal = cross(e1, e2);
    const double volume = -dot(v0, normal);
    const Side side = side_of(volume, normal, v0, p);
    if (side == Side::behind) return 0;
    if (side == Side::on) return touching_share(p, n, t, normal);

    if (is_far(std::max(length2(e1), length2(e2)), v0)) return as_share(far_share(n, v0, e1, e2, volume));
    FourVec3 seen = four_of({t[0], t[1], t[2], t[0]}) - four_of({p, p, p, p});
    const Four height = dot(n, seen);
    const int above = bits_of(height > 0.0);
    if (above == 0) return 0;
    if (above != kAllFour) seen = four_of(part_above({v0, t[1] - p, t[2] - p}, {height[0], height[1], height[2]}));
    return as_share(sum_of(dot(n, edge_vectors(seen))) * kPerTurn);
}

double point_to_polygon_above(const Vec3& p, const Vec3& n, std::span<const Vec3> polygon) {
    const std::size_t count = polygon.size();
    Four sum{};
    for (std::size_t first = 0; first < count; first += 4) {
        FourVec3 from{}, to{};
        for (std::size_t lane = 0; lane < 4; ++lane) {  // the contour closes; what fills up has no length
            const Vec3 a = polygon[first + lane < count ? first + lane : 0] - p;
            const Vec3 b = polygon[first + lane + 1 < count ? first + lane + 1 : 0] - p;
            from.x[lane] = a.x, from.y[lane] = a.y, from.z[lane] = a.z;
            to.x[lane] = b.x, to.y[lane] = b.y, to.z[lane] = b.z;
        }
        sum += dot(n, edge_vectors(from, to));
    }
    return as_share(sum_of(sum) * kPerTurn);
}

Vec3 polygon_vector_irradiance(const Vec3& p, std::span<const Vec3> polygon) {
    const PolygonView view = view_of(p, polygon);
    if (view.side == Side::behind || length2(view.normal) == 0) return {};
    if (view.side == Side::on)
        return touching_contour_of(p, polygon, -normalised(view.normal), ContourSum()) * kPerTurn;
    if (is_far(view.extent2, polygon[0] - p))
        return sum_of_fan<Vec3>(p, polygon, [](const auto&... triangle) { return sum_of(far_terms(triangle...)); });
    return contour_of(p, polygon, ContourSum()) * kPerTurn;
}

double disk_to_disk(double r1, double r2) {
    const double difference = r1 - r2, sum = r1 + r2;
    const double y = 1 + r1 * r1 + r2 * r2;
    return 2 * r2 * r2 / (y + std::sqrt((1 + difference * difference) * (1 + sum * sum)));
}

namespace {

/// Quadrature of F(x -> b) over parts of one triangle with unit normal n.
class Exchange {
  public:
    Exchange(const Vec3& n, const TriangleCorners& b) : n_(n), b_(b), rule_(triangle_rule(16)) {}

    double estimate(const TriangleCorners& t) const {
        const double area = length(area_vector(t));
        if (area == 0) return 0;
        double sum = 0;
        for (const auto& [b1, b2, weight] : rule_.nodes)
            sum += weight * point_to_triangle(triangle_point(t, b1, b2), n_, b_);
        return area * sum;
    }

    /// Quarters t until that moves the value by less than `allowed`. The four parts get twice that between them: parts
    /// that still move are few, about a touching corner or along a touching edge.
    double refined(const TriangleCorners& t, double coarse, double allowed, int depth) const {
        if (depth == 0) return coarse;
        const Vec3 m01 = 0.5 * (t[0] + t[1]), m12 = 0.5 * (t[1] + t[2]), m20 = 0.5 * (t[2] + t[0]);
        const std::array<TriangleCorners, 4> parts{
            {{t[0], m01, m20}, {m01, t[1], m12}, {m20, m12, t[2]}, {m01, m12, m20}}};
        std::array<double, 4> values{};
        double fine = 0;
        for (std::size_t i = 0; i < parts.size(); ++i) fine += values[i] = estimate(parts[i]);
        if (std::abs(fine - coarse) <= allowed) return fine;
        double sum = 0;
        for (std::size_t i = 0; i < parts.size(); ++i) sum += refined(parts[i], values[i], 0.5 * allowed, depth - 1);
        return sum;
    }

  private:
    Vec3 n_;
    TriangleCorners b_;
    TriangleRule rule_;
};

/// The part of t in front of the plane of b. All its points see b's front, so that F has no kink inside it.
CutTriangle part_in_front(const TriangleCorners& t, const TriangleCorners& b) {
    const Vec3 normal = area_vector(b);
    std::array<double, 3> height{};
    for (std::size_t i = 0; i < 3; ++i) {
        const double volume = dot(t[i] - b[0], normal);
        height[i] = side_of(volume, normal, t[i] - b[0], t[i]) == Side::on ? 0 : volume;
    }
    return part_above(t, height);
}

}  // namespace

double exchange_area(const TriangleCorners& a, const TriangleCorners& b, double tolerance, int max_depth) {
    // Over the smaller one: a large one may see a small one from so few places that no node of a rule is among them.
    if (length2(area_vector(b)) < length2(area_vector(a))) return exchange_area(b, a, tolerance, max_depth);
    const Exchange exchange(normalised(area_vector(a)), b);
    const CutTriangle part = part_in_front(a, b);
    const TriangleCorners first{part[0], part[1], part[2]}, second{part[2], part[3], part[0]};
    const double coarse1 = exchange.estimate(first), coarse2 = exchange.estimate(second);
    const double rounding = 1e-14 * length(area_vector(a));  // where b is just below the horizon, F is nothing else
    const double allowed = std::max(tolerance * (coarse1 + coarse2), rounding);
    return exchange.refined(first, coarse1, allowed, max_depth) + exchange.refined(second, coarse2, allowed, max_depth);
}

}  // namespace rro
