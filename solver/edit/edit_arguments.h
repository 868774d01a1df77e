// Transforms on the command line.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "format/result.h"
#include "solver/edit/manifest_edit.h"

namespace rro {

/// What stands behind the options of place and move; empty where one is not given.
struct TransformOptions {
    std::string translate, rotate, scale;
    std::vector<std::string> matrix;  // 16 numbers, divided by commas or spaces
};

/// errors   Usage: not finite numbers, or not as many as the option takes; a matrix beside parts
Result<TransformChange> parse_transform(const TransformOptions& options);

}  // namespace rro
