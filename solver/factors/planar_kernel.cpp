#include "solver/factors/planar_kernel.h"

#include <cmath>
#include <numbers>

#include "format/form_factor.h"
#include "format/sample_points.h"

namespace rro {
namespace {

using std::numbers::pi;

// Largest ratio of both radii to the distance between centres at which products of rules keep 2e-7, as measured on
// random triangles and parallelograms, slender and grazing ones included.
constexpr double kCoarseRatio = 0.01, kFineRatio = 0.1, kFinestRatio = 0.22;
constexpr std::uint32_t kManyNodes = 64;  // of both rules' product: more cost more than exact points
// Largest ratio of one radius to the distance at which a rule over that polygon keeps 1e-7, without and with quartering.
constexpr double kPointRatio = 0.25, kQuarteredRatio = 0.5;

/// Sum over pairs of nodes of w w' cos cos' / (pi r^2).
double rule_product(const Polygon& a, const PolygonRule& ra, const Polygon& b, const PolygonRule& rb) {
    Four sum{};
    for (std::uint32_t i = 0; i < ra.count; ++i) {
        const FourVec3& from = ra.nodes[i / 4];
        const Vec3 x{from.x[i % 4], from.y[i % 4], from.z[i % 4]};
        Four part{};
        for (std::size_t j = 0; j < rb.nodes.size(); ++j) {
            const FourVec3 r{rb.nodes[j].x - x.x, rb.nodes[j].y - x.y, rb.nodes[j].z - x.z};
            const Four r2 = dot(r, r);
            part += rb.weights[j] * dot(a.normal, r) * dot(b.normal, r) / (r2 * r2);
        }
        sum -= part * ra.weights[i / 4][i % 4];
    }
    return sum_of(sum) / pi;
}

/// A triangle's rule of the exact factor to a polygon, the triangle quartered `depth` times.
double point_rule(const TriangleCorners& t, const Vec3& normal, std::span<const Vec3> polygon, int depth) {
    if (depth > 0) {
        const Vec3 ab = (t[0] + t[1]) * 0.5, bc = (t[1] + t[2]) * 0.5, ca = (t[2] + t[0]) * 0.5;
        return point_rule({t[0], ab, ca}, normal, polygon, depth - 1) + point_rule({ab, t[1], bc}, normal, polygon, depth - 1) +
               point_rule({ca, bc, t[2]}, normal, polygon, depth - 1) + point_rule({ab, bc, ca}, normal, polygon, depth - 1);
    }
    double sum = 0;
    for (const auto& node : triangle_rule(16).nodes)
        sum += node.weight * point_to_polygon_above(triangle_point(t, node.b1, node.b2), normal, polygon);
    return sum * length(area_vector(t));
}

double polygon_rule(const Polygon& small, const Polygon& other, int depth) {
    double sum = 0;
    for (std::size_t k = 1; k + 1 < small.corners.size(); ++k)
        sum += point_rule({small.corners[0], small.corners[k], small.corners[k + 1]}, small.normal, other.corners, depth);
    return sum;
}

/// Kronrod's 15 nodes on [-1, 1] (the non-negative ones) with their weights, and those of the 7 of Gauss among them.
constexpr std::array<double, 8> kNodes{0.991455371120812639206854697526329, 0.949107912342758524526189684047851,
                                       0.864864423359769072789712788640926, 0.741531185599394439863864773280788,
                                       0.586087235467691130294144691258080, 0.405845151377397166906606412076961,
                                       0.207784955007898467600689403773245, 0.0};
constexpr std::array<double, 8> kKronrod{0.022935322010529224963732008058970, 0.063092092629978553290700663189204,
                                         0.104790010322250183839876322541518, 0.140653259715525918745189590510238,
                                         0.169004726639267902826583426598550, 0.190350578064785409913256402421014,
                                         0.204432940075298892414161999234649, 0.209482141084727828012999174891714};
constexpr std::array<double, 4> kGauss{0.129484966168869693270611432679082, 0.279705391489276667901467771423780,
                                       0.381830050505118944950369775488975, 0.417959183673469387755102040816327};

/// One edge against another: the integral of ln(r / unit) over both, per m of each.
class EdgePair {
  public:
    EdgePair(const Vec3& a0, const Vec3& a1, const Vec3& b0, const Vec3& b1, double unit)
        : from_(a0), step_(a1 - a0), to_(b0), along_(normalised(b1 - b0)), length_(length(b1 - b0)),
          per_unit2_(1 / (unit * unit)) {}

    /// The double integral; the outer one until a rule's two halves agree to `tolerance` (m^2).
    double integral(double tolerance) const { return part(0, 1, tolerance / length(step_), 0) * length(step_); }

  private:
    static constexpr int kDepth = 40;  // here a part is a rounding of the whole

