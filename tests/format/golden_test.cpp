// Archives of every released version stay readable, with the values that flatc read in them when they were made.
#include <filesystem>

#include <catch2/catch.hpp>

#include "format/archive_reader.h"
#include "format/layout.h"
#include "tests/support/object_json.h"
#include "tests/support/temporary_folder.h"

using namespace rro;

TEST_CASE("archives of all versions are read with the values they were written with", "[golden]") {
    std::size_t archives = 0;
    bool current = false;
    for (const auto& version : std::filesystem::directory_iterator(RRO_SOURCE_DIR "/tests/golden")) {
        const std::string name = version.path().filename().string();
        if (!version.is_directory() || name == "sources") continue;
        current |= name == std::to_string(layout::kVersionMajor) + "." + std::to_string(layout::kVersionMinor);
        for (const auto& file : std::filesystem::directory_iterator(version.path())) {
            if (file.path().extension() != ".rro") continue;
            INFO(file.path().string());
            const auto archive = Archive::open(file.path());
            REQUIRE(archive);
            CHECK(name == std::to_string(archive->version_major()) + "." + std::to_string(archive->version_minor()));
            auto path = file.path();
            const test::Json expected = test::Json::parse(test::file_text(path.replace_extension(".json")));
            const test::Json found = test::object_json(archive->data());
            for (const auto& section : expected.items())
                CHECK(test::difference(section.value(), found.at(section.key()), section.key()) == "");
            ++archives;
        }
    }
    CHECK(archives >= 3);
    CHECK(current);  // whoever raises the version adds its archives
}
