// From what a manifest says about light to values: reads pictures and photometric files, numbers the light groups.
#pragma once

#include "solver/scene/scene.h"

namespace rro {

/// Fills sky, sun, lights, medium and light groups of a scene from its manifest; its instances stand already. What would
/// give no light is left out.
///
/// errors   BadInput naming manifest, place and file: a picture or a photometric file that cannot be used
Status resolve_lights(Scene& scene);

}  // namespace rro
