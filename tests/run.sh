#!/usr/bin/env bash
# From a fresh clone to tested: installs what is missing, builds with warnings as errors, runs every test.
#
#   tests/run.sh          every test (preset dev: optimised, assertions on); the tests of the archive format once more
#                         with sanitizers; each parser of untrusted input under a fuzzer, the same runs every time
#   tests/run.sh --dev    every test, and no more
#   tests/run.sh --asan   every test with sanitizers (preset asan: addresses, leaks, undefined behaviour); takes an hour
set -euo pipefail

cd "$(dirname "${BASH_SOURCE[0]}")/.."
source .ci/packages.sh
install_missing "${RRO_PACKAGES[@]}"

# every_test PRESET
every_test() {
    cmake --preset "$1"
    cmake --build --preset "$1"
    ctest --preset "$1" --output-on-failure -j2
}

case "${1:-}" in
    "")
        every_test dev
        cmake --preset asan
        cmake --build --preset asan --target format_tests
        build/asan/bin/format_tests
        tests/fuzz/run.sh check
        ;;
    --dev) every_test dev ;;
    --asan) every_test asan ;;
    *)
        echo "usage: tests/run.sh [--dev | --asan]" >&2
        exit 2
        ;;
esac
