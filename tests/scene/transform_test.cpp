#include "solver/scene/transform.h"

#include <catch2/catch.hpp>

using namespace rro;

TEST_CASE("the condition number is the ratio of singular values", "[transform]") {
    // Rotations leave singular values alone. 1e-8 leaves room for the rounding of the product, which moves the smallest
    // of singular values 1e8 apart by 1e-16 * 1e8.
    const Mat3 a = compose({{}, {1, 2, 3}, 40, {1, 1, 1}}).linear,
               b = compose({{}, {-2, 1, 0.5}, 77, {1, 1, 1}}).linear;
    for (const double ratio : {1.0, 3.0, 1e4, 1e8}) {
        const Mat3 m = a * Mat3{{Vec3{ratio, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}} * b;
        CHECK(condition_number(m) == Approx(ratio).epsilon(1e-7));
    }
    // A shear x' = x + s y has singular values s/2 +- sqrt(s^2/4 + 1).
    const double s = 2.5, root = std::sqrt(s * s / 4 + 1);
    CHECK(condition_number({{Vec3{1, s, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}}) ==
          Approx((s / 2 + root) / (root - s / 2)).epsilon(1e-12));
    // The scale of all entries does not matter, even where squares would overflow.
    CHECK(condition_number({{Vec3{1e200, 0, 0}, Vec3{0, 2e200, 0}, Vec3{0, 0, 1e200}}}) == Approx(2).epsilon(1e-12));
    CHECK(std::isinf(condition_number({{Vec3{}, Vec3{}, Vec3{}}})));
}
