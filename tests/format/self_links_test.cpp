// The pair tree of self links: what its steps mean.
#include "format/self_links.h"

#include <catch2/catch.hpp>

#include "tests/support/tiny_object.h"

namespace rro::test {

TEST_CASE("steps in preorder name pairs of clusters", "[self_links]") {
    const TinyObject object = tiny_object();
    const ObjectData data = object.data();
    const std::vector<SelfPair> pairs = self_pairs(data);
    REQUIRE(pairs.size() == 8);
    struct Expected {
        std::uint32_t a, b, end;
    };
    // Cluster 0 holds 1 (walls 0 to 2) and 6 (walls 3 to 5); 1 holds 2 and 3, 3 holds 4 and 5; 6 holds 7 and 8.
    const std::vector<Expected> expected{{0, 0, 8}, {1, 1, 2}, {1, 6, 7}, {2, 6, 4}, {3, 6, 7}, {3, 7, 6}, {3, 8, 7}, {6, 6, 8}};
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        INFO("pair " << i);
        CHECK(pairs[i].a == expected[i].a);
        CHECK(pairs[i].b == expected[i].b);
        CHECK(pairs[i].end == expected[i].end);
    }
}

TEST_CASE("pairs above links hold what the links exchange", "[self_links]") {
    const TinyObject object = tiny_object();
    const ObjectData data = object.data();
    const std::vector<SelfPair> pairs = self_pairs(data);
    CHECK(pairs[3].unoccluded == 0.5f);
    CHECK(pairs[3].seen == 0.5f);
    CHECK(pairs[4].unoccluded == 0.25f);
    CHECK(pairs[4].seen == Approx(0.25 * 128 / 255));
    CHECK(pairs[2].unoccluded == 0.75f);
    // Light between two halves of a cluster goes both ways; the last link is hidden.
    CHECK(pairs[0].unoccluded == 2 * 0.75f + 1.5f);
    CHECK(pairs[0].seen == Approx(2 * (0.5 + 0.25 * 128 / 255)));
}

TEST_CASE("an object without self links has no pairs", "[self_links]") {
    TinyObject object = tiny_object();
    object.self_steps.clear();
    object.self_exchange.clear();
    const ObjectData data = object.data();
    CHECK(self_pairs(data).empty());
    CHECK_FALSE(check_self_pairs(data));
}

TEST_CASE("steps that do not fit their pairs are found", "[self_links]") {
    TinyObject object = tiny_object();
    REQUIRE_FALSE(check_self_pairs(object.data()));
    std::size_t step = 0;
    SECTION("no such step") { object.self_steps[step = 3] = 5; }
    SECTION("a cluster against itself is not divided on one side") { object.self_steps[step = 1] = 2; }
    SECTION("two clusters are not divided like one") { object.self_steps[step = 2] = 4; }
    SECTION("one patch is not divided") { object.self_steps[step = 3] = 2; }
    SECTION("too few") { object.self_steps.resize(step = 5); }
    SECTION("too many") {
        step = object.self_steps.size();
        object.self_steps.push_back(0);
    }
    SECTION("more links than numbers") {
        object.self_steps[1] = 1;
        step = object.self_steps.size();
    }
    const auto fault = check_self_pairs(object.data());
    REQUIRE(fault);
    CHECK(fault->step == step);
    CHECK_FALSE(fault->found.empty());
    CHECK_FALSE(fault->expected.empty());
}

}  // namespace rro::test