    /// Integral of ln(r / unit) over the second edge as seen from a point, in closed form.
    double inner(double s) const {
        const Vec3 to_start = to_ - (from_ + step_ * s);
        const double u0 = dot(to_start, along_), u1 = u0 + length_;
        const double h2 = length2(to_start - along_ * u0), h = std::sqrt(h2);
        const auto term = [&](double u) {
            const double r2 = (u * u + h2) * per_unit2_;
            return r2 > 0 ? u * (0.5 * std::log(r2) - 1) : 0;
        };
        return term(u1) - term(u0) + (h > 0 ? h * std::atan2(h * length_, h2 + u0 * u1) : 0);
    }

    double part(double begin, double end, double tolerance, int depth) const {
        const double middle = 0.5 * (begin + end), half = 0.5 * (end - begin);
        double kronrod = kKronrod[7] * inner(middle), gauss = kGauss[3] * (kronrod / kKronrod[7]);
        for (std::size_t k = 0; k < 7; ++k) {
            const double pair = inner(middle - half * kNodes[k]) + inner(middle + half * kNodes[k]);
            kronrod += kKronrod[k] * pair;
            if (k % 2 == 1) gauss += kGauss[k / 2] * pair;
        }
        if (std::abs(kronrod - gauss) * half <= tolerance || depth == kDepth) return kronrod * half;
        return part(begin, middle, tolerance, depth + 1) + part(middle, end, tolerance, depth + 1);
    }

    Vec3 from_, step_, to_, along_;
    double length_, per_unit2_;
};

double perimeter(std::span<const Vec3> p) {
    double sum = 0;
    for (std::size_t k = 0; k < p.size(); ++k) sum += length(p[(k + 1) % p.size()] - p[k]);
    return sum;
}

}  // namespace

double contour_exchange(std::span<const Vec3> a, std::span<const Vec3> b) {
    // Agreement of two rules far below what counts in the sum, but above what double can tell.
    constexpr double kAgreement = 1e-11, kRounding = 1e-15;
    const double lengths = perimeter(a) * perimeter(b), smaller = std::min(perimeter(a), perimeter(b));
    const double tolerance = std::max(kAgreement * smaller * smaller / 16, kRounding * lengths / 16);
    const double unit = std::max(perimeter(a), perimeter(b));  // contours are closed: any unit gives the same sum
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        const Vec3 a0 = a[i], a1 = a[(i + 1) % a.size()];
        for (std::size_t j = 0; j < b.size(); ++j) {
            const Vec3 b0 = b[j], b1 = b[(j + 1) % b.size()];
            const double cosines = dot(normalised(a1 - a0), normalised(b1 - b0));
            if (cosines != 0) sum += cosines * EdgePair(a0, a1, b0, b1, unit).integral(tolerance);
        }
    }
    return sum / (2 * pi);
}

double facing_exchange(const Polygon& a, const Polygon& b) {
    const double apart = length(b.centre - a.centre), radii = a.radius + b.radius;
    if (radii < kCoarseRatio * apart) return rule_product(a, a.coarse, b, b.coarse);
    if (radii < kFineRatio * apart) return rule_product(a, a.fine, b, b.fine);
    if (radii < kFinestRatio * apart && a.finest.count * b.finest.count <= kManyNodes * kManyNodes)
        return rule_product(a, a.finest, b, b.finest);
    const bool a_first = a.radius <= b.radius;
    const Polygon& small = a_first ? a : b;
    const Polygon& other = a_first ? b : a;
    const double distance = distance_below(small.centre, other);
    if (small.radius < kPointRatio * distance) return polygon_rule(small, other, 0);
    if (small.radius < kQuarteredRatio * distance) return polygon_rule(small, other, 1);
    return std::max(0.0, contour_exchange(small.corners, other.corners));
}

bool facing_parts(const Polygon& a, const Polygon& b, FacingPair& pair) {
    const Lies b_lies = lies(b, a);
    if (b_lies == Lies::Behind) return false;
    const Lies a_lies = lies(a, b);
    if (a_lies == Lies::Behind || same_plane(a, b)) return false;
    pair.a = &a;
    pair.b = &b;
    const auto cut = [](const Polygon& polygon, const Polygon& plane, Polygon& part) {
        clip_to_front(polygon.corners, plane.normal, plane.offset, part.corners);
        if (part.corners.empty()) return false;
        part.rounding = polygon.rounding;
        derive_from_corners(part);
        part.normal = polygon.normal;  // a sliver's own is rounding
        part.offset = polygon.offset;
        add_rules(part);
        return part.area > 0;
    };
    if (b_lies == Lies::Across) {
        if (!cut(b, a, pair.cut_b)) return false;
        pair.b = &pair.cut_b;
    }
    if (a_lies == Lies::Across) {
        if (!cut(a, b, pair.cut_a)) return false;
        pair.a = &pair.cut_a;
    }
    return true;
}

}  // namespace rro
