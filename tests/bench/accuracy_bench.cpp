// Error and seconds of the reusable method against the Monte Carlo reference, on one scene.
//
//   accuracy_bench SCENE.json SAMPLES ACCURACY...     e.g. samples/scenes/cornell.json 1024 0.1 0.05 0.02
//
// Error: area-weighted relative root mean square of reflected radiosity over all faces and channels; the reference's own
// variance, which it estimates without bias, is subtracted.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "solver/solve_scene.h"

using namespace rro;

namespace {

struct Sums {
    double difference = 0, noise = 0, reference = 0;
    double error() const { return reference > 0 ? std::sqrt(std::max(0.0, difference - noise) / reference) : 0; }
};

Sums compare(const Instance& instance, const InstanceSolution& x, const InstanceSolution& truth) {
    Sums s;
    for (std::size_t f = 0; f < truth.radiosity.size(); ++f) {
        const double a = length(area_vector(instance.world_corners(instance.data().faces[f])));
        const Vec3 b = to_double(truth.radiosity[f]);
        s.difference += a * length2(to_double(x.radiosity[f]) - b);
        s.noise += a * length2(to_double(truth.standard_error[f]));
        s.reference += a * (length2(b - to_double(instance.exitance[instance.object->patch_of_face[f]])) -
                            length2(to_double(truth.standard_error[f])));
    }
    return s;
}

Solution timed(const Scene& scene, const SolveOptions& options, double& seconds) {
    const auto start = std::chrono::steady_clock::now();
    auto solution = solve_scene(scene, options, {});
    seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (!solution) {
        std::fprintf(stderr, "%s\n", solution.error().message.c_str());
        std::exit(1);
    }
    return std::move(*solution);
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 4) {
        std::fprintf(stderr, "usage: accuracy_bench SCENE.json SAMPLES ACCURACY...\n");
        return 2;
    }
    auto manifest = read_manifest(argv[1]);
    if (!manifest) return std::fprintf(stderr, "%s\n", manifest.error().message.c_str()), 3;
    auto scene = open_scene(std::move(*manifest));
    if (!scene) return std::fprintf(stderr, "%s\n", scene.error().message.c_str()), 3;

    SolveOptions reference;
    reference.method = Method::Reference;
    reference.samples = static_cast<std::uint32_t>(std::atoi(argv[2]));
    double seconds = 0;
    const Solution truth = timed(*scene, reference, seconds);
    std::printf("%s: %zu triangles, %zu instances; reference: %u samples per face, %.2f s, standard error %.4f\n", argv[1],
                scene->triangle_count(), scene->instances.size(), reference.samples, seconds, truth.estimated_error);
    std::printf("%-10s %-8s %-10s %-9s %-10s %s\n", "asked", "error", "estimate", "seconds", "links", "worst instance above 0.1 % of the light");
    for (int k = 3; k < argc; ++k) {
        SolveOptions options;
        options.accuracy = std::atof(argv[k]);
        const Solution s = timed(*scene, options, seconds);
        Sums all;
        std::vector<Sums> each;
        for (std::size_t i = 0; i < scene->instances.size(); ++i) {
            each.push_back(compare(scene->instances[i], s.instances[i], truth.instances[i]));
            all.difference += each.back().difference;
            all.noise += each.back().noise;
            all.reference += each.back().reference;
        }
        std::size_t worst = 0;
        for (std::size_t i = 0; i < each.size(); ++i)
            if (each[i].reference > 1e-3 * all.reference && each[i].error() > each[worst].error()) worst = i;
        std::printf("%-10s %-8.4f %-10.4f %-9.2f %-10llu %s %.3f\n", argv[k], all.error(), s.estimated_error, seconds,
                    static_cast<unsigned long long>(s.links.total()), scene->instances[worst].name.c_str(),
                    each[worst].error());
    }
}
