// Error and cost of the reusable method, by either transport, or of the hierarchical one, against the Monte Carlo
// reference, on one scene.
//
//   accuracy_bench SCENE.json SAMPLES ACCURACY... [--reference-file FILE.csv] [--transport directional|plain]
//                  [--method reusable|hierarchical]
//   e.g. samples/scenes/cornell.json 1024 0.1 0.05 0.02
//
// Error: area-weighted relative root mean square of reflected radiosity over all faces and channels; the reference's own
// variance, which it estimates without bias, is subtracted. Bias: area-weighted mean of B - B_ref, over the mean reflected
// radiosity; its standard error comes from the reference alone.
//
// --reference-file: the reference is read from FILE.csv, or computed and written there where it is missing. It holds one
// line per face, in the order of instances and archives; the scene and its archives must be those it was made from.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include "format/clock.h"
#include "solver/solve_scene.h"

using namespace rro;

namespace {

double face_area(const Instance& instance, std::size_t f) {
    return length(area_vector(instance.world_corners(instance.data().faces[f])));
}

struct Sums {
    double difference = 0, noise = 0, reference = 0;                         // of area times square
    double bias = 0, bias_variance = 0, reflected = 0;                       // of area times value, all channels

    double error() const { return reference > 0 ? std::sqrt(std::max(0.0, difference - noise) / reference) : 0; }
    void add(const Sums& s) {
        difference += s.difference, noise += s.noise, reference += s.reference;
        bias += s.bias, bias_variance += s.bias_variance, reflected += s.reflected;
    }
};

double sum(const Vec3& v) { return v.x + v.y + v.z; }

Sums compare(const Instance& instance, const InstanceSolution& x, const InstanceSolution& truth) {
    Sums s;
    for (std::size_t f = 0; f < truth.radiosity.size(); ++f) {
        const double a = face_area(instance, f);
        const Vec3 b = to_double(truth.radiosity[f]), e = to_double(truth.standard_error[f]);
        const Vec3 r = b - to_double(instance.exitance[instance.object->patch_of_face[f]]);
        const Vec3 off = to_double(x.radiosity[f]) - b;
        s.difference += a * length2(off);
        s.noise += a * length2(e);
        s.reference += a * (length2(r) - length2(e));
        s.bias += a * sum(off);
        s.bias_variance += a * a * sum(e) * sum(e);  // the channels of a path rise and fall together
        s.reflected += a * sum(r);
    }
    return s;
}

Solution timed(const Scene& scene, const SolveOptions& options, double& seconds) {
    const auto start = Clock::now();
    auto solution = solve_scene(scene, options, {});
    seconds = seconds_since(start);
    if (!solution) {
        std::fprintf(stderr, "%s\n", solution.error().message.c_str());
        std::exit(1);
    }
    return std::move(*solution);
}

constexpr const char* kColumns = "instance,face,radiosity_r,radiosity_g,radiosity_b,stderr_r,stderr_g,stderr_b";

bool write_reference(const std::string& path, const Solution& truth) {
    std::FILE* file = std::fopen(path.c_str(), "w");
    if (file == nullptr) return false;
    std::fprintf(file, "%s\n", kColumns);
    for (std::size_t i = 0; i < truth.instances.size(); ++i)
        for (std::size_t f = 0; f < truth.instances[i].radiosity.size(); ++f) {
            const Rgb b = truth.instances[i].radiosity[f], e = truth.instances[i].standard_error[f];
            std::fprintf(file, "%zu,%zu,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g\n", i, f, double(b.x), double(b.y), double(b.z),
                         double(e.x), double(e.y), double(e.z));
        }
    return std::fclose(file) == 0;
}

/// False where the file is not one of this scene's faces.
bool read_reference(std::ifstream& file, const Scene& scene, Solution& truth) {
    std::string line;
    if (!std::getline(file, line) || line != kColumns) return false;
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        InstanceSolution& s = truth.instances.emplace_back();
        for (std::size_t f = 0; f < scene.instances[i].data().faces.size(); ++f) {
            std::size_t instance = 0, face = 0;
            Rgb b, e;
            if (!std::getline(file, line) ||
                std::sscanf(line.c_str(), "%zu,%zu,%f,%f,%f,%f,%f,%f", &instance, &face, &b.x, &b.y, &b.z, &e.x, &e.y,
                            &e.z) != 8 ||
                instance != i || face != f)
                return false;
            s.radiosity.push_back(b);
            s.standard_error.push_back(e);
        }
    }
    return !std::getline(file, line);
}

