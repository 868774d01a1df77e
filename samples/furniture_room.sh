#!/usr/bin/env bash
# A living room of real furniture: models of Debian's sweethome3d-furniture (120 MB), compiled as they are, in centimetres,
# with open and doubled faces. Everything goes into out/furniture. Needs what samples/quickstart.sh builds.
set -euo pipefail

cd "$(dirname "${BASH_SOURCE[0]}")/.."
source .ci/packages.sh
programs=build/release/bin
work=out/furniture
catalogues=/usr/share/sweethome3d/furniture

if [ ! -x "$programs/rro-solve" ] || [ ! -x "$programs/rro-compile" ]; then
    echo "furniture_room.sh: run samples/quickstart.sh first; it builds the programs" >&2
    exit 2
fi
mkdir -p "$work"

# Installed if that is possible, else unpacked beside the results, which needs no rights.
if [ ! -d "$catalogues" ] && ! install_missing sweethome3d-furniture; then
    catalogues=$work/package/usr/share/sweethome3d/furniture
    if [ ! -d "$catalogues" ]; then
        mkdir -p "$work/package"
        (cd "$work/package" && apt-get download sweethome3d-furniture)
        dpkg -x "$work"/package/sweethome3d-furniture_*.deb "$work/package"
    fi
fi
python3 samples/furniture_room.py extract "$catalogues" "$work"

started=$SECONDS
"$programs/rro-compile" library samples/library.json --out samples/library
python3 samples/furniture_room.py library "$work"
"$programs/rro-compile" library "$work/library.json" --out "$work/library"
python3 samples/furniture_room.py manifest "$work"
compiled=$SECONDS

status=0
"$programs/rro-solve" run "$work/scene.json" --picture "$work/room.png" --out "$work/room.glb" \
    --report "$work/room.json" || status=$?
if [ "$status" -gt 1 ]; then exit "$status"; fi  # 1: the results are written, but less accurate than asked

cat <<END

Furniture compiled in $((compiled - started)) s, room solved in $((SECONDS - compiled)) s.
  $PWD/$work/room.png   the picture
  $PWD/$work/room.glb   the solution, for any glTF viewer
  $PWD/$work/room.json  report
  $PWD/$work/scene.json the manifest
END
exit "$status"
