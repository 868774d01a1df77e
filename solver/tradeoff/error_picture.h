// Where the error of a solution sits: a picture in false colours.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "format/result.h"
#include "solver/scene/scene.h"
#include "solver/solution.h"

namespace rro {

/// The scale of such pictures: errors of faces relative to the root mean square of reflected radiosity, from dark to light,
/// by their logarithm.
inline constexpr double kLeastShownError = 0.003, kMostShownError = 3;

/// The colour of an error, sRGB codes. Lightness grows with the error, so it reads without colours, too.
std::array<std::uint8_t, 3> error_colour(double error);

/// A PNG of the scene as its camera (or one that is chosen) sees it, each face in the colour of its error ([instances][F], as
/// face_errors gives them). Grey is where no face is seen.
///
/// errors   Failed: cannot be written
Status write_error_picture(const Scene& scene, const Solution& solution, const std::vector<std::vector<float>>& errors,
                           const std::filesystem::path& path);

}  // namespace rro
