// Visibility: rays, error and time of every method.
//
//   visibility_bench paper FOLDER     the layout of the paper's Table 1 (its section 6.1)
//   visibility_bench methods FOLDER   every method: root mean square error of mean visibility, and time per link
//
// FOLDER holds archives of the sample library: ball, chair, bust, palm, bookshelf. One thread.
#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include <time.h>

#include "format/parallel.h"
#include "tests/support/shafts.h"

using namespace rro;
using namespace rro::test;

namespace {

Affine3 rotation(const Vec3& axis, double angle) {
    const Vec3 u = normalised(axis);
    const double c = std::cos(angle), s = std::sin(angle);
    const Mat3 cross_matrix{{Vec3{0, -u.z, u.y}, Vec3{u.z, 0, -u.x}, Vec3{-u.y, u.x, 0}}};
    Mat3 m;
    for (int r = 0; r < 3; ++r)
        for (int k = 0; k < 3; ++k)
            m.rows[static_cast<std::size_t>(r)][k] = (r == k ? c : 0.0) + s * cross_matrix(r, k) + (1 - c) * u[r] * u[k];
    return {m, {}};
}

std::unique_ptr<Object> load(const std::string& folder, const std::string& name) {
    const std::string path = folder + "/" + name + ".rro";
    auto archive = Archive::open(path);
    if (!archive) {
        std::fprintf(stderr, "%s: %s\n", path.c_str(), archive.error().message.c_str());
        std::exit(3);
    }
    return make_object(path, std::move(*archive));
}

struct Ball {
    Vec3 centre;
    double radius;
};

Ball ball_of(const Object& object) {
    const ObjectData& d = object.data();
    return {d.origin + to_double(d.atlas_centre), double(d.atlas_radius)};
}

Demand adaptive(StopRule rule, double deviation, LinePoints points = LinePoints::Sobol, std::uint32_t first = 16) {
    Demand d;
    d.rule = rule;
    d.deviation = deviation;
    d.points = points;
    d.first = first;
    return d;
}

using Visibilities = std::vector<double>;

double rms(const Visibilities& v) {
    double sum = 0;
    for (const double x : v) sum += x * x;
    return std::sqrt(sum / double(v.size()));
}

double rms_difference(const Visibilities& a, const Visibilities& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
    return std::sqrt(sum / double(a.size()));
}

// ---------------------------------------------------------------------------------------------------- the paper's table

/// One light over an object over a floor of n x n patches.
struct Experiment {
    Scene scene;
    std::unique_ptr<SceneRays> rays;
    std::uint32_t n;
    Panel light;
    std::vector<std::vector<std::uint32_t>> neighbours;  // [n * n]

    /// side    of the floor, m
    std::vector<Shaft> shafts(double side, std::uint64_t seed) const {
        std::vector<Shaft> out;
        const double s = side / n;
        for (std::uint32_t i = 0; i < n * n; ++i) {
            const Vec3 at{(i % n + 0.5) * s - side / 2, 0, (i / n + 0.5) * s - side / 2};
            out.push_back(shaft_between({at, {s, 0, 0}, {0, 0, s}}, light, mix64(seed ^ i)));
        }
        return out;
    }

    struct Outcome {
        Visibilities values;
        double rays = 0;
    };
    Outcome estimate(double side, VisibilityMethod method, const Demand& demand, bool by_neighbours, std::uint64_t seed) const {
        const Visibility visibility(scene, *rays, method);
        const std::vector<Shaft> all = shafts(side, seed);
        std::vector<Transmittance> got;
        if (by_neighbours) got = visibility.transmittances(all, neighbours, demand);
        else
            for (const Shaft& s : all) got.push_back(visibility.transmittance(s, demand));
        Outcome out;
        for (const Transmittance& t : got) {
            out.values.push_back(t.mean);
            out.rays += t.rays;
        }
        return out;
    }

