// Prints nanoseconds per call of the kernels in the inner loops: the least of many rounds over inputs that fit the
// cache.
#include <chrono>
#include <cstdio>
#include <limits>
#include <random>
#include <vector>

#include "format/form_factor.h"
#include "format/sample_points.h"

namespace {

using namespace rro;

constexpr std::size_t kInputs = 1000;  // 144 kB of views: the second-level cache
constexpr int kRounds = 300;

/// A receiving point, its normal, and what it looks at.
struct View {
    Vec3 p, n;
    TriangleCorners t;
};

/// Which of the kernel's ways a view takes: how many corners are above the horizon, and whether it sees the front.
struct Kind {
    const char* name;
    double size;  // of the triangle, in units of the distance
    bool front;
    int least_above, most_above;
};

class Random {
  public:
    Vec3 point() { return {uniform_(engine_), uniform_(engine_), uniform_(engine_)}; }

  private:
    std::mt19937_64 engine_{1};
    std::uniform_real_distribution<double> uniform_{-1, 1};
};

std::vector<View> views_of(const Kind& kind, Random& random) {
    std::vector<View> views;
    while (views.size() < kInputs) {
        View view{normalised(random.point()), normalised(random.point()), {}};
        for (Vec3& corner : view.t) corner = random.point() * kind.size;
        int above = 0;
        for (const Vec3& corner : view.t) above += dot(view.n, corner - view.p) > 0;
        const bool front = dot(area_vector(view.t), view.p - view.t[0]) > 0;
        if (front == kind.front && above >= kind.least_above && above <= kind.most_above) views.push_back(view);
    }
    return views;
}

/// Prints the least time over the rounds, and the sum of the results, which keeps the calls from being left out.
template <class Kernel>
void measure(const char* name, std::size_t calls, Kernel&& kernel) {
    double best = std::numeric_limits<double>::infinity(), sum = 0;
    for (int round = 0; round < kRounds; ++round) {
        const auto start = std::chrono::steady_clock::now();
        for (std::size_t i = 0; i < calls; ++i) sum += kernel(i);
        const std::chrono::duration<double, std::nano> took = std::chrono::steady_clock::now() - start;
        best = std::min(best, took.count() / static_cast<double>(calls));
    }
    std::printf("%-36s %8.1f ns per call   (checksum %.6g)\n", name, best, sum / kRounds);
}

}  // namespace

int main() {
    Random random;
    for (const Kind& kind :
         {Kind{"point_to_triangle, far", 0.01, true, 3, 3}, Kind{"point_to_triangle, middle", 0.2, true, 3, 3},
          Kind{"point_to_triangle, near", 1, true, 3, 3}, Kind{"point_to_triangle, clipped", 1, true, 1, 2},
          Kind{"point_to_triangle, below horizon", 1, true, 0, 0},
          Kind{"point_to_triangle, from behind", 1, false, 0, 3}}) {
        const std::vector<View> views = views_of(kind, random);
        measure(kind.name, kInputs,
                [&](std::size_t i) { return point_to_triangle(views[i].p, views[i].n, views[i].t); });
    }
    const std::vector<View> near = views_of({"", 1, true, 3, 3}, random);
    measure("point_to_polygon, near, 3 corners", kInputs,
            [&](std::size_t i) { return point_to_polygon(near[i].p, near[i].n, near[i].t); });
    measure("polygon_vector_irradiance, near", kInputs,
            [&](std::size_t i) { return polygon_vector_irradiance(near[i].p, near[i].t).x; });
    measure("disk_to_disk", kInputs, [&](std::size_t i) { return disk_to_disk(1 + near[i].p.x, 1 + near[i].p.y); });
    measure("sobol4", kInputs, [](std::size_t i) { return double(sobol4(static_cast<std::uint32_t>(i), 1)[0]); });
    measure("exchange_area", 20, [&](std::size_t i) {
        return exchange_area(near[i].t, {near[i].p, near[i].p + near[i].n, near[i].t[0]}, 1e-4);
    });
    return 0;
}
