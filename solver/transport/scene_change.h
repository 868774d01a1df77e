// What differs between two states of a scene.
#pragma once

#include <cstdint>
#include <vector>

#include "solver/scene/scene.h"

namespace rro {

struct SceneChange {
    static constexpr std::uint32_t kPlaced = 0xffffffffu;

    std::vector<std::uint32_t> before;   // [instances] its number before; kPlaced: it was not there
    std::vector<std::uint8_t> moved;     // [instances] stands elsewhere, or was not there
    std::vector<std::uint32_t> deleted;  // numbers before
    bool materials = false;              // of an instance that was there before
    bool lights = false;                 // lamps
    bool surroundings = false;           // sky, sun or medium

    bool places() const;
    bool any() const { return places() || materials || lights || surroundings; }
};

/// Instances are the same where name and archive are.
SceneChange scene_change(const Scene& before, const Scene& after);

}  // namespace rro
