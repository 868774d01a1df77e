#include "solver/factors/closure.h"

#include <algorithm>
#include <cmath>

namespace rro {
namespace {

constexpr int kMostRounds = 50;             // of holding negative exchanges at 0
constexpr double kClosed = 1e-12;           // residual of the linear system, relative
constexpr double kClosedRow = 1e-9;         // |row sum - 1| that counts as reached

const Factor* find(const std::vector<Factor>& row, std::uint32_t to) {
    const auto at = std::lower_bound(row.begin(), row.end(), to, [](const Factor& f, std::uint32_t t) { return f.to < t; });
    return at != row.end() && at->to == to ? &*at : nullptr;
}

/// One exchange of two groups, once; m^2.
struct Exchange {
    std::uint32_t a = 0, b = 0;
    double value = 0;
    bool held = false;  // at 0
};

/// Mean of the two estimates of a pair by the inverse of their variances; an exact one counts alone.
double merged(double k1, double e1, double k2, double e2) {
    if (e1 == 0 && e2 == 0) return 0.5 * (k1 + k2);
    return (k1 * e2 * e2 + k2 * e1 * e1) / (e1 * e1 + e2 * e2);
}

std::vector<Exchange> exchanges_of(const Factors& f) {
    std::vector<Exchange> exchanges;
    for (std::uint32_t i = 0; i < f.rows.size(); ++i)
        for (const Factor& there : f.rows[i]) {
            if (there.to < i) continue;
            double value = f.area[i] * there.value;
            if (const Factor* back = there.to == i ? nullptr : find(f.rows[there.to], i))
                value = merged(value, f.area[i] * static_cast<double>(there.standard_error),
                               f.area[there.to] * back->value,
                               f.area[there.to] * static_cast<double>(back->standard_error));
            if (value > 0) exchanges.push_back({i, there.to, value, false});
        }
    return exchanges;
}

/// sum_j K_ij (m_i + m_j) over the exchanges that are not held; of one group with itself K (m + m) / 2 twice.
void apply(const std::vector<Exchange>& exchanges, const std::vector<double>& m, std::vector<double>& out) {
    std::fill(out.begin(), out.end(), 0.0);
    for (const Exchange& e : exchanges) {
        if (e.held) continue;
        const double both = e.value * (m[e.a] + m[e.b]);
        out[e.a] += both;
        if (e.b != e.a) out[e.b] += both;
    }
}

double dot_of(const std::vector<double>& a, const std::vector<double>& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
    return sum;
}

/// Conjugate gradients from 0, scaled by the diagonal; the system may be singular where it has a solution.
std::vector<double> multipliers(const std::vector<Exchange>& exchanges, const std::vector<double>& missing) {
    const std::size_t n = missing.size();
    std::vector<double> diagonal(n, 0), m(n, 0), r = missing, z(n), q(n);
    for (const Exchange& e : exchanges) {
        if (e.held) continue;
        diagonal[e.a] += e.a == e.b ? 2 * e.value : e.value;
        if (e.b != e.a) diagonal[e.b] += e.value;
    }
    const auto scale = [&] {
        for (std::size_t i = 0; i < n; ++i) z[i] = diagonal[i] > 0 ? r[i] / diagonal[i] : 0;
    };
    scale();
    std::vector<double> p = z;
    double rz = dot_of(r, z);
    const double goal = kClosed * kClosed * rz;
    for (std::size_t step = 0; step < 20 * n + 200 && rz > goal; ++step) {
        apply(exchanges, p, q);
        const double pq = dot_of(p, q);
        if (!(pq > 0)) break;
        const double alpha = rz / pq;
        for (std::size_t i = 0; i < n; ++i) {
            m[i] += alpha * p[i];
            r[i] -= alpha * q[i];
        }
        scale();
        const double next = dot_of(r, z), beta = next / rz;
        rz = next;
        for (std::size_t i = 0; i < n; ++i) p[i] = z[i] + beta * p[i];
    }
    return m;
}

/// Exchanges that close, in place of the old ones; the number of rounds it took.
int solve(std::vector<Exchange>& exchanges, const std::vector<double>& area) {
    for (int round = 1;; ++round) {
        std::vector<double> missing = area;
        for (const Exchange& e : exchanges) {
            if (e.held) continue;
            missing[e.a] -= e.value;
            if (e.b != e.a) missing[e.b] -= e.value;
        }
        const std::vector<double> m = multipliers(exchanges, missing);
        bool all_positive = true;
        for (Exchange& e : exchanges)
            if (!e.held && 1 + m[e.a] + m[e.b] < 0) {
                e.held = true;
                all_positive = false;
            }
        if (!all_positive && round < kMostRounds) continue;
        for (Exchange& e : exchanges) e.value = e.held ? 0 : std::max(0.0, e.value * (1 + m[e.a] + m[e.b]));
        return round;
    }
}

}  // namespace

void ClosureMeter::add_row(std::span<const Factor> row) {
    const auto i = static_cast<std::uint32_t>(report_.row_sum.size());
    double sum = 0;
    for (const Factor& factor : row) sum += factor.value;
    report_.row_sum.push_back(sum);
    const double defect = std::abs(sum - 1);
    if (defect > report_.largest_defect) {
        report_.largest_defect = defect;
        report_.worst_row = i;
    }
    weighted_defect_ += area_[i] * defect;
    weight_ += area_[i];
}

void ClosureMeter::add_pair(std::uint32_t i, std::uint32_t j, double there, double back) {
    const double apart = std::abs(there - back), smaller = std::min(area_[i], area_[j]);
    if (apart > report_.largest_asymmetry * smaller) {
        report_.largest_asymmetry = apart / smaller;
        report_.asymmetric_from = i;
        report_.asymmetric_to = j;
    }
    if (std::max(there, back) > kSmallFactor * std::max(area_[i], area_[j]))
        report_.largest_relative_asymmetry =
            std::max(report_.largest_relative_asymmetry, apart / std::max(there, back));
}

ClosureReport ClosureMeter::report() const {
    ClosureReport report = report_;
    report.mean_defect = weight_ > 0 ? weighted_defect_ / weight_ : 0;
    return report;
}

ClosureReport measure_closure(const Factors& f) {
    ClosureMeter meter(f.area);
    for (std::uint32_t i = 0; i < f.rows.size(); ++i) {
        meter.add_row(f.rows[i]);
        for (const Factor& there : f.rows[i]) {
            if (there.to <= i) continue;
            const Factor* back = find(f.rows[there.to], i);
            meter.add_pair(i, there.to, f.area[i] * there.value, back ? f.area[there.to] * back->value : 0);
        }
    }
    return meter.report();
}

Result<Closing> close_rows(Factors& f) {
    std::vector<Exchange> exchanges = exchanges_of(f);
    Closing closing;
    closing.rounds = solve(exchanges, f.area);
    std::vector<double> sums(f.rows.size(), 0);
    for (const Exchange& e : exchanges) {
        sums[e.a] += e.value / f.area[e.a];
        if (e.b != e.a) sums[e.b] += e.value / f.area[e.b];
    }
    for (std::size_t i = 0; i < sums.size(); ++i)
        if (!(std::abs(sums[i] - 1) <= kClosedRow))
            return failed("", "--close: no factors that keep reciprocity bring the row of \"" + f.names[i] + "\" to 1",
                          "the scene is open, or the row sees too little; leave out --close");
    closing.moved.assign(f.rows.size(), 0);
    closing.sum_moved = sums;
    std::vector<std::vector<Factor>> rows(f.rows.size());
    for (const Exchange& e : exchanges) {
        const auto put = [&](std::uint32_t from, std::uint32_t to) {
            const Factor* old = find(f.rows[from], to);
            rows[from].push_back({to, old ? old->standard_error : 0, e.value / f.area[from]});
        };
        put(e.a, e.b);
        if (e.b != e.a) put(e.b, e.a);
    }
    for (std::uint32_t i = 0; i < f.rows.size(); ++i) {
        std::sort(rows[i].begin(), rows[i].end(), [](const Factor& a, const Factor& b) { return a.to < b.to; });
        for (const Factor& old : f.rows[i]) {
            const Factor* now = find(rows[i], old.to);
            closing.moved[i] = std::max(closing.moved[i], std::abs((now ? now->value : 0) - old.value));
            closing.sum_moved[i] -= old.value;
        }
        if (closing.moved[i] > closing.largest_move) {
            closing.largest_move = closing.moved[i];
            closing.worst_row = i;
        }
    }
    f.rows = std::move(rows);
    return closing;
}

}  // namespace rro
