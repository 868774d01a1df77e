// Scene manifests, as text. What is taken must be placed by transforms that can be inverted; no archive is opened.
#include <cmath>
#include <fstream>

#include "solver/scene/manifest.h"
#include "tests/fuzz/json_mutator.h"
#include "tests/fuzz/reading.h"
#include "tests/support/temporary_folder.h"

namespace {

using namespace rro;
using fuzz::require;

void check_manifest(const Manifest& manifest) {
    for (const InstanceEntry& instance : manifest.instances) {
        require(!instance.name.empty() && instance.name.find('/') == std::string::npos, "names are not paths");
        require(!instance.archive.empty(), "archives have paths");
        for (const Vec3& row : instance.to_world.inverse().linear.rows)
            require(is_finite(row), "transforms can be inverted");
        for (const auto& [name, material] : instance.materials)
            for (int c = 0; c < 3; ++c) {
                require(!material.reflectance || ((*material.reflectance)[c] >= 0 && (*material.reflectance)[c] < 1),
                        "reflectances are below 1");
                require(!material.exitance || ((*material.exitance)[c] >= 0 && std::isfinite((*material.exitance)[c])),
                        "exitances are finite");
            }
    }
    for (const LightEntry& light : manifest.lights)
        require(!light.name.empty() && is_finite(light.position) && length2(light.direction) > 0.5, "lights stand and point");
    if (manifest.sun) require(length2(manifest.sun->direction) > 0.5, "the sun shines somewhere");
    if (manifest.camera)
        require(length(normalised(manifest.camera->target - manifest.camera->position)) > 0.5, "cameras look somewhere");
    require(!manifest.accuracy || (*manifest.accuracy > 0 && *manifest.accuracy <= 1), "accuracies are above 0");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const test::TemporaryFolder folder;
    const std::filesystem::path file = folder / "scene.json";
    std::ofstream(file, std::ios::binary | std::ios::trunc).write(reinterpret_cast<const char*>(data),
                                                                  static_cast<std::streamsize>(size));
    if (const auto manifest = read_manifest(file)) check_manifest(*manifest);
    return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most, unsigned seed) {
    constexpr unsigned plain_one_in = 4;  // changes bytes, and so mostly what JSON is
    if (seed % plain_one_in != 0)
        if (const auto changed =
                fuzz::mutate_json({reinterpret_cast<const char*>(data), size}, seed, LLVMFuzzerMutate))
            if (const std::size_t changed_size = fuzz::hand_over(*changed, data, most)) return changed_size;
    return LLVMFuzzerMutate(data, size, most);
}
