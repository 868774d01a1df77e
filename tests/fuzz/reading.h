// Reads every byte that a parser hands out, so that the address sanitizer sees a view that points anywhere else.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <type_traits>
#include <utility>

#include "format/layout.h"
#include "format/table_view.h"

namespace rro::fuzz {

/// A finding that no sanitizer would see: ends the run, with a reproducer.
inline void require(bool holds, const char* what) {
    if (holds) return;
    std::fprintf(stderr, "does not hold: %s\n", what);
    std::abort();
}

/// Bytes read so far; volatile, so that no read is optimised away.
inline volatile std::uint64_t read_sum = 0;

inline void read_bytes(std::span<const std::byte> bytes) {
    std::uint64_t sum = 0;
    for (const std::byte b : bytes) sum += std::to_integer<std::uint64_t>(b);
    read_sum = read_sum + sum;
}

/// A view of records: aligned for them, and readable.
template <class Record>
void read_array(std::span<const Record> records) {
    static_assert(std::is_trivially_copyable_v<Record>);
    require(reinterpret_cast<std::uintptr_t>(records.data()) % alignof(Record) == 0, "records are aligned");
    read_bytes(std::as_bytes(records));
}

inline constexpr std::size_t kLargestInPlace = 64;  // bytes of a struct inside a table

template <std::size_t... N>
void read_in_place(const TableView& table, std::uint16_t field, std::size_t bytes, std::index_sequence<N...>) {
    const auto read = [&](const auto& value) { read_bytes(std::as_bytes(std::span(value))); };
    ((bytes == N + 1 ? read(table.value<std::array<std::byte, N + 1>>(field)) : void()), ...);
}

/// All that a table of a verified buffer holds, as its description says.
inline void read_table(const TableView& table, std::span<const layout::FieldSpec> specs) {
    for (std::size_t i = 0; i < specs.size(); ++i) {
        const layout::FieldSpec& spec = specs[i];
        const auto field = static_cast<std::uint16_t>(i);
        switch (spec.kind) {
            case layout::FieldKind::InPlace:
                require(spec.bytes <= kLargestInPlace, "a struct in a table is at most 64 bytes");
                read_in_place(table, field, spec.bytes, std::make_index_sequence<kLargestInPlace>{});
                break;
            case layout::FieldKind::Text:
                read_bytes(std::as_bytes(std::span(table.text(field))));
                break;
            case layout::FieldKind::Array: {
                const auto elements = table.array<std::byte>(field);  // as many as there are, whatever their size
                require(elements.empty() || reinterpret_cast<std::uintptr_t>(elements.data()) % spec.alignment == 0,
                        "elements are aligned");
                read_bytes({elements.data(), elements.size() * spec.bytes});
                break;
            }
            case layout::FieldKind::Tables:
                for (const TableView& entry : table.tables(field)) read_table(entry, spec.table);
                break;
        }
    }
}

}  // namespace rro::fuzz
