#!/usr/bin/env bash
# From a fresh clone to a picture, in one command: installs what is missing, builds the two programs, compiles the sample
# objects, solves the room of the twelve objects. Everything it makes is in build/, samples/library/ and out/.
set -euo pipefail

cd "$(dirname "${BASH_SOURCE[0]}")/.."
source .ci/packages.sh
install_missing "${RRO_PACKAGES[@]}"

echo "Building"
cmake --preset release
cmake --build --preset release --target rro-compile rro-solve
programs=build/release/bin

echo "Compiling the sample objects"
started=$SECONDS
"$programs/rro-compile" library samples/library.json --out samples/library
compiled=$SECONDS

echo "Solving the room"
mkdir -p out
status=0
"$programs/rro-solve" run samples/scenes/twelve_object_room.json --picture out/room.png --out out/room.glb \
    --radiosity out/room.csv --report out/room.json || status=$?
if [ "$status" -gt 1 ]; then exit "$status"; fi  # 1: the results are written, but less accurate than asked

cat <<END

Objects compiled in $((compiled - started)) s, room solved in $((SECONDS - compiled)) s.
  $PWD/out/room.png   the picture
  $PWD/out/room.glb   the solution, for any glTF viewer
  $PWD/out/room.csv   radiosity and irradiance of every triangle
  $PWD/out/room.json  report: accuracy, times, links, energy
END
exit "$status"
