// The smallest archive, cut at every length and changed at every byte, in a buffer of its own each time so that an
// overrun meets the sanitizer.
#include <catch2/catch.hpp>

#include "format/archive_reader.h"
#include "format/archive_writer.h"
#include "tests/support/archive_bytes.h"
#include "tests/support/flatc.h"
#include "tests/support/object_json.h"
#include "tests/support/tiny_object.h"

using namespace rro;
using test::Bytes;

namespace {

Bytes smallest_golden() { return test::read_bytes(RRO_SOURCE_DIR "/tests/golden/1.0/smallest.rro"); }

bool refused(const Bytes& bytes) {
    const auto archive = Archive::from_bytes(Bytes(bytes.begin(), bytes.end()), "small.rro");
    if (archive) return false;
    return archive.error().kind == ErrorKind::BadInput && archive.error().where.starts_with("small.rro") &&
           !archive.error().message.empty();
}

}  // namespace

TEST_CASE("an archive cut at any length is refused", "[corrupt]") {
    const Bytes good = smallest_golden();
    for (std::size_t length = 0; length < good.size(); ++length)
        if (!refused(Bytes(good.begin(), good.begin() + std::ptrdiff_t(length)))) FAIL("cut at " << length);
    Bytes longer = good;
    longer.push_back({});
    CHECK(refused(longer));
    CHECK_FALSE(refused(good));
}

TEST_CASE("an archive with any byte changed is refused", "[corrupt]") {
    const Bytes good = smallest_golden();
    for (const unsigned change : {0xffu, 0x01u, 0x10u, 0x80u})
        for (std::size_t i = 0; i < good.size(); ++i) {
            Bytes bad = good;
            bad[i] ^= static_cast<std::byte>(change);
            // The minor version is no fault by itself, but the header's checksum covers it too.
            if (!refused(bad)) FAIL("byte " << i << " changed by " << change);
        }
}

TEST_CASE("with its checksums made right, a changed payload is refused or read within its bounds", "[corrupt]") {
    const Bytes good = smallest_golden();
    std::size_t refusals = 0, readings = 0;
    const auto intact = Archive::from_bytes(Bytes(good), "small.rro");
    REQUIRE(intact);
    for (const SectionInfo& info : intact->sections()) {
        const std::string& section = info.name;
        const Bytes payload = test::payload_of(good, section);
        for (const unsigned change : {0xffu, 0x01u, 0x80u})
            for (std::size_t i = 0; i < payload.size(); ++i) {
                Bytes changed = payload;
                changed[i] ^= static_cast<std::byte>(change);
                const auto archive = Archive::from_bytes(test::with_payload(good, section, changed), "small.rro");
                if (!archive) {
                    ++refusals;
                    continue;
                }
                // Every view is walked to its end.
                if (!test::object_json(archive->data()).empty()) ++readings;
            }
    }
    CHECK(refusals > 100);
    CHECK(readings > 100);  // names, colours, positions: not every byte can be known to be wrong
}
