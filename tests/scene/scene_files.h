// Manifests and archives in a temporary folder, for tests of what reads them.
#pragma once

#include <catch2/catch.hpp>
#include <fstream>
#include <string>

#include "format/archive_writer.h"
#include "solver/scene/scene.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_object.h"

namespace rro::test {

/// A folder with box.rro: the convex box of tiny_object, materials `walls` (0.5, 0.25, 0.125) and `lamp` (textured,
/// exitance 20, 18, 15.5).
class SceneFiles {
  public:
    SceneFiles() { add_archive("box.rro", tiny_object()); }

    void add_archive(const std::string& name, const TinyObject& object) {
        const auto written = write_archive(object.data(), folder / name);
        if (!written) FAIL(written.error().message);
    }

    /// The manifest's path.
    std::filesystem::path manifest(const std::string& text) {
        std::ofstream(folder / "room.json", std::ios::binary) << text;
        return folder / "room.json";
    }

    /// A manifest of the instances given, as JSON objects with commas between.
    std::filesystem::path instances(const std::string& list, const std::string& more = "") {
        return manifest("{\"format\": \"rro-scene/1\", \"instances\": [" + list + "]" + more + "}");
    }

    Scene open(const std::filesystem::path& path) {
        auto read = read_manifest(path);
        if (!read) FAIL(read.error().where << ": " << read.error().message);
        auto scene = open_scene(std::move(*read));
        if (!scene) FAIL(scene.error().where << ": " << scene.error().message);
        return std::move(*scene);
    }

    /// The error of reading and opening, with the folder left out of it.
    Error error(const std::filesystem::path& path) {
        auto read = read_manifest(path);
        if (!read) return without_folder(read.error());
        auto scene = open_scene(std::move(*read));
        if (!scene) return without_folder(scene.error());
        FAIL("expected an error");
        return {};
    }

    TemporaryFolder folder;

  private:
    Error without_folder(Error error) const {
        const std::string prefix = folder.path().string() + "/";
        for (std::string* text : {&error.where, &error.message})
            for (auto at = text->find(prefix); at != std::string::npos; at = text->find(prefix))
                text->erase(at, prefix.size());
        return error;
    }
};

/// As a person reads it, without the hint.
inline std::string text_of(const Error& error) {
    return error.where + ": " + error.message;
}

}  // namespace rro::test
