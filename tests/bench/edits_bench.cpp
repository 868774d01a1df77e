// What edits cost: replays a recorded list of edits on a scene, each followed by a solve, and compares the end with a solve
// from scratch.
//
//   edits_bench SCENE.json EDITS.txt [ACCURACY] [REPEATS]
//
// Lines of EDITS.txt: move NAME dx dy dz | place NAME LIKE dx dy dz | delete NAME | material NAME r g b | dim GROUP scale.
// Distances are in metres; every second repeat moves back.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "format/clock.h"
#include "solver/session.h"

using namespace rro;

namespace {

struct Figures {
    std::vector<double> ms;
    std::uint64_t removed = 0, retested = 0, added = 0;
};

[[noreturn]] void fail(const Error& error) {
    std::fprintf(stderr, "edits_bench: %s: %s\n", error.where.c_str(), error.message.c_str());
    std::exit(1);
}

const Instance& instance_of(const SceneSession& session, const std::string& name) {
    for (const Instance& i : session.scene().instances)
        if (i.name == name) return i;
    fail({ErrorKind::BadInput, name, "no such instance", ""});
}

Status apply(SceneSession& session, std::istringstream& line, const std::string& kind, double sign) {
    std::string name, like;
    line >> name;
    if (kind == "place") line >> like;
    double x = 0, y = 0, z = 0;
    line >> x >> y >> z;
    if (kind == "delete") return session.remove(name);
    if (kind == "material") return session.set_reflectance(name, "*", {x, y, z});
    if (kind == "dim") return session.dim(name, x);
    const Instance& from = instance_of(session, kind == "place" ? like : name);
    Affine3 place = from.to_world;
    place.translation += Vec3{x, y, z} * sign;
    return kind == "move" ? session.move(name, place) : session.place(name, from.object->path, place);
}

/// Root mean square over the area, relative to b's.
double reflected_difference(const Scene& scene, const Solution& a, const Solution& b) {
    double sum = 0, all = 0;
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const Instance& instance = scene.instances[i];
        for (std::size_t f = 0; f < instance.data().faces.size(); ++f) {
            const double area = length(area_vector(instance.world_corners(instance.data().faces[f])));
            const Vec3 x = to_double(a.instances[i].radiosity[f]), y = to_double(b.instances[i].radiosity[f]);
            sum += area * length2(x - y);
            all += area * length2(y - to_double(instance.exitance[instance.object->patch_of_face[f]]));
        }
    }
    return std::sqrt(sum / all);
}

double resident_megabytes() {
    std::ifstream status("/proc/self/statm");
    double pages = 0;
    status >> pages >> pages;
    return pages * 4096 / 1e6;
}

}  // namespace

int main(int count, char** words) {
    if (count < 3) return std::fprintf(stderr, "usage: edits_bench SCENE.json EDITS.txt [ACCURACY] [REPEATS]\n"), 2;
    SolveOptions options;
    if (count > 3) options.accuracy = std::atof(words[3]);
    const int repeats = count > 4 ? std::atoi(words[4]) : 2;
    auto session = SceneSession::open(words[1], options);
    if (!session) fail(session.error());
    const auto start = Clock::now();
    const auto first = session->solve();
    if (!first) fail(first.error());
    const double first_ms = milliseconds_since(start);
    std::printf("first solve: %.0f ms, %.0f links, estimate %.4f, %.0f MB\n", first_ms, double((*first)->links.total()),
                (*first)->estimated_error, resident_megabytes());

    std::map<std::string, Figures> kinds;
    for (int repeat = 0; repeat < repeats; ++repeat) {
        std::ifstream edits(words[2]);
        for (std::string text; std::getline(edits, text);) {
            std::istringstream line(text);
            std::string kind;
            if (!(line >> kind) || kind[0] == '#') continue;
            const auto begun = Clock::now();
            if (const auto done = apply(*session, line, kind, repeat % 2 == 0 ? 1 : -1); !done) fail(done.error());
            const auto solved = session->solve();
            if (!solved) fail(solved.error());
            const double ms = milliseconds_since(begun);
            Figures& figures = kinds[kind == "move" ? text.substr(0, text.find(' ', 5)) : kind];
            figures.ms.push_back(ms);
            figures.removed += session->change().removed;
            figures.retested += session->change().retested;
            figures.added += session->change().added;
            std::printf("%-36s %8.0f ms, estimate %.4f, %8.0f links (-%.0f ~%.0f +%.0f), %.0f MB\n", text.c_str(), ms,
                        (*solved)->estimated_error, double((*solved)->links.total()), double(session->change().removed),
                        double(session->change().retested), double(session->change().added), resident_megabytes());
            std::fflush(stdout);
        }
    }
    std::printf("\n| edit | median, ms | 95th percentile, ms | first solve / median | removed | retested | added |\n|---|---|---|---|---|---|---|\n");
    for (auto& [kind, figures] : kinds) {
        std::sort(figures.ms.begin(), figures.ms.end());
        const std::size_t n = figures.ms.size();
        const double median = figures.ms[n / 2], high = figures.ms[std::min(n - 1, n * 95 / 100)];
        std::printf("| %s | %.0f | %.0f | %.0f | %.0f | %.0f | %.0f |\n", kind.c_str(), median, high, first_ms / median,
                    double(figures.removed) / double(n), double(figures.retested) / double(n), double(figures.added) / double(n));
    }
    // The scene as it has become, by a session that knows nothing of the edits.
    SceneSolver alone;
    const auto again = Clock::now();
    const auto shared = std::make_shared<const Scene>(session->scene());
    auto scratch = alone.solve(shared, options);
    if (!scratch) fail(scratch.error());
    std::printf("\nfrom scratch at the end: %.0f ms, %.0f links, estimate %.4f; difference of the reflected light: %.5f\n",
                milliseconds_since(again), double(scratch->links.total()), scratch->estimated_error,
                reflected_difference(session->scene(), session->solution(), *scratch));
    return 0;
}
