#!/usr/bin/env bash
# From a fresh clone to tested: installs what is missing, builds with warnings as errors, runs every test.
#
#   tests/run.sh          preset dev: optimised, assertions on
#   tests/run.sh --asan   preset asan: address and undefined behaviour sanitizers
set -euo pipefail

preset=dev
case "${1:-}" in
    "") ;;
    --asan) preset=asan ;;
    *) echo "usage: tests/run.sh [--asan]" >&2; exit 2 ;;
esac

cd "$(dirname "${BASH_SOURCE[0]}")/.."
source .ci/packages.sh
install_missing "${RRO_PACKAGES[@]}"

cmake --preset "$preset"
cmake --build --preset "$preset"
ctest --preset "$preset" --output-on-failure -j2
