// What differs between two states of a scene.
#pragma once

#include <cstdint>
#include <vector>

#include "solver/scene/scene.h"

namespace rro {

/// The difference; numbers are of the state after where nothing else is said.
struct SceneChange {
    static constexpr std::uint32_t kPlaced = 0xffffffffu;

    std::vector<std::uint32_t> before;   // [instances] its number before; kPlaced: it was not there
    std::vector<std::uint8_t> moved;     // [instances] stands elsewhere, or was not there
    std::vector<std::uint32_t> deleted;  // numbers before
    bool exitance = false, reflectance = false, transmittance = false;  // of instances that were there before
    bool lights = false;                 // lamps
    bool surroundings = false;           // sky, sun or medium

    bool places() const;
    /// Nothing but what surfaces emit and reflect.
    bool only_materials() const { return !places() && !lights && !surroundings && !transmittance; }
    /// Nothing but where instances stand.
    bool only_places() const { return !exitance && !reflectance && !transmittance && !lights && !surroundings; }
};

/// Instances are the same where name and archive are.
SceneChange scene_change(const Scene& before, const Scene& after);

/// Are all instances there, in the same order, and those moved only shifted or turned?
bool same_shapes(const Scene& before, const Scene& after, const SceneChange& change);

}  // namespace rro
