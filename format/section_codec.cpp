#include "format/section_codec.h"

#include <algorithm>
#include <cassert>
#include <new>

#include <zlib.h>

#include "format/layout.h"
#include "format/parallel.h"

namespace rro {
namespace {

/// Deflate's densest code gives 258 bytes for 2 bits.
constexpr std::uint64_t kMaxBytesPerStoredByte = 1032;

const Bytef* zlib_input(std::span<const std::byte> bytes) { return reinterpret_cast<const Bytef*>(bytes.data()); }
Bytef* zlib_output(std::vector<std::byte>& bytes) { return reinterpret_cast<Bytef*>(bytes.data()); }

}  // namespace

std::uint32_t crc32_of(std::span<const std::byte> bytes) {
    constexpr std::size_t kChunk = std::size_t{1} << 19;  // 0.3 ms: long against the start of a task
    std::vector<uLong> sums((bytes.size() + kChunk - 1) / kChunk);
    parallel_chunks(bytes.size(), kChunk, [&](std::size_t begin, std::size_t end) {
        sums[begin / kChunk] = ::crc32_z(0, zlib_input(bytes.subspan(begin)), end - begin);
    });
    uLong crc = 0;
    for (std::size_t i = 0; i < sums.size(); ++i)
        crc = ::crc32_combine(crc, sums[i], static_cast<z_off_t>(std::min(kChunk, bytes.size() - i * kChunk)));
    return static_cast<std::uint32_t>(crc);
}

std::vector<std::byte> compress_zlib(std::span<const std::byte> raw) {
    assert(raw.size() <= layout::kMaxSectionBytes);
    uLongf size = ::compressBound(static_cast<uLong>(raw.size()));
    std::vector<std::byte> stored(size);
    [[maybe_unused]] const int status = ::compress2(zlib_output(stored), &size, zlib_input(raw),
                                                    static_cast<uLong>(raw.size()), Z_DEFAULT_COMPRESSION);
    assert(status == Z_OK);
    stored.resize(size);
    return stored;
}

Result<std::vector<std::byte>> decompress_zlib(std::span<const std::byte> stored, std::uint64_t raw_bytes,
                                               const std::string& where) {
    const auto refuse = [&](const std::string& reason) {
        return bad_input(where, "found " + std::to_string(stored.size()) + " bytes of zlib data that " + reason +
                                    ", expected " + std::to_string(raw_bytes) + " bytes in them");
    };
    if (stored.size() > layout::kMaxSectionBytes || raw_bytes > layout::kMaxSectionBytes)
        return refuse("exceed a section's 2147483647 bytes");
    if (raw_bytes > kMaxBytesPerStoredByte * stored.size()) return refuse("cannot hold as much");

    std::vector<std::byte> raw(raw_bytes);
    z_stream stream{};
    if (::inflateInit(&stream) != Z_OK) throw std::bad_alloc();
    stream.next_in = const_cast<Bytef*>(zlib_input(stored));  // zlib's interface; it does not write there
    stream.avail_in = static_cast<uInt>(stored.size());
    stream.next_out = zlib_output(raw);
    stream.avail_out = static_cast<uInt>(raw_bytes);
    const int status = ::inflate(&stream, Z_FINISH);
    const bool all_read = stream.avail_in == 0, all_written = stream.avail_out == 0;
    ::inflateEnd(&stream);

    if (status == Z_MEM_ERROR) throw std::bad_alloc();
    if (status == Z_STREAM_END && all_read && all_written) return raw;
    if (status == Z_STREAM_END) return refuse(all_read ? "hold less" : "go on after their end");
    if (status == Z_BUF_ERROR && all_written) return refuse("hold more");
    return refuse(status == Z_BUF_ERROR ? "break off" : "are damaged");
}

}  // namespace rro
