#include "compiler/mesh_gltf_accessor.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>
#include <type_traits>

namespace rro {
namespace {

/// Elements of a strided array that lie wholly in a view.
struct Strided {
    const unsigned char* data = nullptr;
    std::size_t stride = 0;
};

template <class Component>
double component(const unsigned char* from, bool normalised) {
    Component value;
    std::memcpy(&value, from, sizeof value);
    const auto number = static_cast<double>(value);
    if constexpr (std::is_integral_v<Component>)
        if (normalised) return std::max(number / std::numeric_limits<Component>::max(), -1.0);
    return number;
}

double read_component(const unsigned char* from, int type, bool normalised) {
    switch (type) {
        case TINYGLTF_COMPONENT_TYPE_BYTE:
            return component<std::int8_t>(from, normalised);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
            return component<std::uint8_t>(from, normalised);
        case TINYGLTF_COMPONENT_TYPE_SHORT:
            return component<std::int16_t>(from, normalised);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
            return component<std::uint16_t>(from, normalised);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
            return component<std::uint32_t>(from, normalised);
        default:
            return component<float>(from, normalised);
    }
}

/// 0 for types that glTF does not have.
std::size_t component_bytes(int type) {
    switch (type) {
        case TINYGLTF_COMPONENT_TYPE_BYTE:
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
            return 1;
        case TINYGLTF_COMPONENT_TYPE_SHORT:
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
            return 2;
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
        case TINYGLTF_COMPONENT_TYPE_FLOAT:
            return 4;
        default:
            return 0;
    }
}

Result<Strided> elements(const tinygltf::Model& model, int view, std::size_t offset, std::size_t count,
                         std::size_t element_bytes, std::size_t stride, const std::string& where) {
    const auto bytes = gltf_view_bytes(model, view, where);
    if (!bytes) return bytes.error();
    if (stride == 0) stride = element_bytes;
    const bool fits = count == 0 || (offset <= bytes->size && element_bytes <= bytes->size - offset &&
                                     (count - 1) <= (bytes->size - offset - element_bytes) / stride);
    if (!fits)
        return bad_input(where, std::to_string(count) + " elements end behind their buffer view of " +
                                    std::to_string(bytes->size) + " bytes");
    return Strided{bytes->data + offset, stride};
}

Status apply_sparse(const tinygltf::Model& model, const tinygltf::Accessor& accessor, std::size_t width,
                    const std::string& where, std::vector<double>& values) {
    const auto& sparse = accessor.sparse;
    const std::size_t index_bytes = component_bytes(sparse.indices.componentType);
    const std::size_t value_bytes = component_bytes(accessor.componentType);
    if (sparse.count < 0 || static_cast<std::size_t>(sparse.count) > accessor.count || sparse.indices.byteOffset < 0 || sparse.values.byteOffset < 0 || index_bytes == 0)
        return bad_input(where, "a broken sparse accessor");
    const auto count = static_cast<std::size_t>(sparse.count);
    const auto indices = elements(model, sparse.indices.bufferView, static_cast<std::size_t>(sparse.indices.byteOffset),
                                  count, index_bytes, 0, where);
    if (!indices) return indices.error();
    const auto changes = elements(model, sparse.values.bufferView, static_cast<std::size_t>(sparse.values.byteOffset),
                                  count, width * value_bytes, 0, where);
    if (!changes) return changes.error();
    for (std::size_t i = 0; i < count; ++i) {
        const double at = read_component(indices->data + i * indices->stride, sparse.indices.componentType, false);
        if (!(at >= 0 && at < static_cast<double>(accessor.count)))
            return bad_input(where, "a sparse accessor changes element " + std::to_string(at) + " of " +
                                        std::to_string(accessor.count));
        for (std::size_t c = 0; c < width; ++c)
            values[static_cast<std::size_t>(at) * width + c] = read_component(
                changes->data + i * changes->stride + c * value_bytes, accessor.componentType, accessor.normalized);
    }
    return Done{};
}

}  // namespace

Result<GltfBytes> gltf_view_bytes(const tinygltf::Model& model, int view, const std::string& where) {
    if (view < 0 || static_cast<std::size_t>(view) >= model.bufferViews.size())
        return bad_input(where, "buffer view " + std::to_string(view) + ", but there are " +
                                    std::to_string(model.bufferViews.size()));
    const tinygltf::BufferView& found = model.bufferViews[static_cast<std::size_t>(view)];
    if (found.buffer < 0 || static_cast<std::size_t>(found.buffer) >= model.buffers.size())
        return bad_input(where, "buffer " + std::to_string(found.buffer) + ", but there are " +
                                    std::to_string(model.buffers.size()));
    const auto& data = model.buffers[static_cast<std::size_t>(found.buffer)].data;
    if (found.byteOffset > data.size() || found.byteLength > data.size() - found.byteOffset)
        return bad_input(where, "buffer view " + std::to_string(view) + " ends behind its buffer of " +
                                    std::to_string(data.size()) + " bytes");
    return GltfBytes{data.data() + found.byteOffset, found.byteLength};
}

Result<std::vector<double>> gltf_values(const tinygltf::Model& model, int number, int width,
                                        std::uint64_t most_elements, const std::string& where) {
    if (number < 0 || static_cast<std::size_t>(number) >= model.accessors.size())
        return bad_input(
            where, "accessor " + std::to_string(number) + ", but there are " + std::to_string(model.accessors.size()));
    const tinygltf::Accessor& accessor = model.accessors[static_cast<std::size_t>(number)];
    const std::string place = where + ": accessor " + std::to_string(number);
    const int found_width = tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(accessor.type));
    const std::size_t bytes = component_bytes(accessor.componentType);
    if (found_width != width || bytes == 0)
        return bad_input(place, "elements of " + std::to_string(found_width) + " components of type " +
                                    std::to_string(accessor.componentType) + ", expected " + std::to_string(width) +
                                    " of a known type");
    if (accessor.count > most_elements)
        return bad_input(place, std::to_string(accessor.count) + " elements, expected at most " +
                                    std::to_string(most_elements));
    const auto columns = static_cast<std::size_t>(width);
    std::vector<double> values;
    if (accessor.bufferView >= 0) {
        const std::size_t stride = static_cast<std::size_t>(accessor.bufferView) < model.bufferViews.size()
                                       ? model.bufferViews[static_cast<std::size_t>(accessor.bufferView)].byteStride
                                       : 0;
        const auto array =
            elements(model, accessor.bufferView, accessor.byteOffset, accessor.count, columns * bytes, stride, place);
        if (!array) return array.error();
        values.reserve(accessor.count * columns);
        for (std::size_t i = 0; i < accessor.count; ++i)
            for (std::size_t c = 0; c < columns; ++c)
                values.push_back(read_component(array->data + i * array->stride + c * bytes, accessor.componentType,
                                                accessor.normalized));
    } else {
        values.assign(accessor.count * columns, 0.0);  // zeros, says glTF
    }
    if (accessor.sparse.isSparse)
        if (auto applied = apply_sparse(model, accessor, columns, place, values); !applied) return applied.error();
    return values;
}

}  // namespace rro
