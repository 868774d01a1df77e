// What a library may do to the process that it runs in, done on purpose.
#include "compiler/import_process.h"

#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <stdexcept>
#include <thread>
#include <vector>

#include "compiler/import_transfer.h"
#include "tests/support/temporary_folder.h"

using namespace rro;

namespace {

#if defined(__SANITIZE_ADDRESS__)
constexpr bool sanitized = true;
#else
constexpr bool sanitized = false;
#endif

bool has(const std::string& text, const std::string& part) {
    return text.find(part) != text.npos;
}

Error contained_error(const std::function<std::string()>& work, const ContainmentLimits& limits = {}) {
    const auto result = run_contained("a.obj", work, limits);
    REQUIRE(!result);
    CHECK(result.error().where == "a.obj");
    CHECK(!result.error().hint.empty());
    return result.error();
}

/// No child is left, running or dead.
bool has_no_children() {
    return waitpid(-1, nullptr, WNOHANG) == -1 && errno == ECHILD;
}

/// Two triangles with two materials, one of them textured; nothing is empty that could be filled.
ImportedMesh filled() {
    ImportedMesh imported;
    Mesh& mesh = imported.mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    mesh.triangles = {{0, 1, 2}, {0, 1, 3}};
    mesh.source_triangle = {0, 2};
    mesh.material = {0, 1};
    mesh.reflectance = {{0.5f, 0.25f, 0.125f}, {0, 0, 0}};
    mesh.materials = {{"a", {0.1, 0.2, 0.3}, {1, 2, 3}, true}, {"", {}, {}, false}};
    mesh.two_sided = {1, 0};
    mesh.source_triangles = 3;
    mesh.closed = true;
    mesh.slits = {{1, 2, 3}};
    imported.report = {3, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, {1, 2, 3}, {"one", "", "three"}, {"absent.mtl"}};
    imported.sha256 = "00ff";
    imported.files = {"a.obj", "b c.mtl"};
    return imported;
}

}  // namespace

TEST_CASE("a contained function's answer comes back whole", "[import][process]") {
    CHECK(*run_contained("", [] { return std::string(); }, {}) == "");
    std::string large(5'000'000, 'x');  // more than any pipe holds
    large[4'999'999] = '\0';
    CHECK(*run_contained("", [&] { return large; }, {}) == large);
    CHECK(has_no_children());
}

TEST_CASE("a crash in a contained function is an error that names the signal", "[import][process]") {
    const auto raising = [](int signal) {
        return contained_error([signal] {
            std::signal(signal, SIG_DFL);  // also where a sanitizer would report it
            std::raise(signal);
            return std::string();
        });
    };
    CHECK(has(raising(SIGSEGV).message, "stopped by signal SIGSEGV"));
    CHECK(has(raising(SIGABRT).message, "stopped by signal SIGABRT"));
    CHECK(has(raising(SIGKILL).message, "stopped by signal SIGKILL"));
    CHECK(raising(SIGFPE).kind == ErrorKind::BadInput);
    CHECK(has_no_children());
}

TEST_CASE("a contained function that does not end is ended, busy or idle", "[import][process]") {
    const Error busy = contained_error(
        [] {
            for (std::atomic<unsigned> i = 0;; ++i) {
            }
            return std::string();
        },
        {.cpu_seconds = 1});
    CHECK(has(busy.message, "more than 1 s of CPU"));
    const Error idle = contained_error(
        [] {
            for (;;) pause();
            return std::string();
        },
        {.wall_seconds = 1});
    CHECK(has(idle.message, "no end in 1 s"));
    CHECK(has_no_children());
}

TEST_CASE("a contained function has the memory it may have, and no more", "[import][process]") {
    const auto taking = [](std::size_t bytes) {
        return [bytes] { return std::to_string(std::vector<char>(bytes, 'x').size()); };
    };
    ContainmentLimits limits;
    limits.memory_bytes = std::uint64_t{1} << 28;
    CHECK(*run_contained("", taking(std::size_t{1} << 27), limits) == std::to_string(1 << 27));
    if (sanitized) return;  // not limited there
    const Error error = contained_error(taking(std::size_t{1} << 29), limits);
    CHECK(error.kind == ErrorKind::BadInput);
    CHECK(has(error.message, "than the 0.25 GiB"));
}

