// The smallest archive, cut at every length and changed at every byte, in a buffer of its own each time so that an
// overrun meets the sanitizer.
#include <catch2/catch.hpp>

#include "format/archive_reader.h"
#include "format/archive_writer.h"
#include "tests/support/tiny_object.h"

using namespace rro;

namespace {

using Bytes = std::vector<std::byte>;

Bytes small_archive() {
    auto bytes = encode_archive(test::tiny_object(2).data());
    REQUIRE(bytes);
    return *std::move(bytes);
}

bool refused(const Bytes& bytes) {
    const auto archive = Archive::from_bytes(Bytes(bytes.begin(), bytes.end()), "small.rro");
    if (archive) return false;
    return archive.error().kind == ErrorKind::BadInput && archive.error().where.starts_with("small.rro") &&
           !archive.error().message.empty();
}

}  // namespace

TEST_CASE("an archive cut at any length is refused", "[corrupt]") {
    const Bytes good = small_archive();
    for (std::size_t length = 0; length < good.size(); ++length)
        if (!refused(Bytes(good.begin(), good.begin() + std::ptrdiff_t(length)))) FAIL("cut at " << length);
    Bytes longer = good;
    longer.push_back({});
    CHECK(refused(longer));
    CHECK_FALSE(refused(good));
}

TEST_CASE("an archive with any byte changed is refused", "[corrupt]") {
    const Bytes good = small_archive();
    for (const unsigned change : {0xffu, 0x01u})
        for (std::size_t i = 0; i < good.size(); ++i) {
            Bytes bad = good;
            bad[i] ^= static_cast<std::byte>(change);
            // The minor version is no fault by itself, but the header's checksum covers it too.
            if (!refused(bad)) FAIL("byte " << i << " changed by " << change);
        }
}
