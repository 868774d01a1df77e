#include <cstring>

#include "format/verifier.h"

namespace rro {
namespace {

using layout::FieldKind;
using layout::FieldSpec;

std::string number(std::uint64_t value) { return std::to_string(value); }

/// Walks a buffer from its root. Positions count from the buffer's start and are checked before each read.
class WireVerifier {
  public:
    WireVerifier(std::span<const std::byte> buffer, const std::string& where) : buffer_(buffer), where_(where) {}

    Status root(std::span<const FieldSpec> table) {
        const auto at = follow(0, 4, "root");
        if (!at) return at.error();
        return this->table(*at, table, "");
    }

  private:
    Error wrong(const std::string& field, const std::string& found, const std::string& expected) const {
        return bad_input(where_ + ": field " + field, "found " + found + ", expected " + expected);
    }

    bool holds(std::uint64_t at, std::uint64_t bytes) const {
        return at <= buffer_.size() && bytes <= buffer_.size() - at;
    }

    template <class T>
    T load(std::uint64_t at) const {
        T value;
        std::memcpy(&value, buffer_.data() + at, sizeof value);
        return value;
    }

    /// Where the offset stored at `at` points to: aligned, with room for 4 bytes.
    Result<std::uint64_t> follow(std::uint64_t at, std::uint64_t alignment, const std::string& field) const {
        if (!holds(at, 4))
            return wrong(field, "a buffer of " + number(buffer_.size()) + " bytes", "at least " + number(at + 4));
        const auto offset = load<std::uint32_t>(at);
        const std::uint64_t target = at + offset;
        if (offset == 0 || target % alignment != 0 || !holds(target, 4))
            return wrong(field, "an offset to byte " + number(target),
                         "a later byte, a multiple of " + number(alignment) + ", with 4 bytes before the end at " +
                             number(buffer_.size()));
        return target;
    }

    /// Counts bytes that something refers to. Content used twice would let a small file unfold to a large one.
    Status spend(std::uint64_t bytes, const std::string& field) {
        spent_ += bytes;
        if (spent_ > buffer_.size())
            return wrong(field, "more content than the section's " + number(buffer_.size()) + " bytes",
                         "each byte referred to once");
        return Done{};
    }

    Status table(std::uint64_t at, std::span<const FieldSpec> specs, const std::string& path);
    Status field(std::uint64_t at, const FieldSpec& spec, const std::string& path);
    Status vector(std::uint64_t at, const FieldSpec& spec, const std::string& path);

    std::span<const std::byte> buffer_;
    const std::string& where_;
    std::uint64_t spent_ = 0;
};

Status WireVerifier::table(std::uint64_t at, std::span<const FieldSpec> specs, const std::string& path) {
    const std::string self = path.empty() ? "root" : path;
    const std::int64_t back = load<std::int32_t>(at);
    const std::int64_t vtable_at = static_cast<std::int64_t>(at) - back;
    const auto vtable = static_cast<std::uint64_t>(vtable_at);
    if (vtable_at < 0 || vtable % 2 != 0 || !holds(vtable, 4))
        return wrong(self, "a vtable at byte " + std::to_string(vtable_at), "an even place inside the buffer");
    const auto vtable_bytes = load<std::uint16_t>(vtable), table_bytes = load<std::uint16_t>(vtable + 2);
    if (vtable_bytes < 4 || vtable_bytes % 2 != 0 || !holds(vtable, vtable_bytes))
        return wrong(self, "a vtable of " + number(vtable_bytes) + " bytes", "an even number from 4, inside the buffer");
    if (table_bytes < 4 || !holds(at, table_bytes))
        return wrong(self, "a table of " + number(table_bytes) + " bytes", "at least 4, inside the buffer");
    if (auto spent = spend(table_bytes, self); !spent) return spent;

    for (std::size_t i = 0; i < specs.size() && 4 + 2 * i < vtable_bytes; ++i) {
        const auto place = load<std::uint16_t>(vtable + 4 + 2 * i);
        if (place == 0) continue;
        const FieldSpec& spec = specs[i];
        const std::string name = (path.empty() ? "" : path + ".") + std::string(spec.name);
        const bool in_place = spec.kind == FieldKind::InPlace;
        const std::uint64_t bytes = in_place ? spec.bytes : 4, alignment = in_place ? spec.alignment : 4;
        if (place < 4 || place + bytes > table_bytes || (at + place) % alignment != 0)
            return wrong(name, "a place " + number(place) + " bytes into its table",
                         number(bytes) + " bytes inside the table's " + number(table_bytes) + ", aligned to " +
                             number(alignment));
        if (in_place) continue;
        if (auto checked = field(at + place, spec, name); !checked) return checked;
    }
    return Done{};
}

Status WireVerifier::field(std::uint64_t at, const FieldSpec& spec, const std::string& path) {
    const auto target = follow(at, 4, path);
    if (!target) return target.error();
    if (spec.kind != FieldKind::Text) return vector(*target, spec, path);

    const std::uint64_t length = load<std::uint32_t>(*target);
    if (!holds(*target + 4, length + 1))
        return wrong(path, "a string of " + number(length) + " bytes", "one that ends inside the buffer");
    if (load<char>(*target + 4 + length) != '\0')
        return wrong(path, "a string of " + number(length) + " bytes without a zero after it", "a zero byte");
    return spend(length, path);
}

Status WireVerifier::vector(std::uint64_t at, const FieldSpec& spec, const std::string& path) {
    const std::uint64_t count = load<std::uint32_t>(at), first = at + 4;
    if (!holds(first, count * spec.bytes))
        return wrong(path, number(count) + " elements of " + number(spec.bytes) + " bytes",
                     "at most the " + number((buffer_.size() - first) / spec.bytes) + " that fit into the buffer");
    if (count != 0 && first % spec.alignment != 0)
        return wrong(path, "elements at byte " + number(first), "a multiple of " + number(spec.alignment));
    if (auto spent = spend(count * spec.bytes, path); !spent) return spent;
    if (spec.kind != FieldKind::Tables) return Done{};

    for (std::uint64_t i = 0; i < count; ++i) {
        const std::string element = path + "[" + number(i) + "]";
        const auto target = follow(first + 4 * i, 4, element);
        if (!target) return target.error();
        if (auto checked = table(*target, spec.table, element); !checked) return checked;
    }
    return Done{};
}

}  // namespace

Status verify_table(std::span<const std::byte> buffer, std::span<const FieldSpec> table, const std::string& where) {
    return WireVerifier(buffer, where).root(table);
}

}  // namespace rro
