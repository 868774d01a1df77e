// Writes a table in the FlatBuffers wire format. The bytes depend on the fields alone.
//
// Layout: the root's offset, then each table as vtable, table, and after it what its fields refer to, in field order. All
// offsets to content therefore point forward, as the format demands.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>
#include <type_traits>
#include <vector>

namespace rro {

/// The fields of one table. Fields are added in ascending order of their numbers; one left out takes its default.
class TableBuilder {
  public:
    /// Left out where it equals `absent`, the schema's default.
    template <class T>
        requires std::is_arithmetic_v<T>
    void scalar(std::uint16_t field, T value, T absent = {}) {
        if (value != absent) structure(field, value);
    }

    /// A struct of scalars without padding, as it lies in memory.
    template <class T>
        requires std::is_trivially_copyable_v<T>
    void structure(std::uint16_t field, const T& value) {
        add(field, Kind::InPlace, alignof(T)).own.assign(bytes_of(value).begin(), bytes_of(value).end());
    }

    /// Left out where empty.
    void text(std::uint16_t field, std::string_view value);

    /// A vector of scalars or structs, left out where empty. Refers to the values until finish().
    template <class T>
        requires std::is_trivially_copyable_v<T>
    void array(std::uint16_t field, std::span<const T> values) {
        if (values.empty()) return;
        Field& added = add(field, Kind::Array, alignof(T));
        added.count = values.size();
        added.borrowed = std::as_bytes(values);
    }

    /// A vector of tables, left out where empty.
    void tables(std::uint16_t field, std::vector<TableBuilder> values);

    /// Bytes of everything that fields refer to: slightly less than finish() will give.
    std::uint64_t content_bytes() const;

    /// The buffer whose root is this table. Content must stay below 2 GiB (asserted).
    std::vector<std::byte> finish() const;

  private:
    enum class Kind : std::uint8_t { InPlace, Text, Array, Tables };
    struct Field {
        std::uint16_t number;
        Kind kind;
        std::size_t alignment;
        std::size_t count = 0;                // of characters or elements
        std::vector<std::byte> own;           // InPlace, Text
        std::span<const std::byte> borrowed;  // Array
        std::vector<TableBuilder> tables;     // Tables
    };

    template <class T>
    static std::span<const std::byte> bytes_of(const T& value) {
        return std::as_bytes(std::span(&value, 1));
    }

    Field& add(std::uint16_t field, Kind kind, std::size_t alignment);
    std::size_t write(std::vector<std::byte>& out) const;
    static void write_content(const Field& field, std::vector<std::byte>& out);

    std::vector<Field> fields_;
};

}  // namespace rro
