#include <catch2/catch.hpp>

#include <limits>

#include "solver/visibility/reciprocals.h"

using namespace rro;

// Slab tests rest on it: times a distance to a face it is an infinity again, which says on which side of the face a line is.
TEST_CASE("where a line stays in place, its reciprocal is an infinity with the sign of the zero", "[visibility][reciprocals]") {
    constexpr double endless = std::numeric_limits<double>::infinity();
    CHECK(reciprocals({0.0, -0.0, 4.0}) == Vec3{endless, -endless, 0.25});
}
