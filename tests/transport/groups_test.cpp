// Groups of instances: the same light as without them, for work that grows with the number of instances.
#include "solver/transport/groups.h"

#include <catch2/catch.hpp>
#include <map>

#include "format/parallel.h"
#include "format/sample_points.h"
#include "solver/study/reference.h"
#include "solver/transport/transport.h"
#include "tests/support/meshes.h"
#include "tests/support/scenes.h"
#include "tests/support/solutions.h"

namespace rro::test {
namespace {

/// Mean irradiance over the instances whose names begin like this.
double mean_irradiance(const Scene& scene, const Solution& solution, const std::string& name) {
    double sum = 0, area = 0;
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        if (scene.instances[i].name.rfind(name, 0) != 0) continue;
        for (std::size_t f = 0; f < scene.instances[i].data().faces.size(); ++f) {
            const double a = face_area(scene.instances[i], f);
            sum += a * double(solution.instances[i].irradiance[f].y);
            area += a;
        }
    }
    return sum / area;
}

/// A place that is as random as it is the same every time.
double scattered(std::uint64_t key) {
    return double(mix64(key) >> 11) * 0x1p-53;
}

/// What a scene needs of each object: one archive, placed many times.
struct Placing {
    std::size_t object;
    Affine3 to_world;
    Vec3 reflectance, exitance;
    std::string name;
};

Scene place(const std::vector<Mesh>& meshes, const std::vector<Placing>& placings) {
    Scene scene;
    scene.manifest.path = "in memory";
    for (const Mesh& mesh : meshes) scene.objects.push_back(compile_to_object(mesh));
    for (const Placing& p : placings)
        add_instance(scene, *scene.objects[p.object], p.to_world, p.reflectance, p.exitance, p.name);
    return scene;
}

/// Boxes and balls over a floor, side x side of them 1 m apart, under lamps that face down, one over every four by four.
std::vector<Placing> field(int side) {
    std::vector<Placing> out;
    const double middle = 0.5 * (side - 1);
    Affine3 floor;
    floor.linear = {{Vec3{double(side) + 2, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, double(side) + 2}}};
    out.push_back({0, floor, {0.6, 0.6, 0.6}, {}, "floor"});
    for (int x = 0; x < side; ++x)
        for (int z = 0; z < side; ++z) {
            const auto key = static_cast<std::uint64_t>(x * 1000 + z);
            const double turn = 6.28 * scattered(key);
            Affine3 map = translation({x - middle + 0.4 * scattered(key + 1), 0.301, z - middle + 0.4 * scattered(key + 2)});
            map.linear.rows[0] = {std::cos(turn), 0, std::sin(turn)};
            map.linear.rows[2] = {-std::sin(turn), 0, std::cos(turn)};
            const bool ball = (x + z) % 3 == 0;
            out.push_back({ball ? 2u : 1u, map, {0.7, 0.6, 0.4}, {}, (ball ? "ball_" : "box_") + std::to_string(key)});
        }
    for (int x = 1; x < side; x += 4)
        for (int z = 1; z < side; z += 4)
            out.push_back({3, {kUpsideDown, {x - middle + 0.5, 2.5, z - middle + 0.5}}, {}, {20, 20, 16},
                           "lamp_" + std::to_string(x * 1000 + z)});
    return out;
}

std::vector<Mesh> field_meshes() {
    return {make_quad(1, 1, false, 8), make_box(0.3, 0.6, 0.4, 2), make_sphere(1, 0.25), make_quad(0.5, 0.5, false, 2)};
}

}  // namespace

TEST_CASE("groups hold every instance once, whatever the order of the manifest", "[transport][groups]") {
    Scene scene = place(field_meshes(), field(6));
    const GroupTree tree = group_instances(scene);
    REQUIRE(tree.groups.size() == scene.instances.size() - 1);
    std::vector<int> seen(scene.instances.size(), 0);
    for (const Group& group : tree.groups)
        for (const std::uint32_t child : group.child)
            if (!tree.is_group(child)) ++seen[tree.instance(child)];
    CHECK(seen == std::vector<int>(seen.size(), 1));
    // Lamps apart from the others, and the floor, which reaches as far as all of these.
    const auto [lamps, others] = tree.groups[0].child;
    for (std::uint32_t m = 0; m < tree.members.size(); ++m)
        CHECK((scene.instances[tree.members[m]].name.rfind("lamp", 0) == 0) == (m < tree.groups[lamps].count));
    REQUIRE(!tree.is_group(tree.groups[others].child[0]));
    CHECK(scene.instances[tree.instance(tree.groups[others].child[0])].name == "floor");

    const auto names = [&](const GroupTree& t) {
        std::vector<std::string> out;
        for (const std::uint32_t i : t.members) out.push_back(scene.instances[i].name);
        return out;
    };
    const auto before = names(tree);
    std::reverse(scene.instances.begin(), scene.instances.end());
    CHECK(names(group_instances(scene)) == before);

    scene.instances.resize(20);
    CHECK(group_instances(scene).groups.empty());
}

