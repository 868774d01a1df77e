#include "format/atomic_file.h"

#include <csignal>

#include <catch2/catch.hpp>
#include <sys/resource.h>
#include <unistd.h>

#include "tests/support/temporary_folder.h"

using namespace rro;
using test::file_text;
using test::TemporaryFolder;

namespace {

std::size_t files_in(const std::filesystem::path& folder) {
    return static_cast<std::size_t>(
        std::distance(std::filesystem::directory_iterator(folder), std::filesystem::directory_iterator()));
}

/// Files of this process cannot grow beyond `bytes` while it lives: a full disk on demand.
class FileSizeLimit {
  public:
    explicit FileSizeLimit(rlim_t bytes) : signal_(::signal(SIGXFSZ, SIG_IGN)) {
        ::getrlimit(RLIMIT_FSIZE, &before_);
        const rlimit limit{bytes, before_.rlim_max};
        ::setrlimit(RLIMIT_FSIZE, &limit);
    }
    ~FileSizeLimit() {
        ::setrlimit(RLIMIT_FSIZE, &before_);
        ::signal(SIGXFSZ, signal_);
    }

  private:
    rlimit before_{};
    sighandler_t signal_;
};

}  // namespace

TEST_CASE("a file is written, replaced, and nothing is left beside it", "[atomic_file]") {
    const TemporaryFolder folder;
    const auto path = folder / "out.txt";
    REQUIRE(write_file_atomically(path, std::string_view("first")));
    CHECK(file_text(path) == "first");
    REQUIRE(write_file_atomically(path, std::string_view("")));
    CHECK(file_text(path).empty());
    const std::vector<std::byte> bytes{std::byte{0}, std::byte{255}};
    REQUIRE(write_file_atomically(path, bytes));
    CHECK(file_text(path) == std::string("\0\xff", 2));
    CHECK(files_in(folder.path()) == 1);
}

TEST_CASE("where the folder is missing, nothing appears and the file is named", "[atomic_file]") {
    const TemporaryFolder folder;
    const auto path = folder / "missing" / "out.txt";
    const Status status = write_file_atomically(path, std::string_view("text"));
    REQUIRE_FALSE(status);
    CHECK(status.error().kind == ErrorKind::Failed);
    CHECK(status.error().where == path.string());
    CHECK(status.error().message.find("No such file") != std::string::npos);
    CHECK(files_in(folder.path()) == 0);
}

TEST_CASE("where the folder may not be written to the old content stays", "[atomic_file]") {
    if (::geteuid() == 0) {
        WARN("the administrator may write anywhere: nothing was tested");
        return;
    }
    const TemporaryFolder folder;
    const auto path = folder / "out.txt";
    REQUIRE(write_file_atomically(path, std::string_view("old")));
    using std::filesystem::perms;
    std::filesystem::permissions(folder.path(), perms::owner_read | perms::owner_exec);
    const Status status = write_file_atomically(path, std::string_view("new"));
    REQUIRE_FALSE(status);
    CHECK(status.error().kind == ErrorKind::Failed);
    CHECK(file_text(path) == "old");
    CHECK(files_in(folder.path()) == 1);
}

TEST_CASE("where a write fails half-way the old content stays and the half is removed", "[atomic_file]") {
    const TemporaryFolder folder;
    const auto path = folder / "out.txt";
    REQUIRE(write_file_atomically(path, std::string_view("old")));
    const FileSizeLimit limit(10);
    const Status status = write_file_atomically(path, std::string(100, 'n'));
    REQUIRE_FALSE(status);
    CHECK(status.error().kind == ErrorKind::Failed);
    CHECK(status.error().message.find("File too large") != std::string::npos);
    CHECK(file_text(path) == "old");
    CHECK(files_in(folder.path()) == 1);
}

TEST_CASE("a folder in the target's place is refused and stays", "[atomic_file]") {
    const TemporaryFolder folder;
    std::filesystem::create_directory(folder / "out");
    const Status status = write_file_atomically(folder / "out", std::string_view("text"));
    REQUIRE_FALSE(status);
    CHECK(status.error().kind == ErrorKind::Failed);
    CHECK(files_in(folder.path()) == 1);
}

TEST_CASE("permissions stay, links keep pointing to their file", "[atomic_file]") {
    const TemporaryFolder folder;
    const auto path = folder / "real.txt", link = folder / "link.txt";
    REQUIRE(write_file_atomically(path, std::string_view("old")));
    std::filesystem::permissions(path, std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
    std::filesystem::create_symlink("real.txt", link);
    REQUIRE(write_file_atomically(link, std::string_view("new")));
    CHECK(std::filesystem::is_symlink(link));
    CHECK(file_text(path) == "new");
    CHECK(std::filesystem::status(path).permissions() ==
          (std::filesystem::perms::owner_read | std::filesystem::perms::owner_write));
}

TEST_CASE("a device is written to, not replaced", "[atomic_file]") {
    REQUIRE(write_file_atomically("/dev/null", std::string_view("text")));
    CHECK(std::filesystem::is_character_file("/dev/null"));
}
