// The effects there are, and which of them this build has: all, or those of the build option RRO_EFFECTS.
#pragma once

#include <algorithm>
#include <array>
#include <string_view>

#include "solver/scene/chosen.h"  // of CMakeLists.txt: kChosenEffects, [] names

namespace rro {

/// The names of the effects, in the order in which explain and reports list them.
inline constexpr std::array<std::string_view, 12> kEffects{"emitters", "interreflection", "occlusion",    "self",
                                                           "colour",   "sky",             "sun",          "lights",
                                                           "transmission", "textures",    "groups",       "medium"};

/// Is the effect part of this build?
constexpr bool is_built(std::string_view effect) {
    return std::find(std::begin(kChosenEffects), std::end(kChosenEffects), effect) != std::end(kChosenEffects);
}

/// The same, answered by the compiler: code of an effect that is not is left out, and the question costs nothing.
consteval bool built_in(std::string_view effect) { return is_built(effect); }

static_assert(std::all_of(std::begin(kChosenEffects), std::end(kChosenEffects),
                          [](std::string_view name) { return std::find(kEffects.begin(), kEffects.end(), name) != kEffects.end(); }),
              "RRO_EFFECTS names an effect that does not exist");

/// Does this build know light that no surface sends?
inline constexpr bool kOutsideLight = built_in("sky") || built_in("sun") || built_in("lights");

}  // namespace rro
