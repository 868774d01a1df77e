#!/usr/bin/env bash
# Compiles the sample objects, listed in samples/library.json, into samples/library; what has not changed is left alone.
#
#   samples/compile_library.sh RRO_COMPILE    the path of the compiler
set -euo pipefail

compiler=${1:?usage: samples/compile_library.sh RRO_COMPILE}
samples=$(dirname "${BASH_SOURCE[0]}")
exec "$compiler" library "$samples/library.json" --out "$samples/library"
