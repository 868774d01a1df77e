// Ends that are near for their size, as several points each: how much they exchange, and how evenly.
#include <array>
#include <cmath>
#include <numbers>

#include "format/sample_points.h"
#include "solver/transport/flat_light.h"
#include "solver/transport/link.h"

namespace rro {

namespace {

// From this share of the distance on, an end counts as several points.
constexpr double kOnePoint = 0.08;

// A point that stands for a part of an end.
struct Spot {
    Vec3 position;
    double area;
    const Node* node;  // knows the cosines
};
constexpr std::size_t kMostSpots = 8;

// A few points of an end, `levels` halvings below it; more where it is nearer.
class Spots {
  public:
    Spots(const Nodes& nodes, std::uint32_t id, int levels) : nodes_(nodes) { add(id, levels); }
    const Spot* begin() const { return spots_.data(); }
    const Spot* end() const { return spots_.data() + count_; }

  private:
    void add(std::uint32_t id, int levels) {
        const Node& n = nodes_[id];
        const std::size_t room = kMostSpots - count_;
        if (levels > 0 && n.kind == NodeKind::Surface) {
            const TriangleCorners c = nodes_.corners(id);
            for (const TriangleRule::Node& q : triangle_rule(3).nodes)
                spots_[count_++] = {triangle_point(c, q.b1, q.b2), q.weight * n.area, &n};
        } else if (levels > 0 && n.second_child != 0) {
            add(n.first_child, levels - 1);
            add(n.second_child, levels - 1);
        } else if (levels > 0 && n.child_count > 0 && n.child_count <= std::min(room, std::size_t(1) << levels)) {
            for (std::uint32_t k = 0; k < n.child_count; ++k) add(n.first_child + k, 0);
        } else {
            spots_[count_++] = {n.centre, n.area, &n};
        }
    }

    const Nodes& nodes_;
    std::array<Spot, kMostSpots> spots_;
    std::size_t count_ = 0;
};

// How far the light of each point of a flat receiver lies from what vector and gradient tell, root mean square over its
// area and relative to the mean. u: from the receiver to the source.
double misfit(const Node& receiver, const Spots& spots, const std::array<double, kMostSpots>& exchange, const Node& source,
              const Vec3& u, double d, double whole) {
    if (receiver.kind != NodeKind::Flat || spots.end() - spots.begin() < 2 || !(whole > 0)) return 0;
    const Vec3 along = arrival(receiver, u), gradient = slope(receiver, source, u, d);
    const double per_area = whole / dot(receiver.area_vector, along);
    double sum = 0;
    for (const Spot& p : spots) {
        if (!(p.area > 0)) continue;
        const double cosine = dot(p.node->normal(), along) + dot(gradient, p.position - receiver.centre);
        const double told = per_area * p.area * std::max(0.0, cosine);
        sum += std::pow(exchange[static_cast<std::size_t>(&p - spots.begin())] - told, 2) / p.area;
    }
    return std::sqrt(sum * receiver.area) / whole;
}

}  // namespace

LinkBuilder::Quadrature LinkBuilder::by_points(std::uint32_t a, std::uint32_t b) const {
    const Node &na = nodes_[a], &nb = nodes_[b];
    const double d = length(nb.centre - na.centre);
    const auto levels = [&](const Node& n) {
        const double r = double(n.radius) / d;
        if (n.kind == NodeKind::Surface) return r > kOnePoint ? 1 : 0;
        return r > 4 * kOnePoint ? 3 : r > 2 * kOnePoint ? 2 : r > kOnePoint ? 1 : 0;
    };
    const Spots at_a(nodes_, a, levels(na)), at_b(nodes_, b, levels(nb));
    const auto exchange = [](const Spot& p, const Spot& q, double fan_p, double fan_q) {
        const Vec3 v = q.position - p.position;
        const double d2 = length2(v);
        if (!(d2 > 0)) return 0.0;
        const Vec3 w = v / std::sqrt(d2);
        return p.area * p.node->mean_cosine(w, fan_p) * q.area * q.node->mean_cosine(-w, fan_q) / (std::numbers::pi * d2);
    };
    Quadrature out;
    const auto count = [](const Spots& s) { return static_cast<double>(s.end() - s.begin()); };
    // Each point still stands for a part of some extent.
    const double fan_a = 0.5 * double(nb.radius) / (d * std::sqrt(count(at_b))), fan_b = 0.5 * double(na.radius) / (d * std::sqrt(count(at_a)));
    std::array<double, kMostSpots> to_a{}, to_b{};
    for (const Spot& p : at_a)
        for (const Spot& q : at_b) {
            const double g = exchange(p, q, fan_a, fan_b);
            to_a[static_cast<std::size_t>(&p - at_a.begin())] += g;
            to_b[static_cast<std::size_t>(&q - at_b.begin())] += g;
            out.exchange += g;
        }
    const Vec3 w = (nb.centre - na.centre) / d;
    out.received_a = misfit(na, at_a, to_a, nb, w, d, out.exchange);
    out.received_b = misfit(nb, at_b, to_b, na, -w, d, out.exchange);
    const Spot one{na.centre, na.area, &na}, other{nb.centre, nb.area, &nb};
    out.difference = std::abs(out.exchange - exchange(one, other, 0.5 * double(nb.radius) / d, 0.5 * double(na.radius) / d));
    return out;
}

}  // namespace rro
