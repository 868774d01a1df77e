// How long work tells how far it is. Libraries never print: main passes a function that does.
#pragma once

#include <functional>
#include <string_view>

namespace rro {

/// Called with the phase and the share done in [0, 1], from one thread at a time; may be empty.
using Progress = std::function<void(std::string_view phase, double done)>;

}  // namespace rro