Solution reference(const Scene& scene, std::uint32_t samples, const std::string& path) {
    Solution truth;
    if (std::ifstream file(path); !path.empty() && file) {
        if (!read_reference(file, scene, truth)) {
            std::fprintf(stderr, "%s: not a reference of this scene; delete it to have it made anew\n", path.c_str());
            std::exit(3);
        }
        std::printf("reference: %s", path.c_str());
    } else {
        SolveOptions options;
        options.method = Method::Reference;
        options.samples = samples;
        double seconds = 0;
        truth = timed(scene, options, seconds);
        if (!path.empty() && !write_reference(path, truth)) {
            std::fprintf(stderr, "%s: cannot be written\n", path.c_str());
            std::exit(1);
        }
        std::printf("reference: %u samples per face, %.2f s", samples, seconds);
    }
    Sums all;
    for (std::size_t i = 0; i < scene.instances.size(); ++i)
        all.add(compare(scene.instances[i], truth.instances[i], truth.instances[i]));
    std::printf(", standard error %.4f, of the mean %.5f\n", all.reference > 0 ? std::sqrt(all.noise / all.reference) : 0.0,
                all.reflected > 0 ? std::sqrt(all.bias_variance) / all.reflected : 0.0);
    return truth;
}

void print_row(const char* asked, const Scene& scene, const Solution& s, const Solution& truth, double seconds) {
    Sums all;
    std::vector<Sums> each;
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        each.push_back(compare(scene.instances[i], s.instances[i], truth.instances[i]));
        all.add(each.back());
    }
    constexpr double kMatters = 1e-3;  // of all reflected power
    double worst = 0;
    std::string name;
    for (std::size_t i = 0; i < each.size(); ++i)
        if (each[i].reflected > kMatters * all.reflected && each[i].error() > worst) {
            worst = each[i].error();
            name = scene.instances[i].name;
        }
    const double links = double(s.links.total());
    std::printf("%-8s %-8.4f %-9.4f %-10.2f %+-9.4f %-9.2f %-8.2f %-8.2f %-9llu %-10.0f %-10.1f %-10llu %s %.3f\n", asked, all.error(),
                s.estimated_error, all.error() > 0 ? s.estimated_error / all.error() : 0.0,
                all.reflected > 0 ? all.bias / all.reflected : 0.0, seconds, s.seconds.links + s.seconds.visibility, s.seconds.iterate,
                static_cast<unsigned long long>(s.elements), links,
                links > 0 ? double(s.links.bytes) / links : 0.0, static_cast<unsigned long long>(s.rays), name.c_str(), worst);
}

}  // namespace

int main(int argc, char** argv) {
    std::vector<const char*> words;
    std::string file, transport = "directional", method_name = "reusable";
    for (int k = 1; k < argc; ++k) {
        if (std::string(argv[k]) == "--reference-file" && k + 1 < argc) file = argv[++k];
        else if (std::string(argv[k]) == "--transport" && k + 1 < argc) transport = argv[++k];
        else if (std::string(argv[k]) == "--method" && k + 1 < argc) method_name = argv[++k];
        else words.push_back(argv[k]);
    }
    const auto how = parse_transport(transport);
    const auto method = parse_method(method_name);
    if (words.size() < 3 || !how || !method) {
        std::fprintf(stderr, "usage: accuracy_bench SCENE.json SAMPLES ACCURACY... [--reference-file FILE.csv] "
                             "[--transport directional|plain] [--method reusable|hierarchical]\n");
        return 2;
    }
    auto manifest = read_manifest(words[0]);
    if (!manifest) return std::fprintf(stderr, "%s\n", manifest.error().message.c_str()), 3;
    auto scene = open_scene(std::move(*manifest));
    if (!scene) return std::fprintf(stderr, "%s\n", scene.error().message.c_str()), 3;

    std::printf("%s: %zu triangles, %zu instances; ", words[0], scene->triangle_count(), scene->instances.size());
    const Solution truth = reference(*scene, static_cast<std::uint32_t>(std::atoi(words[1])), file);
    std::printf("%-8s %-8s %-9s %-10s %-9s %-9s %-8s %-8s %-9s %-10s %-10s %-10s %s\n", "asked", "error", "estimate", "est/error",
                "bias", "seconds", "links s", "iter. s", "elements", "links", "bytes/link", "rays",
                "worst instance above 0.1 % of the light");
    for (std::size_t k = 2; k < words.size(); ++k) {
        SolveOptions options;
        options.accuracy = std::atof(words[k]);
        options.method = *method;
        if (*method == Method::Reusable) options.transport = *how;
        double seconds = 0;
        const Solution s = timed(*scene, options, seconds);
        print_row(words[k], *scene, s, truth, seconds);
    }
}
