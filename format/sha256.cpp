#include "format/sha256.h"

#include <array>
#include <cassert>
#include <string_view>

#include <openssl/evp.h>

namespace rro {
namespace {

using Digest = std::array<unsigned char, 32>;

Digest digest_of(const EVP_MD* method, std::span<const std::byte> bytes) {
    Digest digest{};
    unsigned length = 0;
    [[maybe_unused]] const int done =
        EVP_Digest(bytes.data(), bytes.size(), digest.data(), &length, method, nullptr);
    assert(done == 1 && length == digest.size());
    return digest;
}

/// Found, and used once, before main. Finding it takes locks of the library; a process that is forked while another
/// thread holds one would wait for it for ever.
const EVP_MD* const sha256 = [] {
    const EVP_MD* method = EVP_MD_fetch(nullptr, "SHA256", nullptr);
    digest_of(method, {});
    return method;
}();

}  // namespace

std::string sha256_hex(std::span<const std::byte> bytes) {
    constexpr std::string_view digits = "0123456789abcdef";
    std::string hex;
    const Digest digest = digest_of(sha256, bytes);
    hex.reserve(2 * digest.size());
    for (const unsigned char byte : digest) {
        hex += digits[byte >> 4];
        hex += digits[byte & 15];
    }
    return hex;
}

}  // namespace rro
