#!/usr/bin/env bash
# Compiles the sample meshes into samples/library, one archive each; what has not changed is left alone.
#
#   samples/compile_library.sh RRO_COMPILE    the path of the compiler
set -euo pipefail

compiler=$(realpath "${1:?usage: samples/compile_library.sh RRO_COMPILE}")
cd "$(dirname "${BASH_SOURCE[0]}")"

# Options of objects that need any. The open ones below are seen from one side only, so their backs are left black.
declare -A options=(
    [cornell_shell]="--two-sided no"
    [cornell_lamp]="--two-sided no"
)

mkdir -p library
for mesh in meshes/*.obj; do
    name=$(basename "$mesh" .obj)
    # The options are words, not one argument.
    # shellcheck disable=SC2086
    "$compiler" build "$mesh" --out "library/$name.rro" --if-changed ${options[$name]:-}
done
