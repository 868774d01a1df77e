// Numbers out of glTF accessors, checked against the buffers before anything is read.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "format/result.h"

namespace tinygltf {
class Model;
}

namespace rro {

/// A part of a buffer.
struct GltfBytes {
    const unsigned char* data = nullptr;
    std::size_t size = 0;
};

/// The bytes of a buffer view.
///
/// errors   BadInput: no such view or buffer, or it ends behind the buffer
Result<GltfBytes> gltf_view_bytes(const tinygltf::Model& model, int view, const std::string& where);

/// All values of an accessor as [count][width] doubles; normalised integers in [-1, 1]; sparse ones with their changes.
///
/// width           numbers per element that are expected: 1 (SCALAR), 2 (VEC2) and so on
/// most_elements   that are taken; elements may overlap, and need no bytes at all, so the file does not bound them
/// errors          BadInput: no such accessor, another width, an unknown component type, too many elements, or it ends
///                 behind its view
Result<std::vector<double>> gltf_values(const tinygltf::Model& model, int accessor, int width,
                                        std::uint64_t most_elements, const std::string& where);

}  // namespace rro