    /// The floor on which the shadow takes as much as in the paper: by bisection.
    double side_for(double wanted_rms) const {
        double lo = 0.5, hi = 50;
        for (int k = 0; k < 20; ++k) {
            const double side = std::sqrt(lo * hi);
            (rms(estimate(side, VisibilityMethod::Rays, fixed_rays(64), false, 1).values) < wanted_rms ? lo : hi) = side;
        }
        return std::sqrt(lo * hi);
    }
};

/// The object on the floor, scaled to a sphere of 1 m about it; the light 0.8 m wide, 3 m above its centre.
Experiment make_experiment(const std::string& folder, const std::string& name, std::uint32_t n) {
    Experiment e;
    e.n = n;
    e.scene.objects.push_back(load(folder, name));
    const Object& object = *e.scene.objects.back();
    const Ball ball = ball_of(object);
    const double scale = 1 / ball.radius;
    Affine3 place;
    for (int i = 0; i < 3; ++i) place.linear.rows[static_cast<std::size_t>(i)] *= scale;
    const Vec3 foot = object.data().meta.bounds.lo;
    constexpr double kGap = 1e-3;
    place.translation = {-ball.centre.x * scale, kGap - foot.y * scale, -ball.centre.z * scale};
    add_instance(e.scene, object, place, {}, {});
    e.rays = std::make_unique<SceneRays>(e.scene);
    e.light = {{0.5, place.point(ball.centre).y + 3, 0.3}, {0.8, 0, 0}, {0, 0, 0.8}};
    for (std::uint32_t i = 0; i < n * n; ++i) {
        auto& beside = e.neighbours.emplace_back();
        if (i % n > 0) beside.push_back(i - 1);
        if (i % n + 1 < n) beside.push_back(i + 1);
        if (i / n > 0) beside.push_back(i - n);
        if (i / n + 1 < n) beside.push_back(i + n);
    }
    return e;
}

struct PaperRow {
    const char* name;
    VisibilityMethod method;
    Demand demand;
    bool by_neighbours;
};

void print_experiment(const Experiment& e, const char* name, double paper_rms_visibility) {
    constexpr int kRepetitions = 20;
    constexpr std::uint32_t kTruthRays = 16384;
    const double side = e.side_for(paper_rms_visibility);
    const Visibilities truth = e.estimate(side, VisibilityMethod::Rays, fixed_rays(kTruthRays), false, 99).values;
    std::printf("\n%s, N = %u: rms visibility %.3f (the paper's: %.3f), floor %.2f m, %d repetitions\n\n", name, e.n, rms(truth),
                paper_rms_visibility, side, kRepetitions);
    std::printf("| method | rays | rays per pair | RMS, 256 random rays as reference | SNR | RMS, truth | SNR | largest error |\n");
    std::printf("|---|---:|---:|---:|---:|---:|---:|---:|\n");
    constexpr auto kRandom = LinePoints::Independent, kSobol = LinePoints::Sobol;
    constexpr auto kRays = VisibilityMethod::Rays, kAuto = VisibilityMethod::Auto;
    const std::vector<PaperRow> rows{
        {"fixed 16", kRays, fixed_rays(16, kRandom), false},
        {"fixed 64", kRays, fixed_rays(64, kRandom), false},
        {"fixed 81", kRays, fixed_rays(81, kRandom), false},
        {"fixed 144", kRays, fixed_rays(144, kRandom), false},
        {"adaptive, paper's rule, 0.04", kRays, adaptive(StopRule::Paper, 0.04, kRandom), false},
        {"Sobol, fixed 16", kRays, fixed_rays(16), false},
        {"Sobol, fixed 64", kRays, fixed_rays(64), false},
        {"Sobol, fixed 144", kRays, fixed_rays(144), false},
        {"Sobol, paper's rule, 0.045", kRays, adaptive(StopRule::Paper, 0.045, kSobol), false},
        {"Sobol, Laplace, 0.05", kRays, adaptive(StopRule::Laplace, 0.05, kSobol), false},
        {"Sobol, neighbours, 0.05", kRays, adaptive(StopRule::Paper, 0.05, kSobol), true},
        {"Sobol, neighbours, 0.055, from 4 rays", kRays, adaptive(StopRule::Paper, 0.055, kSobol, 4), true},
        {"Sobol, neighbours, 0.065, from 4 rays", kRays, adaptive(StopRule::Paper, 0.065, kSobol, 4), true},
        {"auto, neighbours, 0.05", kAuto, adaptive(StopRule::Paper, 0.05, kSobol), true},
        {"auto, neighbours, 0.055, from 4 rays", kAuto, adaptive(StopRule::Paper, 0.055, kSobol, 4), true},
    };
    for (const PaperRow& row : rows) {
        double noisy2 = 0, true2 = 0, rays = 0, worst = 0;
        for (int k = 0; k < kRepetitions; ++k) {
            const auto seed = mix64(1000 + static_cast<std::uint64_t>(k));
            const Visibilities reference = e.estimate(side, kRays, fixed_rays(256, kRandom), false, mix64(seed)).values;
            const auto got = e.estimate(side, row.method, row.demand, row.by_neighbours, seed);
            noisy2 += std::pow(rms_difference(got.values, reference), 2) / kRepetitions;
            true2 += std::pow(rms_difference(got.values, truth), 2) / kRepetitions;
            rays += got.rays / kRepetitions;
            for (std::size_t i = 0; i < truth.size(); ++i) worst = std::max(worst, std::abs(got.values[i] - truth[i]));
        }
        const auto snr = [&](double error2) { return 20 * std::log10(rms(truth) / std::sqrt(error2)); };
        std::printf("| %s | %.0f | %.1f | %.5f | %.2f | %.5f | %.2f | %.2f |\n", row.name, rays, rays / (e.n * e.n),
                    std::sqrt(noisy2), snr(noisy2), std::sqrt(true2), snr(true2), worst);
        std::fflush(stdout);
    }
}

void paper(const std::string& folder) {
    print_experiment(make_experiment(folder, "ball", 16), "ball", 0.804);
    print_experiment(make_experiment(folder, "chair", 32), "chair", 0.903);
}

// ---------------------------------------------------------------------------------------------------------- all methods

/// Shafts through a scene, and what they truly let through.
struct Trial {
    std::string name;
    std::shared_ptr<Scene> scene;
    std::shared_ptr<SceneRays> rays;
    std::vector<Shaft> shafts;
    Visibilities truth;
};

constexpr std::uint32_t kTruthRays = 2048;

double true_visibility(const Trial& t, const Shaft& shaft) {
    Shaft other = shaft;
    other.seed = mix64(shaft.seed ^ 0x7275746855ull);
    return Visibility(*t.scene, *t.rays, VisibilityMethod::Rays).transmittance(other, fixed_rays(kTruthRays)).mean;
}

Panel facing(const Vec3& centre, const Vec3& normal, double side, std::uint64_t& state) {
    const auto [x, y, z] = frame_about(normal);
    const double angle = 2 * std::numbers::pi * uniform(state);
    const Vec3 along = x * std::cos(angle) + y * std::sin(angle);
    return {centre, along * side, cross(normal, along) * side};
}

/// Shafts of this width (in radii of its sphere) through one object, of which it blocks a part.
Trial one_object(const std::string& folder, const std::string& name, double width, std::size_t count) {
    Trial t;
    t.name = name;
    t.scene = std::make_shared<Scene>();
    t.scene->objects.push_back(load(folder, name));
    const Object& object = *t.scene->objects.back();
    add_instance(*t.scene, object, Affine3{}, {}, {});
    t.rays = std::make_shared<SceneRays>(*t.scene);
    const Ball ball = ball_of(object);
    std::uint64_t state = 7;
    while (t.shafts.size() < count) {
        const Vec3 w = random_direction(state);
        const auto [x, y, z] = frame_about(w);
        const double r = std::sqrt(uniform(state)), angle = 2 * std::numbers::pi * uniform(state);
        const Vec3 through = ball.centre + (x * std::cos(angle) + y * std::sin(angle)) * (r * ball.radius);
        const double before = (1.5 + 2.5 * uniform(state)) * ball.radius, behind = (1.5 + 2.5 * uniform(state)) * ball.radius;
        const auto tilted = [&] { return normalised(w + random_direction(state) * 0.5); };
        const Panel a = facing(through - w * before, tilted(), width * ball.radius, state);
        const Panel b = facing(through + w * behind, tilted(), width * ball.radius, state);
        const Shaft shaft = shaft_between(a, b, mix64(state));
        const double v = true_visibility(t, shaft);
        if (v < 0.03 || v > 0.97) continue;
        t.shafts.push_back(shaft);
        t.truth.push_back(v);
    }
    return t;
}

/// Links between squares of this width amid objects of four kinds in a box, turned and stretched at random to radii of
/// about 1 m; their spheres fill a fixed part of the box whatever their number.
Trial crowd(const std::string& folder, std::size_t instances, double width, std::size_t count) {
    constexpr double kFilled = 0.08;
    Trial t;
    char name[80];
    std::snprintf(name, sizeof name, "%zu instances, %.1f m", instances, width);
    t.name = name;
    t.scene = std::make_shared<Scene>();
    for (const char* kind : {"chair", "bust", "palm", "bookshelf"}) t.scene->objects.push_back(load(folder, kind));
    std::uint64_t state = 11;
    const double box = std::cbrt(double(instances) / kFilled * 4.0 / 3 * std::numbers::pi);
    std::vector<Ball> places;
    for (std::size_t i = 0; i < instances; ++i) {
        const Object& object = *t.scene->objects[i % 4];
        const Ball ball = ball_of(object);
        Affine3 place = rotation(random_direction(state), 6.28 * uniform(state));
        Affine3 stretch;
        for (int k = 0; k < 3; ++k) stretch.linear.rows[static_cast<std::size_t>(k)] *= (0.6 + 0.6 * uniform(state)) / ball.radius;
        place = place * stretch;
        const Vec3 at{box * uniform(state), box * uniform(state), box * uniform(state)};
        place.translation = at - place.linear * ball.centre;
        places.push_back({at, 1});
        add_instance(*t.scene, object, place, {}, {});
    }
    t.rays = std::make_shared<SceneRays>(*t.scene);
    while (t.shafts.size() < count) {
        const auto i = static_cast<std::uint32_t>(uniform(state) * double(instances)), j = static_cast<std::uint32_t>(uniform(state) * double(instances));
        const double d = length(places[j].centre - places[i].centre);
        if (i == j || d < 3) continue;
        const auto end = [&](std::uint32_t k) {
            return facing(places[k].centre, random_direction(state), width, state);
        };
        const Panel a = end(i), b = end(j);
        Shaft shaft = shaft_between(a, b, mix64(state));
        shaft.passed = {i, j};
        t.truth.push_back(true_visibility(t, shaft));
        t.shafts.push_back(std::move(shaft));
    }
    return t;
}

struct Method {
    const char* name;
    VisibilityMethod method;
    Demand demand;
    TableOptions tables = {};
};

struct Measured {
    double error = 0, bias = 0, estimate = 0, nanoseconds = 0, rays = 0, without = 0;
};

/// Of this thread: other work on the machine does not count.
double processor_seconds() {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

Measured measure(const Trial& t, const Method& m) {
    const Visibility visibility(*t.scene, *t.rays, m.method, m.tables);
    Measured r;
    Visibilities got(t.shafts.size());
    constexpr int kPasses = 3;
    double best = 1e300;
    for (int pass = 0; pass < kPasses; ++pass) {
        const double start = processor_seconds();
        for (std::size_t i = 0; i < t.shafts.size(); ++i) got[i] = visibility.transmittance(t.shafts[i], m.demand).mean;
        best = std::min(best, processor_seconds() - start);
    }
    const auto n = static_cast<double>(t.shafts.size());
    r.nanoseconds = best / n * 1e9;
    for (std::size_t i = 0; i < t.shafts.size(); ++i) {
        const Transmittance x = visibility.transmittance(t.shafts[i], m.demand);
        r.rays += x.rays / n;
        r.without += (x.rays == 0) / n;
        r.estimate += x.error() * x.error() / n;
        r.bias += (x.mean - t.truth[i]) / n;
    }
    r.estimate = std::sqrt(r.estimate);
    r.error = rms_difference(got, t.truth);
    return r;
}

void print_trials(const char* title, const std::vector<Trial>& trials, const std::vector<Method>& methods) {
    std::printf("\n%s\n\n| method |", title);
    for (const Trial& t : trials) std::printf(" %s |", t.name.c_str());
    std::printf("\n|---|");
    for (std::size_t i = 0; i < trials.size(); ++i) std::printf("---:|");
    std::printf("\n");
    for (const Method& m : methods) {
        std::printf("| %s |", m.name);
        for (const Trial& t : trials) {
            const Measured r = measure(t, m);
            std::printf(" %.3f (%.3f), %+.3f, %.2f us, %.0f rays, %.0f %% |", r.error, r.estimate, r.bias, r.nanoseconds / 1000,
                        r.rays, 100 * r.without);
            std::fflush(stdout);
        }
        std::printf("\n");
    }
}

void methods(const std::string& folder) {
    using enum VisibilityMethod;
    TableOptions dice, paper, coarse;
    dice.dice = true;
    paper.intrinsic = false;
    coarse.tolerance = 0.1;
    const std::vector<Method> all{
        {"rays 16", Rays, fixed_rays(16)},
        {"rays 36", Rays, fixed_rays(36)},
        {"rays 64", Rays, fixed_rays(64)},
        {"rays 144", Rays, fixed_rays(144)},
        {"rays, Laplace 0.05", Rays, adaptive(StopRule::Laplace, 0.05)},
        {"rays, Laplace 0.03", Rays, adaptive(StopRule::Laplace, 0.03)},
        {"tables 0.01, 36 lines", Tables, fixed_rays(36)},
        {"tables 0.01, whole object", Tables, fixed_rays(36), paper},
        {"tables 0.1, 36 lines", Tables, fixed_rays(36), coarse},
        {"tables 0.01, dice", Tables, fixed_rays(36), dice},
        {"atlas, else rays 36", Atlas, fixed_rays(36)},
        {"auto, Laplace 0.05", Auto, adaptive(StopRule::Laplace, 0.05)},
        {"auto, Laplace 0.03", Auto, adaptive(StopRule::Laplace, 0.03)},
        {"none", None, fixed_rays(1)},
    };
    std::printf("Cells: root mean square error of mean visibility (the method's own estimate), bias, processor time per link, rays per link,\n"
                "share of links without rays.\n");
    constexpr std::size_t kShafts = 300, kLinks = 400;
    for (const double width : {0.1, 0.5, 1.0}) {
        std::vector<Trial> trials;
        for (const char* name : {"chair", "bust", "palm", "bookshelf"}) trials.push_back(one_object(folder, name, width, kShafts));
        char title[80];
        std::snprintf(title, sizeof title, "Shafts %.1f R wide, partly blocked by one object", width);
        print_trials(title, trials, all);
    }
    print_trials("A crowd", {crowd(folder, 64, 0.2, kLinks), crowd(folder, 64, 1, kLinks), crowd(folder, 256, 0.2, kLinks), crowd(folder, 256, 1, kLinks)}, all);
}

}  // namespace

int main(int argc, char** argv) {
    const std::string what = argc == 3 ? argv[1] : "";
    set_thread_count(1);
    if (what == "paper") paper(argv[2]);
    else if (what == "methods") methods(argv[2]);
    else return std::fprintf(stderr, "usage: visibility_bench paper|methods FOLDER\n"), 2;
}
