# Sourced first by the scripts of this folder, which are called as SCRIPT RRO_COMPILE RRO_SOLVE SOURCE_DIR: the three by name,
# a working folder that goes when the script ends, and how a test fails.
set -euo pipefail

compile=$1 solve=$2 source=$3
build_tree=$(dirname "$(dirname "$compile")")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

fail() { echo "$(basename "$0"): $*" >&2; exit 1; }

cd "$work"
