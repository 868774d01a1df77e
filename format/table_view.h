// Reads a table in the FlatBuffers wire format in place. Only for buffers that the verifier has passed: nothing is
// checked here.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>
#include <vector>

namespace rro {

/// A table inside a verified buffer, which must outlive it. An absent field gives its default.
class TableView {
  public:
    /// The buffer's root table.
    static TableView root(std::span<const std::byte> buffer) { return TableView(follow(buffer.data())); }

    /// A scalar or struct.
    template <class T>
    T value(std::uint16_t field, T absent = {}) const {
        const std::byte* at = find(field);
        return at ? load<T>(at) : absent;
    }

    std::string_view text(std::uint16_t field) const {
        const std::byte* at = find(field);
        if (!at) return {};
        const std::byte* vector = follow(at);
        return {reinterpret_cast<const char*>(vector + 4), load<std::uint32_t>(vector)};
    }

    template <class T>
    std::span<const T> array(std::uint16_t field) const {
        const std::byte* at = find(field);
        if (!at) return {};
        const std::byte* vector = follow(at);
        return {reinterpret_cast<const T*>(vector + 4), load<std::uint32_t>(vector)};
    }

    std::vector<TableView> tables(std::uint16_t field) const {
        std::vector<TableView> found;
        const std::byte* at = find(field);
        if (!at) return found;
        const std::byte* vector = follow(at);
        const auto count = load<std::uint32_t>(vector);
        found.reserve(count);
        for (std::uint32_t i = 0; i < count; ++i) found.push_back(TableView(follow(vector + 4 + 4 * std::size_t{i})));
        return found;
    }

  private:
    explicit TableView(const std::byte* table) : table_(table) {}

    template <class T>
    static T load(const std::byte* at) {
        T value;
        std::memcpy(&value, at, sizeof value);
        return value;
    }

    static const std::byte* follow(const std::byte* offset) { return offset + load<std::uint32_t>(offset); }

    /// Where a field is, nullptr where it is absent.
    const std::byte* find(std::uint16_t field) const {
        const std::byte* vtable = table_ - load<std::int32_t>(table_);
        const std::size_t slot = 4 + 2 * std::size_t{field};
        if (slot + 2 > load<std::uint16_t>(vtable)) return nullptr;
        const auto place = load<std::uint16_t>(vtable + slot);
        return place ? table_ + place : nullptr;
    }

    const std::byte* table_;
};

}  // namespace rro