TEST_CASE("a field of instances in groups agrees with the reference", "[transport][groups]") {
    const Scene scene = place(field_meshes(), field(7));
    ReferenceOptions reference;
    reference.samples = 1024;
    const auto truth = solve_reference(scene, reference);
    REQUIRE(truth);
    const double noise = truth->estimated_error;
    for (const double accuracy : {0.2, 0.1}) {
        const Solution s = solve_reusably(scene, accuracy);
        const double error = std::sqrt(std::max(0.0, std::pow(difference(scene, s, *truth), 2) - noise * noise));
        INFO("asked " << accuracy << ", error " << error << ", estimate " << s.estimated_error << ", reference noise "
                      << noise << ", links " << s.links.total() << ", rays " << s.rays);
        CHECK(error <= 1.5 * accuracy);
        for (const char* name : {"floor", "box", "ball"}) {
            INFO(name);
            CHECK(mean_irradiance(scene, s, name) == Approx(mean_irradiance(scene, *truth, name)).epsilon(accuracy));
        }
    }
}

TEST_CASE("light between two sparse crowds falls with the square of each distance", "[transport][groups]") {
    // A sphere sends M A / 4 to all sides, and catches a quarter of its area's worth: A_i E_i = sum of M A^2 / (16 pi d^2).
    std::vector<Placing> placings;
    std::vector<Vec3> centres;
    const Vec3 away{17, 3, -2};
    for (int k = 0; k < 64; ++k) {
        const int i = k % 32;
        const auto key = static_cast<std::uint64_t>(k);
        const Vec3 jitter{0.5 * scattered(3 * key), 0.5 * scattered(3 * key + 1), 0.5 * scattered(3 * key + 2)};
        centres.push_back(Vec3{double(i % 4), double(i / 4 % 4), double(i / 16)} + jitter + (k < 32 ? Vec3{} : away));
        const Vec3 none{}, one{1, 1, 1}, half{0.5, 0.5, 0.5};
        placings.push_back({0, translation(centres.back()), k < 32 ? none : half, k < 32 ? one : none, std::to_string(k)});
    }
    const Scene scene = place({make_sphere(2, 0.1)}, placings);
    auto plan = plan_effects(scene, {{}, {"occlusion", "interreflection"}});
    REQUIRE(plan);
    TransportOptions options;
    options.accuracy = 0.4;  // of one crowd with the other, seen through one link; groups need not be divided for less
    const auto solution = solve_reusable(scene, *plan, options);
    REQUIRE(solution);
    double area = 0;
    for (std::size_t f = 0; f < scene.instances[0].data().faces.size(); ++f) area += face_area(scene.instances[0], f);
    double sum = 0, expected_sum = 0;
    for (std::size_t i = 32; i < 64; ++i) {
        double expected = 0;
        for (std::size_t j = 0; j < 32; ++j) expected += area / (16 * 3.14159265358979 * length2(centres[i] - centres[j]));
        const double found = mean_irradiance(scene, *solution, std::to_string(i));
        CHECK(found == Approx(expected).epsilon(0.03));  // groups at six radii, their light translated to each member
        sum += found;
        expected_sum += expected;
    }
    CHECK(sum == Approx(expected_sum).epsilon(0.01));  // errors of place cancel over the crowd
    INFO(solution->links.total() << " links");
    CHECK(solution->links.total() < 32 * 32 / 2);
}

TEST_CASE("links grow with the number of instances, not with its square", "[transport][groups]") {
    std::vector<double> links;
    for (const int side : {8, 16, 32}) {
        std::vector<Placing> placings;
        for (int x = 0; x < side; ++x)
            for (int z = 0; z < side; ++z)
                placings.push_back({0, translation({double(x), 0, double(z)}), {0.5, 0.5, 0.5}, {1, 1, 1},
                                    std::to_string(x) + " " + std::to_string(z)});
        const Scene scene = place({make_box(0.2, 0.2, 0.2)}, placings);
        links.push_back(double(solve_reusably(scene, 0.5).links.total()));
    }
    INFO(links[0] << ", " << links[1] << ", " << links[2]);
    // Four times the instances. All pairs would be sixteen times as many; the border, where partners lack, takes up less.
    CHECK(links[1] < 6 * links[0]);
    CHECK(links[2] < 5 * links[1]);
}

TEST_CASE("the number of threads and the order of instances do not change a bit", "[transport][groups]") {
    Scene scene = place(field_meshes(), field(6));
    const auto radiosities = [&](unsigned threads) {
        set_thread_count(threads);
        const Solution s = solve_reusably(scene, 0.2);
        std::map<std::string, std::vector<Rgb>> out;
        for (std::size_t i = 0; i < scene.instances.size(); ++i) out[scene.instances[i].name] = s.instances[i].radiosity;
        return out;
    };
    const auto alone = radiosities(1);
    CHECK(radiosities(3) == alone);
    std::reverse(scene.instances.begin(), scene.instances.end());
    std::swap(scene.instances[3], scene.instances[20]);
    CHECK(radiosities(2) == alone);
    set_thread_count(0);
}

}  // namespace rro::test