TEST_CASE("an exception in a contained function is an internal error with its text", "[import][process]") {
    const Error error = contained_error([]() -> std::string { throw std::runtime_error("by design"); });
    CHECK(error.kind == ErrorKind::Internal);
    CHECK(has(error.message, "by design"));
}

TEST_CASE("a contained function ignores Ctrl-C, but does not outlive its caller", "[import][process]") {
    CHECK(*run_contained("",
                         [] {
                             std::raise(SIGINT);
                             std::raise(SIGTERM);
                             return std::string("still here");
                         },
                         {}) == "still here");
    // A process in between: it waits for a child that never ends, and is killed.
    int ends[2];
    REQUIRE(pipe(ends) == 0);
    const pid_t between = fork();
    if (between == 0) {
        dup2(ends[1], STDIN_FILENO);  // the standard streams are all that a contained function has of its caller's
        const auto ignored = run_contained("",
                                           [] {
                                               const pid_t self = getpid();
                                               const bool written =
                                                   write(STDIN_FILENO, &self, sizeof self) == sizeof self;
                                               for (; written;) pause();
                                               return std::string();
                                           },
                                           {});
        _exit(ignored ? 0 : 1);
    }
    pid_t child = 0;
    REQUIRE(read(ends[0], &child, sizeof child) == sizeof child);
    close(ends[1]);
    kill(between, SIGKILL);
    CHECK(waitpid(between, nullptr, 0) == between);
    // The child's end of the pipe is closed when it is gone; a test that hangs here has failed.
    CHECK(read(ends[0], &child, sizeof child) == 0);
    close(ends[0]);
}

TEST_CASE("meshes are imported in contained processes from several threads at once", "[import][process]") {
    const test::TemporaryFolder folder;
    std::ofstream(folder / "a.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    std::ofstream(folder / "b.obj") << "v 0 0 0\nf 1 2 3\n";
    std::vector<int> good(4, 0);
    std::vector<std::thread> threads;
    for (int& count : good)
        threads.emplace_back([&] {
            for (int i = 0; i < 10; ++i) {
                const auto a = import_mesh_contained(folder / "a.obj", {}, TwoSided::Auto, false);
                const auto b = import_mesh_contained(folder / "b.obj", {}, TwoSided::Auto, false);
                count +=
                    a && a->mesh.two_sided == std::vector<std::uint8_t>{1} && !b && has(b.error().where, "b.obj:2");
            }
        });
    for (std::thread& thread : threads) thread.join();
    CHECK(good == std::vector<int>(4, 10));
    CHECK(has_no_children());
}

TEST_CASE("an imported mesh is the same behind the transfer, an error too", "[import][transfer]") {
    const std::string bytes = encode_import(filled());
    const auto back = decode_import(bytes);
    REQUIRE((back && *back));
    CHECK(encode_import(*back) == bytes);
    CHECK((*back)->mesh.materials[0].exitance == Vec3{1, 2, 3});
    CHECK((*back)->report.warnings == filled().report.warnings);
    CHECK((*back)->report.absent == filled().report.absent);
    CHECK((*back)->report.winding_fixed == 17);
    CHECK((*back)->files == filled().files);

    const auto error = decode_import(encode_import(Error{ErrorKind::Usage, "a", "b", "c"}));
    REQUIRE((error && !*error));
    CHECK(error->error().kind == ErrorKind::Usage);
    CHECK(error->error().hint == "c");
}

TEST_CASE("an answer that is cut off, or longer than it is, is none", "[import][transfer]") {
    const std::string bytes = encode_import(filled());
    std::size_t taken = 0;
    for (std::size_t size = 0; size < bytes.size(); ++size) taken += decode_import(bytes.substr(0, size)) ? 1 : 0;
    CHECK(taken == 0);
    CHECK(!decode_import(bytes + "x"));
    std::string huge = bytes;
    huge.replace(1, 8, 8, '\xff');  // the number of positions
    CHECK(!decode_import(huge));
}
