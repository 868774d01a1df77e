// Many instances, things of very different size in one scene, and edits there and back.
#include "tests/stability/sound.h"

#include <nlohmann/json.hpp>
#include <random>

#include "format/parallel.h"
#include "solver/edit/live.h"
#include "tests/scene/scene_files.h"
#include "tests/stability/wide.h"

namespace rro::test {
namespace {

const Vec3 kGrey{0.5, 0.5, 0.5}, kNone{};

/// side^3 boxes 1 m apart, one in 64 of them glowing.
Scene lattice(int side) {
    Scene scene;
    scene.objects.push_back(compile_to_object(make_box(0.2, 0.2, 0.2), coarse_tables()));
    for (int x = 0; x < side; ++x)
        for (int y = 0; y < side; ++y)
            for (int z = 0; z < side; ++z) {
                const bool glows = x % 4 == 1 && y % 4 == 1 && z % 4 == 1;
                add_instance(scene, *scene.objects[0], translation({double(x), double(y), double(z)}), kGrey,
                             glows ? Vec3{10, 10, 10} : kNone);
            }
    return scene;
}

void check_lattice(const std::string& family, int side, double links_each) {
    const Scene scene = lattice(side);
    const Solution s = solve_soundly(family, scene, 0.5);
    const std::string what = std::to_string(side * side * side) + " instances, accuracy 0.5";
    // Groups keep the work per instance: all pairs would be as many links as there are instances.
    record(family, what, "links per instance", links_each, double(s.links.total()) / double(scene.instances.size()));
    Worst dark;
    for (std::size_t i = 0; i < s.instances.size(); ++i) dark.add(irradiance(scene, s, i).mean > 0 ? 0 : 1);
    record(family, what, "light reaches every one; instances without", 0, dark.value());
    record(family, what, "absorbed is no more than emitted; excess", 0,
           std::max(0.0, s.energy.absorbed.x / s.energy.emitted.x - 1));
}

}  // namespace

TEST_CASE("a thousand instances", "[stability][scale]") { check_lattice("scale", 10, 100); }

TEST_CASE("ten thousand instances", "[.][stability][commands]") { check_lattice("commands", 22, 200); }

TEST_CASE("a thousand instances on one and on many threads", "[stability][scale]") {
    const Scene scene = lattice(8);
    std::vector<std::vector<InstanceSolution>> solutions;
    for (const unsigned threads : {1u, 8u}) {
        set_thread_count(threads);
        solutions.push_back(solve_soundly("scale", scene, 0.5).instances);
    }
    set_thread_count(0);
    double different = 0;
    for (std::size_t i = 0; i < solutions[0].size(); ++i) different += solutions[0][i].radiosity != solutions[1][i].radiosity;
    record("scale", "512 instances on 1 and 8 threads", "the same bits; instances that differ", 0, different);
}

namespace {

/// Boxes of 1e-3, 1 and 1e3 m side by side in a room of 1e4 m, a furnace.
std::array<FurnaceError, 4> nested_scales() {
    std::vector<Placed> placed;
    for (const double size : {1e-3, 1.0, 1e3}) {
        Affine3 map = translation({size * 1.5, size * 0.6, 0});
        map.linear = {{Vec3{size, 0, 0}, Vec3{0, size, 0}, Vec3{0, 0, size}}};
        placed.push_back(furnace(make_box(1, 1, 1, 2), 0.7, map));
    }
    placed.push_back(furnace(turned_inside_out(make_box(1e4, 1e4, 1e4, 4)), 0.5));
    const Scene scene = make_scene(placed, coarse_tables());
    const Solution s = solve_soundly("scale", scene, 0.1);
    std::array<FurnaceError, 4> out;
    for (std::size_t i = 0; i < out.size(); ++i)
        out[i] = furnace_error(scene, s, 1, [&](std::size_t k, std::size_t) { return k == i; });
    return out;
}

}  // namespace

TEST_CASE("a millimetre beside a metre beside a kilometre", "[stability][scale]") {
    const auto e = nested_scales();
    for (const std::size_t i : {2u, 3u})
        record("scale", "a box of 1 km in a furnace of 10 km, among small ones", "B = 1; root mean square over R", 0.1, e[i].rms);

    // Small things under a ceiling of a square kilometre: E on a facet that looks up is the ceiling's factor from there.
    const double height = 500;
    const Mesh ceiling = make_parallelogram({-500, height, -500}, {1000, 0, 0}, {0, 0, 1000});
    const Scene open = make_scene({{make_quad(1, 1), translation({-1, 0, 0}), kGrey, kNone},
                                   {make_quad(1e3, 1e3, false, 4), translation({0, -1, 0}), kGrey, kNone},
                                   {ceiling, {}, kNone, {1, 1, 1}}},
                                  coarse_tables());
    const Solution t = solve_soundly("scale", open, 0.03);
    const std::vector<Vec3> corners{{-500, height, -500}, {500, height, -500}, {500, height, 500}, {-500, height, 500}};
    record("scale", "a square metre under a square kilometre", "E = M F of a point", 0.09,
           std::abs(irradiance(open, t, 0).mean / wide_point_factor(open.instances[0].bounds.centre(), {0, 1, 0}, corners) - 1));
}

// What reflects less than 0.1 % of all light is promised no accuracy, but it is no exception either.
TEST_CASE("a millimetre and a metre in ten kilometres are lit like all else", "[stability][scale]") {
    const auto e = nested_scales();
    for (const std::size_t i : {0u, 1u})
        record("scale", "boxes of 1 mm and 1 m in a furnace of 10 km", "B = 1; root mean square over R", 0.3, e[i].rms);

    // Alone or as a crowd, which other objects see as one.
    Scene scene;
    scene.objects.push_back(compile_to_object(make_box(1e-3, 1e-3, 1e-3, 2), coarse_tables()));
    scene.objects.push_back(compile_to_object(turned_inside_out(make_box(1e4, 1e4, 1e4, 4)), coarse_tables()));
    std::mt19937 bits(1);
    const auto number = [&] { return 0.03 * double(bits()) / 4294967296.0; };
    constexpr std::size_t kCrowd = 100;
    for (std::size_t k = 0; k < kCrowd; ++k)
        add_instance(scene, *scene.objects[0], translation({1000 + number(), 2000 + number(), number() - 100}), {0.7, 0.7, 0.7}, {0.3, 0.3, 0.3});
    add_instance(scene, *scene.objects[1], {}, {0.5, 0.5, 0.5}, {0.5, 0.5, 0.5});
    const FurnaceError crowd = furnace_error(scene, solve_soundly("scale", scene, 0.1), 1, [&](std::size_t i, std::size_t) { return i < kCrowd; });
    record("scale", "100 boxes of 1 mm together in a furnace of 10 km", "B = 1; root mean square over R", 0.3, crowd.rms);
}

TEST_CASE("edits there and back", "[stability][scale]") {
    using nlohmann::json;
    SceneFiles files;
    const auto compiled = compile_object(make_box(1, 1, 1), coarse_tables());
    REQUIRE(compiled);
    REQUIRE(write_archive(compiled->data, files.folder / "box.rro"));
    const json home{{"translate", {0, 0, 0}}}, lamp_home{{"translate", {0, 2, 0}}};
    LiveOptions options;
    options.solve.accuracy = 0.2;
    auto session = LiveSession::open(files.instances(R"({"name": "low", "archive": "box.rro", "transform": {"translate": [0, 0, 0]}},
        {"name": "lamp", "archive": "box.rro", "transform": {"translate": [0, 2, 0]},
         "materials": {"*": {"exitance": [10, 10, 10]}}})"), options);
    REQUIRE(session);
    const auto ask = [&](const json& request) {
        const json reply = json::parse(session->answer(request.dump()));
        INFO(request.dump() << " -> " << reply.dump());
        REQUIRE(reply["ok"] == true);
        check_sound("scale", session->scene(), *session->solution());
    };
    const Solution before = *session->solution();
    std::mt19937 bits(9);
    const auto number = [&] { return double(bits()) / 4294967296.0 * 6 - 3; };
    double furthest = 0;
    for (int round = 0; round < 20; ++round) {
        ask({{"op", "move"}, {"name", "low"}, {"transform", {{"translate", {number(), number(), number()}}, {"scale", std::exp(number())}}}});
        if (round % 2 == 0)
            ask({{"op", "move"}, {"name", "lamp"}, {"transform", {{"translate", {number(), number(), number()}}}}});
        else
            ask({{"op", "place"}, {"name", "more"}, {"archive", "box.rro"}, {"transform", {{"translate", {number(), number(), number()}}}}});
        if (round % 2 == 1) ask({{"op", "delete"}, {"name", "more"}});
        ask({{"op", "move"}, {"name", "low"}, {"transform", home}});
        ask({{"op", "move"}, {"name", "lamp"}, {"transform", lamp_home}});
        furthest = std::max(furthest, compare(session->scene(), *session->solution(), before).all.error());
    }
    // Which links are as fine as the light on the way called for differs; A6 allows a tenth, small scenes half as much again.
    record("scale", "objects moved, placed, deleted and put back, 20 times", "the same light; difference over the accuracy asked", 0.15,
           furthest / options.solve.accuracy.value());
}

}  // namespace rro::test
