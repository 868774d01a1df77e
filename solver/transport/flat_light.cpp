#include "solver/transport/flat_light.h"

#include <algorithm>

namespace rro {

Vec3 arrival(const Node& flat, const Vec3& u) {
    constexpr double kLowest = 0.15;  // cosine
    const Vec3 n = flat.normal();
    return dot(n, u) >= kLowest ? u : n;
}

Vec3 slope(const Node& receiver, const Node& source, const Vec3& u, double d) {
    constexpr double kSoft = 0.5;
    constexpr double kSteepest = 2;  // of 1 / d: beyond that a first order says nothing
    const Vec3 n = receiver.normal();
    if (!(d > 0) || arrival(receiver, u) != u) return {};
    const double cosine = dot(n, u), r = double(source.radius) + double(receiver.radius);
    Vec3 s = (u * (3 * cosine) - n) / d;
    if (source.kind != NodeKind::Bins) {
        const Vec3 m = source.normal();
        const double leaving = -dot(m, u);
        if (leaving > 0) {
            const Vec3 q = m / leaving + u;
            s += q * (cosine / (d * std::max(1.0, length(q) / kSteepest)));
        }
    }
    s *= d * d / (d * d + kSoft * r * r);  // ends of some extent smooth it
    // Nowhere on the receiver may this light fall below zero: others' light would be taken away.
    const double fall = length(s) * double(receiver.radius);
    return fall > cosine ? s * (cosine / fall) : s;
}

}  // namespace rro
