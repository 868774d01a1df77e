#include "format/sha256.h"

#include <string_view>

#include <catch2/catch.hpp>

using namespace rro;

TEST_CASE("SHA-256 of the standard's examples", "[sha256]") {
    const auto hex = [](std::string_view text) { return sha256_hex(std::as_bytes(std::span(text))); };
    CHECK(hex("") == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
    CHECK(hex("abc") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    CHECK(hex("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq") ==
          "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
}
