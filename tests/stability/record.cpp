#include "tests/stability/record.h"

#define CATCH_CONFIG_EXTERNAL_INTERFACES
#include <catch2/catch.hpp>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <utility>
#include <vector>

namespace rro::test {
namespace {

struct Row {
    std::string family, what, law;
    double bound = 0, worst = 0;
};

std::vector<Row>& rows() {
    static std::vector<Row> all;
    return all;
}

constexpr std::pair<const char*, const char*> kFamilies[] = {
    {"kernels", "Kernels: form factors of squares, triangles and disks"},
    {"invariance", "Invariance: the same scene, told otherwise"},
    {"balance", "Balance: furnaces, energy, bounds"},
    {"geometry", "Geometry as it is"},
    {"light", "Light: strong, weak, none"},
    {"sampling", "Sampling: visibility by few rays"},
    {"scale", "Scale: many instances, large beside small, edits"},
    {"transforms", "Transforms: mirrored, sheared, almost singular"},
    {"commands", "By hand: too long for every build"},
};

constexpr const char* kIntroduction = R"(# Stability: hard cases and the laws they obey

Written by the tests themselves:

    RRO_STABILITY_PAGE=tests/stability/README.md build/dev/bin/stability_tests

Each test run checks that this page names the same cases, laws and bounds (`check_page.sh`). A measured value above its
bound fails; the reason for each bound stands beside the case in the source, one file per family. One family alone:
`build/dev/bin/stability_tests '[kernels]'`; the large cases, which are no part of every build:
`build/dev/bin/stability_tests '[commands]'`. With sanitizers, as in `tests/run.sh --asan`; float casts and integer
arithmetic are trapped there too.

Relative errors where nothing else is said. Bound 0 means: to the last bit.
)";

std::string number(double x) {
    char text[32];
    std::snprintf(text, sizeof text, "%.3g", x);
    return text;
}

void write_page(const std::string& file) {
    std::ofstream out(file);
    out << kIntroduction;
    int section = 0;
    for (const auto& [family, title] : kFamilies) {
        ++section;
        std::string table;
        for (const Row& r : rows())
            if (r.family == family)
                table += "| " + r.what + " | " + r.law + " | " + number(r.bound) + " | " + number(r.worst) + " |\n";
        if (table.empty()) continue;
        out << "\n## " << section << ". " << title << " `[" << family << "]`\n\n"
            << "| case | law | bound | measured worst |\n|---|---|---|---|\n" << table;
    }
}

/// Writes the page when all tests have run, where the environment names a file for it.
class PageWriter : public Catch::TestEventListenerBase {
  public:
    using TestEventListenerBase::TestEventListenerBase;
    void testRunEnded(const Catch::TestRunStats&) override {
        if (const char* file = std::getenv("RRO_STABILITY_PAGE")) write_page(file);
    }
};
CATCH_REGISTER_LISTENER(PageWriter)

}  // namespace

void record(const std::string& family, const std::string& what, const std::string& law, double bound, double worst) {
    REQUIRE(std::any_of(std::begin(kFamilies), std::end(kFamilies), [&](const auto& f) { return f.first == family; }));
    INFO(family << ": " << what << ": " << law);
    CHECK(worst <= bound);
    const auto same = [&](const Row& r) { return r.family == family && r.what == what && r.law == law; };
    const auto at = std::find_if(rows().begin(), rows().end(), same);
    if (at == rows().end())
        rows().push_back({family, what, law, bound, worst});
    else
        at->worst = std::max(at->worst, worst);
}

}  // namespace rro::test
