#!/usr/bin/env bash
# Makes the archives of a new version of the format, and what is in them as flatc reads it. Run it once per version, when
# the format is settled; the files are kept for ever and never made again.
#
#   tests/golden/make.sh VERSION RRO_COMPILE
set -euo pipefail

version=$1 compile=$(realpath "$2")
cd "$(dirname "${BASH_SOURCE[0]}")"
[ ! -e "$version" ] || { echo "make.sh: $version is there already, and stays as it is" >&2; exit 1; }
mkdir "$version"
small=area,visibility,errors,hit,selflinks  # silhouettes are a hundred times the rest

"$compile" build sources/smallest.obj --out "$version/smallest.rro" --grid 2 --tables "$small" --quiet
"$compile" build sources/lamp.obj --out "$version/lamp.rro" --grid 4 --unit cm --quiet
"$compile" build sources/leaf.obj --out "$version/leaf.rro" --tables "$small" --grid 3 --map latlong --up z --two-sided yes --quiet

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
for archive in "$version"/*.rro; do
    python3 - "$archive" "$compile" ../../schemas/rro.fbs "$work" > "${archive%.rro}.json" <<'END'
import json, subprocess, sys
archive, compile, schema, work = sys.argv[1:]
sections = {}
for section in json.loads(subprocess.check_output([compile, "inspect", archive, "--json"]))["sections"]:
    name = section["name"]
    subprocess.check_call([compile, "extract", archive, "--section", name, "--out", f"{work}/{name}.bin"])
    subprocess.check_call(["flatc", "--json", "--strict-json", "--raw-binary", "--root-type", "rro." + name.capitalize(),
                           "-o", work, schema, "--", f"{work}/{name}.bin"])
    with open(f"{work}/{name}.json") as file:
        sections[name] = json.load(file)
print("{\n" + ",\n".join(f'"{name}": {json.dumps(value)}' for name, value in sections.items()) + "\n}")
END
done
ls -l "$version"
