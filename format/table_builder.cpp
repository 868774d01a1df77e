#include "format/table_builder.h"

#include <algorithm>
#include <cassert>

#include "format/layout.h"

namespace rro {
namespace {

using Bytes = std::vector<std::byte>;

/// Arrays start at multiples of this, so that they can be read in place by vector instructions.
constexpr std::size_t kArrayAlignment = 16;
/// Of the widest scalar; a table that starts so keeps its fields aligned by their offset within it.
constexpr std::size_t kTableAlignment = 8;

constexpr std::size_t aligned(std::size_t at, std::size_t alignment) {
    return (at + alignment - 1) / alignment * alignment;
}

template <class T>
void put(Bytes& out, std::size_t at, T value) {
    std::memcpy(out.data() + at, &value, sizeof value);
}

/// Points the 32-bit offset at `at` to `target`, which lies after it.
void point(Bytes& out, std::size_t at, std::size_t target) {
    assert(target > at && target - at <= layout::kMaxSectionBytes);
    put(out, at, static_cast<std::uint32_t>(target - at));
}

/// Appends an element count so that the elements after it are aligned; returns where the count is.
std::size_t begin_vector(Bytes& out, std::size_t count, std::size_t alignment) {
    const std::size_t at = aligned(out.size() + 4, alignment) - 4;
    out.resize(at + 4);
    put(out, at, static_cast<std::uint32_t>(count));
    return at;
}

}  // namespace

TableBuilder::Field& TableBuilder::add(std::uint16_t field, Kind kind, std::size_t alignment) {
    assert(fields_.empty() || fields_.back().number < field);
    return fields_.emplace_back(Field{field, kind, alignment, 0, {}, {}, {}});
}

void TableBuilder::text(std::uint16_t field, std::string_view value) {
    if (value.empty()) return;
    Field& added = add(field, Kind::Text, 4);
    added.count = value.size();
    const auto bytes = std::as_bytes(std::span(value));
    added.own.assign(bytes.begin(), bytes.end());
    added.own.push_back(std::byte{0});
}

void TableBuilder::tables(std::uint16_t field, std::vector<TableBuilder> values) {
    if (values.empty()) return;
    Field& added = add(field, Kind::Tables, 4);
    added.count = values.size();
    added.tables = std::move(values);
}

std::uint64_t TableBuilder::content_bytes() const {
    std::uint64_t sum = 0;
    for (const Field& field : fields_) {
        sum += field.own.size() + field.borrowed.size();
        for (const TableBuilder& table : field.tables) sum += table.content_bytes();
    }
    return sum;
}

void TableBuilder::write_content(const Field& field, Bytes& out) {
    if (field.kind != Kind::Tables) {
        const std::span<const std::byte> content = field.kind == Kind::Text ? field.own : field.borrowed;
        out.insert(out.end(), content.begin(), content.end());
        return;
    }
    const std::size_t offsets = out.size();
    out.resize(offsets + 4 * field.count);
    for (std::size_t i = 0; i < field.count; ++i) point(out, offsets + 4 * i, field.tables[i].write(out));
}

std::size_t TableBuilder::write(Bytes& out) const {
    const std::size_t slots = fields_.empty() ? 0 : fields_.back().number + 1u;
    const std::size_t vtable = aligned(out.size(), 2);
    const std::size_t table = aligned(vtable + 4 + 2 * slots, kTableAlignment);

    std::size_t end = 4;  // the table starts with the way to its vtable
    std::vector<std::size_t> places;
    for (const Field& field : fields_) {
        const bool in_place = field.kind == Kind::InPlace;
        places.push_back(aligned(end, in_place ? field.alignment : 4));
        end = places.back() + (in_place ? field.own.size() : 4);
    }

    out.resize(table + end);
    put(out, vtable, static_cast<std::uint16_t>(4 + 2 * slots));
    put(out, vtable + 2, static_cast<std::uint16_t>(end));
    put(out, table, static_cast<std::int32_t>(table - vtable));
    for (std::size_t i = 0; i < fields_.size(); ++i) {
        const Field& field = fields_[i];
        put(out, vtable + 4 + 2 * field.number, static_cast<std::uint16_t>(places[i]));
        if (field.kind == Kind::InPlace) std::memcpy(out.data() + table + places[i], field.own.data(), field.own.size());
    }
    for (std::size_t i = 0; i < fields_.size(); ++i) {
        const Field& field = fields_[i];
        if (field.kind == Kind::InPlace) continue;
        const std::size_t alignment = field.kind == Kind::Array ? std::max(field.alignment, kArrayAlignment) : 4;
        point(out, table + places[i], begin_vector(out, field.count, alignment));
        write_content(field, out);
    }
    return table;
}

std::vector<std::byte> TableBuilder::finish() const {
    Bytes out(4);
    out.reserve(content_bytes() + 4096);
    point(out, 0, write(out));
    return out;
}

}  // namespace rro
