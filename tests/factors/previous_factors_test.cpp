#include "solver/factors/previous_factors.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "solver/factors/factors_output.h"
#include "tests/support/scenes.h"
#include "tests/support/shapes.h"
#include "tests/support/temporary_folder.h"

using namespace rro;
using namespace rro::test;

namespace {

Placed tile(const std::string& name, const Vec3& corner, const Vec3& u, const Vec3& v) {
    Mesh mesh = empty_mesh(false);
    add_parallelogram(mesh, corner, u, v, 1, false);
    Placed placed{mesh};
    placed.name = name;
    return placed;
}

const Vec3 ex{1, 0, 0}, ez{0, 0, 1};

/// A long floor and ceiling of ten tiles each, and a box between them that stands at x.
std::vector<Placed> hall(double x) {
    std::vector<Placed> placed;
    for (int k = 0; k < 10; ++k) {
        placed.push_back(tile("floor" + std::to_string(k), ex * k, ez, ex));
        placed.push_back(tile("ceiling" + std::to_string(k), ex * k + Vec3{0, 1, 0}, ex, ez));
    }
    Placed box{make_box(0.4, 0.4, 0.4)};
    box.name = "box";
    box.to_world = translation({x, 0.5, 0.5});
    placed.push_back(box);
    return placed;
}

Factors factors_of(const Scene& scene, const FactorOptions& options) {
    auto factors = view_factors(scene, options);
    if (!factors) FAIL(factors.error().message);
    return *std::move(factors);
}

PreviousFactors written_and_read(const Factors& factors, const std::filesystem::path& path) {
    REQUIRE(write_factors(factors, {}, false, path));
    auto read = read_previous_factors(path);
    if (!read) FAIL(read.error().message);
    return *std::move(read);
}

/// Every number of both is the same but for the rounding of kernels whose ends are swapped; those of which either has an
/// error lie within their reported errors.
void check_same(const Factors& a, const Factors& b) {
    REQUIRE(a.names == b.names);
    for (std::size_t i = 0; i < a.rows.size(); ++i) {
        REQUIRE(a.rows[i].size() == b.rows[i].size());
        for (std::size_t k = 0; k < a.rows[i].size(); ++k) {
            REQUIRE(a.rows[i][k].to == b.rows[i][k].to);
            const double error = static_cast<double>(a.rows[i][k].standard_error + b.rows[i][k].standard_error);
            CHECK(std::abs(a.rows[i][k].value - b.rows[i][k].value) <= 3 * error + 1e-12);
        }
    }
}

}  // namespace

// The box moves at one end of the hall: pairs at the other end are taken over, and the whole is what it is from scratch.
TEST_CASE("after a move only rows of what moved and pairs it shadows are computed again", "[factors][reuse]") {
    const TemporaryFolder folder;
    FactorOptions options;
    const PreviousFactors before =
        written_and_read(factors_of(make_scene(hall(1.5), least_tables()), options), folder.path() / "before.json");
    const Scene moved = make_scene(hall(2.4), least_tables());
    const Factors scratch = factors_of(moved, options);
    CHECK(scratch.counts.reused == 0);
    options.previous = &before;
    const Factors again = factors_of(moved, options);
    check_same(again, scratch);
    CHECK(again.closure.largest_defect == Approx(scratch.closure.largest_defect).epsilon(1e-3));
    // Of 21 groups the seven last tiles of floor and ceiling see one another past nothing; nearer ones also see the box.
    CHECK(again.counts.reused >= 14 * 14);
    CHECK(again.counts.reused < 20 * 20);

    const Factors same = factors_of(make_scene(hall(1.5), least_tables()), options);
    CHECK(same.counts.reused == 21 * 21);
    check_same(same, before);
}

// Numbers of groups change when an instance comes or goes; names tell which they were.
TEST_CASE("what has come and gone is told by its name", "[factors][reuse]") {
    const TemporaryFolder folder;
    FactorOptions options;
    const Scene with = make_scene(hall(1.5), least_tables());
    std::vector<Placed> empty = hall(1.5);
    empty.pop_back();
    std::reverse(empty.begin(), empty.end());
    const Scene without = make_scene(empty, least_tables());
    const PreviousFactors full = written_and_read(factors_of(with, options), folder.path() / "full.json");
    const PreviousFactors bare = written_and_read(factors_of(without, options), folder.path() / "bare.json");
    options.previous = &full;
    const Factors gone = factors_of(without, options);
    check_same(gone, bare);
    CHECK(gone.counts.reused > 0);
    options.previous = &bare;
    const Factors come = factors_of(with, options);
    check_same(come, full);
    CHECK(come.counts.reused > 0);
}

TEST_CASE("blocks of rows are the same bits as the whole", "[factors]") {
    const Scene scene = make_scene(hall(1.5), least_tables());
    FactorOptions options;
    const Factors whole = factors_of(scene, options);
    options.numbers_at_a_time = 21 * 4;
    std::vector<FactorRow> rows;
    std::size_t largest = 0;
    const auto table = view_factors(scene, options, [&](const FactorTable&, std::uint32_t first, std::span<const FactorRow> some) -> Status {
        CHECK(first == rows.size());
        rows.insert(rows.end(), some.begin(), some.end());
        largest = std::max(largest, some.size());
        return Done{};
    });
    REQUIRE(table);
    CHECK(largest == 4);
    REQUIRE(rows.size() == whole.rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i) {
        REQUIRE(rows[i].size() == whole.rows[i].size());
        for (std::size_t k = 0; k < rows[i].size(); ++k) {
            CHECK(rows[i][k].to == whole.rows[i][k].to);
            CHECK(rows[i][k].value == whole.rows[i][k].value);
            CHECK(rows[i][k].standard_error == whole.rows[i][k].standard_error);
        }
    }
    CHECK(table->closure.row_sum == whole.closure.row_sum);
}

TEST_CASE("factors that cannot be reused are refused by name", "[factors][reuse]") {
    const TemporaryFolder folder;
    const auto path = folder.path() / "f.json";
    const Scene scene = make_scene(hall(1.5), least_tables());
    const Factors f = factors_of(scene, {});
    const auto refused = [&](const std::string& what) {
        const auto read = read_previous_factors(path);
        REQUIRE(!read);
        CHECK(read.error().kind == ErrorKind::BadInput);
        CHECK(read.error().where == path.string());
        CHECK(read.error().message.find(what) != std::string::npos);
    };
    REQUIRE(write_factors(f, 1e-3, false, path));
    refused("threshold");
    REQUIRE(write_factors(f, {}, true, path));
    refused("closed");
    for (const char* text : {"", "[1, 2", "{}", "{\"format\": \"rro-factors/1\", \"rows\": [{\"from\": 3, \"to\": []}]}",
                             "{\"format\": \"rro-factors/1\", \"rows\": [{\"from\": 0, \"to\": [1], \"factor\": [], "
                             "\"standard_error\": []}]}"}) {
        REQUIRE(write_file_atomically(path, std::string_view(text)));
        refused("expected a matrix");
    }
    CHECK(!read_previous_factors(folder.path() / "none.json"));

    PreviousFactors other = written_and_read(f, path);
    other.options.accuracy = 0.5;
    FactorOptions options;
    options.previous = &other;
    const auto computed = view_factors(scene, options);
    REQUIRE(!computed);
    CHECK(computed.error().message.find("other options") != std::string::npos);
}
